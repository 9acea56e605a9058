#include "contact/compliant.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "contact/tolerances.hpp"
#include "integrator/stepper.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// Phases of sticking and slip; steps of one phase.
constexpr int kMostPhases = 200, kMostSteps = 5000;
// Error of a step of slip, in units in which velocity, mobility and normal stiffness are 1.
constexpr double kError = 1e-13, kImplicit = 1e3;
// A spring with less than this part of its first deflection is spent: what is left of its impulse
// is the square of that.
constexpr double kSpent = 1e-9;
// Slip that begins with the impact keeps its way for this time, up to its square.
constexpr double kBegins = 1e-6;
// Sticking is looked at so often in a radian of its fastest mode.
constexpr double kLook = 0.1;
constexpr int kHalvings = 80;

// Eigenvalues and vectors (columns of Q) of a symmetric 3 × 3 matrix, by Jacobi's rotations.
void diagonalize(double (&S)[3][3], double (&Q)[3][3]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) Q[i][j] = i == j;
    for (int sweep = 0; sweep < 12; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                if (S[p][q] == 0.0) continue;
                const double a = (S[q][q] - S[p][p]) / (2.0 * S[p][q]);
                const double t = std::copysign(1.0, a) / (std::abs(a) + std::hypot(a, 1.0));
                const double c = 1.0 / std::hypot(t, 1.0), s = t * c;
                for (int k = 0; k < 3; ++k) {
                    const double x = S[k][p], y = S[k][q];
                    S[k][p] = c * x - s * y, S[k][q] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = S[p][k], y = S[q][k];
                    S[p][k] = c * x - s * y, S[q][k] = s * x + c * y;
                }
                for (int k = 0; k < 3; ++k) {
                    const double x = Q[k][p], y = Q[k][q];
                    Q[k][p] = c * x - s * y, Q[k][q] = s * x + c * y;
                }
                S[p][q] = S[q][p] = 0.0;
            }
}

class Springs {
  public:
    // Units in which W_nn and k are 1.
    Springs(const double* W, const double* u, double e, double mu, double ratio)
        : e2_(e * e), mu_(mu), kappa_(ratio) {
        for (int i = 0; i < 9; ++i) W_[i] = W[i] / W[8];
        std::copy(u, u + 3, u_);
        std::copy(u, u + 3, start_);
        least_ = kSpent * std::abs(u[2]);
        scale_ = std::max(std::abs(u[2]), std::hypot(u[0], u[1]));
    }

    bool follow() {
        // At first both springs are loaded at the rates of their velocities.
        slips_ = kappa_ * std::hypot(u_[0], u_[1]) > mu_ * std::abs(u_[2]);
        if (slips_) begin_slip();
        for (int phase = 0; phase < kMostPhases && !over_; ++phase)
            if (!(slips_ ? slip() : stick())) return false;
        return over_;
    }

    double P[3] = {}, normal_work = 0.0;

    // How far velocities that were followed are from W P.
    double off() const {
        double most = 0.0;
        for (int i = 0; i < 3; ++i) {
            double u = start_[i];
            for (int j = 0; j < 3; ++j) u += W_[3 * i + j] * P[j];
            most = std::max(most, std::abs(u - u_[i]));
        }
        return most / scale_;
    }

  private:
    // The first moments of slip, in which its way does not turn yet but its rate is 0/0.
    void begin_slip() {
        way_ = std::atan2(u_[1], u_[0]);
        depth_ = -kBegins * u_[2];
        P[2] = 0.5 * kBegins * depth_;
        P[0] = -mu_ * P[2] * std::cos(way_);
        P[1] = -mu_ * P[2] * std::sin(way_);
        turn(0.0);
    }

    // Depth per approach.
    double gives() const { return restores_ ? 1.0 / e2_ : 1.0; }

    // At the end of a phase: the normal turns, or the impact is over.
    void turn(double depth_before) {
        normal_work -= 0.5 / gives() * (depth_ * depth_ - depth_before * depth_before);
    }
    void change_normal(bool turned, bool spent) {
        if (spent || (turned && !restores_ && e2_ == 0.0))
            over_ = true;
        else if (turned)
            restores_ = !restores_;
    }

    // Modes of sticking: z = (ζ, −δ) with z'' = −G W K z, G the depth per approach, K stiffness.
    struct Modes {
        double to[3][3], rate2[3], at[3], speed[3];

