#include "impact/bilateral.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {

BilateralRows::BilateralRows(const double* half, int m, int nv, const int* vectors,
                             const double* wider)
    : m_(m), nv_(nv), length_(m, 0.0), order_(m), unique_(m, 1) {
    // The longest row of each vector.
    for (int i = 0; i < m; ++i) {
        double own = dot(half + i * nv, half + i * nv, nv);
        for (int j = 0; j < m && own > 0.0; ++j)
            if (vectors[j] == vectors[i])
                own = std::max(own, dot(half + j * nv, half + j * nv, nv));
        length_[i] = std::sqrt(own) * (wider ? wider[i] : 1.0);
        order_[i] = i;
    }
    std::vector<double> rows(m * nv);
    for (int i = 0; i < m; ++i)
        for (int k = 0; k < nv; ++k)
            rows[i * nv + k] = length_[i] > 0.0 ? half[i * nv + k] / length_[i] : 0.0;
    orthogonalize(rows);
    if (rank_ < m) find_shares();
}

// Gram-Schmidt with pivoting of rows of unit length, each new vector orthogonalized twice.
void BilateralRows::orthogonalize(std::vector<double>& rows) {
    const int m = m_, nv = nv_;
    upper_.assign(m * m, 0.0);
    auto subtract_projection = [&](int of, int row) {
        const double* unit = basis_.data() + of * nv;
        double* x = rows.data() + row * nv;
        double along = dot(unit, x, nv);
        for (int k = 0; k < nv; ++k) x[k] -= along * unit[k];
        return along;
    };
    for (int k = 0; k < m; ++k) {
        int best = k;
        double longest = -1.0;
        poll(m - k, nv, 2);
        for (int i = k; i < m; ++i) {
            const double* x = rows.data() + order_[i] * nv;
            double size = dot(x, x, nv);
            if (size > longest) {
                longest = size;
                best = i;
            }
        }
        double length = std::sqrt(std::max(longest, 0.0));
        if (!(length > tolerance::dependent_row)) {
            nearly_ = length > tolerance::sums;
            break;
        }
        std::swap(order_[k], order_[best]);
        for (int j = 0; j < k; ++j) std::swap(upper_[j * m + k], upper_[j * m + best]);
        for (int j = 0; j < k; ++j) upper_[j * m + k] += subtract_projection(j, order_[k]);
        double* x = rows.data() + order_[k] * nv;
        length = std::sqrt(dot(x, x, nv));
        upper_[k * m + k] = length;
        least_ = std::min(least_, length);
        for (int j = 0; j < nv; ++j) x[j] /= length;
        basis_.insert(basis_.end(), x, x + nv);
        rank_ = k + 1;
        for (int i = k + 1; i < m; ++i) upper_[k * m + i] = subtract_projection(k, order_[i]);
    }
}

// Dependent rows as shares of the independent ones: S = (R₁⁻¹ R₂)ᵀ.
void BilateralRows::find_shares() {
    const int m = m_, count = m - rank_;
    shares_.assign(count * rank_, 0.0);
    for (int c = 0; c < count; ++c)
        for (int i = rank_ - 1; i >= 0; --i) {
            double total = upper_[i * m + rank_ + c];
            for (int j = i + 1; j < rank_; ++j) total -= upper_[i * m + j] * shares_[c * rank_ + j];
            shares_[c * rank_ + i] = total / upper_[i * m + i];
        }
    gram_.assign(count * count, 0.0);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j <= i; ++j) {
            double total = (i == j ? 1.0 : 0.0) +
                           dot(shares_.data() + i * rank_, shares_.data() + j * rank_, rank_);
            for (int k = 0; k < j; ++k) total -= gram_[i * count + k] * gram_[j * count + k];
            gram_[i * count + j] = i == j ? std::sqrt(total) : total / gram_[j * count + j];
        }
    // A row whose unit vector lies in the range is determined: its part in the null space is sᵀ G⁻¹
    // s.
    std::vector<double> column(count);
    for (int k = 0; k < rank_; ++k) {
        double part = 0.0;
        for (int i = 0; i < count; ++i) {
            double total = shares_[i * rank_ + k];
            for (int j = 0; j < i; ++j) total -= gram_[i * count + j] * column[j];
            column[i] = total / gram_[i * count + i];
            part += column[i] * column[i];
        }
        unique_[order_[k]] = part <= tolerance::shared;
    }
    for (int i = rank_; i < m; ++i) unique_[order_[i]] = 0;
}

