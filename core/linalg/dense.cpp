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
    double* first = scratch().allocate(n);
    for (int i = 0; i < n; ++i) {
        order[i] = i;
        first[i] = a[i * n + i];
    }
    // Rows and columns stay where they are: row order[i] of `a` holds row i of L.
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int i = k + 1; i < n; ++i) {
            int r = order[i], s = order[best];
            if (a[r * n + r] * first[s] > a[s * n + s] * first[r]) best = i;
        }
        std::swap(order[k], order[best]);
        if (k % kColumns == kColumns - 1) poll(n - k, n - k, kColumns);
        int p = order[k];
        if (!(a[p * n + p] > tolerance * first[p])) return k;
        double root = std::sqrt(a[p * n + p]);
        a[p * n + p] = root;
        for (int i = k + 1; i < n; ++i) a[order[i] * n + p] /= root;
        for (int i = k + 1; i < n; ++i) {
            double* row = a + order[i] * n;
            double factor = row[p];
            for (int j = k + 1; j < n; ++j) row[order[j]] -= factor * a[order[j] * n + p];
        }
    }
    return n;
}

void solve_pivoted(const double* l, const int* order, int n, double* x, Arena& arena) {
    Arena::Scope scope(arena);
    double* y = arena.allocate(n);
    for (int i = 0; i < n; ++i) {
        const double* row = l + order[i] * n;
        double total = x[order[i]];
        for (int j = 0; j < i; ++j) total -= row[order[j]] * y[j];
        y[i] = total / row[order[i]];
    }
    for (int i = n - 1; i >= 0; --i) {
        double total = y[i];
        for (int j = i + 1; j < n; ++j) total -= l[order[j] * n + order[i]] * x[order[j]];
        x[order[i]] = total / l[order[i] * n + order[i]];
    }
}

void null_projector(const double* l, const int* order, int n, int rank, double* projector,
                    Arena& arena) {
    std::fill(projector, projector + n * n, 0.0);
    int count = n - rank;
    if (count == 0) return;
    Arena::Scope scope(arena);
    double* basis = arena.allocate(count, n);
    for (int k = 0; k < count; ++k) {
        double* x = basis + k * n;
        x[order[rank + k]] = 1.0;
        // L₁ᵀ x₁ = −L₂ᵀ x₂
        for (int i = rank - 1; i >= 0; --i) {
            double total = -l[order[rank + k] * n + order[i]];
            for (int j = i + 1; j < rank; ++j) total -= l[order[j] * n + order[i]] * x[order[j]];
            x[order[i]] = total / l[order[i] * n + order[i]];
        }
        for (int round = 0; round < 2; ++round)
            for (int j = 0; j < k; ++j) {
                const double* other = basis + j * n;
                double along = dot(other, x, n);
                for (int i = 0; i < n; ++i) x[i] -= along * other[i];
            }
        double length = std::sqrt(dot(x, x, n));
        for (int i = 0; i < n; ++i) x[i] /= length;
        poll(n, rank + k);
    }
    for (int k = 0; k < count; ++k) {
        const double* x = basis + k * n;
        for (int i = 0; i < n; ++i)
            for (int j = 0; j < n; ++j) projector[i * n + j] += x[i] * x[j];
        poll(n, n);
    }
}

double dot(const double* x, const double* y, int n) {
    double total = 0.0;
    for (int i = 0; i < n; ++i) total += x[i] * y[i];
    return total;
}

double largest(const double* x, int n) {
    double most = 0.0;
    for (int i = 0; i < n; ++i) most = std::max(most, std::abs(x[i]));
    return most;
}

void add_transposed(const double* rows, int count, int nv, const double* x, double* y) {
    for (int r = 0; r < count; ++r) {
        if (x[r] == 0.0) continue;
        const double* row = rows + r * nv;
        for (int k = 0; k < nv; ++k) y[k] += x[r] * row[k];
    }
}

void multiply(const double* a, int n, const double* x, const double* b, double* y) {
    for (int i = 0; i < n; ++i) y[i] = b[i] + dot(a + i * n, x, n);
}

}  // namespace impulsekit
