#include "contact/even_shares.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

constexpr int kProximalSteps = 8, kHeldRounds = 2;

// Rows that P − ξ holds: normals above their floors, and groups within their cones; with those that
// rounding of P by `slack` would hold.
int held_rows(const ConeSystem& s, const double* P, const double* xi, double slack, int* held) {
    int count = 0;
    for (int c = 0; c < s.contacts; ++c)
        if (P[s.normal[c]] - xi[s.normal[c]] > s.floor[c] - slack) held[count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k) {
        const int r = s.first[k];
        const double radius = radius_of(s, k, P, xi);
        double trial[2];
        for (int j = 0; j < s.size[k]; ++j) trial[j] = P[r + j] - xi[r + j];
        if (radius > 0.0 && hypot_of(trial, s.size[k]) <= radius + slack)
            for (int j = 0; j < s.size[k]; ++j) held[count++] = r + j;
    }
    return count;
}

// Rows that would act if all that approaches or adheres stuck.
int acting_rows(const ConeSystem& s, int* held) {
    int count = 0;
    const auto acts = [&](int c) {
        return s.b[s.normal[c]] < 0.0 || s.floor[c] > 0.0 || s.adhesion[c] > 0.0;
    };
    for (int c = 0; c < s.contacts; ++c)
        if (acts(c)) held[count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k)
        if (s.contact[k] < 0 || acts(s.contact[k]))
            for (int j = 0; j < s.size[k]; ++j) held[count++] = s.first[k] + j;
    return count;
}

void factor_held(const ConeSystem& s, Held& held, Arena& arena) {
    const int n = held.count;
    for (int i = 0; i < n; ++i) held.root[i] = std::sqrt(s.mobility_ratio[held.rows[i]]);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            held.factor[i * n + j] =
                s.A[held.rows[i] * s.rows + held.rows[j]] / (held.root[i] * held.root[j]);
    held.rank = factor_pivoted(held.factor, n, held.order, tolerance::dependent);
    null_projector(held.factor, held.order, n, held.rank, held.projector, arena);
    held.is_factored = true;
}

// P of all held rows sticking. Of what can be shared it is the least in the metric D, of equally
// stiff springs.
void stick(const ConeSystem& s, const Held& held, double* P, Arena& arena) {
    Arena::Scope scope(arena);
    const int n = held.count;
    double* x = arena.allocate(n);
    for (int i = 0; i < n; ++i) x[i] = -s.b[held.rows[i]] / held.root[i];
    solve_pivoted(held.factor, held.order, n, held.rank, x, arena);
    for (int i = 0; i < n; ++i) {
        const double shared = held.is_redundant() ? dot(held.projector + i * n, x, n) : 0.0;
        P[held.rows[i]] = (x[i] - shared) / held.root[i];
    }
}

// True if all groups at the edges of their cones slip by more than `slack`. In the limit of g → 0
// some may stay: their slip is of the order of g, and its direction is not to be seen in ξ.
bool edges_slip(const ConeSystem& s, const double* P, const double* xi, double slack) {
    for (int k = 0; k < s.groups; ++k) {
        const double radius = radius_of(s, k, P, xi), edge = radius - slack;
        if (radius > 0.0 && hypot_of(P + s.first[k], s.size[k]) >= edge &&
            hypot_of(xi + s.first[k], s.size[k]) <= slack)
            return false;
    }
    return true;
}

// True if a P holds what it was thought to, a part of which is of full rank as the whole is; then
// `held` has what it holds.
bool holds_as_thought(const ConeSystem& s, const double* P, const double* xi, Held& held,
                      Arena& arena) {
    Arena::Scope scope(arena);
    int* before = arena.allocate_int(held.count);
    const int count = held.count;
    std::copy(held.rows, held.rows + count, before);
    held.count = held_rows(s, P, xi, 0.0, held.rows);
    int* end = held.rows + held.count;
    held.is_factored = held.count == count && std::equal(held.rows, end, before);
    return held.is_factored ||
           (held.rank == count && std::includes(before, before + count, held.rows, end));
}

