// Slopes by the configuration of forms in the velocities of a tree: Σ wrench · twist and xᵀ M c.
//
// A joint's column s moves all that hangs on it. Seen from the world the twists there turn with it,
// T ← T + s × (T − T_p) with T_p of the joint's parent, and so do places and axes. Of a wrench F
// that meets T the slope is s · (T ×* F) less s · (T_p ×* ΣF) over all that hangs on the joint;
// what places and axes add is a wrench D on each body. With M everything turns alike, and the
// second term alone is left. Nothing is differentiated numerically, and M is not formed.
#pragma once

#include <type_traits>
#include <vector>

#include "scene/frame_pair.hpp"

namespace impulsekit {

// A number of the tree as one of the columns that pass through it side by side.
template <typename S, typename G>
S lift(const G& a) {
    return S{} + a;
}
template <typename S, typename G>
Vec3<S> lift(const Vec3<G>& a) {
    if constexpr (std::is_same_v<S, G>)
        return a;
    else
        return {lift<S>(a.x), lift<S>(a.y), lift<S>(a.z)};
}
template <typename S, typename G>
Mat3<S> lift(const Mat3<G>& a) {
    return {lift<S>(a.x), lift<S>(a.y), lift<S>(a.z)};
}
template <typename S, typename G>
Spatial<S> lift(const Spatial<G>& a) {
    return {lift<S>(a.linear), lift<S>(a.angular)};
}

// T ×* F: how a wrench changes that turns with a twist.
template <typename S>
Spatial<S> turning(const Spatial<S>& t, const Spatial<S>& f) {
    return {cross(t.angular, f.linear), cross(t.angular, f.angular) + cross(t.linear, f.linear)};
}

// A frame pair and, for a ball's contact, which of the two it is (1, −1; 0 where none is), its
// centre, and how point and normal move with that.
template <typename G>
struct FramePairSlopes : FramePairState<G> {
    int ball = 0;
    Vec3<G> centre;
    Mat3<G> point_by_centre, normal_by_centre;

    FramePairSlopes(const FramePairState<G>& pair) : FramePairState<G>(pair) {}
};

template <typename G, typename S>
class TreeGradient {
  public:
    using Twists = std::vector<Spatial<S>>;

    explicit TreeGradient(const Tree<G>& tree) : tree_(tree) {}

    void begin() {
        local_.assign(tree_.count(), {});
        own_.assign(tree_.count(), {});
        bent_.assign(tree_.model.has_ellipsoids ? tree_.model.nv : 0, S{});
    }

    // The twists of all bodies, each at its origin, of v (nv).
    void move(const S* v, Twists& twist) const {
        twist.resize(tree_.count());
        twist[0] = {};
        for (int k = 1; k < tree_.count(); ++k) {
            const Body& body = tree_.model.bodies[k];
            twist[k] = twist_at(twist[body.parent], lift<S>(tree_.arm[k]));
            for (int a = body.slot; a < body.slot + body.freedoms; ++a)
                twist[k] += lift<S>(tree_.column[a]) * v[tree_.model.slots[a].v];
        }
    }

    // Wrenches of bodies become those of all that hangs on each.
    void sum(Twists& wrench) const {
        for (int k = tree_.count() - 1; k > 0; --k) {
            const int parent = tree_.model.bodies[k].parent;
            if (parent > 0) wrench[parent] += wrench_about(wrench[k], lift<S>(tree_.arm[k]));
        }
    }

    // Σ F·T of the summed wrenches that meet the twists of v: the part of the parents.
    template <typename V, typename T, typename F>
    void add_parents(const V* v, const std::vector<Spatial<T>>& twist,
                     const std::vector<Spatial<F>>& sums) {
        for (int k = 1; k < tree_.count(); ++k) {
            const Body& body = tree_.model.bodies[k];
            if (body.parent > 0) {
                const Spatial<T> parent = twist_at(twist[body.parent], lift<T>(tree_.arm[k]));
                own_[k] = own_[k] - turning(lift<S>(parent), lift<S>(sums[k]));
            }
            if (body.type.turn == Turn::ellipsoid) bend(k, v, lift<S>(sums[k]));
        }
    }

    // The gradient of a pair: torque on its axes and pull on its point, summed over its forms; and
    // what turns the axes alone, of vectors that are seen from the world.
    struct PairGradient {
        Vec3<S> torque, pull, alone;
    };

