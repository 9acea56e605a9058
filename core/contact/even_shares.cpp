#include "contact/even_shares.hpp"

#include <algorithm>
#include <cmath>

#include "contact/rigid_limit.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Compliances that are tried beside the first, each a share of the one before.
constexpr int kRounds = 4;
constexpr double kFall = 1e-2;

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

// Rows that would act if all that approaches or adheres stuck; `xi` as impulses at floors above
// zero leave it, against which what is pressed sticks too.
int acting_rows(const ConeSystem& s, const double* xi, int* held) {
    int count = 0;
    const auto acts = [&](int c) { return xi[s.normal[c]] < 0.0 || s.adhesion[c] > 0.0; };
    for (int c = 0; c < s.contacts; ++c)
        if (acts(c)) held[count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k)
        if (s.contact[k] < 0 || acts(s.contact[k]) || s.floor[s.contact[k]] > 0.0)
            for (int j = 0; j < s.size[k]; ++j) held[count++] = s.first[k] + j;
    return count;
}

void factor_held(const ConeSystem& s, Held& held, Arena& arena) {
    const int n = held.count;
    for (int i = 0; i < n; ++i) held.root[i] = std::sqrt(s.mobility_ratio[held.rows[i]]);
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            held.factor[i * n + j] =
                s.mobility[held.rows[i] * s.rows + held.rows[j]] / (held.root[i] * held.root[j]);
    held.rank = factor_pivoted(held.factor, n, held.order, tolerance::dependent);
    null_projector(held.factor, held.order, n, held.rank, held.projector, arena);
    held.is_factored = true;
}

// P of all held rows sticking, from a P and its ξ. Of what can be shared it is the least in the
// metric D, of equally stiff springs.
void stick(const Held& held, const double* xi, double* P, Arena& arena) {
    Arena::Scope scope(arena);
    const int n = held.count;
    double* x = arena.allocate(n);
    for (int i = 0; i < n; ++i) x[i] = -xi[held.rows[i]] / held.root[i];
    solve_pivoted(held.factor, held.order, n, held.rank, x, arena);
    for (int i = 0; i < n; ++i) x[i] += held.root[i] * P[held.rows[i]];
    for (int i = 0; i < n; ++i) {
        const double shared = held.is_redundant() ? dot(held.projector + i * n, x, n) : 0.0;
        P[held.rows[i]] = (x[i] - shared) / held.root[i];
    }
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

// Rows that are still in the limit of rigidity: their velocities fall with the compliance from that
// of `softer` to that of P, by `kFall`, and others stay.
void find_still(const ConeSystem& s, const double* softer, const double* P, double compliance,
                Held& held, Arena& arena) {
    Arena::Scope scope(arena);
    double *before = arena.allocate(s.rows), *now = arena.allocate(s.rows);
    multiply(s.A, s.rows, softer, s.b, before);
    multiply(s.A, s.rows, P, s.b, now);
    const double rounding = tolerance::solved * largest(P, s.rows), fall = std::sqrt(kFall);
    const auto is_still = [&](int r, int size) {
        return hypot_of(now + r, size) <= fall * hypot_of(before + r, size) + rounding;
    };
    held.count = 0;
    for (int c = 0; c < s.contacts; ++c)
        if (is_still(s.normal[c], 1)) held.rows[held.count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k) {
        const int r = s.first[k], c = s.contact[k], n = c < 0 ? -1 : s.normal[c];
        const double soft = n < 0 ? 0.0 : now[n] + compliance * s.mobility_ratio[n] * P[n];
        const bool is_loaded = n < 0 || P[n] - soft + s.adhesion[c] > 0.0;
        if (is_loaded && is_still(r, s.size[k]))
            for (int j = 0; j < s.size[k]; ++j) held.rows[held.count++] = r + j;
    }
}

}  // namespace

bool solve_from_sticking(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    double* xi = arena.allocate(s.rows);
    for (int c = 0; c < s.contacts; ++c) P[s.normal[c]] = std::max(s.floor[c], 0.0);
    multiply(s.A, s.rows, P, s.b, xi);
    held.count = acting_rows(s, xi, held.rows);
    factor_held(s, held, arena);
    stick(held, xi, P, arena);
    const bool is_redundant = held.is_redundant();
    if (!is_redundant && !newton(s, s.A, P, steps, arena)) return false;
    multiply(s.A, s.rows, P, s.b, xi);
    return holds_as_thought(s, P, xi, held, arena) &&
           (!is_redundant || residual_of(s, P, arena) <= tolerance::at_rest);
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
    double *soft = arena.allocate(m, m), *softer = arena.allocate(m), *firm = arena.allocate(m);
    double compliance = tolerance::compliance;
    add_to_diagonal(s, compliance, soft);
    bool solved = solve_from(s, soft, P, steps, arena);
    // If redundant rows contradict each other, a smaller compliance tells which gives way.
    for (int round = 0; round < kRounds; ++round) {
        std::copy(P, P + m, softer);
        compliance *= kFall;
        add_to_diagonal(s, compliance, soft);
        solved = solve_from(s, soft, P, steps, arena);
        std::copy(P, P + m, firm);
        find_still(s, softer, P, compliance, held, arena);
        factor_held(s, held, arena);
        if (solve_rigid_limit(s, compliance, held.rows, held.count, held.projector, P, steps,
                              arena) &&
            residual_of(s, P, arena) <= tolerance::at_rest)
            return true;
        std::copy(firm, firm + m, P);
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
    if (!is_noisy) return;
    // Noise is in the sticking answer, too.
    std::fill(P, P + s.rows, 0.0);
    solve_redundant(clear, held, P, steps, arena);
}

}  // namespace impulsekit