// P by Newton's method on ξ + D^½ N D^½ P with N of what is held. Where it is zero both parts are,
// for they are at right angles: P is the answer of A + g D in the limit g → 0, of equally stiff
// springs. False where held rows do not come to be those thought of, or contradict each other.
bool solve_evenly(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    double *even = arena.allocate(m, m), *xi = arena.allocate(m);
    for (int round = 0; round < kHeldRounds; ++round) {
        const int n = held.count;
        factor_held(s, held, arena);
        std::copy(s.A, s.A + m * m, even);
        for (int i = 0; i < n && held.is_redundant(); ++i)
            for (int j = 0; j < n; ++j)
                even[held.rows[i] * m + held.rows[j]] +=
                    held.root[i] * held.projector[i * n + j] * held.root[j];
        if (!newton(s, even, P, steps, arena)) return false;
        multiply(even, m, P, s.b, xi);
        const bool is_redundant = held.is_redundant();
        if (holds_as_thought(s, P, xi, held, arena))
            return !is_redundant || (edges_slip(s, P, xi, tolerance::at_rest) &&
                                     residual_of(s, P, arena) <= tolerance::at_rest);
    }
    return false;
}

}  // namespace

bool solve_from_sticking(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    double* xi = arena.allocate(s.rows);
    held.count = acting_rows(s, held.rows);
    factor_held(s, held, arena);
    stick(s, held, P, arena);
    const bool is_redundant = held.is_redundant();
    if (!is_redundant && !newton(s, s.A, P, steps, arena)) return false;
    multiply(s.A, s.rows, P, s.b, xi);
    if (holds_as_thought(s, P, xi, held, arena))
        return !is_redundant || residual_of(s, P, arena) <= tolerance::at_rest;
    return !is_redundant && solve_evenly(s, held, P, steps, arena);
}

void find_shares(const ConeSystem& s, const double* P, Held& held, double* shares, Arena& arena) {
    Arena::Scope scope(arena);
    double* xi = arena.allocate(s.rows);
    int* touching = arena.allocate_int(s.rows);
    multiply(s.A, s.rows, P, s.b, xi);
    const int count = held_rows(s, P, xi, tolerance::at_rest, touching);
    if (!held.is_factored ||
        !std::equal(touching, touching + count, held.rows, held.rows + held.count)) {
        std::copy(touching, touching + count, held.rows);
        held.count = count;
        factor_held(s, held, arena);
    }
    for (int i = 0; i < count; ++i) shares[touching[i]] = held.projector[i * count + i];
}

bool solve_redundant(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    double *soft = arena.allocate(m, m), *softer = arena.allocate(m), *xi = arena.allocate(m);
    held.is_factored = false;
    add_to_diagonal(s, 2.0 * tolerance::compliance, soft);
    bool solved = solve_from(s, soft, P, steps, arena);
    std::copy(P, P + m, softer);
    multiply(soft, m, P, s.b, xi);
    held.count = held_rows(s, P, xi, 0.0, held.rows);
    multiply(s.A, m, P, s.b, xi);
    if (edges_slip(s, P, xi, std::sqrt(tolerance::compliance))) {
        if (solve_evenly(s, held, P, steps, arena)) return true;
        std::copy(softer, softer + m, P);
    }
    add_to_diagonal(s, tolerance::compliance, soft);
    solved = solve_from(s, soft, P, steps, arena) && solved;
    for (int i = 0; i < m; ++i) P[i] = 2.0 * P[i] - softer[i];
    ConeSystem step = s;
    step.b = arena.allocate(m);
    // If redundant rows contradict each other, a smaller compliance tells sooner which gives way.
    double compliance = tolerance::compliance;
    for (int count = 0; count < kProximalSteps; ++count, compliance *= 0.1) {
        for (int i = 0; i < m; ++i) step.b[i] = s.b[i] - compliance * s.mobility_ratio[i] * P[i];
        add_to_diagonal(s, compliance, soft);
        solved = solve_from(step, soft, P, steps, arena);
        if (residual_of(s, P, arena) <= tolerance::rounding * m) break;
    }
    return solved;
}

void start_without_noise(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    ConeSystem clear = s;
    clear.b = arena.allocate(s.rows);
    const double noise = tolerance::at_rest * largest(s.b, s.rows);
    bool is_noisy = false;
    for (int i = 0; i < s.rows; ++i) {
        const bool is_noise = s.b[i] != 0.0 && std::abs(s.b[i]) < noise;
        clear.b[i] = is_noise ? 0.0 : s.b[i];
        is_noisy = is_noisy || is_noise;
    }
    if (is_noisy) solve_redundant(clear, held, P, steps, arena);
}

}  // namespace impulsekit
