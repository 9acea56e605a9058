#include "contact/lzb.hpp"

#include <algorithm>
#include <cmath>

#include "contact/rest_law.hpp"
#include "contact/tolerances.hpp"
#include "integrator/stepper.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

constexpr int kMostSteps = 20000;
// Error of a step, in units in which velocities and mobilities are of size 1.
constexpr double kError = 1e-13, kImplicit = 1000.0;
// A held contact is loaded again where its force rises in this time.
constexpr double kAhead = 1e-6;

enum class Normal { open, loads, unloads, held };
// Slip that begins has a way of its own only later.
enum class Slipping { none, begins, goes_on };

// The state of several contacts while their impulses grow, in units in which the largest velocity,
// mobility and finite stiffness are 1. y: P (3 n), δ (n), work of normals (n) and of friction (n).
class LzbState {
  public:
    LzbState(const ContactProblem& problem, double exponent)
        : p_(problem),
          n_(problem.contacts),
          rows_(3 * n_),
          size_(rows_ + 3 * n_),
          exponent_(exponent),
          W_(problem.W, problem.W + rows_ * rows_),
          free_(problem.free, problem.free + rows_),
          y_(size_, 0.0),
          u_(rows_),
          force_(rows_),
          kappa_(n_),
          from_(n_),
          way_(2 * n_),
          last_(2 * n_),
          normal_(n_),
          slip_(n_),
          ended_(n_) {
        double stiffest = 0.0;
        for (int i = 0; i < n_; ++i) {
            for (int k = rubs(i) ? 0 : 2; k < 3; ++k) {
                speed_ = std::max(speed_, std::abs(free_[3 * i + k]));
                mobility_ = std::max(mobility_, W_[(3 * i + k) * (rows_ + 1)]);
            }
            approach_ = std::max(approach_, -free_[3 * i + 2]);
            if (problem.stiffness[i] < INFINITY)
                stiffest = std::max(stiffest, problem.stiffness[i]);
        }
        for (int i = 0; i < n_; ++i) kappa_[i] = problem.stiffness[i] / stiffest;
    }

    ContactSolution solve() {
        bool moves = speed_ > 0.0 && mobility_ > 0.0 && approach_ > tolerance::solved * speed_;
        if (moves) {
            for (double& w : W_) w /= mobility_;
            for (double& u : free_) u /= speed_;
            for (int i = 0; i < n_; ++i)
                normal_[i] = free_[3 * i + 2] > tolerance::at_rest ? Normal::open
                             : std::isinf(kappa_[i])               ? Normal::held
                                                                   : Normal::loads;
            run();
        }
        return result(moves);
    }

  private:
    bool rubs(int i) const { return p_.friction[i] > tolerance::negligible; }
    bool springs(int i) const {
        return normal_[i] == Normal::loads || normal_[i] == Normal::unloads;
    }
    bool holds(int i) const { return normal_[i] == Normal::held; }
    bool slips(int i) const { return slip_[i] != Slipping::none; }
    double e2(int i) const { return p_.restitution[i] * p_.restitution[i]; }
    double& depth(int i) { return y_[rows_ + i]; }
    // Depth per approach: a contact that is restored gives e² of its work.
    double gives(int i) const {
        return holds(i) ? 0.0 : normal_[i] == Normal::unloads ? 1.0 / e2(i) : 1.0;
    }

    // F of a spring, or by depth.
    double spring(int i, double depth, bool slope = false) const {
        if (!springs(i) || !(depth > 0.0)) return 0.0;
        const double root = exponent_ == 1.5 ? std::sqrt(depth) : std::pow(depth, exponent_ - 1.0);
        return kappa_[i] * root * (slope ? exponent_ : depth);
    }

    // The points that rest: those that are held, and those that are pressed and do not slip.
    struct Resting {
        std::vector<int> contact;
        std::vector<double> W, b, reach, direction, load, rate;
        std::vector<char> pressed;
        RestProblem problem;
    };