    // The form f·u + m·ω of a pair with twists of its bodies; f, m (world axes, at the point) is
    // the wrench on the first body, which the caller adds to those that meet the twists.
    template <typename T>
    void add_form(const FramePairSlopes<G>& m, const Spatial<S>& force,
                  const std::vector<Spatial<T>>& twist, PairGradient& pair) {
        const Spatial<S> a = lift<S>(twist[m.first]), b = lift<S>(twist[m.other]);
        const Vec3<S>& f = force.linear;
        const Vec3<S> va = at(a, m.first, m.place), vb = at(b, m.other, m.other_place);
        const Vec3<S> u = va - vb, w = a.angular - b.angular;
        pair.torque += cross(f, u) + cross(force.angular, w);
        pair.pull += cross(f, w);
        Spatial<S> first{{}, cross(a.angular, force.angular) + cross(va, f)};
        Spatial<S> other{{}, -(cross(b.angular, force.angular) + cross(vb, f))};
        if (m.coincides) {
            first.linear = cross(a.angular, f);
            other.linear = -cross(b.angular, f);
        }
        if (m.ball > 0) other = {-first.linear, -first.angular};
        if (m.ball < 0) first = {-other.linear, -other.angular};
        add(m.first, m.place, first);
        add(m.other, m.other_place, other);
    }

    // Add the torque and pull of a pair to the bodies that carry it.
    void distribute(const FramePairSlopes<G>& m, const PairGradient& pair) {
        const Vec3<S> torque = pair.torque + pair.alone, along = cross(torque, lift<S>(m.axes.z));
        if (m.ball != 0) {
            const int ball = m.ball > 0 ? m.first : m.other, shape = m.ball > 0 ? m.other : m.first;
            const Vec3<S> h = back(lift<S>(m.point_by_centre), pair.pull) +
                              back(lift<S>(m.normal_by_centre), along);
            add(ball, m.centre, {h, {}});
            add(shape, m.centre, {-h, pair.alone});
            return;
        }
        if (m.carrier == Carrier::line) {
            const S length = dot(lift<S>(m.place - m.other_place), lift<S>(m.axes.z));
            const Vec3<S> pull = along * (1.0 / length);
            add(m.first, m.place, {pull, {}});
            add(m.other, m.other_place, {-pull, {}});
        }
        if (m.coincides) add(m.first, m.place, {pair.pull, {}});
        if (m.carrier == Carrier::first) local_[m.first].angular += torque;
        if (m.carrier == Carrier::other) local_[m.other].angular += torque;
    }

    // Relative velocity and angular velocity of a pair.
    Spatial<S> relative_twist(const FramePairSlopes<G>& m, const Twists& twist) const {
        const Spatial<S>&a = twist[m.first], &b = twist[m.other];
        return {at(a, m.first, m.place) - at(b, m.other, m.other_place), a.angular - b.angular};
    }

    // Add a wrench at a point to that of a body about its origin.
    void wrench_at(int body, const Vec3<G>& place, const Spatial<S>& f, Twists& to) const {
        to[body] += wrench_about(f, lift<S>(place - tree_.origin[body]));
    }

    // Add the slopes (nv) of all that was met and pressed.
    void finish(S* slope) {
        sum(local_);
        for (int k = 1; k < tree_.count(); ++k) {
            const Body& body = tree_.model.bodies[k];
            for (int a = body.slot; a < body.slot + body.freedoms; ++a)
                slope[tree_.model.slots[a].v] += dot(lift<S>(tree_.column[a]), local_[k] + own_[k]);
        }
        for (std::size_t i = 0; i < bent_.size(); ++i) slope[i] += bent_[i];
    }

  private:
    Vec3<S> at(const Spatial<S>& twist, int body, const Vec3<G>& place) const {
        return twist_at(twist, lift<S>(place - tree_.origin[body])).linear;
    }

    void add(int body, const Vec3<G>& place, const Spatial<S>& f) {
        wrench_at(body, place, f, local_);
    }

    // The columns of an ellipsoid do not turn with it alone.
    template <typename V>
    void bend(int k, const V* v, const Spatial<S>& f) {
        const int first = tree_.model.slots[tree_.model.bodies[k].slot].v;
        for (int j = 0; j < 3; ++j)
            for (int i = 0; i < 3; ++i)
                bent_[first + j] += dot(lift<S>(tree_.column_slope(k, i, j)), f) * v[first + i];
    }

    const Tree<G>& tree_;
    Twists local_, own_;  // what hangs on a joint adds up; what a joint alone meets
    std::vector<S> bent_;
};

}  // namespace impulsekit
