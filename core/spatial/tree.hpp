// Placements and velocities of bodies, and the mass matrix: for one state or eight side by side.
//
// All in world axes, each body about the origin of its own joint: however far away a robot stands,
// only places of neighbours are subtracted. Formulas: Featherstone, Rigid Body Dynamics Algorithms
// (2008), chapters 5 (Newton-Euler) and 6 (composite rigid bodies).
#pragma once

#include <vector>

#include "linalg/numbers.hpp"
#include "spatial/model.hpp"

namespace impulsekit {

// A velocity, an acceleration, or a force with its moment: linear before angular.
template <typename S>
struct Spatial {
    Vec3<S> linear, angular;

    Spatial operator+(const Spatial& b) const { return {linear + b.linear, angular + b.angular}; }
    Spatial operator-(const Spatial& b) const { return {linear - b.linear, angular - b.angular}; }
    Spatial& operator+=(const Spatial& b) { return *this = *this + b; }
    Spatial operator*(const S& a) const { return {linear * a, angular * a}; }
};

template <typename S>
S dot(const Spatial<S>& a, const Spatial<S>& b) {
    return dot(a.linear, b.linear) + dot(a.angular, b.angular);
}

// A twist at the point that stands at an arm from its own.
template <typename S>
Spatial<S> twist_at(const Spatial<S>& a, const Vec3<S>& arm) {
    return {a.linear + cross(a.angular, arm), a.angular};
}

// A force about the point from which its own stands at an arm.
template <typename S>
Spatial<S> wrench_about(const Spatial<S>& f, const Vec3<S>& arm) {
    return {f.linear, f.angular + cross(arm, f.linear)};
}

// Mass, first moment and inertia of a body, or of several, about a point.
template <typename S>
struct Inertia {
    S mass{};
    Vec3<S> moment;
    Sym3<S> about;

    Spatial<S> operator*(const Spatial<S>& v) const {
        return {v.linear * mass + cross(v.angular, moment),
                about * v.angular + cross(moment, v.linear)};
    }
};

// About the point from which its own stands at an arm r: I + 2 g·r 1 − g rᵀ − r gᵀ, g = h + m r/2.
template <typename S>
Inertia<S> shifted_to(const Inertia<S>& a, const Vec3<S>& r) {
    const Vec3<S> half = r * (0.5 * a.mass), g = a.moment + half;
    const S x = g.x * r.x, y = g.y * r.y, z = g.z * r.z;
    const Sym3<S> more{2.0 * (y + z), -(g.x * r.y + g.y * r.x), -(g.x * r.z + g.z * r.x),
                       2.0 * (x + z), -(g.y * r.z + g.z * r.y), 2.0 * (x + y)};
    return {a.mass, g + half, a.about + more};
}

// The inertia of a body, or of a link whose mass varies, in the axes of its body.
template <typename S, typename Part>
Inertia<S> inertia_of(const Part& body) {
    const double* i = body.inertia;
    return {number<S>(body.mass),
            vec3<S>(body.moment),
            {number<S>(i[0]), number<S>(i[1]), number<S>(i[2]), number<S>(i[3]), number<S>(i[4]),
             number<S>(i[5])}};
}

// R Rz(c, s) and R Rx(c, s).
template <typename S, typename T>
Mat3<S> about_z(const Mat3<S>& r, const T& c, const T& s) {
    return {{r.x.x * c + r.y.x * s, r.x.y * c + r.y.y * s, r.x.z * c + r.y.z * s},
            {r.y.x * c - r.x.x * s, r.y.y * c - r.x.y * s, r.y.z * c - r.x.z * s},
            r.z};
}

template <typename S>
Mat3<S> about_x(const Mat3<S>& r, double c, double s) {
    return {r.x,
            {r.y.x * c + r.z.x * s, r.y.y * c + r.z.y * s, r.y.z * c + r.z.z * s},
            {r.z.x * c - r.y.x * s, r.z.y * c - r.y.y * s, r.z.z * c - r.y.z * s}};
}

// An ellipsoid's joint: its origin at p = (a sin q₁, −b sin q₀ cos q₁, c cos q₀ cos q₁), with
// derivatives, and the axes Rx(q₀) Ry(q₁).
template <typename S>
struct Ellipsoid {
    Vec3<S> place, by_first, by_second, twice_first, both, twice_second;
    Vec3<S> second_axis;  // about which q₁ turns
    Mat3<S> axes;

