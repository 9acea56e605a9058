#include "contact/path.hpp"

#include <algorithm>
#include <cmath>
#include <type_traits>

#include "contact/series.hpp"

namespace impulsekit {
namespace {

constexpr int kSegments = 200, kSteps = 400;
// The last terms of a series may add this much.
constexpr double kCut = 1e-17;
// A normal velocity below this share ended with the slip, where friction wedges.
constexpr double kWedged = 1e-6;

template <typename S>
struct Rates {
    S u1, u2, un, p1, p2;  // by the normal impulse
};

// The state of an impact along its path.
template <typename S>
class Path {
  public:
    static constexpr bool is_derived = !std::is_same_v<S, double>;

    // W (3, 3), u_n⁻, u_free (3).
    Path(const S* W, const S& before, const S* free, const S& e, const S& mu,
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
        target_ = restitution == Restitution::newton ? std::max(S{}, -(e * before)) : S{};
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

    // The impulse (3) of a normal impulse that is given. No phase ends by u_n.
    void push(double normal, double* impulse) {
        compressing_ = false;
        pressed_ = normal;
        un_ = INFINITY;
        bool over = false, wedged = false;
        for (int k = 0; k < kSegments && !over && !wedged; ++k) segment(over, wedged);
        impulse[0] = value_of(p1_);
        impulse[1] = value_of(p2_);
        impulse[2] = value_of(p_);
    }

    // The impulse with its derivatives, its edges, and whether friction draws it in.
    void derive(double before, PathDerivative& found) {
        const double slip = length(u1_, u2_);
        if (mu_ > 0.0 && slip > 0.0 && slip <= tolerance::edge * scale_) edges_ |= 4;
        bool over = false, wedged = false;
        for (int k = 0; k < kSegments && !over && !wedged && !drawn_in_; ++k) segment(over, wedged);
        found.edges = edges_;
        found.is_drawn_in = drawn_in_ || !over;
        const S p[3] = {p1_, p2_, p_};
        double more[3] = {};
        if (e_ <= 0.0 && !(restitution_ == Restitution::newton && before >= 0.0))
            restore_energy(before, more);
        for (int i = 0; i < 3; ++i) {
            found.impulse[i] = p[i].value;
            for (int k = 0; k < kPathParameters; ++k)
                found.by[kPathParameters * i + k] = p[i].slope[k];
            found.by[kPathParameters * i + 10] += more[i];
        }
    }

    bool acts() const { return un_ - target_ < -tolerance::rounding * scale_; }

  private:
    static double length(const S& x, const S& y) { return std::hypot(value_of(x), value_of(y)); }

    // ∂P/∂e at e = 0: nothing comes back, but a little e would bring a little.
    void restore_energy(double before, double* more) const {
        S k1, k2;
        const double speed = length(u1_, u2_), mu = value_of(mu_);
        if (mu > 0.0 && speed > tolerance::rounding * scale_) {
            k1 = -(mu_ * u1_) / speed;
            k2 = -(mu_ * u2_) / speed;
        } else if (mu > 0.0) {
            holding(k1, k2);
            if (length(k1, k2) > mu) {
                outgoing(k1, k2);
                k1 = -(mu_ * k1);
                k2 = -(mu_ * k2);
            }
        } else {
            k1 = k2 = S{};
        }
        const double lift = value_of(nn_ + n1_ * k1 + n2_ * k2);
        double share = 0.0;
        if (restitution_ == Restitution::newton)
            share = -before / lift;
        else if (restitution_ == Restitution::poisson)
            share = value_of(pressed_);
        else if (lift > 0.0)
            share = std::sqrt(-2.0 * value_of(spent_) / lift);
        more[0] = share * value_of(k1);
        more[1] = share * value_of(k2);
        more[2] = share;
    }

    // All that the parameters make of u_t comes to rest where slip is about to end: across the slip
    // it may shrink more slowly than the slip itself. W_tt ∂P_t + W_tn ∂p = −∂u_t with
    // s·∂P_t = −µ ∂p brings the rest.
    void stop_slip() {
        const double speed = length(u1_, u2_);
        if (speed == 0.0) return;
        const double s1 = value_of(u1_) / speed, s2 = value_of(u2_) / speed, mu = value_of(mu_);
        const double t11 = value_of(t11_), t12 = value_of(t12_), t22 = value_of(t22_);
        const double n1 = value_of(n1_), n2 = value_of(n2_);
        // ∂P_t = −µ s ∂p + c s⊥, in the axes s and s⊥ = (−s2, s1).
        const double ss = s1 * (t11 * s1 + t12 * s2) + s2 * (t12 * s1 + t22 * s2);
        const double sc = -s2 * (t11 * s1 + t12 * s2) + s1 * (t12 * s1 + t22 * s2);
        const double cc = s2 * (t11 * s2 - t12 * s1) - s1 * (t12 * s2 - t22 * s1);
        const double a = s1 * n1 + s2 * n2 - mu * ss, b = s1 * n2 - s2 * n1 - mu * sc;
        const double determinant = a * cc - b * sc;
        for (int k = 0; k < kPathParameters; ++k) {
            const double along = -(s1 * u1_.slope[k] + s2 * u2_.slope[k]);
            const double across = -(s1 * u2_.slope[k] - s2 * u1_.slope[k]);
            double p = along / a, c = 0.0;
            if (std::abs(cc) > tolerance::parallel * (t11 + t22)) {
                p = (along * cc - across * sc) / determinant;
                c = (a * across - b * along) / determinant;
            }
            const double p1 = -mu * s1 * p - s2 * c, p2 = -mu * s2 * p + s1 * c;
            p1_.slope[k] += p1;
            p2_.slope[k] += p2;
            p_.slope[k] += p;
            (compressing_ ? spent_ : regained_).slope[k] += value_of(un_) * p;
            if (compressing_) pressed_.slope[k] += p;
            un_.slope[k] += n1 * p1 + n2 * p2 + value_of(nn_) * p;
        }
    }

    // One stretch in which rates keep, or slip that turns.
    void segment(bool& over, bool& wedged) {
        S speed = length_of(u1_, u2_);
        bool begins = !(speed > tolerance::rounding * scale_);
        if (value_of(mu_) == 0.0) return straight({n1_, n2_, nn_, S{}, S{}}, false, over, wedged);
        S s1, s2;
        if (begins) {
            if (!sticks_) stopped_at_ = value_of(p_);
            sticks_ = true;
            u1_ = u2_ = S{};
            S k1, k2;
            holding(k1, k2);
            const double pull = length(k1, k2), mu = value_of(mu_);
            if (std::abs(pull - mu) <= tolerance::edge * mu) edges_ |= 1;
            if (pull <= mu) {
                S rise = nn_ + n1_ * k1 + n2_ * k2;
                if (!(rise > tolerance::parallel * nn_)) rise = S{};
                return straight({S{}, S{}, rise, k1, k2}, false, over, wedged);
            }
            sticks_ = false;
            outgoing(s1, s2);
        } else {
            s1 = u1_ / speed;
            s2 = u2_ / speed;
        }
        S d1 = n1_ - mu_ * (t11_ * s1 + t12_ * s2), d2 = n2_ - mu_ * (t12_ * s1 + t22_ * s2);
        S size = size_of(n1_) + size_of(n2_) + mu_ * (t11_ + t22_);
        // If slip turns, however slowly, its direction may change with the parameters.
        if (!begins && (is_derived || size_of(s1 * d2 - s2 * d1) > tolerance::solved * size)) {
            over = turn();
            return;
        }
        S along = s1 * d1 + s2 * d2;
        straight(
            {along * s1, along * s2, nn_ - mu_ * (n1_ * s1 + n2_ * s2), -(mu_ * s1), -(mu_ * s2)},
            true, over, wedged);
    }

    // Go on while rates keep, to the end of the phase or of the slip.
    void straight(const Rates<S>& d, bool slips, bool& over, bool& wedged) {
        const S never = number<S>(INFINITY), speed = slips ? length_of(u1_, u2_) : S{};
        S phase = to_end_of_phase(d.un, slips), stop = never, back = never;
        if (speed > 0.0) {
            S decay = -(d.u1 * u1_ + d.u2 * u2_) / speed;
            if (decay > 0.0) stop = speed / decay;
        }
        // Friction may draw a contact back in after it has begun to part.
        if (!compressing_ && d.un < 0.0 && un_ > 0.0) back = -un_ / d.un;
        S step = std::min({phase, stop, back});
        if (value_of(step) == INFINITY) {
            // Friction holds all that moves: u_n ended with the slip, up to rounding, or is held.
            wedged = is_derived || !(compressing_ && size_of(un_) <= kWedged * scale_);
            if (!wedged) over = ends_phase();
            return;
        }
        S work = step * (un_ + 0.5 * step * d.un);
        if (slips) {
            S x = u1_ + d.u1 * step, y = u2_ + d.u2 * step;
            friction_ -= mu_ * step * 0.5 * (speed + length_of(x, y));
        }
        (compressing_ ? spent_ : regained_) += work;
        if (compressing_) pressed_ += step;
        u1_ += d.u1 * step;
        u2_ += d.u2 * step;
        un_ += d.un * step;
        p1_ += d.p1 * step;
        p2_ += d.p2 * step;
        p_ += step;
        const double at = value_of(step);
        if (at == value_of(stop)) u1_ = u2_ = S{};
        if (at == value_of(phase)) {
            over = ends_phase();
        } else if (at == value_of(back)) {
            un_ = S{};
            compressing_ = true;
        }
    }

    // The end of the phase in u_n, in p and in work; infinite if there is none.
    void left_to_go(S& velocity, S& impulse, S& work) const {
        velocity = impulse = work = number<S>(INFINITY);
        if (compressing_)
            velocity = -un_;
        else if (restitution_ == Restitution::newton)
            velocity = target_ - un_;
        else if (restitution_ == Restitution::poisson)
            impulse = (1.0 + e_) * pressed_ - p_;
        else
            work = -(e_ * e_ * spent_) - regained_;
    }

    // The impulse to the end of the phase if du_n/dp keeps.
    S to_end_of_phase(const S& dn, bool slips) const {
        const S never = number<S>(INFINITY);
        S velocity, impulse, work;
        left_to_go(velocity, impulse, work);
        if (velocity < INFINITY) return dn > 0.0 ? std::max(velocity / dn, S{}) : never;
        if (impulse < INFINITY) return std::max(impulse, S{});
        if (!(work > 0.0)) return S{};
        // un p + dn p²/2 = work. What friction holds wholly does not lift off by rounding.
        S un = !slips && dn <= 0.0 && size_of(un_) <= tolerance::at_rest * scale_ ? S{} : un_;
        S square = un * un + 2.0 * dn * work, below = un;
        if (square > 0.0) below += root(square);
        return square >= 0.0 && below > 0.0 ? 2.0 * work / below : never;
    }

    // Go over from compression to restitution; whether the impact is over.
    bool ends_phase() {
        const double slip = length(u1_, u2_);
        // Slip that is about to stop, or has stopped just now.
        const bool lately =
            !sticks_ || value_of(nn_) * (value_of(p_) - stopped_at_) <= tolerance::edge * scale_;
        if (mu_ > 0.0 && slip <= tolerance::edge * scale_ && lately) edges_ |= 2;
        if (!compressing_) return true;
        compressing_ = false;
        drawn_in_ = drawn_in_ || has_compressed_;
        has_compressed_ = true;
        un_ = S{};
        return value_of(e_) == 0.0 ||
               (restitution_ == Restitution::newton && target_ <= tolerance::rounding * scale_);
    }

    // dP_t/dp that keeps u_t = 0.
    void holding(S& k1, S& k2) const {
        S determinant = t11_ * t22_ - t12_ * t12_, trace = t11_ + t22_;
        if (determinant > tolerance::parallel * t11_ * t22_ && determinant > 0.0) {
            k1 = (t12_ * n2_ - t22_ * n1_) / determinant;
            k2 = (t12_ * n1_ - t11_ * n2_) / determinant;
        } else {
            // W_tt of rank one at most; W_tn lies in its range.
            k1 = trace > 0.0 ? -(n1_ / trace) : S{};
            k2 = trace > 0.0 ? -(n2_ / trace) : S{};
        }
    }

    // s with (λ + µ W_tt) s = W_tn and λ > 0: the direction in which slip starts again.
    static void outgoing_of(double t11_, double t12_, double t22_, double n1_, double n2_,
                            double mu_, double& s1, double& s2) {
        double mean = 0.5 * (t11_ + t22_), half = 0.5 * (t11_ - t22_);
        double size = std::hypot(n1_, n2_);
        // |(λ + µ W_tt)⁻¹ W_tn| falls with λ: Newton on its inverse climbs to the root from below.
        double lambda =
            std::max(size - mu_ * (mean + std::hypot(half, t12_)), tolerance::rounding * size);
        s1 = n1_ / size;
        s2 = n2_ / size;
        for (int count = 0; count < 100; ++count) {
            double k1 = mu_ * t11_ + lambda, k2 = mu_ * t22_ + lambda, k12 = mu_ * t12_;
            double determinant = k1 * k2 - k12 * k12;
            s1 = (k2 * n1_ - k12 * n2_) / determinant;
            s2 = (k1 * n2_ - k12 * n1_) / determinant;
            double length = std::hypot(s1, s2);
            if (length <= 1.0 + tolerance::rounding) break;
            double slope = (k2 * s1 * s1 - 2.0 * k12 * s1 * s2 + k1 * s2 * s2) / determinant;
            double step = length * length * (length - 1.0) / slope;
            if (step <= 0.25 * tolerance::last_bits * lambda) break;
            lambda += step;
        }
        double length = std::hypot(s1, s2);
        s1 /= length;
        s2 /= length;
    }

    void outgoing(S& s1, S& s2) const {
        double x = 0.0, y = 0.0;
        outgoing_of(value_of(t11_), value_of(t12_), value_of(t22_), value_of(n1_), value_of(n2_),
                    value_of(mu_), x, y);
        s1 = number<S>(x);
        s2 = number<S>(y);
        if constexpr (is_derived) turn_outgoing(s1, s2);
    }

    // (λ + µ W_tt) s = W_tn and |s| = 1 say how s turns: across s, (λ + µ s⊥·W_tt s⊥) dφ is what is
    // given there.
    void turn_outgoing(S& s1, S& s2) const {
        const S g1 = n1_ - mu_ * (t11_ * s1 + t12_ * s2), g2 = n2_ - mu_ * (t12_ * s1 + t22_ * s2);
        const double x = s1.value, y = s2.value, lambda = x * g1.value + y * g2.value;
        const double stiff =
            y * (t11_.value * y - t12_.value * x) - x * (t12_.value * y - t22_.value * x);
        for (int k = 0; k < kPathParameters; ++k) {
            const double angle = (x * g2.slope[k] - y * g1.slope[k]) / (lambda + mu_.value * stiff);
            s1.slope[k] = -y * angle;
            s2.slope[k] = x * angle;
        }
    }

    // Slip that turns: in τ with dp = |u_t| dτ,
    //     du_t/dτ = W_tn |u_t| − µ W_tt u_t,  du_n/dτ = W_nn |u_t| − µ W_tn·u_t,
    // smooth down to |u_t| = 0 at τ → ∞, followed by Taylor series (Jorba & Zou 2005) until the
    // phase or the slip ends, or it keeps its direction. Whether the impact is over.
    bool turn() {
        const double first = length(u1_, u2_);
        const S tangential = size_of(n1_) + size_of(n2_) + mu_ * (t11_ + t22_);
        // Per step: velocities in units of |u_t|, τ of 1/inertia, impulses of |u_t|/inertia.
        const S inertia = tangential + nn_;
        const S a11 = mu_ * t11_ / inertia, a12 = mu_ * t12_ / inertia, a22 = mu_ * t22_ / inertia;
        const S w1 = n1_ / inertia, w2 = n2_ / inertia, wn = nn_ / inertia;
        for (int count = 0; count < kSteps; ++count) {
            S r = length_of(u1_, u2_);
            if (r <= tolerance::sums * first) {
                if constexpr (is_derived) stop_slip();
                u1_ = u2_ = S{};
                return false;
            }
            S s1 = u1_ / r, s2 = u2_ / r;
            S turning = size_of(s1 * (w2 - a12 * s1 - a22 * s2) - s2 * (w1 - a11 * s1 - a12 * s2));
            if (!is_derived && turning <= tolerance::solved * tangential / inertia &&
                turning * r <= tolerance::rounding * first)
                return false;
            Series<S> x{}, y{}, z{}, speed{}, square{};
            x.c[0] = s1;
            y.c[0] = s2;
            z.c[0] = un_ / r;
            speed.c[0] = square.c[0] = number<S>(1.0);
            for (int k = 0; k < kOrder; ++k) {
                double part = 1.0 / (k + 1);
                x.c[k + 1] = part * (w1 * speed.c[k] - a11 * x.c[k] - a12 * y.c[k]);
                y.c[k + 1] = part * (w2 * speed.c[k] - a12 * x.c[k] - a22 * y.c[k]);
                z.c[k + 1] = part * (wn * speed.c[k] - mu_ * (w1 * x.c[k] + w2 * y.c[k]));
                S total{}, own{};
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
    bool step(const Series<S>& x, const Series<S>& y, const Series<S>& z, const Series<S>& speed,
              const Series<S>& square, const S& r, const S& inertia) {
        double longest = 1e12;
        for (int k = kOrder - 1; k <= kOrder; ++k) {
            double size = std::max({std::abs(value_of(x.c[k])), std::abs(value_of(y.c[k])),
                                    std::abs(value_of(speed.c[k]))});
            if (size > 0.0) longest = std::min(longest, std::pow(kCut / size, 1.0 / k));
        }
        // On each step u_n shall rise or fall, not both.
        S h = number<S>(longest);
        Series<S> rise{};
        for (int k = 0; k < kOrder; ++k) rise.c[k] = (k + 1.0) * z.c[k + 1];
        if (rise.c[0] * rise.at(h) < 0.0) {
            S extreme = rise.root(S{}, h);
            if (extreme > tolerance::same * h) h = extreme;
        }
        bool falls = !compressing_ && z.c[0] + z.gain(h) < 0.0 && rise.at(h) < 0.0;
        if (falls) {
            Series<S> change = z;
            change.c[0] = S{};
            h = z.c[0] > 0.0 ? change.root(-z.c[0], h) : S{};
        }
        S velocity, impulse, work;
        left_to_go(velocity, impulse, work);
        Series<S> power = product(speed, z), end{};
        S goal;
        if (velocity < INFINITY) {
            end = z;
            end.c[0] = S{};
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
        S unit = r / inertia, p = unit * speed.integral(h);
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
            un_ = S{};
            compressing_ = true;
        }
        return reached;
    }

    // The relative residual of the law at the end.
    double end_residual() const {
        if (restitution_ == Restitution::newton) return std::abs(un_ - target_) / scale_;
        if (restitution_ == Restitution::poisson) return std::abs(p_ - (1.0 + e_) * pressed_) / p_;
        return spent_ == 0.0 ? 0.0 : std::abs(regained_ + e_ * e_ * spent_) / -spent_;
    }

    // u⁺ from the impulse, so that both agree to rounding, and the works.
    void finish(const double* free, PathImpact& impact) const {
        const double p[3] = {p1_, p2_, p_}, followed[3] = {u1_, u2_, un_};
        const double W[9] = {t11_, t12_, n1_, t12_, t22_, n2_, n1_, n2_, nn_};
        double off = 0.0, total = 0.0, size = 0.0;
        for (int i = 0; i < 3; ++i) {
            double after = free[i];
            for (int j = 0; j < 3; ++j) after += W[3 * i + j] * p[j];
            impact.impulse[i] = p[i];
            impact.after[i] = after;
            off = std::max(off, std::abs(after - followed[i]));
            total += 0.5 * p[i] * (free[i] + after);
            size += std::abs(p[i] * free[i]);
        }
        impact.friction_work = friction_;
        impact.normal_work = total - friction_;
        if (impact.status != Status::solved) return;
        if ((p1_ != 0.0 || p2_ != 0.0) && !(off <= tolerance::same * scale_))
            impact.status = Status::not_converged;
        else if (total > tolerance::gain * (size + std::abs(impact.normal_work) - friction_))
            impact.status = Status::energy_gain;
    }

    const S t11_, t12_, t22_, n1_, n2_, nn_, e_, mu_;
    const double scale_;
    const Restitution restitution_;
    S u1_, u2_, un_, p1_{}, p2_{}, p_{};
    S friction_{}, pressed_{}, spent_{}, regained_{}, target_{};
    int edges_ = 0;
    bool compressing_ = false, has_compressed_ = false, drawn_in_ = false, sticks_ = false;
    double stopped_at_ = 0.0;  // P_n when slip stopped
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
    Path<double> path(W, unit * before, own, e, mu, restitution, unit * scale);
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

void push_along_path(const double* W, const double* start, double normal, double mu,
                     double* impulse) {
    mu = mu > tolerance::negligible ? mu : 0.0;
    const double scale = std::max({W[8] * normal, std::abs(start[0]), std::abs(start[1])});
    Path<double>(W, 0.0, start, 0.0, mu, Restitution::poisson, scale).push(normal, impulse);
}

PathDerivative derive_path(const double* W, double before, const double* free, double e, double mu,
                           Restitution restitution) {
    PathDerivative found;
    // The approach of a contact that cannot move is rounding, and no impulse changes it.
    if (std::all_of(W, W + 9, [](double x) { return x == 0.0; })) return found;
    const double scale =
        std::max({std::abs(before), std::abs(free[0]), std::abs(free[1]), std::abs(free[2])});
    const double numbers[kPathParameters] = {W[0],    W[1],    W[4],    W[2],   W[5], W[8],
                                             free[0], free[1], free[2], before, e,    mu};
    Derived x[kPathParameters];
    for (int k = 0; k < kPathParameters; ++k) {
        x[k].value = numbers[k];
        x[k].slope[k] = 1.0;
    }
    const Derived block[9] = {x[0], x[1], x[3], x[1], x[2], x[4], x[3], x[4], x[5]};
    Path<Derived>(block, x[9], x + 6, x[10], x[11], restitution, scale).derive(before, found);
    return found;
}

}  // namespace impulsekit
