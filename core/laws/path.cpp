#include "laws/path.hpp"

#include <algorithm>
#include <cmath>

#include "laws/tolerances.hpp"

namespace impulsekit {
namespace {

// Terms of the Taylor series of slip that turns: a step of this order is exact to rounding.
constexpr int kOrder = 20;
constexpr int kSegments = 200, kSteps = 400;
// Slip below this share of the velocities has ended; a direction that turns by less than this
// against its decay keeps.
constexpr double kStopped = 1e-15, kStraight = 1e-13;
// What the last terms of a series may add.
constexpr double kCut = 1e-17;
// A normal velocity below this share ended with the slip, where friction wedges.
constexpr double kWedged = 1e-6;
// Velocities of the way that are farther than this from W P have lost digits.
constexpr double kClose = 1e-8;

struct Series {
    double c[kOrder + 1];

    double at(double x) const {
        double total = 0.0;
        for (int k = kOrder; k >= 0; --k) total = total * x + c[k];
        return total;
    }
    double gain(double x) const {
        double total = 0.0;
        for (int k = kOrder; k >= 1; --k) total = total * x + c[k];
        return x * total;
    }
    double integral(double x) const {
        double total = 0.0;
        for (int k = kOrder - 1; k >= 0; --k) total = total * x + c[k] / (k + 1);
        return x * total;
    }
    // Where between 0 and `high` the series, monotone there, has a value: Newton, bisected.
    double root(double value, double high) const {
        double low = 0.0, x = high;
        bool rising = at(high) >= c[0];
        for (int count = 0; count < 100; ++count) {
            double here = 0.0, slope = 0.0;
            for (int k = kOrder; k >= 0; --k) {
                slope = slope * x + here;
                here = here * x + c[k];
            }
            double missing = value - here;
            if (missing == 0.0) break;
            ((missing > 0.0) == rising ? low : high) = x;
            double next = slope != 0.0 ? x + missing / slope : 0.5 * (low + high);
            if (!(low <= next && next <= high)) next = 0.5 * (low + high);
            if (std::abs(next - x) <= 1e-16 * x) break;
            x = next;
        }
        return x;
    }
};

Series integral_of(const Series& f) {
    Series result{};
    for (int k = 0; k < kOrder; ++k) result.c[k + 1] = f.c[k] / (k + 1);
    return result;
}

Series product(const Series& f, const Series& g) {
    Series result{};
    for (int k = 0; k <= kOrder; ++k)
        for (int j = 0; j <= k; ++j) result.c[k] += f.c[j] * g.c[k - j];
    return result;
}

struct Rates {
    double u1, u2, un, p1, p2;  // by the normal impulse
};

// How far an impact has come.
class Path {
  public:
    Path(const double* W, double before, const double* free, double e, double mu,
         Restitution restitution, double scale)
        : t11_(W[0]),
          t12_(W[1]),
          t22_(W[4]),
          n1_(W[2]),
          n2_(W[5]),
          nn_(W[8]),
          e_(e),
          mu_(mu),
          scale_(scale),
          restitution_(restitution),
          u1_(free[0]),
          u2_(free[1]),
          un_(free[2]) {
        target_ = restitution == Restitution::newton ? std::max(0.0, -e * before) : 0.0;
        compressing_ = free[2] < 0.0;
    }

    PathImpact follow(const double* free) {
        PathImpact impact;
        bool over = false, wedged = false;
        for (int k = 0; k < kSegments && !over && !wedged; ++k) segment(over, wedged);
        bool unanswered = wedged && (compressing_ || e_ > 0.0);
        impact.residual = over || wedged ? (unanswered ? 1.0 : end_residual()) : 1.0;
        if (unanswered)
            impact.status = Status::no_solution;
        else if (!over && !wedged)
            impact.status = Status::not_converged;
        else if (!(impact.residual <= tolerance::residual))
            impact.status = Status::not_converged;
        finish(free, impact);
        return impact;
    }

