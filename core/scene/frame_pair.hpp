// Two points of bodies with axes between them at a state: rows, velocities and their rates, and
// wrenches; see the conventions of rows in scene.hpp.
#pragma once

#include <cmath>

#include "scene/contact_geometry.hpp"
#include "scene/scene.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

using Vec = Vec3<double>;
using Mat = Mat3<double>;

// Both bodies are 0 of a joint stop, or of functions.
template <typename S>
struct FramePairState {
    int first = 0, other = 0;
    bool coincides = true;  // the other point is that of its body at the first's place
    Carrier carrier = Carrier::world;
    Vec3<S> place, other_place;  // as a tree has origins
    Vec3<S> arm, other_arm;      // of both points from the origins of their bodies
    Mat3<S> axes = identity<S>();
};

// The pair in one lane.
template <typename S>
FramePairState<double> lane_of(const FramePairState<S>& pair, int lane) {
    return {pair.first,
            pair.other,
            pair.coincides,
            pair.carrier,
            lane_of(pair.place, lane),
            lane_of(pair.other_place, lane),
            lane_of(pair.arm, lane),
            lane_of(pair.other_arm, lane),
            lane_of(pair.axes, lane)};
}

template <typename S>
Vec3<S> place_of(const Tree<S>& tree, const Site& site) {
    return tree.origin[site.body] + tree.rotation[site.body] * vec3<S>(site.point);
}

template <typename S>
Mat3<S> axes_of(const Tree<S>& tree, const Site& site) {
    return tree.rotation[site.body] * mat3<S>(site.axes);
}

// Contact axes on the normals of all lanes.
template <typename S>
Mat3<S> contact_axes_of_lanes(const Vec3<S>& normal) {
    if constexpr (Number<S>::lanes == 1) {
        return contact_axes(normal);
    } else {
        Mat3<S> axes;
        for (int k = 0; k < Number<S>::lanes; ++k) {
            const Mat3<double> own = contact_axes(lane_of(normal, k));
            set_lane(axes.x, k, own.x);
            set_lane(axes.y, k, own.y);
            set_lane(axes.z, k, own.z);
        }
        return axes;
    }
}

// Let both points be at a place; the first is at an arm from its body's origin.
template <typename S>
void set_coincident(const Tree<S>& tree, const Vec3<S>& place, const Vec3<S>& arm,
                    FramePairState<S>& pair) {
    pair.place = pair.other_place = place;
    pair.arm = arm;
    pair.other_arm = place - tree.origin[pair.other];
}

// A pair of frames; the tree with places.
template <typename S>
FramePairState<S> frame_pair_state(const Tree<S>& tree, const Pair& pair) {
    FramePairState<S> state;
    state.first = pair.first.body;
    state.other = pair.other.body;
    state.coincides = pair.coincides;
    state.carrier = pair.carrier;
    const Vec3<S> arm = tree.rotation[state.first] * vec3<S>(pair.first.point);
    set_coincident(tree, tree.origin[state.first] + arm, arm, state);
    if (!pair.coincides) {
        state.other_arm = tree.rotation[state.other] * vec3<S>(pair.other.point);
        state.other_place = tree.origin[state.other] + state.other_arm;
    }
    state.axes = mat3<S>(pair.axes);
    if (pair.carrier == Carrier::first || pair.carrier == Carrier::other) {
        state.axes =
            axes_of(tree, pair.carrier == Carrier::first ? pair.first : pair.other) * state.axes;
    } else if (pair.carrier == Carrier::line) {
        const Vec3<S> offset = state.place - state.other_place;
        state.axes = contact_axes_of_lanes(offset * (pair.axes[8] / root(dot(offset, offset))));
    }
    return state;
}

// The gap of a point over a plane, or of a rope.
template <typename S>
S gap_of(const Tree<S>& tree, const Contact& contact, const FramePairState<S>& state) {
    if (contact.kind == Contact::point)
        return dot(state.axes.z, state.place - place_of(tree, contact.frames.other));
    const Vec3<S> offset = state.place - state.other_place;
    return contact.limit - root(dot(offset, offset));
}

