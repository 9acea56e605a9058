#include "impact/constrained_mass.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {

namespace {

// Steps at most by which rounding of large multipliers is brought down.
constexpr int kRefinements = 3;

}  // namespace

bool ConstrainedMass::factor(const double* M, const int* parent, int nv,
                             const ConstraintRows& rows) {
    nv_ = nv;
    given_ = rows;
    weak_ = -1;
    is_filled_ = false;
    rows_.reset();
    half_.assign(rows.A, rows.A + rows.count * nv);
    if (!mass_.factor(M, parent, nv, &weak_) && !(rows.count > 0 && fill_mass(M))) return false;
    weak_ = -1;
    if (rows.count == 0) return true;
    for (int r = 0; r < rows.count; ++r) mass_.half(half_.data() + r * nv);
    rows_.emplace(half_.data(), rows.count, nv, rows.vectors, rows.wider);
    return true;
}

bool ConstrainedMass::fill_mass(const double* M) {
    std::vector<double> filled(M, M + nv_ * nv_);
    squares_.assign(given_.count, 0.0);
    double heaviest = 0.0;
    for (int k = 0; k < nv_; ++k) heaviest = std::max(heaviest, M[k * nv_ + k]);
    for (int r = 0; r < given_.count; ++r) {
        const double* row = given_.A + r * nv_;
        for (int k = 0; k < nv_; ++k) {
            const double own = M[k * nv_ + k];
            squares_[r] += row[k] * row[k] / (own > tolerance::at_rest * heaviest ? own : heaviest);
        }
        if (!(squares_[r] > 0.0)) continue;
        for (int i = 0; i < nv_; ++i)
            for (int j = 0; j < nv_; ++j) filled[i * nv_ + j] += row[i] * row[j] / squares_[r];
    }
    std::vector<int> dense(nv_);
    for (int k = 0; k < nv_; ++k) dense[k] = k - 1;
    is_filled_ = true;
    return mass_.factor(filled.data(), dense.data(), nv_);
}

void ConstrainedMass::fill(const double* target, double* impulse) const {
    if (!is_filled_) return;
    for (int r = 0; r < given_.count; ++r) {
        if (!(squares_[r] > 0.0)) continue;
        const double* row = given_.A + r * nv_;
        for (int k = 0; k < nv_; ++k) impulse[k] += row[k] * target[r] / squares_[r];
    }
}

ConstrainedMass::Disagreement ConstrainedMass::apply_multipliers(double* demand, double* x,
                                                                 double* multipliers) const {
    const int m = given_.count;
    const Arena::Scope scope(scratch());
    double *left = scratch().allocate(m), *more = scratch().allocate(m),
           *shortfall = scratch().allocate(m);
    Disagreement found;
    for (int round = 0; round <= kRefinements && m > 0; ++round) {
        double off = 0.0, terms = 0.0;
        for (int r = 0; r < m; ++r) {
            const double own = dot(half_.data() + r * nv_, x, nv_);
            left[r] = demand[r] - own;
            off = std::max(off, std::abs(left[r]));
            terms = std::max(terms, std::abs(demand[r]) + std::abs(own));
        }
        if (off <= tolerance::rounding * terms) break;
        rows_->solve(left, more, shortfall);
        if (round == 0) {
            found = {largest(shortfall, m), terms};
            for (int r = 0; r < m; ++r) demand[r] -= shortfall[r];
        }
        for (int r = 0; r < m; ++r) multipliers[r] += more[r];
        add_transposed(half_.data(), m, nv_, more, x);
    }
    return found;
}

std::vector<char> ConstrainedMass::project_out_constraints(const double* half, int count,
                                                           double* left) const {
    std::vector<char> held(count, 0);
    if (!rows_) return held;
    const double bar = rows_->rounding_of_span();
    for (int first = 0; first < count; first += 3) {
        const int end = std::min(first + 3, count);
        double size = 0.0;
        for (int r = first; r < end; ++r)
            size = std::max(size, dot(half + r * nv_, half + r * nv_, nv_));
        for (int r = first; r < end; ++r) {
            double* row = left + r * nv_;
            rows_->project_out(row);
            if (dot(row, row, nv_) > bar * bar * size) continue;
            std::fill(row, row + nv_, 0.0);
            held[r] = 1;
        }
    }
    return held;
}

void ConstrainedMass::respond(const double* points, int count,
                              std::vector<double>& velocity_changes,
                              std::vector<double>& unit_multipliers, std::vector<double>& W) const {
    const int m = given_.count;
    std::vector<double> half(points, points + count * nv_), target(m), shortfall(m);
    for (int r = 0; r < count; ++r) mass_.half(half.data() + r * nv_);
    velocity_changes = half;
    project_out_constraints(half.data(), count, velocity_changes.data());
    W.assign(count * count, 0.0);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j)
            W[i * count + j] =
                dot(velocity_changes.data() + i * nv_, velocity_changes.data() + j * nv_, nv_);
    unit_multipliers.assign(count * m, 0.0);
    for (int r = 0; r < count && m > 0; ++r) {
        for (int k = 0; k < m; ++k)
            target[k] = -dot(half_.data() + k * nv_, half.data() + r * nv_, nv_);
        rows_->solve(target.data(), unit_multipliers.data() + r * m, shortfall.data());
    }
    for (int r = 0; r < count; ++r) mass_.rest(velocity_changes.data() + r * nv_);
}

}  // namespace impulsekit
