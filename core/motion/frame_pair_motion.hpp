// Two points of bodies with axes between them: rows, velocities, and rates of these at no joint
// acceleration.
#pragma once

#include <cmath>

#include "scene/contact_geometry.hpp"
#include "scene/scene.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

using Vec = Vec3<double>;
using Mat = Mat3<double>;

struct FramePairMotion {
    int first = 0, other = 0;  // bodies
    Vec place, other_place;    // as a tree has origins
    bool coincides = true;     // the other point is that of its body at the first's place
    Mat axes = identity<double>();
    Vec wanders;  // velocity of the place where they coincide
    Vec turns;    // angular velocity of the axes
};

// Velocity and acceleration of the point of a body that is at a place.
inline Vec velocity_at(const Tree<double>& tree, int body, const Vec& place) {
    return twist_at(tree.twist[body], place - tree.origin[body]).linear;
}

// The same of accelerations without those of joints, and with the pull of gravity upside down.
inline Vec acceleration_at(const Tree<double>& tree, int body, const Vec& place) {
    return twist_at(tree.rate[body], place - tree.origin[body]).linear +
           cross(tree.twist[body].angular, velocity_at(tree, body, place));
}

// Rᵀ(v − v') and Rᵀ(ω − ω').
inline Spatial<double> relative_velocity(const Tree<double>& tree, const FramePairMotion& b) {
    return {back(b.axes,
                 velocity_at(tree, b.first, b.place) - velocity_at(tree, b.other, b.other_place)),
            back(b.axes, tree.twist[b.first].angular - tree.twist[b.other].angular)};
}

// Their rates at no joint acceleration. Where points coincide, both move over their bodies:
// d/dt v(c) = a(c) + ω × (ċ − v(c)).
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

// Add (3, nv) rows of the relative velocity, and where asked for of the angular one.
inline void add_rows(const Tree<double>& tree, const FramePairMotion& b, double* rows,
                     double* turning) {
    const int nv = tree.model.nv;
    for_slots_between(tree, b.first, b.other, b.place, b.other_place, b.coincides,
                      [&](int a, const Vec& w, const Vec& spin) {
                          const int at = tree.model.slots[a].v;
                          if (rows) {
                              const Vec u = back(b.axes, w);
                              rows[at] += u.x;
                              rows[nv + at] += u.y;
                              rows[2 * nv + at] += u.z;
                          }
                          if (!turning) return;
                          const Vec omega = back(b.axes, spin);
                          turning[at] += omega.x;
                          turning[nv + at] += omega.y;
                          turning[2 * nv + at] += omega.z;
                      });
}

inline Vec place_of(const Tree<double>& tree, const Site& site) {
    return tree.origin[site.body] + tree.rotation[site.body] * vec3<double>(site.point);
}

inline Mat axes_of(const Tree<double>& tree, const Site& site) {
    return tree.rotation[site.body] * mat3<double>(site.axes);
}

// The points and axes of a pair of frames at the tree's state.
inline FramePairMotion frame_pair_motion(const Tree<double>& tree, const Pair& pair) {
    FramePairMotion b;
    b.first = pair.first.body;
    b.other = pair.other.body;
    b.place = place_of(tree, pair.first);
    b.coincides = pair.coincides;
    b.other_place = pair.coincides ? b.place : place_of(tree, pair.other);
    b.wanders = velocity_at(tree, b.first, b.place);
    b.axes = mat3<double>(pair.axes);
    if (pair.carrier == Carrier::first || pair.carrier == Carrier::other) {
        const Site& site = pair.carrier == Carrier::first ? pair.first : pair.other;
        b.axes = axes_of(tree, site) * b.axes;
        b.turns = tree.twist[site.body].angular;
    } else if (pair.carrier == Carrier::line) {
        const Vec offset = b.place - b.other_place;
        const double length = std::sqrt(dot(offset, offset));
        const Vec n = offset * (pair.axes[8] / length);
        b.axes = contact_axes(n);
        // A unit vector n turns by n × ṅ, with ṅ the velocity across over the length.
        const Vec u = b.wanders - velocity_at(tree, b.other, b.other_place);
        b.turns = cross(n, u * (pair.axes[8] / length));
    }
    return b;
}

}  // namespace impulsekit
