// Known blows in O(n): Δv = M⁻¹ I by articulated inertias, for one state or eight side by side.
//
// A = [M H; Hᵀ I] is the articulated inertia of a body with all that hangs on it (Featherstone
// 1983), about the origin of its joint, in the body's own axes: there the inertia about the joint,
// however small beside others, keeps its digits. A degree of freedom along s takes U Uᵀ/D from it,
// U = A s, D = s·U + armature; what is left goes to the parent.
#pragma once

#include <vector>

#include "linalg/numbers.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {

// Steps between bodies are inlined: eight numbers side by side pass between them in registers.

template <typename S>
struct Articulated {
    Sym3<S> linear;   // M
    Mat3<S> coupled;  // H, by columns
    Sym3<S> angular;  // I
};

// R A Rᵀ of M, H and I, R about z; about x with the names of the axes moved on by one.
template <typename S, typename T>
[[gnu::always_inline]] inline Sym3<S> turned_about_z(const Sym3<S>& m, const T& c, const T& s) {
    const S a = c * m.xx - s * m.xy, b = c * m.xy - s * m.yy;
    const S d = s * m.xx + c * m.xy, e = s * m.xy + c * m.yy;
    return {c * a - s * b, s * a + c * b,       c * m.xz - s * m.yz,
            s * d + c * e, s * m.xz + c * m.yz, m.zz};
}

template <typename S, typename T>
[[gnu::always_inline]] inline Vec3<S> vector_about_z(const Vec3<S>& a, const T& c, const T& s) {
    return {c * a.x - s * a.y, s * a.x + c * a.y, a.z};
}

template <typename S>
[[gnu::always_inline]] inline Vec3<S> vector_about_x(const Vec3<S>& a, double c, double s) {
    return {a.x, c * a.y - s * a.z, s * a.y + c * a.z};
}

template <typename S, typename T>
[[gnu::always_inline]] inline Articulated<S> turned_about_z(const Articulated<S>& a, const T& c,
                                                            const T& s) {
    const Mat3<S>& h = a.coupled;
    const Vec3<S> x = vector_about_z(h.x, c, s), y = vector_about_z(h.y, c, s);
    return {turned_about_z(a.linear, c, s),
            {x * c - y * s, x * s + y * c, vector_about_z(h.z, c, s)},
            turned_about_z(a.angular, c, s)};
}

template <typename S>
[[gnu::always_inline]] inline Sym3<S> turned_about_x(const Sym3<S>& m, double c, double s) {
    const Sym3<S> n = turned_about_z(Sym3<S>{m.yy, m.yz, m.xy, m.zz, m.xz, m.xx}, c, s);
    return {n.zz, n.xz, n.yz, n.xx, n.xy, n.yy};
}

template <typename S>
[[gnu::always_inline]] inline Articulated<S> turned_about_x(const Articulated<S>& a, double c,
                                                            double s) {
    const Mat3<S>& h = a.coupled;
    const Vec3<S> y = vector_about_x(h.y, c, s), z = vector_about_x(h.z, c, s);
    return {turned_about_x(a.linear, c, s),
            {vector_about_x(h.x, c, s), y * c - z * s, y * s + z * c},
            turned_about_x(a.angular, c, s)};
}

// Add to an inertia another one, whose point stands at an arm r from its own:
// G = H − M [r]×, I + [r]× G + ([r]× H)ᵀ.
template <typename S>
[[gnu::always_inline]] inline void add_moved(const Articulated<S>& a, const Vec3<S>& r,
                                             Articulated<S>& to) {
    const Sym3<S>& m = a.linear;
    const Mat3<S>& h = a.coupled;
    // Rows of M [r]× are m × r.
    const Vec3<S> p = cross(Vec3<S>{m.xx, m.xy, m.xz}, r), q = cross(Vec3<S>{m.xy, m.yy, m.yz}, r),
                  t = cross(Vec3<S>{m.xz, m.yz, m.zz}, r);
    const Mat3<S> g{h.x - Vec3<S>{p.x, q.x, t.x}, h.y - Vec3<S>{p.y, q.y, t.y},
                    h.z - Vec3<S>{p.z, q.z, t.z}};
    to.linear = to.linear + m;
    to.coupled.x += g.x;
    to.coupled.y += g.y;
    to.coupled.z += g.z;
    Sym3<S>& i = to.angular;
    const Sym3<S>& own = a.angular;
    i.xx += own.xx + (r.y * (g.x.z + h.x.z) - r.z * (g.x.y + h.x.y));
    i.xy += own.xy + ((r.y * g.y.z - r.z * g.y.y) + (r.z * h.x.x - r.x * h.x.z));
    i.xz += own.xz + ((r.y * g.z.z - r.z * g.z.y) + (r.x * h.x.y - r.y * h.x.x));
    i.yy += own.yy + (r.z * (g.y.x + h.y.x) - r.x * (g.y.z + h.y.z));
    i.yz += own.yz + ((r.z * g.z.x - r.x * g.z.z) + (r.x * h.y.y - r.y * h.y.x));
    i.zz += own.zz + (r.x * (g.z.y + h.z.y) - r.y * (g.z.x + h.z.x));
}