    Ellipsoid(const Body& body, const S* q) {
        const double a = body.radius[0], b = body.radius[1], c = body.radius[2];
        S s0, c0, s1, c1;
        sine_cosine(q[0], s0, c0);
        sine_cosine(q[1], s1, c1);
        place = {a * s1, -(b * (s0 * c1)), c * (c0 * c1)};
        by_first = {S{}, -(b * (c0 * c1)), -(c * (s0 * c1))};
        by_second = {a * c1, b * (s0 * s1), -(c * (c0 * s1))};
        twice_first = {S{}, b * (s0 * c1), -(c * (c0 * c1))};
        both = {S{}, b * (c0 * s1), c * (s0 * s1)};
        twice_second = {-(a * s1), b * (s0 * c1), -(c * (c0 * c1))};
        second_axis = {S{}, c0, s0};
        axes = {{c1, s0 * s1, -(c0 * s1)}, second_axis, {s1, -(s0 * c1), c0 * c1}};
    }
};

// The placement of a body in its parent: cosine and sine of γ + θ where it turns about z alone;
// else a rotation and its origin.
template <typename S>
struct Stance {
    S cosine{}, sine{};
    Mat3<S> rotation;
    Vec3<S> shift;
};

template <typename S>
void set_stance(const Body& body, const S* all, Stance<S>& to) {
    const S* q = all + body.q;
    S c = q[0], s{};
    if (body.is_scalar()) c = body.ratio * c + body.offset;
    const S own = c;
    if (body.joint == Joint::circle) s = q[1];
    if (body.joint == Joint::angle || body.joint == Joint::helix) sine_cosine(own, s, c);
    if (body.turns_about_z()) {
        to.cosine = body.gamma[0] * c - body.gamma[1] * s;
        to.sine = body.gamma[1] * c + body.gamma[0] * s;
        return;
    }
    const Mat3<S> f = mat3<S>(body.rotation);
    to.shift = vec3<S>(body.shift);
    to.rotation = f;
    switch (body.joint) {
        case Joint::slide:
            to.shift += f.z * own;
            break;
        case Joint::helix:
            to.shift += f.z * (own * body.pitch);
            to.rotation = about_z(f, c, s);
            break;
        case Joint::ball:
            to.rotation = f * of_quaternion(q[0], q[1], q[2], q[3]);
            break;
        case Joint::free:
            to.shift += f * Vec3<S>{q[0], q[1], q[2]};
            to.rotation = f * of_quaternion(q[3], q[4], q[5], q[6]);
            break;
        case Joint::planar:
            to.shift += f.x * q[0] + f.y * q[1];
            to.rotation = about_z(f, q[2], q[3]);
            break;
        case Joint::translation:
            to.shift += f * Vec3<S>{q[0], q[1], q[2]};
            break;
        default: {
            const Ellipsoid<S> e(body, q);
            to.shift += f * e.place;
            sine_cosine(q[2], s, c);
            to.rotation = about_z(Mat3<S>{f * e.axes.x, f * e.axes.y, f * e.axes.z}, c, s);
        }
    }
}

template <typename S>
Vec3<S> shift_of(const Body& body, const Stance<S>& to) {
    return body.turns_about_z() ? vec3<S>(body.shift) : to.shift;
}

template <typename S>
Mat3<S> turned_on(const Mat3<S>& parent, const Body& body, const Stance<S>& to) {
    if (!body.turns_about_z()) return parent * to.rotation;
    Mat3<S> r = parent;
    if (body.about_z) r = about_z(r, body.beta[0], body.beta[1]);
    if (body.about_x) r = about_x(r, body.alpha[0], body.alpha[1]);
    return about_z(r, to.cosine, to.sine);
}

// The bodies of a model at a state.
template <typename S>
struct Tree {
    const Model& model;
    std::vector<Mat3<S>> rotation;     // to world axes
    std::vector<Vec3<S>> origin;       // seen from the first root that can go anywhere [m]
    std::vector<Vec3<S>> arm;          // from the parent's origin
    std::vector<Spatial<S>> column;    // (slots) the twist of a slot's body at unit speed
    std::vector<Inertia<S>> gathered;  // of each body with all that hangs on it
    std::vector<Spatial<S>> twist, rate, wrench;
    std::vector<Vec3<S>> bend;  // second derivatives of an ellipsoid's origin: 00, 01, 11