    // True if slip keeps the way that it had when the step began: it is too small for a way of its
    // own, or has passed zero.
    bool keeps_way(int i) const { return slip_[i] == Slipping::begins || ahead(i) <= 0.0; }
    // Speed of slip along the way that it had when the step began.
    double ahead(int i) const {
        return u_[3 * i] * last_[2 * i] + u_[3 * i + 1] * last_[2 * i + 1];
    }
    double slip(int i) const { return rubs(i) ? std::hypot(u_[3 * i], u_[3 * i + 1]) : 0.0; }

    // Velocities, ways of slip, and the forces of springs and of their slip; then what rests.
    void find_resting(const double* y) {
        poll(rows_, rows_);
        multiply(W_.data(), rows_, y, free_.data(), u_.data());
        std::fill(force_.begin(), force_.end(), 0.0);
        Resting& r = rest_;
        r.contact.clear();
        for (int i = 0; i < n_; ++i) {
            const bool keeps = keeps_way(i);
            for (int k = 0; k < 2; ++k)
                way_[2 * i + k] = !slips(i) ? 0.0
                                  : keeps   ? last_[2 * i + k]
                                            : u_[3 * i + k] / slip(i);
            const double F = force_[3 * i + 2] = spring(i, y[rows_ + i]);
            for (int k = 0; k < 2; ++k) force_[3 * i + k] = -p_.friction[i] * F * way_[2 * i + k];
            if (holds(i) || (F > 0.0 && rubs(i) && !slips(i))) r.contact.push_back(i);
        }
        const int m = static_cast<int>(r.contact.size());
        if (m == 0) return;
        r.W.resize(9 * m * m);
        r.b.resize(3 * m);
        r.reach.resize(m);
        r.direction.resize(2 * m);
        r.load.resize(m);
        r.pressed.assign(m, 1);
        for (int a = 0; a < m; ++a) {
            const int i = r.contact[a];
            r.reach[a] = rubs(i) ? p_.friction[i] : 0.0;
            r.load[a] = holds(i) ? NAN : force_[3 * i + 2];
            for (int k = 0; k < 2; ++k) r.direction[2 * a + k] = way_[2 * i + k];
            for (int k = 0; k < 3; ++k) {
                const double* row = W_.data() + (3 * i + k) * rows_;
                r.b[3 * a + k] = dot(row, force_.data(), rows_);
                for (int c = 0; c < m; ++c)
                    std::copy(row + 3 * r.contact[c], row + 3 * r.contact[c] + 3,
                              r.W.data() + (3 * a + k) * 3 * m + 3 * c);
            }
        }
        r.problem.points = m;
        r.problem.W = r.W.data();
        r.problem.b = r.b.data();
        r.problem.reach = r.reach.data();
        r.problem.direction = r.direction.data();
        r.problem.load = r.load.data();
    }

    // dy/dt at y; velocities and forces are left in u_ and force_.
    void rates(const double* y, double* dy) {
        find_resting(y);
        const int m = static_cast<int>(rest_.contact.size());
        if (m > 0) {
            Arena::Scope scope(scratch());
            double* F = scratch().allocate(3 * m);
            rest_.rate.resize(3 * m);
            solve_rest(rest_.problem, rest_.pressed.data(), F, rest_.rate.data());
            for (int r = 0; r < 3 * m; ++r) force_[3 * rest_.contact[r / 3] + r % 3] += F[r];
        }
        if (!dy) return;
        for (int i = 0; i < n_; ++i) {
            const double *f = force_.data() + 3 * i, *u = u_.data() + 3 * i;
            std::copy(f, f + 3, dy + 3 * i);
            dy[rows_ + i] = -gives(i) * u[2];
            dy[rows_ + n_ + i] = f[2] * u[2];
            dy[rows_ + 2 * n_ + i] = f[0] * u[0] + f[1] * u[1];
        }
    }

