// The pivoted Cholesky factorization of one matrix, or of eight side by side, and its null space.
#pragma once

#include <algorithm>
#include <utility>

#include "linalg/alike.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {

// Entry x[at] of each state, `at` (states).
template <typename S>
S gathered(const S* x, const int* at) {
    S y{};
    for (int l = 0; l < Number<S>::lanes; ++l) Number<S>::set(y, l, Number<S>::get(x[at[l]], l));
    return y;
}

// Swap a number of one state with another.
template <typename S>
void swap_lane(S& x, S& y, int lane) {
    const double kept = Number<S>::get(x, lane);
    Number<S>::set(x, lane, Number<S>::get(y, lane));
    Number<S>::set(y, lane, kept);
}

// Pivoted Cholesky of a symmetric positive semidefinite matrix in place: P A Pᵀ = L Lᵀ, L in the
// lower triangle, its row i that of row order[i] of A; `order` (n, states). Returns the rank:
// pivots above `tolerance` times the diagonal that the row had at first.
template <typename S>
int factor_pivoted(S* a, int n, int* order, double tolerance, Alike<S>& alike) {
    using Bits = typename Number<S>::Bits;
    constexpr int lanes = Number<S>::lanes, columns = 64;  // between two counts of work
    Arena::Scope scope(scratch());
    S *first = scratch().allocate_of<S>(n), *column = scratch().allocate_of<S>(n);
    for (int i = 0; i < n; ++i) {
        std::fill(order + i * lanes, order + (i + 1) * lanes, i);
        first[i] = a[i * n + i];
    }
    for (int k = 0; k < n; ++k) {
        Bits best = Bits{} + k;
        S most = a[k * n + k], of = first[k];
        for (int i = k + 1; i < n; ++i) {
            const S own = a[i * n + i];
            const auto is_better = own * of > most * first[i];
            best = is_better ? Bits{} + i : best;
            most = is_better ? own : most;
            of = is_better ? first[i] : of;
        }
        for (int l = 0; l < lanes; ++l) {
            const int at = static_cast<int>(Number<S>::bit(best, l));
            if (at == k) continue;
            std::swap(order[k * lanes + l], order[at * lanes + l]);
            swap_lane(first[k], first[at], l);
            for (int j = 0; j < n; ++j) swap_lane(a[k * n + j], a[at * n + j], l);
            for (int i = k; i < n; ++i) swap_lane(a[i * n + k], a[i * n + at], l);
        }
        if (k % columns == columns - 1) poll(n - k, n - k, columns);
        if (!alike(a[k * n + k] > tolerance * first[k])) return k;
        const S pivot = root(a[k * n + k]);
        a[k * n + k] = pivot;
        for (int i = k + 1; i < n; ++i) column[i] = a[i * n + k] /= pivot;
        for (int i = k + 1; i < n; ++i) {
            S* row = a + i * n;
            const S factor = column[i];
            for (int j = k + 1; j < n; ++j) row[j] -= factor * column[j];
        }
    }
    return n;
}

inline int factor_pivoted(double* a, int n, int* order, double tolerance) {
    Alike<double> alike;
    return factor_pivoted(a, n, order, tolerance, alike);
}

// Solve A x = b in place: x of the first rows of a factor, as many as its rank, and zeros.
template <typename S>
void solve_pivoted(const S* l, const int* order, int n, int rank, S* x, Arena& arena) {
    constexpr int lanes = Number<S>::lanes;
    Arena::Scope scope(arena);
    S* y = arena.allocate_of<S>(n);
    for (int i = 0; i < rank; ++i)
        y[i] = (gathered(x, order + i * lanes) - dot(l + i * n, y, i)) / l[i * n + i];
    for (int i = rank - 1; i >= 0; --i) {
        const S* row = l + i * n;
        y[i] /= row[i];
        for (int j = 0; j < i; ++j) y[j] -= row[j] * y[i];
    }
    for (int i = 0; i < n; ++i)
        for (int k = 0; k < lanes; ++k)
            Number<S>::set(x[order[i * lanes + k]], k, Number<S>::get(y[i], k));
}

// (n, n) the orthogonal projector onto the null space of A, from its pivoted factor.
template <typename S>
void null_projector(const S* l, const int* order, int n, int rank, S* projector, Arena& arena) {
    constexpr int lanes = Number<S>::lanes;
    std::fill(projector, projector + n * n, S{});
    const int count = n - rank;
    if (count == 0) return;
    Arena::Scope scope(arena);
    S *basis = arena.allocate_of<S>(count * n), *own = arena.allocate_of<S>(n * n);
    // Rows X = (−L₂ L₁⁻¹, 1) of the null space.
    for (int k = 0; k < count; ++k) {
        S* x = basis + k * n;
        x[rank + k] = number<S>(1.0);
        for (int i = 0; i < rank; ++i) x[i] = -l[(rank + k) * n + i];
        for (int i = rank - 1; i >= 0; --i) {
            const S* row = l + i * n;
            x[i] /= row[i];
            for (int j = 0; j < i; ++j) x[j] -= row[j] * x[i];
        }
        poll(n, rank);
    }
    // Rows that are nearly dependent are long: orthogonal to the last digit in two rounds.
    for (int k = 0; k < count; ++k) {
        S* x = basis + k * n;
        for (int round = 0; round < 2; ++round)
            for (int j = 0; j < k; ++j) {
                const S* other = basis + j * n;
                const S along = dot(other, x, n);
                for (int i = 0; i < n; ++i) x[i] -= along * other[i];
            }
        const S length = root(dot(x, x, n));
        for (int i = 0; i < n; ++i) x[i] /= length;
        poll(n, k);
    }
    for (int k = 0; k < count; ++k) {
        const S* x = basis + k * n;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) own[i * n + j] += x[i] * x[j];
        poll(n, n);
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j)
            for (int k = 0; k < lanes; ++k)
                Number<S>::set(projector[order[i * lanes + k] * n + order[j * lanes + k]], k,
                               Number<S>::get(own[i * n + j], k));
}

}  // namespace impulsekit
