// Small dense linear algebra, row-major: what contact laws need and no more.
#pragma once

#include <utility>

#include "linalg/arena.hpp"
#include "linalg/numbers.hpp"

namespace impulsekit {

// LU with partial pivoting in place; false where a pivot is zero.
bool factor_lu(double* a, int n, int* pivot);

// Σ term(i), in four sums side by side: one alone would wait for each addition.
template <typename Term>
auto sum_of(int n, Term term) {
    decltype(term(0)) total[4] = {};
    int i = 0;
    for (; i + 4 <= n; i += 4)
        for (int k = 0; k < 4; ++k) total[k] += term(i + k);
    for (; i < n; ++i) total[0] += term(i);
    return (total[0] + total[1]) + (total[2] + total[3]);
}

// Solve with the factors of `factor_lu`, in place; of eight sets of numbers side by side, too.
template <typename S>
void solve_lu(const double* lu, const int* pivot, int n, S* x) {
    const auto subtract = [&](int i, int from, int to) {
        const double* row = lu + i * n;
        x[i] -= sum_of(to - from, [&](int j) -> S { return row[from + j] * x[from + j]; });
    };
    for (int k = 0; k < n; ++k) std::swap(x[k], x[pivot[k]]);
    for (int i = 0; i < n; ++i) subtract(i, 0, i);
    for (int i = n - 1; i >= 0; --i) {
        subtract(i, i + 1, n);
        x[i] /= lu[i * n + i];
    }
}

template <typename S>
S dot(const S* x, const S* y, int n) {
    return sum_of(n, [&](int i) -> S { return x[i] * y[i]; });
}

// Σ |x_i| y_i.
template <typename S>
S dot_of_sizes(const S* x, const S* y, int n) {
    return sum_of(n, [&](int i) -> S { return magnitude(x[i]) * y[i]; });
}

template <typename S>
S largest(const S* x, int n) {
    S most{};
    for (int i = 0; i < n; ++i) most = larger(most, magnitude(x[i]));
    return most;
}

// y += rowsᵀ x, of (count, nv) rows.
template <typename S>
void add_transposed(const S* rows, int count, int nv, const S* x, S* y) {
    for (int r = 0; r < count; ++r) {
        if (!any(x[r] != 0.0)) continue;
        const S* row = rows + r * nv;
        for (int k = 0; k < nv; ++k) y[k] += x[r] * row[k];
    }
}

// y = A x + b.
template <typename S>
void multiply(const S* a, int n, const S* x, const S* b, S* y) {
    for (int i = 0; i < n; ++i) y[i] = b[i] + dot(a + i * n, x, n);
}

}  // namespace impulsekit