    explicit Tree(const Model& m)
        : model(m),
          rotation(m.bodies.size(), identity<S>()),
          origin(m.bodies.size()),
          arm(m.bodies.size()),
          column(m.slots.size()),
          gathered(m.bodies.size()),
          twist(m.bodies.size()),
          rate(m.bodies.size()),
          wrench(m.bodies.size()),
          bend(m.has_ellipsoids ? 3 * m.bodies.size() : 0) {}

    int count() const { return static_cast<int>(model.bodies.size()); }

    // Places and columns at q (nq).
    void place(const S* q) {
        Stance<S> to;
        for (int k = 1; k < count(); ++k) {
            const Body& body = model.bodies[k];
            set_stance(body, q, to);
            arm[k] = rotation[body.parent] * shift_of(body, to);
            if (k == 1) origin[0] = goes_anywhere(body) ? -arm[1] : Vec3<S>{};
            origin[k] = origin[body.parent] + arm[k];
            rotation[k] = turned_on(rotation[body.parent], body, to);
            write_columns(k);
            if (body.joint == Joint::ellipsoid) write_ellipsoid(k, q + body.q);
        }
    }

    // A place in the world, and a place as `origin` has it.
    Vec3<S> world_place(const Vec3<S>& place) const { return place - origin[0]; }

    // M (nv, nv), all of it: composite rigid bodies. Inertias have been set by `weigh`.
    void mass_matrix(S* M) {
        const int nv = model.nv;
        for (int i = 0; i < nv * nv; ++i) M[i] = S{};
        for (int k = count() - 1; k > 0; --k) {
            const Body& body = model.bodies[k];
            for (int a = body.slot; a < body.slot + body.freedoms; ++a) {
                const Slot& slot = model.slots[a];
                const Spatial<S> own = gathered[k] * column[a];
                M[slot.v * nv + slot.v] += dot(column[a], own) + slot.armature;
                for (int b = body.slot; b < a; ++b) add_entry(a, b, dot(column[b], own), M);
                Spatial<S> f = own;
                for (int p = k; model.bodies[p].parent > 0;) {
                    f = wrench_about(f, arm[p]);
                    p = model.bodies[p].parent;
                    const Body& above = model.bodies[p];
                    for (int b = above.slot; b < above.slot + above.freedoms; ++b)
                        add_entry(a, b, dot(column[b], f), M);
                }
            }
            if (body.parent > 0) {
                const Inertia<S> shifted = shifted_to(gathered[k], arm[k]);
                Inertia<S>& above = gathered[body.parent];
                above.mass += shifted.mass;
                above.moment += shifted.moment;
                above.about = above.about + shifted.about;
            }
        }
    }

    // Each body's own inertia in world axes; with places.
    void weigh() {
        for (int k = 1; k < count(); ++k) gathered[k] = in_world(k, inertia_of<S>(model.bodies[k]));
    }

    Inertia<S> in_world(int k, const Inertia<S>& own) const {
        return {own.mass, rotation[k] * own.moment, turned(rotation[k], own.about)};
    }

    // The twists of all bodies, each at its origin, of v (nv).
    void move(const S* v) {
        for (int k = 1; k < count(); ++k) {
            const Body& body = model.bodies[k];
            twist[k] = twist_at(twist[body.parent], arm[k]) + of_joint(body, v);
        }
    }