    bool acts() const { return un_ - target_ < -1e-15 * scale_; }

  private:
    // One stretch in which rates keep, or slip that turns.
    void segment(bool& over, bool& wedged) {
        double speed = std::hypot(u1_, u2_);
        bool rests = mu_ == 0.0, begins = !(speed > kStopped * scale_);
        if (rests) return straight({n1_, n2_, nn_, 0.0, 0.0}, false, over, wedged);
        double s1 = 0.0, s2 = 0.0;
        if (begins) {
            u1_ = u2_ = 0.0;
            double k1, k2;
            holding(k1, k2);
            if (std::hypot(k1, k2) <= mu_) {
                double rise = nn_ + n1_ * k1 + n2_ * k2;
                if (!(rise > 1e-10 * nn_)) rise = 0.0;
                return straight({0.0, 0.0, rise, k1, k2}, false, over, wedged);
            }
            outgoing(s1, s2);
        } else {
            s1 = u1_ / speed;
            s2 = u2_ / speed;
        }
        double d1 = n1_ - mu_ * (t11_ * s1 + t12_ * s2), d2 = n2_ - mu_ * (t12_ * s1 + t22_ * s2);
        double size = std::abs(n1_) + std::abs(n2_) + mu_ * (t11_ + t22_);
        if (!begins && std::abs(s1 * d2 - s2 * d1) > kStraight * size) {
            over = turn();
            return;
        }
        double along = s1 * d1 + s2 * d2;
        straight({along * s1, along * s2, nn_ - mu_ * (n1_ * s1 + n2_ * s2), -mu_ * s1, -mu_ * s2},
                 true, over, wedged);
    }

    // Go on while rates keep, to the end of the phase or of the slip.
    void straight(const Rates& d, bool slips, bool& over, bool& wedged) {
        double speed = slips ? std::hypot(u1_, u2_) : 0.0;
        double phase = to_end_of_phase(d.un, slips), stop = INFINITY, back = INFINITY;
        if (speed > 0.0) {
            double decay = -(d.u1 * u1_ + d.u2 * u2_) / speed;
            if (decay > 0.0) stop = speed / decay;
        }
        // Friction may draw a contact back in after it has begun to part.
        if (!compressing_ && d.un < 0.0 && un_ > 0.0) back = -un_ / d.un;
        double step = std::min({phase, stop, back});
        if (step == INFINITY) {
            // Friction holds all that moves: u_n ended with the slip, up to rounding, or is held.
            wedged = !(compressing_ && std::abs(un_) <= kWedged * scale_);
            if (!wedged) over = ends_phase();
            return;
        }
        double work = step * (un_ + 0.5 * step * d.un);
        if (slips) {
            double x = u1_ + d.u1 * step, y = u2_ + d.u2 * step;
            friction_ -= mu_ * step * 0.5 * (speed + std::hypot(x, y));
        }
        (compressing_ ? spent_ : regained_) += work;
        if (compressing_) pressed_ += step;
        u1_ += d.u1 * step;
        u2_ += d.u2 * step;
        un_ += d.un * step;
        p1_ += d.p1 * step;
        p2_ += d.p2 * step;
        p_ += step;
        if (step == stop) u1_ = u2_ = 0.0;
        if (step == phase) {
            over = ends_phase();
        } else if (step == back) {
            un_ = 0.0;
            compressing_ = true;
        }
    }

    // What ends the phase, in u_n, in p and in work; infinite where it is not asked.
    void left_to_go(double& velocity, double& impulse, double& work) const {
        velocity = impulse = work = INFINITY;
        if (compressing_)
            velocity = -un_;
        else if (restitution_ == Restitution::newton)
            velocity = target_ - un_;
        else if (restitution_ == Restitution::poisson)
            impulse = (1.0 + e_) * pressed_ - p_;
        else
            work = -e_ * e_ * spent_ - regained_;
    }