    // ∂(dy/dt)/∂y (size, size); works follow from the rest, and nothing from them.
    void slopes(const double* y, double* J) {
        rates(y, nullptr);
        std::fill(J, J + size_ * size_, 0.0);
        for (int i = 0; i < n_; ++i) {
            const double* W = W_.data() + 3 * i * rows_;
            for (int c = 0; c < rows_; ++c)
                J[(rows_ + i) * size_ + c] = -gives(i) * W[2 * rows_ + c];
            const double *s = way_.data() + 2 * i, rise = spring(i, y[rows_ + i], true);
            J[(3 * i + 2) * size_ + rows_ + i] = rise;
            if (!slips(i)) continue;
            const double turns =
                -p_.friction[i] * force_[3 * i + 2] / std::hypot(u_[3 * i], u_[3 * i + 1]);
            for (int k = 0; k < 2; ++k) {
                double* row = J + (3 * i + k) * size_;
                row[rows_ + i] = -p_.friction[i] * rise * s[k];
                for (int c = 0; c < rows_; ++c)
                    row[c] =
                        turns * (W[k * rows_ + c] - s[k] * (s[0] * W[c] + s[1] * W[rows_ + c]));
            }
        }
        const int m = static_cast<int>(rest_.contact.size());
        if (m == 0) return;
        // Contacts at rest answer to the forces of all others.
        Arena::Scope scope(scratch());
        double *answer = scratch().allocate(9 * m * m), *b = scratch().allocate(3 * m),
               *known = scratch().allocate(rows_);
        rest_slopes(rest_.problem, rest_.pressed.data(), answer);
        for (int c = 0; c < rows_ + n_; ++c) {
            for (int r = 0; r < rows_; ++r) known[r] = J[r * size_ + c];
            for (int r = 0; r < 3 * m; ++r)
                b[r] = dot(W_.data() + (3 * rest_.contact[r / 3] + r % 3) * rows_, known, rows_);
            for (int r = 0; r < 3 * m; ++r)
                J[(3 * rest_.contact[r / 3] + r % 3) * size_ + c] +=
                    dot(answer + r * 3 * m, b, 3 * m);
        }
    }

    // The least margin of any contact to its next change along its normal, at y whose velocities
    // are known: below zero it is past.
    double margin(const double* y) {
        const std::vector<double>& rise = rises_of_held(y);
        double least = 1.0;
        for (int i = 0; i < n_; ++i) {
            const double un = u_[3 * i + 2], depth = y[rows_ + i];
            if (normal_[i] != Normal::open) {
                if (slips(i)) least = std::min(least, ahead(i) - from_[i]);
                if (slip_[i] != Slipping::goes_on && slip(i) > tolerance::gain)
                    least = std::min(least, tolerance::gain - slip(i));
            }
            if (holds(i)) {
                least = std::min({least, -rise[i], -un});
                continue;
            }
            if (normal_[i] == Normal::open) {
                if (un < -tolerance::at_rest) least = std::min(least, -depth);
                continue;
            }
            if (un > 0.0) least = std::min(least, depth);
            if (normal_[i] == Normal::unloads)
                least = std::min(least, un);
            else if (e2(i) < 1.0 && depth > tolerance::solved)
                least = std::min(least, -un);
        }
        return least;
    }

    void run() {
        const Stepper::Rate f = [this](double, const double* y, double* dy) {
            rates(y, dy);
            return true;
        };
        Stepper stepper(Method::dop853, 0, size_, {kError, kError, kImplicit, 0.0}, 0.0);
        stepper.slopes = [this](const double* y, double* J) { slopes(y, J); };
        stepper.next = 1e-3;
        settle();
        std::vector<double> next, rate(size_);
        for (steps_ = 0; steps_ < kMostSteps; ++steps_) {
            rates(y_.data(), rate.data());
            if (is_over()) return;
            Step step;
            next = y_;
            // Nothing depends on time itself: each step begins at zero.
            if (!stepper.step(f, [](double*) {}, 0.0, next.data(), rate.data(), INFINITY, step))
                break;
            rates(next.data(), nullptr);
            if (margin(next.data()) < -tolerance::solved) {
                shorten(stepper, f, step, next);
                stepper.restart();
                stepper.next = std::max(step.end, kAhead);
            }
            y_ = next;
            settle();
        }
        status_ = Status::not_converged;
    }