    // c(q, v) (nv), Pinocchio's nonlinear effects: what holds all joints at no acceleration under
    // gravity g; with places and twists of v.
    void bias(const S* v, const double* gravity, S* c) {
        rate[0] = {-vec3<S>(gravity), {}};
        for (int k = 1; k < count(); ++k) {
            const Body& body = model.bodies[k];
            const Spatial<S> joint = of_joint(body, v), &own = twist[k];
            // v × S q̇, of motions.
            const Spatial<S> turning{
                cross(own.angular, joint.linear) + cross(own.linear, joint.angular),
                cross(own.angular, joint.angular)};
            rate[k] = twist_at(rate[body.parent], arm[k]) + turning;
            if (body.joint == Joint::ellipsoid) rate[k] += bending(k, v);
            const Inertia<S> inertia = in_world(k, inertia_of<S>(body));
            const Spatial<S> momentum = inertia * own;
            // v × I v, of forces.
            wrench[k] = inertia * rate[k] + Spatial<S>{cross(own.angular, momentum.linear),
                                                       cross(own.angular, momentum.angular) +
                                                           cross(own.linear, momentum.linear)};
        }
        gather(c);
    }

    // Σ over all that hangs on each joint of the wrenches (each about its body's origin, world
    // axes), and the part along the joints (nv); `wrench` holds the sums then.
    void gather(S* along) {
        for (int i = 0; i < model.nv; ++i) along[i] = S{};
        for (int k = count() - 1; k > 0; --k) {
            const Body& body = model.bodies[k];
            for (int a = body.slot; a < body.slot + body.freedoms; ++a)
                along[model.slots[a].v] += dot(column[a], wrench[k]);
            if (body.parent > 0) wrench[body.parent] += wrench_about(wrench[k], arm[k]);
        }
    }

    Spatial<S> of_joint(const Body& body, const S* v) const {
        Spatial<S> total;
        for (int a = body.slot; a < body.slot + body.freedoms; ++a)
            total += column[a] * v[model.slots[a].v];
        return total;
    }

  private:
    static bool goes_anywhere(const Body& body) {
        return body.parent == 0 && (body.joint == Joint::free || body.joint == Joint::planar ||
                                    body.joint == Joint::translation);
    }

    void write_columns(int k) {
        const Body& body = model.bodies[k];
        const Mat3<S>& r = rotation[k];
        for (int a = body.slot; a < body.slot + body.freedoms; ++a) {
            const Slot& slot = model.slots[a];
            const int d = slot.direction % 3;
            Vec3<S> axis = d == 0 ? r.x : d == 1 ? r.y : r.z;
            if (slot.ratio != 1.0) axis = axis * number<S>(slot.ratio);
            column[a] = {};
            if (slot.direction < 3)
                column[a].linear = axis;
            else
                column[a].angular = axis;
            if (body.joint == Joint::helix) column[a].linear = axis * number<S>(body.pitch);
        }
    }

    void write_ellipsoid(int k, const S* q) {
        const Body& body = model.bodies[k];
        const Ellipsoid<S> e(body, q);
        const Mat3<S> f = rotation[body.parent] * mat3<S>(body.rotation);
        column[body.slot] = {f * e.by_first, f.x};
        column[body.slot + 1] = {f * e.by_second, f * e.second_axis};
        bend[3 * k] = f * e.twice_first;
        bend[3 * k + 1] = f * e.both;
        bend[3 * k + 2] = f * e.twice_second;
    }

    // Ṡ q̇ of an ellipsoid as its parent sees it: p̈ − ω × ṗ and ω̇.
    Spatial<S> bending(int k, const S* v) const {
        const Body& body = model.bodies[k];
        const Spatial<S>* s = column.data() + body.slot;
        const S* u = v + model.slots[body.slot].v;
        const Spatial<S> joint = of_joint(body, v);
        const Vec3<S> first = s[0].angular * u[0], second = s[1].angular * u[1],
                      third = s[2].angular * u[2];
        return {bend[3 * k] * (u[0] * u[0]) + bend[3 * k + 1] * (2.0 * u[0] * u[1]) +
                    bend[3 * k + 2] * (u[1] * u[1]) - cross(joint.angular, joint.linear),
                cross(first, second) + cross(first + second, third)};
    }

    // Slots of one chain that stand for one entry of v meet on the diagonal.
    void add_entry(int a, int b, const S& value, S* M) const {
        const int i = model.slots[a].v, j = model.slots[b].v, nv = model.nv;
        M[i * nv + j] += value;
        M[j * nv + i] += value;
    }
};

}  // namespace impulsekit
