// Radau's method IIA of order 5, for stiff springs and dampers (Hairer & Wanner, Solving Ordinary
// Differential Equations II, 1996, section IV.8).
#include <algorithm>
#include <cmath>

#include "integrator/stepper.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

const double kRoot6 = std::sqrt(6.0);
const double kPlaces[3] = {(4.0 - kRoot6) / 10.0, (4.0 + kRoot6) / 10.0, 1.0};
// The inverse of the weights, and to and from the axes T in which it falls apart: a real eigenvalue
// and a pair.
const double kInverse[3][3] = {
    {2.0 + kRoot6 / 2.0, -1.2 + 29.0 / 30.0 * kRoot6, 0.4 - 4.0 / 15.0 * kRoot6},
    {-1.2 - 29.0 / 30.0 * kRoot6, 2.0 - kRoot6 / 2.0, 0.4 + 4.0 / 15.0 * kRoot6},
    {-1.0 + 8.0 / 3.0 * kRoot6, -1.0 - 8.0 / 3.0 * kRoot6, 5.0}};
const double kToAxes[3][3] = {
    {4.178718591551904727346, 0.327682820761062387083, 0.523376445499449548040},
    {-4.178718591551904727346, -0.327682820761062387083, 0.476623554500550451960},
    {0.502872634945786875951, -2.571926949855605429187, 0.596039204828224924969}};
const double kFromAxes[3][3] = {
    {0.094438762488975241487, -0.141255295020954208428, 0.030029194105147424492},
    {0.250213122965333311377, 0.204129352293799931996, -0.382942112757261937795},
    {1.0, 1.0, 0.0}};
const double kReal = 3.0 + std::cbrt(9.0) - std::cbrt(3.0), kAlpha = 2.681082873627752133896,
             kBeta = 3.050430199247410569426;
// Weights of the error by a formula of order 3, with the real eigenvalue of the weights' inverse.
const double kError[3] = {(-13.0 - 7.0 * kRoot6) / 3.0, (-13.0 + 7.0 * kRoot6) / 3.0, -1.0 / 3.0};
// Newton's iteration ends at this share of what errors may be, after so many rounds at most.
constexpr double kNewton = 1e-3;
constexpr int kRounds = 10;
// Derivatives are kept for another step where each round leaves this share of the last one's.
constexpr double kSlow = 0.1;
constexpr double kDifference = 1.5e-8;
constexpr int kGrowths = 8;

}  // namespace

// J_ = ∂f/∂y (n, n), given or by differences.
void Stepper::differentiate(const Rate& f, double t, const double* y, const double* rate) {
    Arena::Scope scope(scratch());
    J_.resize(n_ * n_);
    double *vector = scratch().allocate(n_), *other = scratch().allocate(n_);
    std::copy(y, y + n_, vector);
    if (slopes) slopes(y, J_.data());
    for (int j = 0; j < n_ && !slopes; ++j) {
        const double step = kDifference * std::max(1.0, std::abs(y[j]));
        vector[j] = y[j] + step;
        if (!f(t, vector, other)) std::copy(rate, rate + n_, other);
        for (int i = 0; i < n_; ++i) J_[i * n_ + j] = (other[i] - rate[i]) / step;
        vector[j] = y[j];
    }
    // The largest of its eigenvalues in size, by how a vector grows.
    std::fill(vector, vector + n_, 1.0);
    double grown = 0.0;
    for (int round = 0; round < 2 * kGrowths; ++round) {
        for (int i = 0; i < n_; ++i) other[i] = dot(J_.data() + i * n_, vector, n_);
        const double size = std::sqrt(dot(other, other, n_));
        if (!(size > 0.0)) break;
        for (int i = 0; i < n_; ++i) vector[i] = other[i] / size;
        if (round >= kGrowths) grown += std::log(size) / kGrowths;
    }
    fastest_ = std::exp(grown);
}