    // Decide what contacts do from here on.
    void settle() {
        end_slips();
        remove_drift();
        // A contact that has come to be held may have to be let go at once.
        for (int k = 0; k < 2 * n_; ++k) change_normal(k % n_);
        begin_slips();
    }

    // The ways of slip at the end of a step; slip that has passed zero has ended.
    void end_slips() {
        rates(y_.data(), nullptr);
        for (int i = 0; i < n_; ++i) {
            const double speed = slip(i);
            const bool slipped = slips(i),
                       remains = slipped && speed > tolerance::solved && ahead(i) > 0.0;
            slip_[i] = speed > tolerance::gain ? Slipping::goes_on
                       : remains               ? Slipping::begins
                                               : Slipping::none;
            for (int k = 0; k < 2 && slips(i); ++k) last_[2 * i + k] = u_[3 * i + k] / speed;
            from_[i] = 0.0;
            ended_[i] = slipped && !slips(i);
        }
    }

    // Bring what is left of velocities of all that sticks and is held to zero, by impulses of its
    // own.
    void remove_drift() {
        rates(y_.data(), nullptr);
        const int m = static_cast<int>(rest_.contact.size());
        double drift = 0.0;
        for (int i : rest_.contact) {
            if (holds(i)) drift = std::max(drift, std::abs(u_[3 * i + 2]));
            if (rubs(i) && !slips(i)) drift = std::max(drift, std::hypot(u_[3 * i], u_[3 * i + 1]));
        }
        if (drift <= tolerance::solved) return;
        Arena::Scope scope(scratch());
        double *answer = scratch().allocate(9 * m * m), *u = scratch().allocate(3 * m);
        rest_slopes(rest_.problem, rest_.pressed.data(), answer);
        for (int r = 0; r < 3 * m; ++r) u[r] = u_[3 * rest_.contact[r / 3] + r % 3];
        for (int r = 0; r < 3 * m; ++r)
            y_[3 * rest_.contact[r / 3] + r % 3] += dot(answer + r * 3 * m, u, 3 * m);
        rates(y_.data(), nullptr);
    }

    // A contact that is held by all its friction begins to slip, or may: against its friction.
    void begin_slips() {
        rates(y_.data(), nullptr);
        const double most = largest(rest_.b.data(), 3 * static_cast<int>(rest_.contact.size()));
        for (std::size_t a = 0; a < rest_.contact.size(); ++a) {
            const int i = rest_.contact[a];
            const double *rate = rest_.rate.data() + 3 * a, torn = std::hypot(rate[0], rate[1]);
            if (slips(i) || !rubs(i) || !(torn > tolerance::torn * most)) continue;
            slip_[i] = Slipping::begins;
            for (int k = 0; k < 2; ++k) last_[2 * i + k] = rate[k] / torn;
            from_[i] = std::min(0.0, ahead(i));
        }
    }

