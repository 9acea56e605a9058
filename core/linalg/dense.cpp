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

}  // namespace impulsekit
