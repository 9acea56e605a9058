// The mass matrix factored: M = Lᵀ D L, sparse by the tree (Featherstone 2008, section 6.5).
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "linalg/numbers.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit {

// Rows of L reach along `parent` alone: the degree of freedom that each hangs on, −1 for none,
// always smaller than its own. A dense matrix has parent i − 1. Of one state or eight side by side.
template <typename F>
class MassFactorOf {
  public:
    static constexpr int lanes = Number<F>::lanes;

    // M (n, n) symmetric, its lower triangle read. False where a pivot is rounding in some lane;
    // `weak` (lanes) is then its degree of freedom there, else left as it is.
    bool factor(const F* M, const int* parent, int n, int* weak = nullptr) {
        n_ = n;
        parent_.assign(parent, parent + n);
        L_.assign(M, M + n * n);
        roots_.resize(n);
        bool sound[lanes];
        std::fill(sound, sound + lanes, true);
        for (int k = n - 1; k >= 0; --k) {
            F* row = L_.data() + k * n;
            for (int l = 0; l < lanes; ++l) {
                if (Number<F>::get(row[k], l) >
                    tolerance::parallel * Number<F>::get(M[k * n + k], l))
                    continue;
                if (weak && sound[l]) weak[l] = k;
                sound[l] = false;
                Number<F>::set(row[k], l, INFINITY);
            }
            const F pivot = row[k];
            roots_[k] = root(pivot);
            for (int i = parent[k]; i >= 0; i = parent[i]) {
                const F share = row[i] / pivot;
                F* upper = L_.data() + i * n;
                for (int j = i; j >= 0; j = parent[j]) upper[j] -= share * row[j];
                row[i] = share;
            }
        }
        return std::all_of(sound, sound + lanes, [](bool x) { return x; });
    }

    // x ← D^-½ L⁻ᵀ x: with it W = J M⁻¹ Jᵀ is a product of rows with themselves. Of several rows
    // (rows, n) at once, such as those of a point, which reach along the same branches.
    template <int rows = 1, typename S>
    void half(S* x) const {
        for (int i = n_ - 1; i >= 0; --i) {
            S own[rows];
            bool moves = false;
            for (int r = 0; r < rows; ++r) {
                own[r] = x[r * n_ + i];
                moves = moves || any(own[r] != 0.0);
            }
            if (!moves) continue;
            const F* row = L_.data() + i * n_;
            for (int j = parent_[i]; j >= 0; j = parent_[j])
                for (int r = 0; r < rows; ++r) x[r * n_ + j] -= row[j] * own[r];
        }
        for (int r = 0; r < rows; ++r)
            for (int i = 0; i < n_; ++i) x[r * n_ + i] /= roots_[i];
    }

    // x ← L⁻¹ D^-½ x: the rest of the way to M⁻¹.
    template <typename S>
    void rest(S* x) const {
        for (int i = 0; i < n_; ++i) {
            const F* row = L_.data() + i * n_;
            x[i] /= roots_[i];
            for (int j = parent_[i]; j >= 0; j = parent_[j]) x[i] -= row[j] * x[j];
        }
    }

    template <typename S>
    void solve(S* x) const {
        half(x);
        rest(x);
    }

    // The factor of one of the states.
    void extract(int lane, MassFactorOf<double>& to) const {
        to.n_ = n_;
        to.parent_ = parent_;
        to.L_.resize(L_.size());
        to.roots_.resize(n_);
        for (int i = 0; i < n_; ++i) {
            to.roots_[i] = Number<F>::get(roots_[i], lane);
            for (int j = parent_[i]; j >= 0; j = parent_[j])
                to.L_[i * n_ + j] = Number<F>::get(L_[i * n_ + j], lane);
        }
    }

  private:
    template <typename>
    friend class MassFactorOf;

    int n_ = 0;
    std::vector<int> parent_;
    std::vector<F> L_, roots_;
};

using MassFactor = MassFactorOf<double>;

}  // namespace impulsekit