// Z (3, n): y at the three places of a step less y, by Newton's method with J_, which will do for
// the next step if that comes near fast enough. Each round solves with γ/h − J and with
// (α + iβ)/h − J (Hairer & Wanner 1996, eq. (IV.8.4)).
bool Stepper::collocate(const Rate& f, double t, const double* y, double h, double* Z) {
    Arena::Scope scope(scratch());
    const int n = n_, m = 2 * n;
    double *pair = scratch().allocate(m * m), *F = scratch().allocate(3 * n),
           *left = scratch().allocate(3 * n), *at = scratch().allocate(n);
    int* pivots = scratch().allocate_int(m);
    real_.resize(n * n);
    pivot_.resize(n);
    for (int i = 0; i < n; ++i) {
        for (int j = 0; j < n; ++j) {
            const double own = -J_[i * n + j];
            real_[i * n + j] = own;
            pair[i * m + j] = pair[(n + i) * m + n + j] = own;
        }
        real_[i * n + i] += kReal / h;
        pair[i * m + i] += kAlpha / h;
        pair[(n + i) * m + n + i] += kAlpha / h;
        pair[i * m + n + i] = kBeta / h;
        pair[(n + i) * m + i] = -kBeta / h;
    }
    if (!factor_lu(real_.data(), n, pivot_.data()) || !factor_lu(pair, m, pivots)) return false;
    const auto turn = [&](const double (&by)[3][3], const double* x, double* to) {
        for (int a = 0; a < 3; ++a)
            for (int j = 0; j < n; ++j)
                to[a * n + j] = by[a][0] * x[j] + by[a][1] * x[n + j] + by[a][2] * x[2 * n + j];
    };
    foresee(t, h, Z);
    double last = INFINITY;
    keeps_J_ = true;
    for (int round = 0; round < kRounds; ++round) {
        for (int a = 0; a < 3; ++a) {
            for (int j = 0; j < n; ++j) at[j] = y[j] + Z[a * n + j];
            if (!f(t + kPlaces[a] * h, at, F + a * n)) return false;
        }
        // A⁻¹ Z/h is what the rates would be.
        turn(kInverse, Z, left);
        for (int i = 0; i < 3 * n; ++i) F[i] -= left[i] / h;
        turn(kToAxes, F, left);
        solve_lu(real_.data(), pivot_.data(), n, left);
        solve_lu(pair, pivots, m, left + n);
        turn(kFromAxes, left, F);
        double size = 0.0;
        for (int i = 0; i < 3 * n; ++i) {
            const int j = i % n;
            size = std::max(size, std::abs(F[i]) / std::max(allowed(j, y[j], y[j] + Z[2 * n + j]),
                                                            accuracy_.noise));
            Z[i] += F[i];
        }
        if (size > kSlow * last) keeps_J_ = false;
        if (size <= kNewton || (size < 1.0 && size > 0.5 * last)) return true;
        if (!(size < 2.0 * last)) return false;
        last = size;
    }
    return false;
}

// A guess of Z: the polynomial of the last step, beyond its end.
void Stepper::foresee(double t, double h, double* Z) const {
    std::fill(Z, Z + 3 * n_, 0.0);
    if (!(last_.length > 0.0) || last_.end != t) return;
    Arena::Scope scope(scratch());
    double* end = scratch().allocate(n_);
    last_.at(t, end);
    for (int a = 0; a < 3; ++a) {
        last_.at(t + kPlaces[a] * h, Z + a * n_);
        for (int j = 0; j < n_; ++j) Z[a * n_ + j] -= end[j];
    }
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

bool Stepper::implicit(const Rate& f, const std::function<void(double*)>& project, double t,
                       double* y, double* rate, double longest, Step& found) {
    Arena::Scope scope(scratch());
    double *Z = scratch().allocate(3 * n_), *off = scratch().allocate(n_);
    bool is_fresh = !keeps_J_;
    if (is_fresh) differentiate(f, t, y, rate);
    double h = std::min(next, longest);
    bool failed = false;
    for (int trial = 0; trial < kMostTrials; ++trial) {
        if (!(h > shortest_step(t))) return false;
        double size = INFINITY;
        bool found_any = collocate(f, t, y, h, Z);
        if (!found_any && !is_fresh) {
            is_fresh = true;
            differentiate(f, t, y, rate);
            found_any = collocate(f, t, y, h, Z);
        }
        if (found_any) {
            for (int j = 0; j < n_; ++j) {
                off[j] = rate[j];
                for (int a = 0; a < 3; ++a) off[j] += kError[a] * Z[a * n_ + j] / h;
            }
            solve_lu(real_.data(), pivot_.data(), n_, off);
            size = 0.0;
            for (int j = 0; j < n_; ++j) {
                const double part =
                    off[j] / (accuracy_.implicit * allowed(j, y[j], y[j] + Z[2 * n_ + j]));
                size += part * part / n_;
            }
            size = std::sqrt(size);
        }
        if (size <= 1.0) {
            for (int j = 0; j < n_; ++j) end_[j] = y[j] + Z[2 * n_ + j];
            project(end_.data());
            if (f(t + h, end_.data(), trial_.data())) {
                factor_ = std::max(kLeast, kSafety * std::pow(size, -0.25));
                const double factor = std::min(failed ? 1.0 : kMost, factor_);
                keep_cubic(t, y, h, Z, found);
                last_ = found;
                next =
                    !failed && h < next && factor >= 1.0 ? std::max(next, h * factor) : h * factor;
                std::copy(end_.begin(), end_.end(), y);
                std::copy(trial_.begin(), trial_.end(), rate);
                ++steps;
                // Explicit steps would be as long.
                if (next * fastest_ < kStable) stiff_ = 0;
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