    // The step to just beyond the first change in it: false position, halved (Illinois).
    void shorten(Stepper& stepper, const Stepper::Rate& f, Step& step, std::vector<double>& next) {
        Step cut;
        const auto left = [&](double end) -> double {
            if (!stepper.shortened(f, step, end, cut)) return NAN;
            cut.at(end, next.data());
            rates(next.data(), nullptr);
            return margin(next.data()) + 2.0 * tolerance::solved;
        };
        double low = 0.0, high = step.end;
        double at_low = 1.0, at_high = margin(next.data()) + 2.0 * tolerance::solved;
        for (int count = 0; count < 100 && high - low > tolerance::rounding * step.end; ++count) {
            double middle = (low * at_high - high * at_low) / (at_high - at_low);
            if (count % 2 == 1 || !(low < middle && middle < high)) middle = 0.5 * (low + high);
            const double here = left(middle);
            if (!(here < 0.0)) {
                low = middle, at_low = std::isnan(here) ? 1.0 : here;
                at_high *= 0.5;
            } else {
                high = middle, at_high = here;
                at_low *= 0.5;
                if (here > -tolerance::solved) break;
            }
        }
        left(high);
        step.end = high;
    }

    // Decide what contact i does along its normal at the end of a step.
    void change_normal(int i) {
        rates(y_.data(), nullptr);
        const double un = u_[3 * i + 2];
        if (normal_[i] == Normal::open) {
            if (!(depth(i) >= -tolerance::solved && un < -tolerance::at_rest)) return;
            normal_[i] = std::isinf(kappa_[i]) ? Normal::held : Normal::loads;
            depth(i) = 0.0;
        } else if (holds(i)) {
            if (force_[3 * i + 2] <= tolerance::solved) {
                normal_[i] = Normal::open;
                depth(i) = 0.0;
            } else if (rises_of_held(y_.data())[i] > tolerance::solved) {
                // Loaded again where its force rises, from the force that it carries. The residue
                // of u_n = 0 after the steps would end the loading at once.
                const double F = force_[3 * i + 2];
                normal_[i] = Normal::open;
                depth(i) = 0.0;
                rates(y_.data(), nullptr);
                // Friction that draws it in holds what would part by itself.
                if (rises(i) >= 0.0) return;
                normal_[i] = Normal::loads;
                depth(i) = std::pow(F / kappa_[i], 1.0 / exponent_);
                y_[3 * i + 2] -= u_[3 * i + 2] / W_[(3 * i + 2) * (rows_ + 1)];
            }
        } else if (depth(i) <= tolerance::solved && un > tolerance::solved) {
            normal_[i] = Normal::open;
            depth(i) = -tolerance::tiny;
        } else if (normal_[i] == Normal::loads && e2(i) < 1.0 &&
                   (un > tolerance::solved ||
                    (ended_[i] && un > -tolerance::gain && rises(i) >= 0.0))) {
            // It has stopped, or friction that has ended its slip wedges it.
            ended_[i] = 0;
            normal_[i] = e2(i) > 0.0 ? Normal::unloads : Normal::held;
        } else if (normal_[i] == Normal::unloads && un < -tolerance::solved) {
            normal_[i] = Normal::loads;
        }
    }

    // du_n/dt of a contact under the forces that are there.
    double rises(int i) const { return dot(W_.data() + (3 * i + 2) * rows_, force_.data(), rows_); }

    // By how much the forces of held contacts with finite stiffness rise in a short time from y on.
    const std::vector<double>& rises_of_held(const double* y) {
        rise_.assign(n_, 0.0);
        bool any = false;
        for (int i = 0; i < n_; ++i) any = any || (holds(i) && kappa_[i] < INFINITY);
        if (!any) return rise_;
        std::vector<double> dy(size_), later(y, y + size_);
        rates(y, dy.data());
        for (int q = 0; q < size_; ++q) later[q] += kAhead * dy[q];
        rates(later.data(), nullptr);
        for (int i = 0; i < n_; ++i)
            if (holds(i) && kappa_[i] < INFINITY) rise_[i] = force_[3 * i + 2] - dy[3 * i + 2];
        rates(y, nullptr);
        return rise_;
    }