    // The impulse to the end of the phase if du_n/dp keeps.
    double to_end_of_phase(double dn, bool slips) const {
        double velocity, impulse, work;
        left_to_go(velocity, impulse, work);
        if (velocity < INFINITY) return dn > 0.0 ? std::max(velocity / dn, 0.0) : INFINITY;
        if (impulse < INFINITY) return std::max(impulse, 0.0);
        if (!(work > 0.0)) return 0.0;
        // un p + dn p²/2 = work. What friction holds wholly does not lift off by rounding.
        double un = !slips && dn <= 0.0 && std::abs(un_) <= 1e-12 * scale_ ? 0.0 : un_;
        double root = un * un + 2.0 * dn * work, below = un + std::sqrt(std::max(root, 0.0));
        return root >= 0.0 && below > 0.0 ? 2.0 * work / below : INFINITY;
    }

    // Go over from compression to restitution; whether the impact is over.
    bool ends_phase() {
        if (!compressing_) return true;
        compressing_ = false;
        un_ = 0.0;
        return e_ == 0.0 || (restitution_ == Restitution::newton && target_ <= 1e-15 * scale_);
    }

    // dP_t/dp that keeps u_t = 0.
    void holding(double& k1, double& k2) const {
        double determinant = t11_ * t22_ - t12_ * t12_, trace = t11_ + t22_;
        if (determinant > 1e-10 * t11_ * t22_ && determinant > 0.0) {
            k1 = (t12_ * n2_ - t22_ * n1_) / determinant;
            k2 = (t12_ * n1_ - t11_ * n2_) / determinant;
        } else {
            // W_tt of rank one at most; W_tn lies in its range.
            k1 = trace > 0.0 ? -n1_ / trace : 0.0;
            k2 = trace > 0.0 ? -n2_ / trace : 0.0;
        }
    }

    // s with (λ + µ W_tt) s = W_tn and λ > 0: the direction in which slip starts again.
    void outgoing(double& s1, double& s2) const {
        double mean = 0.5 * (t11_ + t22_), half = 0.5 * (t11_ - t22_);
        double size = std::hypot(n1_, n2_);
        // |(λ + µ W_tt)⁻¹ W_tn| falls with λ: Newton on its inverse climbs to the root from below.
        double lambda = std::max(size - mu_ * (mean + std::hypot(half, t12_)), 1e-15 * size);
        s1 = n1_ / size;
        s2 = n2_ / size;
        for (int count = 0; count < 100; ++count) {
            double k1 = mu_ * t11_ + lambda, k2 = mu_ * t22_ + lambda, k12 = mu_ * t12_;
            double determinant = k1 * k2 - k12 * k12;
            s1 = (k2 * n1_ - k12 * n2_) / determinant;
            s2 = (k1 * n2_ - k12 * n1_) / determinant;
            double length = std::hypot(s1, s2);
            if (length <= 1.0 + 1e-15) break;
            double slope = (k2 * s1 * s1 - 2.0 * k12 * s1 * s2 + k1 * s2 * s2) / determinant;
            double step = length * length * (length - 1.0) / slope;
            if (step <= 1e-16 * lambda) break;
            lambda += step;
        }
        double length = std::hypot(s1, s2);
        s1 /= length;
        s2 /= length;
    }

