#include "linalg/dense.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// So many columns of a factorization are done between two counts of its work.
constexpr int kColumns = 64;

}  // namespace

bool factor_lu(double* a, int n, int* pivot) {
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int i = k + 1; i < n; ++i)
            if (std::abs(a[i * n + k]) > std::abs(a[best * n + k])) best = i;
        pivot[k] = best;
        if (k % kColumns == kColumns - 1) poll(n - k, n - k, kColumns);
        if (!(std::abs(a[best * n + k]) > 0.0)) return false;
        if (best != k) std::swap_ranges(a + k * n, a + (k + 1) * n, a + best * n);
        const double* upper = a + k * n;
        double inverse = 1.0 / upper[k];
        for (int i = k + 1; i < n; ++i) {
            double* row = a + i * n;
            double factor = row[k] *= inverse;
            if (factor == 0.0) continue;
            for (int j = k + 1; j < n; ++j) row[j] -= factor * upper[j];
        }
    }
    return true;
}

int factor_pivoted(double* a, int n, int* order, double tolerance) {
    Arena::Scope scope(scratch());
    double *first = scratch().allocate(n), *column = scratch().allocate(n);
    for (int i = 0; i < n; ++i) {
        order[i] = i;
        first[i] = a[i * n + i];
    }
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int i = k + 1; i < n; ++i)
            if (a[i * n + i] * first[best] > a[best * n + best] * first[i]) best = i;
        if (best != k) {
            std::swap(order[k], order[best]);
            std::swap(first[k], first[best]);
            std::swap_ranges(a + k * n, a + (k + 1) * n, a + best * n);
            for (int i = 0; i < n; ++i) std::swap(a[i * n + k], a[i * n + best]);
        }
        if (k % kColumns == kColumns - 1) poll(n - k, n - k, kColumns);
        if (!(a[k * n + k] > tolerance * first[k])) return k;
        const double root = std::sqrt(a[k * n + k]);
        a[k * n + k] = root;
        for (int i = k + 1; i < n; ++i) column[i] = a[i * n + k] /= root;
        for (int i = k + 1; i < n; ++i) {
            double* row = a + i * n;
            const double factor = column[i];
            for (int j = k + 1; j < n; ++j) row[j] -= factor * column[j];
        }
    }
    return n;
}

void solve_pivoted(const double* l, const int* order, int n, int rank, double* x, Arena& arena) {
    Arena::Scope scope(arena);
    double* y = arena.allocate(n);
    for (int i = 0; i < rank; ++i) y[i] = (x[order[i]] - dot(l + i * n, y, i)) / l[i * n + i];
    for (int i = rank - 1; i >= 0; --i) {
        const double* row = l + i * n;
        y[i] /= row[i];
        for (int j = 0; j < i; ++j) y[j] -= row[j] * y[i];
    }
    for (int i = 0; i < n; ++i) x[order[i]] = y[i];
}

void null_projector(const double* l, const int* order, int n, int rank, double* projector,
                    Arena& arena) {
    std::fill(projector, projector + n * n, 0.0);
    const int count = n - rank;
    if (count == 0) return;
    Arena::Scope scope(arena);
    double *basis = arena.allocate(count, n), *own = arena.allocate(n, n);
    // Rows X = (−L₂ L₁⁻¹, 1) of the null space.
    for (int k = 0; k < count; ++k) {
        double* x = basis + k * n;
        x[rank + k] = 1.0;
        for (int i = 0; i < rank; ++i) x[i] = -l[(rank + k) * n + i];
        for (int i = rank - 1; i >= 0; --i) {
            const double* row = l + i * n;
            x[i] /= row[i];
            for (int j = 0; j < i; ++j) x[j] -= row[j] * x[i];
        }
        poll(n, rank);
    }
    // Rows that are nearly dependent are long: orthogonal to the last digit in two rounds.
    for (int k = 0; k < count; ++k) {
        double* x = basis + k * n;
        for (int round = 0; round < 2; ++round)
            for (int j = 0; j < k; ++j) {
                const double* other = basis + j * n;
                const double along = dot(other, x, n);
                for (int i = 0; i < n; ++i) x[i] -= along * other[i];
            }
        const double length = std::sqrt(dot(x, x, n));
        for (int i = 0; i < n; ++i) x[i] /= length;
        poll(n, k);
    }
    for (int k = 0; k < count; ++k) {
        const double* x = basis + k * n;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) own[i * n + j] += x[i] * x[j];
        poll(n, n);
    }
    for (int i = 0; i < n; ++i)
        for (int j = 0; j < n; ++j) projector[order[i] * n + order[j]] = own[i * n + j];
}

double largest(const double* x, int n) {
    double most = 0.0;
    for (int i = 0; i < n; ++i) most = std::max(most, std::abs(x[i]));
    return most;
}

void multiply(const double* a, int n, const double* x, const double* b, double* y) {
    for (int i = 0; i < n; ++i) y[i] = b[i] + dot(a + i * n, x, n);
}

}  // namespace impulsekit