// The articulated inertia behind a free joint about z without armature: all along z is nothing.
template <typename S>
struct Turned {
    Sym3<S> linear;
    Vec3<S> x, y;  // columns of H
    S xx, xy, yy;  // of I
};

template <typename S>
[[gnu::always_inline]] inline Turned<S> turned_about_z(const Turned<S>& a, const S& c, const S& s) {
    const Vec3<S> x = vector_about_z(a.x, c, s), y = vector_about_z(a.y, c, s);
    const S p = c * a.xx - s * a.xy, q = c * a.xy - s * a.yy;
    const S t = s * a.xx + c * a.xy, u = s * a.xy + c * a.yy;
    return {turned_about_z(a.linear, c, s),
            x * c - y * s,
            x * s + y * c,
            c * p - s * q,
            s * p + c * q,
            s * t + c * u};
}

// U = A s and 1/D of a slot, and u, the impulse along it that the joint has not yet answered.
template <typename S>
struct Freed {
    Spatial<S> u;
    S inverse{}, impulse{};
};

// The bodies of a model under known impulses. Scratch: one per thread.
template <typename S>
struct ArticulatedTree {
    const Model& model;
    std::vector<Stance<S>> stance;
    std::vector<Articulated<S>> inertia;
    std::vector<Freed<S>> slots;
    std::vector<Spatial<S>> wrench;  // on each body about its origin, in its axes: used up
    std::vector<Spatial<S>> jump;    // of each body's twist
    std::vector<int> bodies;         // those that move, from the roots outwards

    explicit ArticulatedTree(const Model& m)
        : model(m),
          stance(m.bodies.size()),
          inertia(m.bodies.size()),
          slots(m.slots.size()),
          wrench(m.bodies.size()),
          jump(m.bodies.size()) {
        for (int k = 1; k < count(); ++k) bodies.push_back(k);
    }

    int count() const { return static_cast<int>(model.bodies.size()); }

    // Place bodies at q (nq), with their own inertias.
    void place(const S* q) {
        for (int k : bodies) {
            set_stance(model.bodies[k], q, stance[k]);
            set_inertia(k, inertia_of<S>(model.bodies[k]));
        }
    }

    void set_inertia(int k, const Inertia<S>& own) {
        const S m = own.mass, zero{};
        const Vec3<S>& h = own.moment;
        inertia[k] = {{m, zero, zero, m, zero, m},
                      {{zero, -h.z, h.y}, {h.z, zero, -h.x}, {-h.y, h.x, zero}},
                      own.about};
    }

    // U and 1/D of all slots, from the tips inwards.
    void factor() {
        for (auto at = bodies.rbegin(); at != bodies.rend(); ++at) {
            const int k = *at;
            const Body& body = model.bodies[k];
            Articulated<S>& a = inertia[k];
            if (body.turns_about_z && model.slots[body.slot].armature == 0.0) {
                const Turned<S> left = free_turn(body.slot, a);
                if (body.parent > 0)
                    add_moved(turned_inwards(body, stance[k], left), shift_of(body, stance[k]),
                              inertia[body.parent]);
            } else {
                free_all(body, a);
                if (body.parent > 0)
                    add_moved(turned_inwards(body, stance[k], a), shift_of(body, stance[k]),
                              inertia[body.parent]);
            }
        }
    }

