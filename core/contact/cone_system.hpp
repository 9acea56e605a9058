// The cones' problem in units of its own, and the natural map whose zeros are its answers.
#pragma once

#include <algorithm>
#include <cmath>

#include "contact/cones.hpp"
#include "contact/tolerances.hpp"
#include "linalg/alike.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {

// The used rows alone, each contact and group in units in which its own mobility is 1, velocities
// in units of the largest: then P and ξ have one unit, and the natural map has no parameter.
template <typename S>
struct ConeSystemOf {
    int rows = 0, contacts = 0, groups = 0;
    S* A = nullptr;               // (rows, rows)
    S* mobility = nullptr;        // (rows, rows) A without friction of what slides, symmetric
    S* b = nullptr;               // (rows)
    int* source = nullptr;        // (rows) row of the given problem
    S* unit = nullptr;            // (rows) P_given = unit · P · velocity
    S* mobility_ratio = nullptr;  // (rows) the largest mobility in any direction of a group
    int* normal = nullptr;        // (contacts)
    int* owner = nullptr;         // (contacts) number of the given contact
    S* floor = nullptr;           // (contacts)
    S* adhesion = nullptr;        // (contacts)
    int* first = nullptr;         // (groups)
    int* size = nullptr;          // (groups)
    int* contact = nullptr;       // (groups)
    S* friction = nullptr;        // (groups)
    double* even = nullptr;       // (groups) ones, the balance of what is measured
    double* balance = nullptr;    // (groups) that of steps, which follows them
    S velocity{};
    bool blocked = false;
};

using ConeSystem = ConeSystemOf<double>;

inline double hypotenuse(double a, double b) { return std::hypot(a, b); }
inline Pack hypotenuse(const Pack& a, const Pack& b) {
    Pack c{};
    for (int k = 0; k < kLanes; ++k) c[k] = std::hypot(a[k], b[k]);
    return c;
}

// The larger eigenvalue of two rows of W: unlike its diagonal, the same for whatever tangents.
template <typename S>
S largest_mobility(const S* W, int rows, int i, int j) {
    const S a = W[i * rows + i], b = W[i * rows + j], c = W[j * rows + j];
    return 0.5 * (a + c) + hypotenuse(0.5 * (a - c), b);
}

// W, b, floors and radii of a system in the units of its rows.
template <typename S>
void scale_system(ConeSystemOf<S>& s, const S* W, int rows, const S* b, const S& scale,
                  const ConesOf<S>& cones, Arena& arena) {
    s.A = arena.allocate_of<S>(s.rows * s.rows);
    s.mobility = cones.mobility ? arena.allocate_of<S>(s.rows * s.rows) : s.A;
    const auto in_units = [&](const S* matrix, S* own) {
        for (int i = 0; i < s.rows; ++i)
            for (int j = 0; j < s.rows; ++j)
                own[i * s.rows + j] =
                    s.unit[i] * matrix[s.source[i] * rows + s.source[j]] * s.unit[j];
    };
    in_units(W, s.A);
    if (cones.mobility) in_units(cones.mobility, s.mobility);
    s.b = arena.allocate_of<S>(s.rows);
    S fastest{};
    for (int i = 0; i < s.rows; ++i) {
        s.b[i] = s.unit[i] * b[s.source[i]];
        fastest = larger(larger(fastest, magnitude(s.b[i])), S(s.unit[i] * scale * 1e-3));
    }
    for (int c = 0; c < s.contacts; ++c) {
        s.floor[c] = cones.floor[s.owner[c]] / s.unit[s.normal[c]];
        s.adhesion[c] = cones.adhesion[s.owner[c]] / s.unit[s.normal[c]];
        fastest = larger(fastest, s.floor[c]);
    }
    s.velocity = fastest > 0.0 ? fastest : number<S>(1.0);
    for (int i = 0; i < s.rows; ++i) s.b[i] /= s.velocity;
    for (int c = 0; c < s.contacts; ++c) {
        s.floor[c] /= s.velocity;
        s.adhesion[c] /= s.velocity;
    }
    for (int k = 0; k < s.groups; ++k)
        if (s.contact[k] < 0) s.friction[k] /= s.velocity;
}

