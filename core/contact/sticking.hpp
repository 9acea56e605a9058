// The first trial of the cones' problem: all that acts sticks, by one factorization. Of one state,
// or of eight side by side that act alike.
#pragma once

#include "contact/cone_newton.hpp"
#include "linalg/pivoted.hpp"

namespace impulsekit {

// Held rows, and the pivoted factor of their D^-½ A D^-½, D the shares of a compliance.
template <typename S>
struct HeldRowsOf {
    int count = 0, rank = 0;
    bool is_factored = false;  // the factor is that of these rows
    int *rows = nullptr, *order = nullptr;
    S *root = nullptr, *factor = nullptr;  // D^½ (count), (count, count)
    S* projector = nullptr;                // (count, count) N onto its null space

    HeldRowsOf(const ConeSystemOf<S>& s, Arena& arena)
        : rows(arena.allocate_int(s.rows)),
          order(arena.allocate_int(s.rows * Number<S>::lanes)),
          root(arena.allocate_of<S>(s.rows)),
          factor(arena.allocate_of<S>(s.rows * s.rows)),
          projector(arena.allocate_of<S>(s.rows * s.rows)) {}

    bool is_redundant() const { return rank < count; }
};

using HeldRows = HeldRowsOf<double>;

// Rows that P − ξ holds: normals above their floors, and groups within their cones; with those that
// rounding of P by `slack` would hold. States side by side must hold `expected` (rows).
template <typename S>
int held_rows(const ConeSystemOf<S>& s, const S* P, const S* xi, double slack, const char* expected,
              int* held, Alike<S>& alike) {
    int count = 0;
    for (int c = 0; c < s.contacts; ++c) {
        const int r = s.normal[c];
        if (alike.expect(P[r] - xi[r] > s.floor[c] - slack, expected[r])) held[count++] = r;
    }
    for (int k = 0; k < s.groups; ++k) {
        const int r = s.first[k];
        const S radius = radius_of(s, k, P, xi);
        S trial[2] = {};
        for (int j = 0; j < s.size[k]; ++j) trial[j] = P[r + j] - xi[r + j];
        const auto is_within = (radius > 0.0) & (hypot_of(trial, s.size[k]) <= radius + slack);
        if (alike.expect(is_within, expected[r]))
            for (int j = 0; j < s.size[k]; ++j) held[count++] = r + j;
    }
    return count;
}

// Rows that would act if all that approaches or adheres stuck; `xi` as impulses at floors above
// zero leave it, against which what is pressed sticks too.
template <typename S>
int acting_rows(const ConeSystemOf<S>& s, const S* xi, int* held, Alike<S>& alike) {
    int count = 0;
    const auto acts = [&](int c) { return (xi[s.normal[c]] < 0.0) | (s.adhesion[c] > 0.0); };
    for (int c = 0; c < s.contacts; ++c)
        if (alike(acts(c))) held[count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k) {
        const int c = s.contact[k];
        if (c < 0 || alike(acts(c) | (s.floor[c] > 0.0)))
            for (int j = 0; j < s.size[k]; ++j) held[count++] = s.first[k] + j;
    }
    return count;
}

template <typename S>
void factor_held(const ConeSystemOf<S>& s, HeldRowsOf<S>& held, Alike<S>& alike, Arena& arena) {
    const int n = held.count;
    for (int i = 0; i < n; ++i) held.root[i] = root(s.mobility_ratio[held.rows[i]]);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            held.factor[i * n + j] =
                s.mobility[held.rows[i] * s.rows + held.rows[j]] / (held.root[i] * held.root[j]);
    held.rank = factor_pivoted(held.factor, n, held.order, tolerance::dependent, alike);
    null_projector(held.factor, held.order, n, held.rank, held.projector, arena);
    held.is_factored = true;
}

// P of all held rows sticking, from a P and its ξ. Of what can be shared it is the least in the
// metric D, of equally stiff springs.
template <typename S>
void stick(const HeldRowsOf<S>& held, const S* xi, S* P, Arena& arena) {
    Arena::Scope scope(arena);
    const int n = held.count;
    S* x = arena.allocate_of<S>(n);
    for (int i = 0; i < n; ++i) x[i] = -xi[held.rows[i]] / held.root[i];
    solve_pivoted(held.factor, held.order, n, held.rank, x, arena);
    for (int i = 0; i < n; ++i) x[i] += held.root[i] * P[held.rows[i]];
    for (int i = 0; i < n; ++i) {
        const S shared = held.is_redundant() ? dot(held.projector + i * n, x, n) : S{};
        P[held.rows[i]] = (x[i] - shared) / held.root[i];
    }
}

// (rows) 1 where a row is held.
template <typename S>
const char* marked(const ConeSystemOf<S>& s, const HeldRowsOf<S>& held, Arena& arena) {
    char* is_held = arena.allocate_of<char>(s.rows);
    for (int i = 0; i < held.count; ++i) is_held[held.rows[i]] = 1;
    return is_held;
}

// True if a P holds what it was thought to, a part of which is of full rank as the whole is; then
// `held` has what it holds.
template <typename S>
bool holds_as_thought(const ConeSystemOf<S>& s, const S* P, const S* xi, HeldRowsOf<S>& held,
                      Alike<S>& alike, Arena& arena) {
    Arena::Scope scope(arena);
    int* before = arena.allocate_int(held.count);
    const int count = held.count;
    std::copy(held.rows, held.rows + count, before);
    held.count = held_rows(s, P, xi, 0.0, marked(s, held, arena), held.rows, alike);
    int* end = held.rows + held.count;
    held.is_factored = held.count == count && std::equal(held.rows, end, before);
    return held.is_factored ||
           (held.rank == count && std::includes(before, before + count, held.rows, end));
}

// P by one factorization where all that acts sticks; of one state Newton's method goes on from
// there if rows are of full rank. False where neither is the answer.
template <typename S>
bool solve_from_sticking(const ConeSystemOf<S>& s, HeldRowsOf<S>& held, S* P, int& steps,
                         Alike<S>& alike, Arena& arena) {
    Arena::Scope scope(arena);
    S *xi = arena.allocate_of<S>(s.rows), *F = arena.allocate_of<S>(s.rows);
    for (int c = 0; c < s.contacts; ++c) P[s.normal[c]] = larger(s.floor[c], S{});
    multiply(s.A, s.rows, P, s.b, xi);
    held.count = acting_rows(s, xi, held.rows, alike);
    factor_held(s, held, alike, arena);
    stick(held, xi, P, arena);
    const bool is_redundant = held.is_redundant();
    multiply(s.A, s.rows, P, s.b, xi);
    if (!is_redundant) {
        natural_map_residual(s, s.even, P, xi, F);
        const bool is_zero = alike.keep(is_rounding(S(dot(F, F, s.rows)), P, s.rows));
        if constexpr (Number<S>::lanes == 1) {
            if (!is_zero && !newton(s, s.A, P, steps, arena)) return false;
            if (!is_zero) multiply(s.A, s.rows, P, s.b, xi);
        } else if (!is_zero) {
            return false;
        }
    }
    return holds_as_thought(s, P, xi, held, alike, arena) &&
           (!is_redundant || alike.keep(residual_of(s, P, arena) <= tolerance::at_rest));
}

// (rows) the square of each held row in the null space of all of them: what can be shared
// otherwise. What touches without load could bear some.
template <typename S>
void find_shares(const ConeSystemOf<S>& s, const S* P, HeldRowsOf<S>& held, S* shares,
                 Alike<S>& alike, Arena& arena) {
    Arena::Scope scope(arena);
    S* xi = arena.allocate_of<S>(s.rows);
    int* touching = arena.allocate_int(s.rows);
    multiply(s.A, s.rows, P, s.b, xi);
    const int count =
        held_rows(s, P, xi, tolerance::at_rest, marked(s, held, arena), touching, alike);
    if (!held.is_factored ||
        !std::equal(touching, touching + count, held.rows, held.rows + held.count)) {
        std::copy(touching, touching + count, held.rows);
        held.count = count;
        factor_held(s, held, alike, arena);
    }
    for (int i = 0; i < count; ++i) shares[touching[i]] = held.projector[i * count + i];
}

}  // namespace impulsekit