void BilateralRows::solve(const double* target, double* impulse, double* shortfall) const {
    const int count = m_ - rank_;
    std::vector<double> x(rank_), others(count, 0.0);
    std::fill(shortfall, shortfall + m_, 0.0);
    for (int k = 0; k < rank_; ++k) x[k] = target[order_[k]] / length_[order_[k]];
    // If dependent rows disagree each gives way: what lies in the null space, whose columns are
    // (−Sᵀ, 1), is taken off.
    for (int c = 0; c < count; ++c) {
        double length = length_[order_[rank_ + c]];
        double own = length > 0.0 ? target[order_[rank_ + c]] / length : 0.0;
        others[c] = own - dot(shares_.data() + c * rank_, x.data(), rank_);
    }
    solve_gram(others.data());
    for (int c = 0; c < count; ++c) {
        int row = order_[rank_ + c];
        shortfall[row] = length_[row] > 0.0 ? others[c] * length_[row] : target[row];
        if (!(length_[row] > 0.0)) continue;
        for (int k = 0; k < rank_; ++k) {
            double own = shares_[c * rank_ + k] * others[c];
            x[k] += own;
            shortfall[order_[k]] -= own * length_[order_[k]];
        }
    }
    // For the independent rows W₁ = R₁ᵀ R₁.
    for (int i = 0; i < rank_; ++i) {
        for (int j = 0; j < i; ++j) x[i] -= upper_[j * m_ + i] * x[j];
        x[i] /= upper_[i * m_ + i];
    }
    for (int i = rank_ - 1; i >= 0; --i) {
        for (int j = i + 1; j < rank_; ++j) x[i] -= upper_[i * m_ + j] * x[j];
        x[i] /= upper_[i * m_ + i];
    }
    // The solution of least norm: (x, 0) less its part in the null space, whose columns are (−Sᵀ,
    // 1).
    for (int i = 0; i < count; ++i) others[i] = dot(shares_.data() + i * rank_, x.data(), rank_);
    solve_gram(others.data());
    for (int i = 0; i < count; ++i)
        for (int k = 0; k < rank_; ++k) x[k] -= shares_[i * rank_ + k] * others[i];
    for (int k = 0; k < rank_; ++k) impulse[order_[k]] = x[k] / length_[order_[k]];
    for (int c = 0; c < count; ++c) {
        double length = length_[order_[rank_ + c]];
        impulse[order_[rank_ + c]] = length > 0.0 ? others[c] / length : 0.0;
    }
}

void BilateralRows::solve_gram(double* z) const {
    const int count = m_ - rank_;
    for (int i = 0; i < count; ++i)
        z[i] = (z[i] - dot(gram_.data() + i * count, z, i)) / gram_[i * count + i];
    for (int i = count - 1; i >= 0; --i) {
        for (int j = i + 1; j < count; ++j) z[i] -= gram_[j * count + i] * z[j];
        z[i] /= gram_[i * count + i];
    }
}

void BilateralRows::project_out(double* x) const {
    for (int round = 0; round < 2; ++round)
        for (int k = 0; k < rank_; ++k) {
            const double* unit = basis_.data() + k * nv_;
            double along = dot(unit, x, nv_);
            for (int i = 0; i < nv_; ++i) x[i] -= along * unit[i];
        }
}

double BilateralRows::rounding_of_span() const {
    return std::max(tolerance::solved, tolerance::sums / least_);
}

}  // namespace impulsekit