    // Δv (nv), given `wrench` on the bodies and impulses τ (nv) in the joints; `struck`: whether a
    // body or something that hangs on it is, by body.
    void respond(const char* struck, const S* tau, S* dv) {
        for (auto at = bodies.rbegin(); at != bodies.rend(); ++at) {
            const int k = *at;
            if (!struck[k]) continue;
            const Body& body = model.bodies[k];
            for (int a = body.slot + body.freedoms - 1; a >= body.slot; --a) {
                Freed<S>& slot = slots[a];
                slot.impulse = tau[model.slots[a].v] + along(body, a, wrench[k]);
                wrench[k] = wrench[k] - slot.u * (slot.impulse * slot.inverse);
            }
            if (body.parent > 0) wrench[body.parent] += inwards(k, wrench[k]);
        }
        for (int k : bodies) {
            const Body& body = model.bodies[k];
            Spatial<S> own = body.parent > 0 ? outwards(k, jump[body.parent]) : Spatial<S>{};
            for (int a = body.slot; a < body.slot + body.freedoms; ++a) {
                const Freed<S>& slot = slots[a];
                S change = -dot(slot.u, own);
                if (struck[k]) change += slot.impulse;
                change = change * slot.inverse;
                dv[model.slots[a].v] = change;
                add_along(body, a, change, own);
            }
            jump[k] = own;
        }
    }

    // I = τ + Jᵀp (nv) of the wrenches as `respond` takes them; they are used up.
    void collect(const char* struck, const S* tau, S* impulse) {
        for (auto at = bodies.rbegin(); at != bodies.rend(); ++at) {
            const int k = *at;
            const Body& body = model.bodies[k];
            for (int a = body.slot; a < body.slot + body.freedoms; ++a) {
                const int v = model.slots[a].v;
                impulse[v] = tau[v];
                if (struck[k]) impulse[v] += along(body, a, wrench[k]);
            }
            if (body.parent > 0 && struck[k]) wrench[body.parent] += inwards(k, wrench[k]);
        }
    }

  private:
    [[gnu::always_inline]] Turned<S> free_turn(int at, const Articulated<S>& a) {
        Freed<S>& slot = slots[at];
        const Vec3<S> h = a.coupled.z, i{a.angular.xz, a.angular.yz, a.angular.zz};
        slot.u = {h, i};
        slot.inverse = 1.0 / i.z;
        const Vec3<S> p = h * slot.inverse;
        const S x = i.x * slot.inverse, y = i.y * slot.inverse;
        const Sym3<S>& m = a.linear;
        return {{m.xx - p.x * h.x, m.xy - p.x * h.y, m.xz - p.x * h.z, m.yy - p.y * h.y,
                 m.yz - p.y * h.z, m.zz - p.z * h.z},
                a.coupled.x - p * i.x,
                a.coupled.y - p * i.y,
                a.angular.xx - x * i.x,
                a.angular.xy - x * i.y,
                a.angular.yy - y * i.y};
    }

    [[gnu::always_inline]] static Articulated<S> turned_inwards(const Body& body,
                                                                const Stance<S>& to,
                                                                const Turned<S>& left) {
        const Turned<S> a = turned_about_z(left, to.cosine, to.sine);
        const S zero{};
        const double c = body.alpha[0], s = body.alpha[1];
        Articulated<S> b;
        if (body.about_x) {
            const Vec3<S> y = vector_about_x(a.y, c, s);
            const S high = s * a.yy;
            b = {turned_about_x(a.linear, c, s),
                 {vector_about_x(a.x, c, s), y * c, y * s},
                 {a.xx, c * a.xy, s * a.xy, c * c * a.yy, c * high, s * high}};
        } else {
            b = {a.linear, {a.x, a.y, {zero, zero, zero}}, {a.xx, a.xy, zero, a.yy, zero, zero}};
        }
        return body.about_z ? turned_about_z(b, body.beta[0], body.beta[1]) : b;
    }