        void evaluate(double t, double* z, double* v, double* area) const {
            double x[3], y[3], a[3];
            for (int i = 0; i < 3; ++i) {
                const double w = std::sqrt(rate2[i]), c = std::cos(w * t), s = std::sin(w * t);
                const double h = std::sin(0.5 * w * t);
                const bool free = w * t < 1e-8;
                const double sine = free ? t : s / w;
                x[i] = at[i] * c + speed[i] * sine;
                y[i] = -at[i] * w * s + speed[i] * c;
                a[i] = at[i] * sine + speed[i] * (free ? 0.5 * t * t : 2.0 * h * h / rate2[i]);
            }
            for (int i = 0; i < 3; ++i) {
                z[i] = v[i] = area[i] = 0.0;
                for (int j = 0; j < 3; ++j) {
                    z[i] += to[i][j] * x[j];
                    v[i] += to[i][j] * y[j];
                    area[i] += to[i][j] * a[j];
                }
            }
        }
    };

    bool stick() {
        Modes modes;
        double S[3][3], Q[3][3], root[3];
        const double g[3] = {1.0, 1.0, gives()}, k[3] = {kappa_, kappa_, 1.0};
        for (int i = 0; i < 3; ++i) root[i] = std::sqrt(g[i] * k[i]);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) S[i][j] = root[i] * W_[3 * i + j] * root[j];
        diagonalize(S, Q);
        const double z0[3] = {zeta_[0], zeta_[1], -depth_};
        double fastest = 0.0;
        for (int j = 0; j < 3; ++j) {
            modes.rate2[j] = std::max(S[j][j], 0.0);
            fastest = std::max(fastest, modes.rate2[j]);
            modes.at[j] = modes.speed[j] = 0.0;
            for (int i = 0; i < 3; ++i) {
                const double unit = std::sqrt(g[i] / k[i]);
                modes.to[i][j] = unit * Q[i][j];
                modes.at[j] += Q[i][j] * z0[i] / unit;
                modes.speed[j] += Q[i][j] * g[i] * u_[i] / unit;
            }
        }
        double z[3], v[3], area[3];
        // Margins of the cone, of the turn of the normal and of its end.
        const auto margins = [&](double t, double* m) {
            modes.evaluate(t, z, v, area);
            m[0] = -mu_ * z[2] - kappa_ * std::hypot(z[0], z[1]);
            m[1] = restores_ ? v[2] : -v[2];
            m[2] = restores_ ? -z[2] - least_ : 1.0;
            return std::min({m[0], m[1], m[2]});
        };
        const double look = kLook / std::sqrt(fastest);
        double m[3], low = 0.0, high = look;
        for (int count = 0;; ++count) {
            if (count > 100 * kMostSteps) return false;
            poll(1, 100);
            if (margins(high, m) < 0.0) break;
            low = high, high += look;
        }
        // The first of them: where all are past, the middle is, too.
        for (int count = 0; count < kHalvings && low < high; ++count) {
            const double middle = 0.5 * (low + high);
            if (middle <= low || middle >= high) break;
            (margins(middle, m) < 0.0 ? high : low) = middle;
        }
        margins(high, m);
        const double before = depth_;
        for (int i = 0; i < 3; ++i) {
            P[i] -= k[i] * area[i];
            u_[i] = v[i] / g[i];
        }
        zeta_[0] = z[0], zeta_[1] = z[1], depth_ = -z[2];
        turn(before);
        if (m[0] < 0.0) {
            slips_ = true;
            way_ = std::atan2(z[1], z[0]);
        }
        change_normal(m[1] < 0.0, m[2] < 0.0);
        return true;
    }

    // Velocities at impulses y of a phase of slip.
    void velocities(const double* y, double* u) const {
        for (int i = 0; i < 3; ++i) {
            u[i] = start_[i];
            for (int j = 0; j < 3; ++j) u[i] += W_[3 * i + j] * y[j];
        }
    }

    // y: P, δ and the angle of ζ, whose length is µ δ/κ.
    bool slip() {
        const double g = gives();
        const Stepper::Rate f = [&](double, const double* y, double* dy) {
            double u[3];
            velocities(y, u);
            const double F = std::max(y[3], 0.0), c = std::cos(y[4]), s = std::sin(y[4]);
            dy[0] = -mu_ * F * c;
            dy[1] = -mu_ * F * s;
            dy[2] = F;
            dy[3] = -g * u[2];
            dy[4] = F > 0.0 && mu_ > 0.0 ? kappa_ * (c * u[1] - s * u[0]) / (mu_ * F) : 0.0;
            return true;
        };
        const auto margins = [&](const double* y, double* m) {
            double u[3];
            velocities(y, u);
            m[0] = u[0] * std::cos(y[4]) + u[1] * std::sin(y[4]) + mu_ / kappa_ * g * u[2];
            m[1] = restores_ ? u[2] : -u[2];
            m[2] = restores_ ? y[3] - least_ : 1.0;
            return std::min({m[0], m[1], m[2]});
        };
        Stepper stepper(Method::dop853, 0, 5, {kError, kError, kImplicit, 0.0}, 0.0);
        stepper.slopes = [&](const double* y, double* J) {
            double u[3];
            velocities(y, u);
            std::fill(J, J + 25, 0.0);
            if (!(y[3] > 0.0)) return;
            const double F = y[3], c = std::cos(y[4]), s = std::sin(y[4]), by = kappa_ / (mu_ * F);
            J[3] = -mu_ * c, J[4] = mu_ * F * s;
            J[8] = -mu_ * s, J[9] = -mu_ * F * c;
            J[13] = 1.0;
            for (int j = 0; j < 3; ++j) {
                J[15 + j] = -g * W_[6 + j];
                J[20 + j] = by * (c * W_[3 + j] - s * W_[j]);
            }
            J[23] = -by / F * (c * u[1] - s * u[0]);
            J[24] = -by * (c * u[0] + s * u[1]);
        };
        stepper.next = 0.1 * kBegins;
        double y[5] = {P[0], P[1], P[2], depth_, way_}, rate[5], next[5], m[3];
        f(0.0, y, rate);
        const double before = depth_;
        for (int count = 0;; ++count) {
            if (count == kMostSteps) return false;
            Step step, cut;
            std::copy(y, y + 5, next);
            if (!stepper.step(f, [](double*) {}, 0.0, next, rate, INFINITY, step)) return false;
            if (margins(next, m) < 0.0) {
                // On the polynomial of the step, then on a step to there.
                double low = 0.0, high = step.end;
                for (int halving = 0; halving < kHalvings && low < high; ++halving) {
                    const double middle = 0.5 * (low + high);
                    if (middle <= low || middle >= high) break;
                    step.at(middle, next);
                    (margins(next, m) < 0.0 ? high : low) = middle;
                }
                step.at(high, next);
                margins(next, m);
                if (stepper.shortened(f, step, high, cut)) cut.at(high, next);
                std::copy(next, next + 5, y);
                break;
            }
            std::copy(next, next + 5, y);
        }
        std::copy(y, y + 3, P);
        velocities(y, u_);
        depth_ = y[3], way_ = y[4];
        turn(before);
        zeta_[0] = mu_ / kappa_ * depth_ * std::cos(way_);
        zeta_[1] = mu_ / kappa_ * depth_ * std::sin(way_);
        if (m[0] < 0.0) slips_ = false;
        change_normal(m[1] < 0.0, m[2] < 0.0);
        return true;
    }

    const double e2_, mu_, kappa_;
    double W_[9], u_[3], start_[3], zeta_[2] = {}, depth_ = 0.0, way_ = 0.0;
    double least_ = 0.0, scale_ = 0.0;
    bool restores_ = false, slips_ = false, over_ = false;
};

}  // namespace

