#include "linalg/dense.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// So many columns of a factorization are done between two counts of its work.
constexpr int kColumns = 64;

}  // namespace

// The rows of two pivots at a time are subtracted from the others.
bool factor_lu(double* a, int n, int* pivot) {
    const auto bring_up = [&](int k) {
        int best = k;
        for (int i = k + 1; i < n; ++i)
            if (std::abs(a[i * n + k]) > std::abs(a[best * n + k])) best = i;
        pivot[k] = best;
        if (best != k) std::swap_ranges(a + k * n, a + (k + 1) * n, a + best * n);
        return std::abs(a[k * n + k]) > 0.0;
    };
    for (int k = 0; k < n; k += 2) {
        if (k % kColumns == kColumns - 2) poll(n - k, n - k, kColumns);
        if (!bring_up(k)) return false;
        double *first = a + k * n, *second = first + n;
        const double inverse = 1.0 / first[k];
        if (k + 1 == n) break;
        for (int i = k + 1; i < n; ++i) {
            double* row = a + i * n;
            row[k] *= inverse;
            row[k + 1] -= row[k] * first[k + 1];
        }
        if (!bring_up(k + 1)) return false;
        const double other = 1.0 / second[k + 1], share = second[k];
        for (int j = k + 2; j < n; ++j) second[j] -= share * first[j];
        for (int i = k + 2; i < n; ++i) {
            double* row = a + i * n;
            const double one = row[k], two = row[k + 1] *= other;
            for (int j = k + 2; j < n; ++j) row[j] = (row[j] - one * first[j]) - two * second[j];
        }
    }
    return true;
}

}  // namespace impulsekit
