// The mass matrix factored: M = Lᵀ D L, sparse by the tree (Featherstone 2008, section 6.5).
#pragma once

#include <cmath>
#include <vector>

#include "linalg/numbers.hpp"

namespace impulsekit {

// A pivot at or below this share of its diagonal is rounding, not inertia: robots stay above 1e-4,
// bodies 1e8 apart in mass above 1e-8.
inline constexpr double kLeastPivot = 1e-10;

// Rows of L reach along `parent` alone: the degree of freedom that each hangs on, −1 for none,
// always smaller than its own. A dense matrix has parent i − 1.
class MassFactor {
  public:
    // M (n, n) symmetric, its lower triangle read. False where a pivot is rounding; `weak` is then
    // its degree of freedom.
    bool factor(const double* M, const int* parent, int n, int* weak = nullptr) {
        n_ = n;
        parent_.assign(parent, parent + n);
        L_.assign(M, M + n * n);
        roots_.resize(n);
        bool sound = true;
        for (int k = n - 1; k >= 0; --k) {
            double* row = L_.data() + k * n;
            double pivot = row[k];
            if (!(pivot > kLeastPivot * M[k * n + k])) {
                if (weak && sound) *weak = k;
                sound = false;
                pivot = row[k] = INFINITY;
            }
            roots_[k] = std::sqrt(pivot);
            for (int i = parent[k]; i >= 0; i = parent[i]) {
                double share = row[i] / pivot;
                double* upper = L_.data() + i * n;
                for (int j = i; j >= 0; j = parent[j]) upper[j] -= share * row[j];
                row[i] = share;
            }
        }
        return sound;
    }

    // x ← D^-½ L⁻ᵀ x: with it W = J M⁻¹ Jᵀ is a product of rows with themselves.
    template <typename S>
    void half(S* x) const {
        for (int i = n_ - 1; i >= 0; --i) {
            if (!any(x[i] != 0.0)) continue;
            const double* row = L_.data() + i * n_;
            for (int j = parent_[i]; j >= 0; j = parent_[j]) x[j] -= row[j] * x[i];
        }
        for (int i = 0; i < n_; ++i) x[i] /= roots_[i];
    }

    // x ← L⁻¹ D^-½ x: the rest of the way to M⁻¹.
    template <typename S>
    void rest(S* x) const {
        for (int i = 0; i < n_; ++i) {
            const double* row = L_.data() + i * n_;
            x[i] /= roots_[i];
            for (int j = parent_[i]; j >= 0; j = parent_[j]) x[i] -= row[j] * x[j];
        }
    }

    template <typename S>
    void solve(S* x) const {
        half(x);
        rest(x);
    }

  private:
    int n_ = 0;
    std::vector<int> parent_;
    std::vector<double> L_, roots_;
};

}  // namespace impulsekit