PathImpact follow_compliant(const double* W, const double* free, double e, double mu,
                            double ratio) {
    mu = mu > tolerance::negligible ? mu : 0.0;
    e = e > tolerance::negligible ? e : 0.0;
    // A spring that does not give way is rigid: Coulomb's friction along the path.
    if (std::isinf(ratio) || mu == 0.0)
        return follow_path(W, free[2], free, e, mu, Restitution::stronge);
    PathImpact impact;
    std::copy(free, free + 3, impact.after);
    const double scale = std::max({std::abs(free[0]), std::abs(free[1]), std::abs(free[2])});
    if (!(free[2] < -tolerance::rounding * scale)) return impact;
    if (!(W[8] > 0.0)) {
        impact.residual = 1.0;
        impact.status = Status::no_solution;
        return impact;
    }
    const double own[3] = {free[0] / scale, free[1] / scale, free[2] / scale};
    Springs springs(W, own, e, mu, ratio);
    const bool ended = springs.follow();
    double total = 0.0;
    for (int i = 0; i < 3; ++i) {
        impact.impulse[i] = springs.P[i] * scale / W[8];
        for (int j = 0; j < 3; ++j) impact.after[i] += W[3 * i + j] * springs.P[j] * scale / W[8];
    }
    for (int i = 0; i < 3; ++i) total += 0.5 * impact.impulse[i] * (free[i] + impact.after[i]);
    impact.normal_work = springs.normal_work * scale * scale / W[8];
    impact.friction_work = total - impact.normal_work;
    impact.residual = ended ? springs.off() : 1.0;
    if (!(impact.residual <= tolerance::residual)) impact.status = Status::not_converged;
    return impact;
}

}  // namespace impulsekit