// Call add(slot, velocity, spin) for the share of every slot in w = v − v' and ω − ω'. Of a body
// that carries both points only their distance tells. Arms are summed up joint by joint: however
// far away a robot stands, its places cost no digits.
template <typename S, typename Add>
void for_slots(const Tree<S>& tree, const FramePairState<S>& pair, Add add) {
    const std::vector<Body>& bodies = tree.model.bodies;
    const auto each = [&](int body, auto use) {
        for (int a = bodies[body].slot; a < bodies[body].slot + bodies[body].freedoms; ++a)
            use(a, tree.column[a]);
    };
    int first = pair.first, other = pair.other;
    Vec3<S> arm = pair.arm, other_arm = pair.other_arm;
    while (first > 0 || other > 0) {
        if (first == other) {
            if (pair.coincides) return;
            const Vec3<S> between = pair.place - pair.other_place;
            each(first,
                 [&](int a, const Spatial<S>& c) { add(a, cross(c.angular, between), Vec3<S>{}); });
            first = other = bodies[first].parent;
        } else if (first > other) {
            each(first, [&](int a, const Spatial<S>& c) {
                add(a, c.linear + cross(c.angular, arm), c.angular);
            });
            arm += tree.arm[first];
            first = bodies[first].parent;
        } else {
            each(other, [&](int a, const Spatial<S>& c) {
                add(a, -(c.linear + cross(c.angular, other_arm)), -c.angular);
            });
            other_arm += tree.arm[other];
            other = bodies[other].parent;
        }
    }
}

// Add (3, nv) rows of the relative velocity, and where they are asked for of the angular one.
template <typename S>
void add_rows(const Tree<S>& tree, const FramePairState<S>& pair, S* rows, S* turning) {
    const int nv = tree.model.nv;
    for_slots(tree, pair, [&](int a, const Vec3<S>& w, const Vec3<S>& spin) {
        const int at = tree.model.slots[a].v;
        const Vec3<S> u = back(pair.axes, w);
        rows[at] += u.x;
        rows[nv + at] += u.y;
        rows[2 * nv + at] += u.z;
        if (!turning) return;
        const Vec3<S> omega = back(pair.axes, spin);
        turning[at] += omega.x;
        turning[nv + at] += omega.y;
        turning[2 * nv + at] += omega.z;
    });
}

// Rounding of a place, as a length of rows [m].
template <typename S>
S rounding_of(const Vec3<S>& place) {
    return number<S>(tolerance::sums) * (number<S>(1.0) + root(dot(place, place)));
}

// Velocities of what a pair is written at.
struct FramePairMotion : FramePairState<double> {
    Vec wanders;  // of the place where both points coincide
    Vec turns;    // angular, of the axes
};

// The velocity of the point of a body that is at a place; the tree with twists.
inline Vec velocity_at(const Tree<double>& tree, int body, const Vec& place) {
    return twist_at(tree.twist[body], place - tree.origin[body]).linear;
}

// Its acceleration at no joint acceleration, and with the pull of gravity upside down.
inline Vec acceleration_at(const Tree<double>& tree, int body, const Vec& place) {
    return twist_at(tree.rate[body], place - tree.origin[body]).linear +
           cross(tree.twist[body].angular, velocity_at(tree, body, place));
}

// Rᵀ(v − v') and Rᵀ(ω − ω'); the tree with twists.
inline Spatial<double> relative_velocity(const Tree<double>& tree,
                                         const FramePairState<double>& pair) {
    return {back(pair.axes, velocity_at(tree, pair.first, pair.place) -
                                velocity_at(tree, pair.other, pair.other_place)),
            back(pair.axes, tree.twist[pair.first].angular - tree.twist[pair.other].angular)};
}

// Rates of Rᵀ(v − v') and Rᵀ(ω − ω') at no joint acceleration. Where points coincide, both move
// over their bodies: d/dt v(c) = a(c) + ω × (ċ − v(c)).
inline Spatial<double> relative_rate(const Tree<double>& tree, const FramePairMotion& b) {
    const Vec v = velocity_at(tree, b.first, b.place),
              v2 = velocity_at(tree, b.other, b.other_place);
    const Vec w = tree.twist[b.first].angular, w2 = tree.twist[b.other].angular;
    Vec rate =
        acceleration_at(tree, b.first, b.place) - acceleration_at(tree, b.other, b.other_place);
    if (b.coincides) rate += cross(w, b.wanders - v) - cross(w2, b.wanders - v2);
    const Vec spin = tree.rate[b.first].angular - tree.rate[b.other].angular;
    return {back(b.axes, rate - cross(b.turns, v - v2)),
            back(b.axes, spin - cross(b.turns, w - w2))};
}

// A pair of frames and how it moves; the tree with places and twists.
inline FramePairMotion frame_pair_motion(const Tree<double>& tree, const Pair& pair) {
    FramePairMotion b{frame_pair_state(tree, pair), {}, {}};
    b.wanders = velocity_at(tree, b.first, b.place);
    if (pair.carrier == Carrier::first || pair.carrier == Carrier::other)
        b.turns = tree.twist[pair.carrier == Carrier::first ? b.first : b.other].angular;
    if (pair.carrier != Carrier::line) return b;
    // A unit vector n turns by n × ṅ, with ṅ the velocity across over the length.
    const Vec offset = b.place - b.other_place,
              u = b.wanders - velocity_at(tree, b.other, b.other_place);
    b.turns = cross(b.axes.z, u * (pair.axes[8] / std::sqrt(dot(offset, offset))));
    return b;
}

}  // namespace impulsekit
