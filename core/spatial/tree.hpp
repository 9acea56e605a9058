// Placements and velocities of bodies, and the mass matrix: for one state or eight side by side.
//
// All in world axes, each body about the origin of its own joint: however far away a robot stands,
// only places of neighbours are subtracted. Formulas: Featherstone, Rigid Body Dynamics Algorithms
// (2008), chapters 5 (Newton-Euler) and 6 (composite rigid bodies).
#pragma once

#include <vector>

#include "spatial/joints.hpp"

namespace impulsekit {

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
            write_columns(body, model.slots.data() + body.slot, q, rotation[body.parent],
                          rotation[k], column.data() + body.slot,
                          model.has_ellipsoids ? &bend[3 * k] : nullptr);
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
            if (body.parent > 0) gathered[body.parent] += shifted_to(gathered[k], arm[k]);
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
    void move(const S* v) { move(v, twist); }

    // What bodies gain by velocities, jumps or accelerations of the joints (nv).
    void move(const S* v, std::vector<Spatial<S>>& to) const {
        for (int k = 1; k < count(); ++k) {
            const Body& body = model.bodies[k];
            to[k] = twist_at(to[body.parent], arm[k]) + of_joint(body, v);
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
            if (body.type.turn == Turn::ellipsoid) add_bending(k, v, rate[k]);
            const Inertia<S> inertia = in_world(k, inertia_of<S>(body));
            wrench[k] = inertia * rate[k] + gyroscopic(inertia, own);
        }
        gather(c);
    }

    // What each body's parent gives it beyond what hangs on it, in `wrench`, which held what acts
    // on it from outside; of accelerations or jumps of the bodies. `inertia_at`: of a body in its
    // axes; `moves`: with twists.
    template <typename InertiaAt>
    void load(const std::vector<Spatial<S>>& motion, InertiaAt inertia_at, bool moves) {
        for (int k = 1; k < count(); ++k) {
            const Inertia<S> own = in_world(k, inertia_at(k));
            wrench[k] = own * motion[k] - wrench[k];
            if (moves) wrench[k] += gyroscopic(own, twist[k]);
        }
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

    // An ellipsoid's.
    Spatial<S> column_slope(int k, int i, int j) const {
        return slope_of_column(column.data() + model.bodies[k].slot, bend.data() + 3 * k, i, j);
    }

    Spatial<S> of_joint(const Body& body, const S* v) const {
        Spatial<S> total;
        for (int a = body.slot; a < body.slot + body.freedoms; ++a)
            total += column[a] * v[model.slots[a].v];
        return total;
    }

  private:
    static bool goes_anywhere(const Body& body) { return body.parent == 0 && body.type.places > 1; }

    // Ṡ q̇ of an ellipsoid as its parent sees it.
    void add_bending(int k, const S* v, Spatial<S>& to) const {
        const Body& body = model.bodies[k];
        const S* u = v + model.slots[body.slot].v;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) to += column_slope(k, i, j) * (u[i] * u[j]);
    }

    // Slots of one chain that stand for one entry of v meet on the diagonal.
    void add_entry(int a, int b, const S& value, S* M) const {
        const int i = model.slots[a].v, j = model.slots[b].v, nv = model.nv;
        M[i * nv + j] += value;
        M[j * nv + i] += value;
    }
};

}  // namespace impulsekit
