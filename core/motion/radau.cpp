// Radau's method IIA of order 5, for stiff springs and dampers (Hairer & Wanner, Solving Ordinary
// Differential Equations II, 1996, section IV.8).
#include <algorithm>
#include <cmath>

#include "arena.hpp"
#include "laws/dense.hpp"
#include "motion/stepper.hpp"

namespace impulsekit {
namespace {

const double kRoot6 = std::sqrt(6.0);
const double kPlaces[3] = {(4.0 - kRoot6) / 10.0, (4.0 + kRoot6) / 10.0, 1.0};
const double kWeights[3][3] = {{(88.0 - 7.0 * kRoot6) / 360.0, (296.0 - 169.0 * kRoot6) / 1800.0,
                                (-2.0 + 3.0 * kRoot6) / 225.0},
                               {(296.0 + 169.0 * kRoot6) / 1800.0, (88.0 + 7.0 * kRoot6) / 360.0,
                                (-2.0 - 3.0 * kRoot6) / 225.0},
                               {(16.0 - kRoot6) / 36.0, (16.0 + kRoot6) / 36.0, 1.0 / 9.0}};
// Of the error by a formula of order 3, with the real eigenvalue of the inverse of the weights.
const double kError[3] = {(-13.0 - 7.0 * kRoot6) / 3.0, (-13.0 + 7.0 * kRoot6) / 3.0, -1.0 / 3.0};
const double kEigenvalue = 3.0 + std::cbrt(9.0) - std::cbrt(3.0);
// Newton's iteration ends at this share of what errors may be, after so many rounds at most.
constexpr double kNewton = 1e-3;
constexpr int kRounds = 10;
// Below this nothing is told apart: forces at rest are known to some 1e-12.
constexpr double kNoise = 1e-9;
constexpr double kDifference = 1.5e-8;

}  // namespace

// ∂f/∂y (n, n) by differences.
void Stepper::differentiate(const Rate& f, double t, const double* y, const double* rate,
                            double* J) {
    Arena::Scope scope(scratch());
    double *moved = scratch().take(n_), *other = scratch().take(n_);
    std::copy(y, y + n_, moved);
    for (int j = 0; j < n_; ++j) {
        const double step = kDifference * std::max(1.0, std::abs(y[j]));
        moved[j] = y[j] + step;
        if (!f(t, moved, other)) std::copy(rate, rate + n_, other);
        for (int i = 0; i < n_; ++i) J[i * n_ + j] = (other[i] - rate[i]) / step;
        moved[j] = y[j];
    }
}

// Z (3, n): y at the three places of a step less y, by Newton's method with J_.
bool Stepper::collocate(const Rate& f, double t, const double* y, double h, double* Z) {
    Arena::Scope scope(scratch());
    const int m = 3 * n_;
    double *A = scratch().take(m * m), *F = scratch().take(m), *left = scratch().take(m),
           *at = scratch().take(n_);
    int* pivot = scratch().take_int(m);
    for (int a = 0; a < 3; ++a)
        for (int b = 0; b < 3; ++b)
            for (int i = 0; i < n_; ++i)
                for (int j = 0; j < n_; ++j)
                    A[(a * n_ + i) * m + b * n_ + j] =
                        (a == b && i == j ? 1.0 : 0.0) - h * kWeights[a][b] * J_[i * n_ + j];
    if (!factor_lu(A, m, pivot)) return false;
    std::fill(Z, Z + m, 0.0);
    double last = INFINITY;
    for (int round = 0; round < kRounds; ++round) {
        for (int a = 0; a < 3; ++a) {
            for (int j = 0; j < n_; ++j) at[j] = y[j] + Z[a * n_ + j];
            if (!f(t + kPlaces[a] * h, at, F + a * n_)) return false;
        }
        double size = 0.0;
        for (int a = 0; a < 3; ++a)
            for (int j = 0; j < n_; ++j) {
                double sum = 0.0;
                for (int b = 0; b < 3; ++b) sum += kWeights[a][b] * F[b * n_ + j];
                left[a * n_ + j] = h * sum - Z[a * n_ + j];
            }
        solve_lu(A, pivot, m, left);
        for (int i = 0; i < m; ++i) {
            const int j = i % n_;
            const double own = j < places_ ? std::abs(Z[2 * n_ + j]) : std::abs(y[j]);
            size = std::max(
                size, std::abs(left[i]) / std::max(accuracy_.atol + accuracy_.rtol * own, kNoise));
            Z[i] += left[i];
        }
        if (size <= kNewton || (size < 1.0 && size > 0.5 * last)) return true;
        if (!(size < 2.0 * last)) return false;
        last = size;
    }
    return false;
}

// The cubic through the three places, as dense output keeps it.
void Stepper::keep_cubic(double t, const double* y, double h, const double* Z, Step& found) const {
    found.begin_at(t, h, y, n_);
    for (int j = 0; j < n_; ++j) {
        // Divided differences of y over x, from (0, 0).
        const double z1 = Z[j] / kPlaces[0], z2 = Z[n_ + j] / kPlaces[1], z3 = Z[2 * n_ + j];
        const double first = (z2 - z1) / (kPlaces[1] - kPlaces[0]),
                     second = (z3 - z2) / (1.0 - kPlaces[1]),
                     cubic = (second - first) / (1.0 - kPlaces[0]);
        const double square = first - cubic * (kPlaces[0] + kPlaces[1]);
        found.shape[j] = z3;
        found.shape[n_ + j] = -cubic - square;
        found.shape[2 * n_ + j] = -cubic;
    }
}

bool Stepper::implicit(const Rate& f, const std::function<void(double*)>& settle, double t,
                       double* y, double* rate, double longest, Step& found) {
    Arena::Scope scope(scratch());
    J_.resize(n_ * n_);
    double *Z = scratch().take(3 * n_), *real = scratch().take(n_ * n_), *off = scratch().take(n_);
    int* pivot = scratch().take_int(n_);
    differentiate(f, t, y, rate, J_.data());
    double h = std::min(next, longest);
    bool failed = false;
    for (int trial = 0; trial < kMostTrials; ++trial) {
        if (!(h > shortest_step(t))) return false;
        double size = INFINITY;
        if (collocate(f, t, y, h, Z)) {
            for (int i = 0; i < n_ * n_; ++i)
                real[i] = (i % (n_ + 1) == 0 ? kEigenvalue / h : 0.0) - J_[i];
            if (factor_lu(real, n_, pivot)) {
                for (int j = 0; j < n_; ++j) {
                    off[j] = rate[j];
                    for (int a = 0; a < 3; ++a) off[j] += kError[a] * Z[a * n_ + j] / h;
                }
                solve_lu(real, pivot, n_, off);
                size = 0.0;
                for (int j = 0; j < n_; ++j) {
                    const double own =
                        j < places_ ? std::abs(Z[2 * n_ + j])
                                    : std::max(std::abs(y[j]), std::abs(y[j] + Z[2 * n_ + j]));
                    const double part = off[j] / (accuracy_.atol + accuracy_.rtol * own);
                    size += part * part / n_;
                }
                size = std::sqrt(size);
            }
        }
        if (size <= 1.0) {
            for (int j = 0; j < n_; ++j) end_[j] = y[j] + Z[2 * n_ + j];
            settle(end_.data());
            if (f(t + h, end_.data(), trial_.data())) {
                const double factor = std::min(
                    failed ? 1.0 : kMost,
                    std::max(kLeast, size > 0.0 ? kSafety * std::pow(size, -0.25) : kMost));
                keep_cubic(t, y, h, Z, found);
                next = h < next && factor >= 1.0 ? std::max(next, h * factor) : h * factor;
                std::copy(end_.begin(), end_.end(), y);
                std::copy(trial_.begin(), trial_.end(), rate);
                ++steps;
                return true;
            }
        }
        failed = true;
        h *= std::isfinite(size) && size > 1.0 ? std::max(kLeast, kSafety * std::pow(size, -0.25))
                                               : 0.25;
    }
    return false;
}

}  // namespace impulsekit