    // Slip that turns: in τ with dp = |u_t| dτ,
    //     du_t/dτ = W_tn |u_t| − µ W_tt u_t,  du_n/dτ = W_nn |u_t| − µ W_tn·u_t,
    // smooth down to |u_t| = 0 at τ → ∞, followed by Taylor series (Jorba & Zou 2005) until the
    // phase or the slip ends, or it keeps its direction. Whether the impact is over.
    bool turn() {
        const double first = std::hypot(u1_, u2_);
        const double tangential = std::abs(n1_) + std::abs(n2_) + mu_ * (t11_ + t22_);
        // Per step: velocities in units of |u_t|, τ of 1/inertia, impulses of |u_t|/inertia.
        const double inertia = tangential + nn_;
        const double a11 = mu_ * t11_ / inertia, a12 = mu_ * t12_ / inertia,
                     a22 = mu_ * t22_ / inertia;
        const double w1 = n1_ / inertia, w2 = n2_ / inertia, wn = nn_ / inertia;
        for (int count = 0; count < kSteps; ++count) {
            double r = std::hypot(u1_, u2_);
            if (r <= 1e-14 * first) {
                u1_ = u2_ = 0.0;
                return false;
            }
            double s1 = u1_ / r, s2 = u2_ / r;
            double turning =
                std::abs(s1 * (w2 - a12 * s1 - a22 * s2) - s2 * (w1 - a11 * s1 - a12 * s2));
            if (turning <= kStraight * tangential / inertia && turning * r <= 1e-15 * first)
                return false;
            Series x{}, y{}, z{}, speed{}, square{};
            x.c[0] = s1;
            y.c[0] = s2;
            z.c[0] = un_ / r;
            speed.c[0] = square.c[0] = 1.0;
            for (int k = 0; k < kOrder; ++k) {
                double part = 1.0 / (k + 1);
                x.c[k + 1] = part * (w1 * speed.c[k] - a11 * x.c[k] - a12 * y.c[k]);
                y.c[k + 1] = part * (w2 * speed.c[k] - a12 * x.c[k] - a22 * y.c[k]);
                z.c[k + 1] = part * (wn * speed.c[k] - mu_ * (w1 * x.c[k] + w2 * y.c[k]));
                double total = 0.0, own = 0.0;
                for (int j = 0; j <= k + 1; ++j)
                    total += x.c[j] * x.c[k + 1 - j] + y.c[j] * y.c[k + 1 - j];
                for (int j = 1; j <= k; ++j) own += speed.c[j] * speed.c[k + 1 - j];
                square.c[k + 1] = total;
                speed.c[k + 1] = 0.5 * (total - own);
            }
            if (step(x, y, z, speed, square, r, inertia)) return ends_phase();
        }
        return false;
    }

    // One step of series, cut where the phase ends; whether it does.
    bool step(const Series& x, const Series& y, const Series& z, const Series& speed,
              const Series& square, double r, double inertia) {
        double h = 1e12;
        for (int k = kOrder - 1; k <= kOrder; ++k) {
            double size = std::max({std::abs(x.c[k]), std::abs(y.c[k]), std::abs(speed.c[k])});
            if (size > 0.0) h = std::min(h, std::pow(kCut / size, 1.0 / k));
        }
        // On each step u_n shall rise or fall, not both.
        Series rise{};
        for (int k = 0; k < kOrder; ++k) rise.c[k] = (k + 1) * z.c[k + 1];
        if (rise.c[0] * rise.at(h) < 0.0) {
            double extreme = rise.root(0.0, h);
            if (extreme > 1e-8 * h) h = extreme;
        }
        bool falls = !compressing_ && z.c[0] + z.gain(h) < 0.0 && rise.at(h) < 0.0;
        if (falls) {
            Series change = z;
            change.c[0] = 0.0;
            h = z.c[0] > 0.0 ? change.root(-z.c[0], h) : 0.0;
        }
        double velocity, impulse, work;
        left_to_go(velocity, impulse, work);
        Series power = product(speed, z), end{};
        double goal;
        if (velocity < INFINITY) {
            end = z;
            end.c[0] = 0.0;
            goal = velocity / r;
        } else if (impulse < INFINITY) {
            end = integral_of(speed);
            goal = impulse * inertia / r;
        } else {
            end = integral_of(power);
            goal = work * inertia / (r * r);
        }
        bool reached = end.at(h) >= goal;
        if (reached) h = end.root(goal, h);
        double unit = r / inertia, p = unit * speed.integral(h);
        p1_ -= mu_ * unit * x.integral(h);
        p2_ -= mu_ * unit * y.integral(h);
        p_ += p;
        friction_ -= mu_ * unit * r * square.integral(h);
        (compressing_ ? spent_ : regained_) += unit * r * power.integral(h);
        if (compressing_) pressed_ += p;
        u1_ = r * (x.c[0] + x.gain(h));
        u2_ = r * (y.c[0] + y.gain(h));
        un_ += r * z.gain(h);
        if (falls && !reached) {
            un_ = 0.0;
            compressing_ = true;
        }
        return reached;
    }