template <typename S>
ConeSystemOf<S> build_system(const S* W, int rows, const S* b, const S& scale,
                             const ConesOf<S>& cones, Alike<S>& alike, Arena& arena) {
    ConeSystemOf<S> s;
    const int n = cones.contacts, g = cones.groups;
    s.source = arena.allocate_int(rows);
    s.unit = arena.allocate_of<S>(rows);
    s.mobility_ratio = arena.allocate_of<S>(rows);
    s.normal = arena.allocate_int(n);
    s.owner = arena.allocate_int(n);
    s.floor = arena.allocate_of<S>(n);
    s.adhesion = arena.allocate_of<S>(n);
    s.first = arena.allocate_int(g);
    s.size = arena.allocate_int(g);
    s.contact = arena.allocate_int(g);
    s.friction = arena.allocate_of<S>(g);
    s.even = arena.allocate(g);
    s.balance = arena.allocate(g);
    std::fill(s.even, s.even + g, 1.0);
    std::fill(s.balance, s.balance + g, 1.0);
    S mobility{};
    for (int r = 0; r < rows; ++r) mobility = larger(mobility, W[r * rows + r]);
    const auto moves = [&](int r) { return W[r * rows + r] > tolerance::immovable * mobility; };
    const S one = number<S>(1.0), rounding = tolerance::at_rest * scale;
    int* place = arena.allocate_int(n);
    for (int i = 0; i < n; ++i) {
        int r = cones.normal[i];
        place[i] = -1;
        if (!alike(moves(r))) {
            s.blocked = alike(b[r] < -rounding) || s.blocked;
            continue;
        }
        place[i] = s.contacts;
        s.owner[s.contacts] = i;
        s.normal[s.contacts++] = s.rows;
        s.source[s.rows] = r;
        s.mobility_ratio[s.rows] = one;
        s.unit[s.rows++] = 1.0 / root(W[r * rows + r]);
    }
    for (int k = 0; k < g; ++k) {
        const bool fixed = cones.contact[k] < 0;
        int c = fixed ? -1 : place[cones.contact[k]], kept[2], count = 0;
        if ((c < 0 && !fixed) || !alike(cones.friction[k] > tolerance::negligible)) continue;
        // Rows that move, or slip although no impulse moves them.
        for (int r = cones.first[k]; r < cones.first[k] + cones.size[k]; ++r)
            if (alike(moves(r) | (magnitude(b[r]) > rounding))) kept[count++] = r;
        if (count == 0) continue;
        S own{};
        for (int j = 0; j < count; ++j) own = larger(own, W[kept[j] * rows + kept[j]]);
        // The radius is a share of the normal impulse, or an impulse.
        const S normal_unit = fixed ? one : s.unit[s.normal[c]];
        const S unit = own > 0.0 ? S(1.0 / root(own)) : one;
        s.first[s.groups] = s.rows;
        s.size[s.groups] = count;
        s.contact[s.groups] = c;
        s.friction[s.groups++] = cones.friction[k] * normal_unit / unit;
        const S most = count == 2 ? largest_mobility(W, rows, kept[0], kept[1]) : own;
        for (int j = 0; j < count; ++j) {
            s.source[s.rows] = kept[j];
            s.mobility_ratio[s.rows] = own > 0.0 ? S(most / own) : one;
            s.unit[s.rows++] = unit;
        }
    }
    scale_system(s, W, rows, b, scale, cones, arena);
    return s;
}

inline ConeSystem build_system(const double* W, int rows, const double* b, double scale,
                               const Cones& cones, Arena& arena) {
    Alike<double> alike;
    return build_system(W, rows, b, scale, cones, alike, arena);
}

template <typename S>
S hypot_of(const S* x, int size) {
    return size == 1 ? magnitude(x[0]) : root(S(x[0] * x[0] + x[1] * x[1]));
}

// The largest |P_g| of a group: µ times A and the normal impulse that P − ξ is projected to.
template <typename S>
S radius_of(const ConeSystemOf<S>& s, int group, const S* P, const S* xi) {
    const int c = s.contact[group];
    if (c < 0) return s.friction[group];
    const int n = s.normal[c];
    return s.friction[group] * (larger(s.floor[c], S(P[n] - xi[n])) + s.adhesion[c]);
}

// F of the natural map (Alart & Curnier 1991): P − Π(P − ρ ξ), zero where P obeys the law. ρ > 0
// is 1 along normals, and of each group that of `balance` (groups).
template <typename S>
void natural_map_residual(const ConeSystemOf<S>& s, const double* balance, const S* P, const S* xi,
                          S* F) {
    for (int c = 0; c < s.contacts; ++c) {
        int r = s.normal[c];
        F[r] = P[r] - larger(s.floor[c], S(P[r] - xi[r]));
    }
    for (int k = 0; k < s.groups; ++k) {
        int r = s.first[k], size = s.size[k];
        const double rho = balance[k];
        S radius = radius_of(s, k, P, xi), trial[2] = {};
        for (int j = 0; j < size; ++j) trial[j] = P[r + j] - rho * xi[r + j];
        const S length = hypot_of(trial, size);
        for (int j = 0; j < size; ++j)
            F[r + j] =
                length <= radius ? S(rho * xi[r + j]) : S(P[r + j] - radius * trial[j] / length);
    }
}

// A derivative of F by P, with `A` the matrix of ξ.
void natural_map_jacobian(const ConeSystem& s, const double* A, const double* balance,
                          const double* P, const double* xi, double* J);

// The largest entry of F in units of the largest velocity: where no answer is, impulses grow until
// what is left is nothing beside them, but not beside the velocities.
template <typename S>
S residual_of(const ConeSystemOf<S>& s, const S* P, Arena& arena) {
    Arena::Scope scope(arena);
    S *xi = arena.allocate_of<S>(s.rows), *F = arena.allocate_of<S>(s.rows);
    multiply(s.A, s.rows, P, s.b, xi);
    natural_map_residual(s, s.even, P, xi, F);
    return largest(F, s.rows);
}

}  // namespace impulsekit
