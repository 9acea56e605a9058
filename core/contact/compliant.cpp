#include "contact/compliant.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

#include "contact/tolerances.hpp"
#include "integrator/stepper.hpp"
#include "integrator/zero.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// Phases of sticking and slip; steps of one phase.
constexpr int kMostPhases = 100000, kMostSteps = 5000;
// Slip that begins with the impact keeps its way for this time, up to its square; what that misses
// of the impulse is its fourth power.
constexpr double kBegins = 1e-3;
// Sticking is looked at so often in a radian of its fastest mode.
constexpr double kLook = 0.25;

// Eigenvalues and vectors (columns of Q) of a symmetric 3 × 3 matrix, by Jacobi's rotations.
void diagonalize(double (&S)[3][3], double (&Q)[3][3]) {
    for (int i = 0; i < 3; ++i)
        for (int j = 0; j < 3; ++j) Q[i][j] = i == j;
    for (int sweep = 0; sweep < 12; ++sweep)
        for (int p = 0; p < 2; ++p)
            for (int q = p + 1; q < 3; ++q) {
                const double least = std::min(std::abs(S[p][p]), std::abs(S[q][q]));
                if (least + std::abs(S[p][q]) == least) continue;
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
        least_ = tolerance::shallow * std::abs(u[2]);
        scale_ = std::max(std::abs(u[2]), std::hypot(u[0], u[1]));
    }

    bool follow() {
        // At first both springs are loaded at the rates of their velocities.
        slips_ = kappa_ * std::hypot(u_[0], u_[1]) > mu_ * std::abs(u_[2]);
        if (slips_) begin_slip();
        for (int phase = 0; phase < kMostPhases && !over_; ++phase)
            if (!(slips_ ? slip() : stick())) return false;
        if (over_ && restores_) finish();
        return over_;
    }

    double P[3] = {}, normal_work = 0.0;

    // The distance of velocities that were followed from W P.
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
        const double speed = std::hypot(u_[0], u_[1]);
        way_[0] = u_[0] / speed, way_[1] = u_[1] / speed;
        depth_ = -kBegins * u_[2];
        P[2] = 0.5 * kBegins * depth_;
        P[0] = -mu_ * P[2] * way_[0];
        P[1] = -mu_ * P[2] * way_[1];
        turn(0.0);
    }

    // The rest of the normal spring, with the tangential one in proportion: δ²/2 = g ∫ −u_n dP.
    void finish() {
        if (!(depth_ > 0.0)) return;
        const double by[3] = {-kappa_ * zeta_[0] / depth_, -kappa_ * zeta_[1] / depth_, 1.0};
        double gain[3];
        for (int i = 0; i < 3; ++i)
            gain[i] = W_[3 * i] * by[0] + W_[3 * i + 1] * by[1] + W_[3 * i + 2];
        const double left = depth_ * depth_ / gives();
        const double rest = left / (u_[2] + std::sqrt(u_[2] * u_[2] + gain[2] * left));
        for (int i = 0; i < 3; ++i) {
            P[i] += rest * by[i];
            u_[i] += rest * gain[i];
        }
        normal_work += 0.5 * left;
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
        double to[3][3], rate[3], at[3], speed[3];

        void evaluate(double t, double* z, double* v, double* area) const {
            double x[3], y[3], a[3];
            for (int i = 0; i < 3; ++i) {
                const double w = rate[i], h = std::sin(0.5 * w * t);
                const double c = 1.0 - 2.0 * h * h, s = 2.0 * h * std::cos(0.5 * w * t);
                const bool free = w * t * w * t < tolerance::last_bits;
                const double sine = free ? t : s / w;
                x[i] = at[i] * c + speed[i] * sine;
                y[i] = -at[i] * w * s + speed[i] * c;
                a[i] = at[i] * sine + speed[i] * (free ? 0.5 * t * t : 2.0 * h * h / (w * w));
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

    Modes modes_of_sticking() const {
        Modes modes;
        double S[3][3], Q[3][3], root[3];
        const double g[3] = {1.0, 1.0, gives()}, k[3] = {kappa_, kappa_, 1.0};
        for (int i = 0; i < 3; ++i) root[i] = std::sqrt(g[i] * k[i]);
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j) S[i][j] = root[i] * W_[3 * i + j] * root[j];
        diagonalize(S, Q);
        const double z0[3] = {zeta_[0], zeta_[1], -depth_};
        for (int j = 0; j < 3; ++j) {
            modes.rate[j] = std::sqrt(std::max(S[j][j], 0.0));
            modes.at[j] = modes.speed[j] = 0.0;
            for (int i = 0; i < 3; ++i) {
                const double unit = std::sqrt(g[i] / k[i]);
                modes.to[i][j] = unit * Q[i][j];
                modes.at[j] += Q[i][j] * z0[i] / unit;
                modes.speed[j] += Q[i][j] * g[i] * u_[i] / unit;
            }
        }
        return modes;
    }

    bool stick() {
        const Modes modes = modes_of_sticking();
        const double g[3] = {1.0, 1.0, gives()}, k[3] = {kappa_, kappa_, 1.0};
        double z[3], v[3], area[3], m[3];
        // Margins of the cone, of the turn of the normal and of its end.
        const auto margin = [&](double t) {
            modes.evaluate(t, z, v, area);
            m[0] = -mu_ * z[2] - kappa_ * std::sqrt(z[0] * z[0] + z[1] * z[1]);
            m[1] = restores_ ? v[2] : -v[2];
            m[2] = restores_ ? -z[2] : 1.0;
            return std::min({m[0], m[1], m[2]});
        };
        const double look = kLook / std::max({modes.rate[0], modes.rate[1], modes.rate[2]});
        double low = 0.0, at_low = 0.0, high = look, at_high;
        for (int count = 0; (at_high = margin(high)) >= 0.0; ++count) {
            if (count > 100 * kMostSteps) return false;
            poll(1, 100);
            low = high, at_low = at_high, high += look;
        }
        margin(zero_between(low, at_low, high, at_high, margin));
        const double before = depth_;
        for (int i = 0; i < 3; ++i) {
            P[i] -= k[i] * area[i];
            u_[i] = v[i] / g[i];
        }
        zeta_[0] = z[0], zeta_[1] = z[1], depth_ = -z[2];
        turn(before);
        if (m[0] <= 0.0) {
            slips_ = true;
            const double length = std::hypot(z[0], z[1]);
            way_[0] = z[0] / length, way_[1] = z[1] / length;
        }
        change_normal(m[1] <= 0.0, m[2] <= 0.0 || (slips_ && restores_ && depth_ < least_));
        return true;
    }

    // Velocities at impulses y of a phase of slip.
    void velocities(const double* y, double* u) const {
        for (int i = 0; i < 3; ++i) {
            u[i] = start_[i];
            for (int j = 0; j < 3; ++j) u[i] += W_[3 * i + j] * y[j];
        }
    }

    // Rates of slip. y: P and χ = κ ζ/µ, of length δ, over ∫ dt/δ, by which χ does not turn ever
    // faster where the load is small.
    bool rates(const double* y, double* dy) const {
        const double g = gives(), turns = kappa_ / mu_;
        double u[3];
        velocities(y, u);
        const double *chi = y + 3, F = std::sqrt(chi[0] * chi[0] + chi[1] * chi[1]);
        const double along = F > 0.0 ? (chi[0] * u[0] + chi[1] * u[1]) / F : 0.0;
        for (int i = 0; i < 2; ++i) {
            dy[i] = -mu_ * F * chi[i];
            dy[3 + i] = -g * u[2] * chi[i] + turns * (F * u[i] - along * chi[i]);
        }
        dy[2] = F * F;
        return std::isfinite(dy[2] + dy[3] + dy[4]);
    }

    // Their derivatives by y (5, 5).
    void differentiate(const double* y, double* J) const {
        const double g = gives(), turns = kappa_ / mu_;
        double u[3];
        velocities(y, u);
        std::fill(J, J + 25, 0.0);
        const double *chi = y + 3, F = std::sqrt(chi[0] * chi[0] + chi[1] * chi[1]);
        if (!(F > 0.0)) return;
        const double d[2] = {chi[0] / F, chi[1] / F}, along = d[0] * u[0] + d[1] * u[1];
        for (int i = 0; i < 2; ++i) {
            const double across = u[i] - along * d[i];
            J[10 + 3 + i] = 2.0 * chi[i];
            for (int j = 0; j < 3; ++j)
                J[15 + 5 * i + j] =
                    -g * W_[6 + j] * chi[i] +
                    turns * F * (W_[3 * i + j] - d[i] * (d[0] * W_[j] + d[1] * W_[3 + j]));
            for (int j = 0; j < 2; ++j) {
                const double same = i == j, aside = u[j] - along * d[j];
                J[5 * i + 3 + j] = -mu_ * (F * same + chi[i] * d[j]);
                J[15 + 5 * i + 3 + j] = -g * u[2] * same + turns * (d[j] * across - d[i] * aside -
                                                                    along * (same - d[i] * d[j]));
            }
        }
    }

    bool slip() {
        const double g = gives(), turns = kappa_ / mu_;
        const Stepper::Rate f = [&](double, const double* y, double* dy) { return rates(y, dy); };
        double m[3];
        const auto margin = [&](const double* y) {
            double u[3];
            velocities(y, u);
            const double *chi = y + 3, F = std::sqrt(chi[0] * chi[0] + chi[1] * chi[1]);
            m[0] = (chi[0] * u[0] + chi[1] * u[1]) / F + g * u[2] / turns;
            m[1] = restores_ ? u[2] : -u[2];
            m[2] = restores_ ? F - least_ : 1.0;
            return std::min({m[0], m[1], m[2]});
        };
        Stepper stepper(Method::dop853, 0, 5,
                        {tolerance::residual, tolerance::residual * std::abs(start_[2]),
                         tolerance::implicit, 0.0},
                        0.0);
        stepper.slopes = [&](const double* y, double* J) { differentiate(y, J); };
        stepper.next =
            1.0 / (g * std::abs(u_[2]) + turns * std::hypot(u_[0], u_[1]) + std::sqrt(g) * depth_);
        double y[5] = {P[0], P[1], P[2], depth_ * way_[0], depth_ * way_[1]}, rate[5], next[5];
        f(0.0, y, rate);
        const double before = depth_;
        double at_low = 0.0;
        Step step, cut;
        for (int count = 0;; ++count) {
            if (count == kMostSteps) return false;
            std::copy(y, y + 5, next);
            if (!stepper.step(f, [](double*) {}, 0.0, next, rate, INFINITY, step)) return false;
            const double at_high = margin(next);
            if (at_high < 0.0) {
                // On the polynomial of the step, then on a step to there.
                const double high =
                    zero_between(0.0, at_low, step.end, at_high, [&](double middle) {
                        step.at(middle, next);
                        return margin(next);
                    });
                step.at(high, next);
                margin(next);
                if (stepper.shortened(f, step, high, cut)) cut.at(high, next);
                std::copy(next, next + 5, y);
                break;
            }
            at_low = at_high;
            std::copy(next, next + 5, y);
        }
        std::copy(y, y + 3, P);
        velocities(y, u_);
        depth_ = std::hypot(y[3], y[4]);
        turn(before);
        for (int i = 0; i < 2; ++i) {
            zeta_[i] = y[3 + i] / turns;
            way_[i] = y[3 + i] / depth_;
        }
        if (m[0] <= 0.0) slips_ = false;
        change_normal(m[1] <= 0.0, m[2] <= 0.0);
        return true;
    }

    const double e2_, mu_, kappa_;
    double W_[9], u_[3], start_[3], zeta_[2] = {}, depth_ = 0.0, way_[2] = {};
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
