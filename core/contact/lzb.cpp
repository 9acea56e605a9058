#include "contact/lzb.hpp"

#include <algorithm>
#include <cmath>

#include "contact/cones.hpp"
#include "contact/tolerances.hpp"
#include "integrator/stepper.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

constexpr int kMostSteps = 4000, kMostChanges = 400;
// Error of a step, in units in which velocities and mobilities are of size 1.
constexpr double kError = 1e-13;
// The longest step, and how near to a change its polynomial leads, in parts of the step: what so
// many halvings of it come to.
constexpr double kLongest = 1e3, kNearly = 1e-6;
constexpr int kHalvings = 20;
// A change of what a contact does is found to this.
constexpr double kCrossed = 1e-13;
// Slip below this keeps the direction in which it began or ends.
constexpr double kFaint = 1e-10;
// A held contact is loaded again where its force rises faster.
constexpr double kRises = 1e-8;
// Forces and velocities below this have ended.
constexpr double kWeak = 1e-12;

// Compliance of redundant contacts beside their mobility; its effect is taken out again.
constexpr double kCompliance = 1e-6;
constexpr int kProximal = 4;

enum class Normal { open, loads, unloads, held };
enum class Tangent { none, slips, sticks };

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
          direction_(2 * n_, 0.0),
          normal_(n_),
          tangent_(n_, Tangent::none) {
        double stiffest = 0.0;
        for (int i = 0; i < n_; ++i) {
            for (int k = rubs(i) ? 0 : 2; k < 3; ++k) {
                speed_ = std::max(speed_, std::abs(free_[3 * i + k]));
                mobility_ = std::max(mobility_, W_[(3 * i + k) * (rows_ + 1)]);
            }
            if (problem.stiffness[i] < INFINITY)
                stiffest = std::max(stiffest, problem.stiffness[i]);
        }
        for (int i = 0; i < n_; ++i) {
            approach_ = std::max(approach_, -free_[3 * i + 2]);
            kappa_[i] =
                problem.stiffness[i] < INFINITY ? problem.stiffness[i] / stiffest : INFINITY;
        }
    }

    ContactSolution solve() {
        bool moves = speed_ > 0.0 && mobility_ > 0.0 && approach_ > 1e-13 * speed_;
        if (moves) {
            for (double& w : W_) w /= mobility_;
            for (double& u : free_) u /= speed_;
            begin();
            run();
        }
        return result(moves);
    }

  private:
    bool rubs(int i) const { return p_.friction[i] > tolerance::negligible; }
    double e2(int i) const { return p_.restitution[i] * p_.restitution[i]; }
    double& depth(int i) { return y_[rows_ + i]; }

    void begin() {
        for (int i = 0; i < n_; ++i) {
            double un = free_[3 * i + 2];
            normal_[i] = un > kWeak              ? Normal::open
                         : kappa_[i] == INFINITY ? Normal::held
                                                 : Normal::loads;
        }
        rates(y_.data(), nullptr);
        choose_slips();
    }

    void velocities(const double* y) { multiply(W_.data(), rows_, y, free_.data(), u_.data()); }

    double spring(int i, double depth) const {
        if (!(depth > 0.0)) return 0.0;
        return kappa_[i] *
               (exponent_ == 1.5 ? depth * std::sqrt(depth) : std::pow(depth, exponent_));
    }

    // The direction of slip; where it ends or begins the one that it had.
    void direction(int i, double* s) const {
        const double *u = u_.data() + 3 * i, *last = direction_.data() + 2 * i;
        double speed = std::hypot(u[0], u[1]);
        bool keeps = speed <= kFaint || u[0] * last[0] + u[1] * last[1] <= 0.0;
        for (int k = 0; k < 2; ++k) s[k] = keeps ? last[k] : u[k] / speed;
    }

    // dy/dt at y; velocities and forces are left in u_ and force_.
    void rates(const double* y, double* dy) {
        poll(rows_, rows_);
        velocities(y);
        std::fill(force_.begin(), force_.end(), 0.0);
        bool solves = false;
        for (int i = 0; i < n_; ++i) {
            bool springs = normal_[i] == Normal::loads || normal_[i] == Normal::unloads;
            double own = springs ? spring(i, y[rows_ + i]) : 0.0, s[2];
            force_[3 * i + 2] = own;
            solves = solves || normal_[i] == Normal::held || tangent_[i] == Tangent::sticks;
            if (tangent_[i] != Tangent::slips || normal_[i] == Normal::held) continue;
            direction(i, s);
            for (int k = 0; k < 2; ++k) force_[3 * i + k] = -p_.friction[i] * own * s[k];
        }
        if (solves) solve_constraint_forces();
        if (!dy) return;
        for (int i = 0; i < n_; ++i) {
            const double *f = force_.data() + 3 * i, *u = u_.data() + 3 * i;
            for (int k = 0; k < 3; ++k) dy[3 * i + k] = f[k];
            dy[rows_ + i] = normal_[i] == Normal::held      ? 0.0
                            : normal_[i] == Normal::unloads ? -u[2] / e2(i)
                                                            : -u[2];
            dy[rows_ + n_ + i] = f[2] * u[2];
            dy[rows_ + 2 * n_ + i] = f[0] * u[0] + f[1] * u[1];
        }
    }

    // Forces that keep what sticks and what is held still. Redundant contacts that stick share in
    // proportion to what their cones hold: forces in these units, of least norm, by proximal steps.
    void solve_constraint_forces() {
        Arena::Scope scope(scratch());
        int *held = scratch().allocate_int(rows_), *pivot = scratch().allocate_int(rows_);
        double *unit_force = scratch().allocate(rows_, rows_), *unit = scratch().allocate(rows_);
        int count = 0;
        double strongest = 0.0;
        for (int i = 0; i < n_; ++i)
            if (tangent_[i] == Tangent::sticks)
                strongest = std::max(strongest, p_.friction[i] * force_[3 * i + 2]);
        for (int i = 0; i < n_; ++i) {
            if (normal_[i] == Normal::held) {
                double* along = unit_force + count * rows_;
                along[3 * i + 2] = unit[count] = 1.0;
                held[count++] = 3 * i + 2;
                double s[2];
                if (tangent_[i] == Tangent::slips) {
                    direction(i, s);
                    for (int k = 0; k < 2; ++k) along[3 * i + k] = -p_.friction[i] * s[k];
                }
            }
            if (tangent_[i] != Tangent::sticks) continue;
            double own = p_.friction[i] * force_[3 * i + 2];
            for (int k = 0; k < 2; ++k) {
                unit_force[count * rows_ + 3 * i + k] = 1.0;
                unit[count] = own > 1e-6 * strongest ? own / strongest : 1.0;
                held[count++] = 3 * i + k;
            }
        }
        double *A = scratch().allocate(count, count), *lu = scratch().allocate(count, count);
        double *right = scratch().allocate(count), *x = scratch().allocate(count),
               *more = scratch().allocate(count);
        double size = 0.0;
        for (int a = 0; a < count; ++a) {
            right[a] = -unit[a] * dot(W_.data() + held[a] * rows_, force_.data(), rows_);
            for (int b = 0; b < count; ++b)
                A[a * count + b] = unit[a] * unit[b] *
                                   dot(W_.data() + held[a] * rows_, unit_force + b * rows_, rows_);
            size = std::max(size, A[a * count + a]);
        }
        std::copy(A, A + count * count, lu);
        for (int a = 0; a < count; ++a) lu[a * count + a] += kCompliance * size;
        if (!factor_lu(lu, count, pivot)) return;
        for (int round = 0; round < kProximal; ++round) {
            for (int a = 0; a < count; ++a) more[a] = right[a] - dot(A + a * count, x, count);
            solve_lu(lu, pivot, count, more);
            for (int a = 0; a < count; ++a) x[a] += more[a];
        }
        for (int b = 0; b < count; ++b)
            for (int r = 0; r < rows_; ++r) force_[r] += x[b] * unit[b] * unit_force[b * rows_ + r];
    }

    // A contact that does not slip sticks, or begins to slip along its acceleration: Coulomb's
    // law on accelerations, with the cone solver.
    void choose_slips() {
        bool any = false;
        for (int i = 0; i < n_; ++i) {
            if (!rubs(i) || normal_[i] == Normal::open) {
                tangent_[i] = Tangent::none;
                continue;
            }
            if (std::hypot(u_[3 * i], u_[3 * i + 1]) > kFaint) {
                tangent_[i] = Tangent::slips;
                remember_direction(i);
            } else {
                tangent_[i] = Tangent::sticks;
                any = true;
            }
        }
        if (!any) return;
        Cones cones;
        std::vector<double> known(rows_, 0.0), b(rows_), f(rows_, 0.0);
        for (int i = 0; i < n_; ++i) {
            bool springs = normal_[i] == Normal::loads || normal_[i] == Normal::unloads;
            double own = springs ? spring(i, depth(i)) : 0.0, s[2];
            known[3 * i + 2] = own;
            if (normal_[i] == Normal::held) {
                cones.normal.push_back(3 * i + 2);
                cones.floor.push_back(0.0);
                cones.adhesion.push_back(0.0);
            }
            if (tangent_[i] == Tangent::slips) {
                direction(i, s);
                for (int k = 0; k < 2; ++k) known[3 * i + k] = -p_.friction[i] * own * s[k];
            } else if (tangent_[i] == Tangent::sticks) {
                bool held = normal_[i] == Normal::held;
                cones.first.push_back(3 * i);
                cones.size.push_back(2);
                cones.contact.push_back(held ? static_cast<int>(cones.normal.size()) - 1 : -1);
                // Without a normal force yet the direction is that of any small force.
                cones.friction.push_back(p_.friction[i] * (held ? 1.0 : std::max(own, 1e-30)));
            }
        }
        multiply(W_.data(), rows_, known.data(), std::vector<double>(rows_, 0.0).data(), b.data());
        solve_cones(W_.data(), rows_, b.data(), largest(b.data(), rows_), cones, f.data());
        for (std::size_t g = 0; g < cones.first.size(); ++g) {
            int r = cones.first[g], i = r / 3, c = cones.contact[g];
            double bound = c < 0 ? cones.friction[g] : cones.friction[g] * f[cones.normal[c]];
            double size = std::hypot(f[r], f[r + 1]);
            if (size < bound * (1.0 - 1e-12) || size == 0.0) continue;
            tangent_[i] = Tangent::slips;
            for (int k = 0; k < 2; ++k) direction_[2 * i + k] = -f[r + k] / size;
        }
    }

    void remember_direction(int i) {
        double speed = std::hypot(u_[3 * i], u_[3 * i + 1]);
        if (speed <= kFaint) return;
        for (int k = 0; k < 2; ++k) direction_[2 * i + k] = u_[3 * i + k] / speed;
    }

    // The margin of contact i to its next change, at y whose rates are known: below zero it is
    // past.
    double distance_to_change(int i, const double* y, int kind) {
        const double* u = u_.data() + 3 * i;
        const double* f = force_.data() + 3 * i;
        if (kind == 0) {  // along the normal
            if (normal_[i] == Normal::loads)
                return e2(i) == 1.0 || y[rows_ + i] <= kCrossed ? INFINITY : -u[2];
            if (normal_[i] == Normal::unloads) return u[2];
            if (normal_[i] == Normal::held) return f[2];
            return INFINITY;
        }
        if (kind == 1) {  // the gap opens or closes
            if (normal_[i] == Normal::open) return u[2] < 0.0 ? -y[rows_ + i] : INFINITY;
            if (normal_[i] == Normal::held || u[2] <= 0.0) return INFINITY;
            return y[rows_ + i];
        }
        if (tangent_[i] == Tangent::slips)
            return u[0] * direction_[2 * i] + u[1] * direction_[2 * i + 1];
        if (tangent_[i] == Tangent::sticks) return p_.friction[i] * f[2] - std::hypot(f[0], f[1]);
        return INFINITY;
    }

    // The first contact and kind of change that is past at `next`; −1 where none is.
    int first_change(const std::vector<double>& next) {
        for (int i = 0; i < n_; ++i)
            for (int kind = 0; kind < 4; ++kind)
                if (distance_to_change(i, next.data(), kind) < -kCrossed) return 4 * i + kind;
        return -1;
    }

    void run() {
        const Stepper::Rate f = [this](double, const double* y, double* dy) {
            rates(y, dy);
            return true;
        };
        const auto as_it_is = [](double*) {};
        Stepper stepper(Method::dop853, 0, size_, {kError, kError}, 0.0);
        stepper.next = 1e-3;
        std::vector<double> next, rate(size_);
        double t = 0.0;
        int changes = 0;
        for (steps_ = 0; steps_ < kMostSteps; ++steps_) {
            rates(y_.data(), rate.data());
            if (is_over()) return;
            for (int i = 0; i < n_; ++i)
                if (tangent_[i] == Tangent::slips) remember_direction(i);
            Step step;
            next = y_;
            if (!stepper.step(f, as_it_is, t, next.data(), rate.data(), kLongest, step)) break;
            if (is_past(next)) {
                if (++changes > kMostChanges) break;
                shorten(stepper, f, step, next);
                stepper.restart();
                stepper.next = std::max(step.end - step.start, 1e-6);
            }
            y_ = next;
            t = step.end;
            update_modes();
        }
        status_ = Status::not_converged;
    }

    bool is_past(const std::vector<double>& y) {
        rates(y.data(), nullptr);
        return first_change(y) >= 0;
    }

    // The step to the first change in it, by bisection: on its polynomial, then on itself.
    void shorten(Stepper& stepper, const Stepper::Rate& f, Step& step, std::vector<double>& next) {
        double low = step.start, high = step.end;
        const double length = high - low;
        for (int count = 0; count < kHalvings; ++count) {
            const double middle = 0.5 * (low + high);
            step.at(middle, next.data());
            (is_past(next) ? high : low) = middle;
        }
        low = std::max(low - kNearly * length, step.start);
        high = std::min(high + kNearly * length, step.end);
        Step cut;
        const auto past = [&](double end) {
            if (!stepper.shortened(f, step, end, cut)) return true;
            cut.at(end, next.data());
            return is_past(next);
        };
        if (!past(high)) low = high, high = step.end;
        for (int count = 0; count < 60 && high - low > 1e-15 * length; ++count) {
            const double middle = 0.5 * (low + high);
            (past(middle) ? high : low) = middle;
        }
        past(high);
        step.end = high;
    }

    // Change the modes of contacts at the end of a step.
    void update_modes() {
        rates(y_.data(), nullptr);
        bool changed = false;
        for (int i = 0; i < n_; ++i) changed = change_normal(i) || changed;
        for (int i = 0; i < n_; ++i)
            changed = changed || distance_to_change(i, y_.data(), 3) <= 0.0;
        if (!changed) return;
        for (int i = 0; i < n_; ++i)
            if (tangent_[i] == Tangent::slips &&
                u_[3 * i] * direction_[2 * i] + u_[3 * i + 1] * direction_[2 * i + 1] <= kCrossed) {
                // Slip has ended: rounding of what is left has no direction.
                stop_slip(i);
            }
        rates(y_.data(), nullptr);
        choose_slips();
    }

    // Bring what is left of slip to zero by the impulse that takes.
    void stop_slip(int i) {
        double a = W_[(3 * i) * rows_ + 3 * i], b = W_[(3 * i) * rows_ + 3 * i + 1];
        double c = W_[(3 * i + 1) * rows_ + 3 * i + 1], determinant = a * c - b * b;
        if (!(determinant > 1e-12 * a * c)) return;
        double u = u_[3 * i], v = u_[3 * i + 1];
        if (std::hypot(u, v) > 1e-9) return;
        y_[3 * i] -= (c * u - b * v) / determinant;
        y_[3 * i + 1] -= (a * v - b * u) / determinant;
    }

    bool change_normal(int i) {
        double un = u_[3 * i + 2];
        switch (normal_[i]) {
            case Normal::open:
                if (!(depth(i) >= -kCrossed && un < -kWeak)) return false;
                normal_[i] = kappa_[i] < INFINITY ? Normal::loads : Normal::held;
                depth(i) = 0.0;
                return true;
            case Normal::held:
                if (force_[3 * i + 2] <= kCrossed) {
                    normal_[i] = Normal::open;
                    depth(i) = 0.0;
                    return true;
                }
                return kappa_[i] < INFINITY && reloads(i);
            default:
                break;
        }
        if (depth(i) <= kCrossed && un > kCrossed) {
            normal_[i] = Normal::open;
            depth(i) = -1e-30;
            return true;
        }
        if (normal_[i] == Normal::loads && e2(i) < 1.0 && un >= -kCrossed && depth(i) > kCrossed) {
            if (rises(i) < 0.0) return false;
            normal_[i] = e2(i) > 0.0 ? Normal::unloads : Normal::held;
            return true;
        }
        if (normal_[i] == Normal::unloads && un <= kCrossed && rises(i) < 0.0) {
            normal_[i] = Normal::loads;
            return true;
        }
        return false;
    }

    // du_n/dt of a contact under the forces that are there.
    double rises(int i) const { return dot(W_.data() + (3 * i + 2) * rows_, force_.data(), rows_); }

    // dF/dt of contact i at y, by a short way along the rates; forces are kept.
    double force_rate(int i, const double* y) {
        constexpr double ahead = 1e-6;
        std::vector<double> dy(size_), later(y, y + size_);
        rates(y, dy.data());
        double now = force_[3 * i + 2];
        for (int q = 0; q < size_; ++q) later[q] += ahead * dy[q];
        rates(later.data(), nullptr);
        double rate = (force_[3 * i + 2] - now) / ahead;
        rates(y, nullptr);
        return rate;
    }

    // A held contact is loaded again where its force rises, from the force that it carries.
    bool reloads(int i) {
        if (!(force_rate(i, y_.data()) > kRises)) return false;
        double now = force_[3 * i + 2];
        normal_[i] = Normal::loads;
        depth(i) = std::pow(now / kappa_[i], 1.0 / exponent_);
        // The residue of u_n = 0 after the steps would end the loading at once.
        y_[3 * i + 2] -= u_[3 * i + 2] / W_[(3 * i + 2) * (rows_ + 1)];
        return true;
    }

    // True if no contact has a force or approaches, or the forces move nothing any more.
    bool is_over() {
        bool presses = false, moves = false;
        double strongest_force = largest(force_.data(), rows_);
        for (int i = 0; i < n_; ++i) {
            double un = u_[3 * i + 2], f = force_[3 * i + 2];
            if (normal_[i] == Normal::open) {
                moves = moves || un < -1e-13;
                continue;
            }
            presses = presses || f > kWeak;
            if (normal_[i] == Normal::held) continue;
            moves = moves || un < -1e-13 || (depth(i) > 0.0 && un > 1e-13 && f > 0.0);
            moves = moves || (f > kWeak && std::abs(rises(i)) > kWeak * strongest_force);
        }
        if (presses && !moves) {
            bool held = true;
            for (int r = 0; r < rows_; ++r)
                if (rubs(r / 3) || r % 3 == 2)
                    held = held && std::abs(dot(W_.data() + r * rows_, force_.data(), rows_)) <=
                                       kWeak * strongest_force;
            if (!held) return false;
            for (int i = 0; i < n_; ++i)
                if (normal_[i] != Normal::open && normal_[i] != Normal::held && e2(i) > 0.0 &&
                    force_[3 * i + 2] > kWeak)
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
            if (kappa_[i] == INFINITY && s.after[3 * i + 2] < -1e-9 * speed_)
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
    std::vector<double> W_, free_, y_, u_, force_, kappa_, direction_;
    std::vector<Normal> normal_;
    std::vector<Tangent> tangent_;
    double speed_ = 0.0, mobility_ = 0.0, approach_ = 0.0;
    Status status_ = Status::solved;
    int steps_ = 0;
};

}  // namespace

ContactSolution solve_lzb(const ContactProblem& problem, double exponent) {
    return LzbState(problem, exponent).solve();
}

}  // namespace impulsekit