    // The columns of A as twists; one direction after the other is freed, the last first.
    void free_all(const Body& body, Articulated<S>& a) {
        Mat3<S>& h = a.coupled;
        S A[6][6];
        const S *m = &a.linear.xx, *i = &a.angular.xx;
        const int sym[3][3] = {{0, 1, 2}, {1, 3, 4}, {2, 4, 5}};
        const Vec3<S>* columns[3] = {&h.x, &h.y, &h.z};
        for (int j = 0; j < 3; ++j) {
            const S entries[3] = {columns[j]->x, columns[j]->y, columns[j]->z};
            for (int k = 0; k < 3; ++k) {
                A[k][j] = m[sym[k][j]];
                A[3 + k][3 + j] = i[sym[k][j]];
                A[k][3 + j] = A[3 + j][k] = entries[k];
            }
        }
        for (int at = body.slot + body.freedoms - 1; at >= body.slot; --at) {
            S along_slot[6], u[6];
            const Slot& slot = model.slots[at];
            const int d = slot.direction;
            for (int k = 0; k < 6; ++k) {
                u[k] = A[k][d];
                if (body.pitch != 0.0) u[k] += A[k][2] * body.pitch;
            }
            S size = u[d];
            if (body.pitch != 0.0) size += u[2] * body.pitch;
            Freed<S>& to = slots[at];
            to.u = {{u[0], u[1], u[2]}, {u[3], u[4], u[5]}};
            to.inverse = 1.0 / (size + slot.armature);
            for (int k = 0; k < 6; ++k) along_slot[k] = u[k] * to.inverse;
            for (int k = 0; k < 6; ++k)
                for (int j = 0; j < 6; ++j) A[k][j] = A[k][j] - along_slot[k] * u[j];
            if (body.pitch != 0.0) continue;
            for (int k = 0; k < 6; ++k) A[k][d] = A[d][k] = along_slot[k] * slot.armature;
        }
        a.linear = {A[0][0], A[0][1], A[0][2], A[1][1], A[1][2], A[2][2]};
        h = {{A[0][3], A[1][3], A[2][3]}, {A[0][4], A[1][4], A[2][4]}, {A[0][5], A[1][5], A[2][5]}};
        a.angular = {A[3][3], A[3][4], A[3][5], A[4][4], A[4][5], A[5][5]};
    }

    static Articulated<S> turned_inwards(const Body& body, const Stance<S>& to,
                                         const Articulated<S>& a) {
        if (!body.turns_about_z) {
            const Mat3<S>& r = to.rotation;
            const Mat3<S> k = r * a.coupled;
            // R H Rᵀ: rows of R H against rows of R.
            const Vec3<S> x{k.x.x, k.y.x, k.z.x}, y{k.x.y, k.y.y, k.z.y}, z{k.x.z, k.y.z, k.z.z};
            const Vec3<S> p = r * x, q = r * y, t = r * z;
            return {turned(r, a.linear),
                    {{p.x, q.x, t.x}, {p.y, q.y, t.y}, {p.z, q.z, t.z}},
                    turned(r, a.angular)};
        }
        Articulated<S> b = turned_about_z(a, to.cosine, to.sine);
        if (body.about_x) b = turned_about_x(b, body.alpha[0], body.alpha[1]);
        if (body.about_z) b = turned_about_z(b, body.beta[0], body.beta[1]);
        return b;
    }

    // A vector of a body's axes in those of its parent, and back.
    Vec3<S> turned_inwards(int k, Vec3<S> a) const {
        const Body& body = model.bodies[k];
        const Stance<S>& to = stance[k];
        if (!body.turns_about_z) return to.rotation * a;
        a = vector_about_z(a, to.cosine, to.sine);
        if (body.about_x) a = vector_about_x(a, body.alpha[0], body.alpha[1]);
        if (body.about_z) a = vector_about_z(a, body.beta[0], body.beta[1]);
        return a;
    }

    Vec3<S> turned_outwards(int k, Vec3<S> a) const {
        const Body& body = model.bodies[k];
        const Stance<S>& to = stance[k];
        if (!body.turns_about_z) return back(to.rotation, a);
        if (body.about_z) a = vector_about_z(a, body.beta[0], -body.beta[1]);
        if (body.about_x) a = vector_about_x(a, body.alpha[0], -body.alpha[1]);
        return vector_about_z(a, to.cosine, -to.sine);
    }

    Spatial<S> inwards(int k, const Spatial<S>& f) const {
        const Spatial<S> turned{turned_inwards(k, f.linear), turned_inwards(k, f.angular)};
        return wrench_about(turned, shift_of(model.bodies[k], stance[k]));
    }

    Spatial<S> outwards(int k, const Spatial<S>& v) const {
        const Spatial<S> there = twist_at(v, shift_of(model.bodies[k], stance[k]));
        return {turned_outwards(k, there.linear), turned_outwards(k, there.angular)};
    }

    // s · f, and v + s x.
    S along(const Body& body, int at, const Spatial<S>& f) const {
        const int d = model.slots[at].direction;
        const S own = entry(d < 3 ? f.linear : f.angular, d % 3);
        return body.pitch != 0.0 ? own + f.linear.z * body.pitch : own;
    }

    void add_along(const Body& body, int at, const S& x, Spatial<S>& v) const {
        const int d = model.slots[at].direction;
        entry(d < 3 ? v.linear : v.angular, d % 3) += x;
        if (body.pitch != 0.0) v.linear.z += x * body.pitch;
    }
};

}  // namespace impulsekit