    // How far the end is from what the law asks, relative.
    double end_residual() const {
        if (restitution_ == Restitution::newton) return std::abs(un_ - target_) / scale_;
        if (restitution_ == Restitution::poisson) return std::abs(p_ - (1.0 + e_) * pressed_) / p_;
        return spent_ == 0.0 ? 0.0 : std::abs(regained_ + e_ * e_ * spent_) / -spent_;
    }

    // u⁺ from the impulse, so that both agree to rounding, and the works.
    void finish(const double* free, PathImpact& impact) const {
        const double p[3] = {p1_, p2_, p_}, way[3] = {u1_, u2_, un_};
        const double W[9] = {t11_, t12_, n1_, t12_, t22_, n2_, n1_, n2_, nn_};
        double off = 0.0, total = 0.0, size = 0.0;
        for (int i = 0; i < 3; ++i) {
            double after = free[i];
            for (int j = 0; j < 3; ++j) after += W[3 * i + j] * p[j];
            impact.impulse[i] = p[i];
            impact.after[i] = after;
            off = std::max(off, std::abs(after - way[i]));
            total += 0.5 * p[i] * (free[i] + after);
            size += std::abs(p[i] * free[i]);
        }
        impact.friction_work = friction_;
        impact.normal_work = total - friction_;
        if (impact.status != Status::solved) return;
        if ((p1_ != 0.0 || p2_ != 0.0) && !(off <= kClose * scale_))
            impact.status = Status::not_converged;
        else if (total > tolerance::gain * (size + std::abs(impact.normal_work) - friction_))
            impact.status = Status::energy_gain;
    }

    const double t11_, t12_, t22_, n1_, n2_, nn_, e_, mu_, scale_;
    const Restitution restitution_;
    double u1_, u2_, un_, p1_ = 0.0, p2_ = 0.0, p_ = 0.0;
    double friction_ = 0.0, pressed_ = 0.0, spent_ = 0.0, regained_ = 0.0, target_ = 0.0;
    bool compressing_ = false;
};

}  // namespace

PathImpact follow_path(const double* W, double before, const double* free, double e, double mu,
                       Restitution restitution) {
    mu = mu > tolerance::negligible ? mu : 0.0;
    e = e > tolerance::negligible ? e : 0.0;
    double scale = std::max(std::abs(before), std::abs(free[2]));
    if (mu > 0.0) scale = std::max({scale, std::abs(free[0]), std::abs(free[1])});
    PathImpact impact;
    std::copy(free, free + 3, impact.after);
    if (scale == 0.0) return impact;
    // Works are squares of velocities, and might leave the doubles: velocities near 1.
    const double unit = std::ldexp(1.0, -std::ilogb(scale));
    const double own[3] = {unit * free[0], unit * free[1], unit * free[2]};
    Path path(W, unit * before, own, e, mu, restitution, unit * scale);
    if (!path.acts()) return impact;
    if (!(W[8] > 0.0)) {
        impact.residual = 1.0;
        impact.status = Status::no_solution;
        return impact;
    }
    impact = path.follow(own);
    for (int k = 0; k < 3; ++k) {
        impact.impulse[k] /= unit;
        impact.after[k] /= unit;
    }
    impact.normal_work /= unit * unit;
    impact.friction_work /= unit * unit;
    return impact;
}

}  // namespace impulsekit