    // True if no contact has a force or approaches, or the forces move nothing any more.
    bool is_over() {
        bool presses = false, moves = false;
        double strongest_force = largest(force_.data(), rows_);
        for (int i = 0; i < n_; ++i) {
            double un = u_[3 * i + 2], f = force_[3 * i + 2];
            if (normal_[i] == Normal::open) {
                moves = moves || un < -tolerance::at_rest;
                continue;
            }
            presses = presses || f > tolerance::at_rest;
            if (holds(i)) continue;
            moves = moves || un < -tolerance::at_rest ||
                    (f > tolerance::at_rest && un > tolerance::at_rest);
            moves = moves || (f > tolerance::at_rest &&
                              std::abs(rises(i)) > tolerance::at_rest * strongest_force);
        }
        if (presses && !moves) {
            bool held = true;
            for (int r = 0; r < rows_; ++r)
                if (rubs(r / 3) || r % 3 == 2)
                    held = held && std::abs(dot(W_.data() + r * rows_, force_.data(), rows_)) <=
                                       tolerance::at_rest * strongest_force;
            if (!held) return false;
            for (int i = 0; i < n_; ++i)
                if (springs(i) && e2(i) > 0.0 && force_[3 * i + 2] > tolerance::at_rest)
                    status_ = Status::no_solution;
            return true;
        }
        return !presses && !moves;
    }

    ContactSolution result(bool has_moved) {
        ContactSolution s;
        s.impulse.assign(rows_, 0.0);
        s.after.assign(p_.free, p_.free + rows_);
        s.start = s.after;
        s.normal_work.assign(n_, 0.0);
        s.friction_work.assign(n_, 0.0);
        s.unique.assign(n_, 1);
        if (!has_moved) return s;
        const double impulse = speed_ / mobility_, work = speed_ * impulse;
        double total = 0.0, added = 0.0, size = 0.0;
        for (int r = 0; r < rows_; ++r) s.impulse[r] = y_[r] * impulse;
        multiply(p_.W, rows_, s.impulse.data(), p_.free, s.after.data());
        for (int i = 0; i < n_; ++i) {
            s.normal_work[i] = y_[rows_ + n_ + i] * work;
            s.friction_work[i] = y_[rows_ + 2 * n_ + i] * work;
            total += s.normal_work[i] + s.friction_work[i];
        }
        for (int r = 0; r < rows_; ++r) {
            added += 0.5 * s.impulse[r] * (p_.free[r] + s.after[r]);
            size += std::abs(s.impulse[r]) * (std::abs(p_.free[r]) + std::abs(s.after[r]));
        }
        s.status = status_;
        s.iterations = steps_;
        s.residual = size > 0.0 ? std::abs(added - total) / size : 0.0;
        if (status_ == Status::not_converged || !std::isfinite(added)) s.residual = 1.0;
        for (int i = 0; i < n_; ++i)
            if (std::isinf(kappa_[i]) && s.after[3 * i + 2] < -tolerance::residual * speed_)
                s.refused =
                    "contacts: contact " + std::to_string(i) +
                    " has an infinite stiffness, parts in this impact and is met again at " +
                    std::to_string(-s.after[3 * i + 2]) +
                    " m/s; such a stiffness is for supports that stay, give it a finite one";
        return s;
    }

    const ContactProblem& p_;
    const int n_, rows_, size_;
    const double exponent_;
    std::vector<double> W_, free_, y_, u_, force_, kappa_, rise_;
    std::vector<double>
        from_;  // (n) speed along its way with which slip begins, but for rounding 0
    std::vector<double> way_, last_;  // (n, 2) of slip, zeros where there is none; at the last step
    std::vector<Normal> normal_;
    std::vector<Slipping> slip_;
    std::vector<char> ended_;  // (n) whether its slip ended with the last step
    Resting rest_;
    double speed_ = 0.0, mobility_ = 0.0, approach_ = 0.0;
    Status status_ = Status::solved;
    int steps_ = 0;
};

}  // namespace

ContactSolution solve_lzb(const ContactProblem& problem, double exponent) {
    return LzbState(problem, exponent).solve();
}

}  // namespace impulsekit
