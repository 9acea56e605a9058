#include "contact/outcomes.hpp"

#include <algorithm>
#include <cmath>

#include "contact/path.hpp"
#include "contact/schedule.hpp"
#include "contact/sequence.hpp"
#include "contact/simultaneous.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"
#include "linalg/numbers.hpp"
#include "linalg/parallel.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// Orders that follow each other in the compression, and in the expansion.
constexpr int kCompressions = 4, kExpansions = 2;
// Friction of contacts that stick together is looked for by so many sweeps.
constexpr int kSweeps = 200;
// Approach below this share of the velocities has ended: a tenth of what a law's residual may be.
constexpr double kEnded = 0.1 * tolerance::residual;

constexpr auto kDone = static_cast<std::int8_t>(OutcomeState::ended);

// One outcome of a problem after the other.
class Process {
  public:
    explicit Process(const ContactProblem& problem)
        : p_(problem),
          n_(problem.contacts),
          rows_(problem.rows()),
          ended_(kEnded * velocity_scale(problem)),
          blocks_(9 * n_),
          u_(rows_),
          budget_(n_),
          zeros_(n_),
          goal_(n_),
          rate_(rows_),
          change_(rows_) {
        double lightest = 0.0;
        for (int i = 0; i < n_; ++i) lightest = std::max(lightest, mobility(i));
        for (int i = 0; i < n_; ++i) {
            moves_.push_back(mobility(i) > tolerance::immovable * lightest);
            expands_ = expands_ || problem.restitution[i] > 0.0;
            for (int k = 0; k < 9; ++k)
                blocks_[9 * i + k] = problem.W[(3 * i + k / 3) * rows_ + 3 * i + k % 3];
        }
    }

    // The count of numbers that say an outcome.
    int numbers() const {
        return Schedule::size(n_, kCompressions) + (expands_ ? Schedule::size(n_, kExpansions) : 0);
    }

    std::int8_t run(const double* numbers, double* P, double* work) {
        return static_cast<std::int8_t>(end(numbers, P, work));
    }

  private:
    OutcomeState end(const double* numbers, double* P, double* work) {
        std::copy(p_.free, p_.free + rows_, u_.begin());
        std::fill(P, P + rows_, 0.0);
        std::fill(budget_.begin(), budget_.end(), 0.0);
        bool ends = follow(Schedule(numbers, n_, kCompressions), P);
        if (ends && expands_) {
            for (int i = 0; i < n_; ++i) budget_[i] = p_.restitution[i] * P[3 * i + 2];
            ends =
                follow(Schedule(numbers + Schedule::size(n_, kCompressions), n_, kExpansions), P);
        }
        multiply(p_.W, rows_, P, p_.free, u_.data());
        double size = 0.0;
        *work = 0.0;
        for (int r = 0; r < rows_; ++r) {
            const double own = 0.5 * P[r] * (p_.free[r] + u_[r]);
            *work += own;
            size += std::abs(own);
        }
        if (!ends) return OutcomeState::not_ended;
        const bool gains = gains_energy(P, p_.free, p_.free, rows_, *work, size);
        return gains ? OutcomeState::gains_energy : OutcomeState::ended;
    }

    double mobility(int i) const { return p_.W[(3 * i + 2) * (rows_ + 1)]; }

    // Piece after piece until nothing approaches and no budget is left.
    bool follow(Schedule schedule, double* P) {
        if (schedule.tries_all() && press_all(P)) return true;
        for (int i; (i = chosen(schedule)) >= 0;) {
            poll(rows_, 3, 10);
            const bool together = schedule.is_shared() && press_shared(schedule, P);
            if (!together && !press(i, schedule.fraction(), P)) return false;
            schedule.advance();
            if (schedule.tries_all() && press_all(P)) return true;
            if (schedule.is_long()) return press_in_turn(P);
        }
        return true;
    }

    // A piece of all contacts that approach, in shares by their weights, until the approach of one
    // has fallen by a fraction; false where slip turns, which only one contact is followed along.
    bool press_shared(const Schedule& schedule, double* P) {
        for (int i = 0; i < n_; ++i) {
            const bool acts = moves_[i] && u_[3 * i + 2] < -ended_;
            rate_[3 * i + 2] = acts ? std::sqrt(std::sqrt(schedule.weight(i))) : 0.0;
            goal_[i] = (1.0 - schedule.fraction()) * u_[3 * i + 2];
        }
        for (int count = 0; count <= 2 * n_; ++count) {
            if (!set_friction()) return false;
            double step = INFINITY;
            bool ends = false;
            for (int i = 0; i < n_; ++i) {
                const double own = until(goal_[i] - u_[3 * i + 2], change_[3 * i + 2]);
                if (rate_[3 * i + 2] > 0.0 && own <= step) {
                    step = own;
                    ends = true;
                }
                const double slip = slip_of(i);
                const double stop = until(-slip, slip > 0.0 ? slip_change(i) / slip : 0.0);
                if (rate_[3 * i + 2] > 0.0 && stop < step) {
                    step = stop;
                    ends = false;
                }
            }
            if (!(step < INFINITY)) return false;
            for (int r = 0; r < rows_; ++r) {
                P[r] += step * rate_[r];
                u_[r] += step * change_[r];
            }
            if (ends) return true;
        }
        return false;
    }

    // The way to go at a rate; infinite where the rate leads away.
    static double until(double distance, double rate) {
        return distance * rate > 0.0 ? distance / rate : INFINITY;
    }

    double slip_of(int i) const {
        const double slip = std::hypot(u_[3 * i], u_[3 * i + 1]);
        return slip > ended_ ? slip : 0.0;
    }
    double slip_change(int i) const {
        return u_[3 * i] * change_[3 * i] + u_[3 * i + 1] * change_[3 * i + 1];
    }

    // Friction beside the normal rates: against the slip, or what keeps sticking as far as it can;
    // and the changes W dP. False where slip turns, or what sticks is not found.
    bool set_friction() {
        for (int i = 0; i < n_; ++i) {
            const double slip = slip_of(i), most = p_.friction[i] * rate_[3 * i + 2];
            for (int k = 0; k < 2; ++k)
                rate_[3 * i + k] = slip > 0.0 ? -most * u_[3 * i + k] / slip : 0.0;
        }
        double off = INFINITY;
        for (int sweep = 0; sweep < kSweeps && off > tolerance::rounding; ++sweep) {
            off = 0.0;
            for (int i = 0; i < n_; ++i) off = std::max(off, hold(i));
        }
        if (off > tolerance::at_rest) return false;
        for (int r = 0; r < rows_; ++r) change_[r] = dot(p_.W + r * rows_, rate_.data(), rows_);
        for (int i = 0; i < n_; ++i) {
            const double slip = slip_of(i);
            const double turn = u_[3 * i] * change_[3 * i + 1] - u_[3 * i + 1] * change_[3 * i];
            if (p_.friction[i] * rate_[3 * i + 2] > 0.0 && slip > 0.0 &&
                std::abs(turn) >
                    tolerance::at_rest * slip * std::hypot(change_[3 * i], change_[3 * i + 1]))
                return false;
        }
        return true;
    }

    // A step of a sticking contact's friction towards rest; its size over the largest friction.
    double hold(int i) {
        const double most = p_.friction[i] * rate_[3 * i + 2];
        const double* W = p_.W + 3 * i * rows_;
        const double trace = W[3 * i] + W[rows_ + 3 * i + 1];
        if (!(most > 0.0) || slip_of(i) > 0.0 || !(trace > 0.0)) return 0.0;
        double next[2], size = 0.0, step = 0.0;
        for (int k = 0; k < 2; ++k) {
            next[k] = rate_[3 * i + k] - dot(W + k * rows_, rate_.data(), rows_) / trace;
            size = std::hypot(size, next[k]);
        }
        for (int k = 0; k < 2; ++k) {
            if (size > most) next[k] *= most / size;
            step = std::max(step, std::abs(next[k] - rate_[3 * i + k]));
            rate_[3 * i + k] = next[k];
        }
        return step / most;
    }

    // The compression that remains.
    ContactProblem remaining() const {
        ContactProblem rest = p_;
        rest.before = rest.free = u_.data();
        rest.restitution = rest.tangential = zeros_.data();
        return rest;
    }

    // Spend what is left of budgets; false where friction jams a contact.
    bool spend(double* P) {
        for (int i = 0; i < n_; ++i)
            if (budget_[i] * mobility(i) > ended_ && !press(i, 1.0, P)) return false;
        return true;
    }

    // All contacts at once to their end, in constant shares; false where their friction would not
    // keep its direction on the way.
    bool press_all(double* P) {
        if (!spend(P)) return false;
        const ContactSolution found = solve_simultaneous(remaining(), Law{});
        if (found.status != Status::solved) return false;
        for (int i = 0; i < n_; ++i)
            if (!is_straight(i, found)) return false;
        return add(found, P);
    }

    // Whole impacts, the fastest approach first; false where they have no end.
    bool press_in_turn(double* P) {
        if (!spend(P)) return false;
        const Law law{Restitution::newton, Slip::path, Order::sequential};
        const ContactSolution found = solve_sequence(remaining(), law);
        return found.status <= Status::energy_gain && add(found, P);
    }

    bool add(const ContactSolution& found, double* P) {
        for (int r = 0; r < rows_; ++r) {
            P[r] += found.impulse[r];
            u_[r] = found.after[r];
        }
        return true;
    }

    // True if a contact sticks all the way, or its slip turns by no more than rounding.
    bool is_straight(int i, const ContactSolution& found) const {
        const double *u = u_.data() + 3 * i, *after = found.after.data() + 3 * i;
        const double normal = found.impulse[3 * i + 2];
        if (!(p_.friction[i] > 0.0 && normal > 0.0)) return true;
        const double slip = std::hypot(u[0], u[1]), end = std::hypot(after[0], after[1]);
        if (end <= ended_) return slip <= ended_;
        const double turn = (u[0] * after[1] - u[1] * after[0]) / (slip * end);
        const double friction = p_.friction[i] * normal * mobility(i);
        return u[0] * after[0] + u[1] * after[1] > 0.0 && friction * std::abs(turn) <= ended_;
    }

    // Among contacts that approach or expand the one with the largest weighted speed √W_nn P_n.
    int chosen(const Schedule& schedule) const {
        int best = -1;
        double most = 0.0;
        for (int i = 0; i < n_; ++i) {
            const double left = std::max(budget_[i] * mobility(i), -u_[3 * i + 2]);
            if (!(left > ended_) || !moves_[i]) continue;
            const double pace = schedule.weight(i) * left / std::sqrt(mobility(i));
            if (pace > most) {
                best = i;
                most = pace;
            }
        }
        return best;
    }

    // A piece of one contact; false where friction jams it.
    bool press(int i, double fraction, double* P) {
        const double* W = blocks_.data() + 9 * i;
        const double* u = u_.data() + 3 * i;
        double impulse[3];
        if (budget_[i] * mobility(i) > ended_) {
            push_along_path(W, u, fraction * budget_[i], p_.friction[i], impulse);
            budget_[i] -= impulse[2];
        } else {
            // Paths end at u_n = 0, and nothing else depends on u_n.
            const double start[3] = {u[0], u[1], fraction * u[2]};
            const PathImpact found =
                follow_path(W, 0.0, start, 0.0, p_.friction[i], Restitution::newton);
            if (found.status > Status::energy_gain || !(found.impulse[2] > 0.0)) return false;
            std::copy(found.impulse, found.impulse + 3, impulse);
        }
        for (int k = 0; k < 3; ++k) P[3 * i + k] += impulse[k];
        for (int r = 0; r < rows_; ++r) u_[r] += dot(p_.W + r * rows_ + 3 * i, impulse, 3);
        return true;
    }

    const ContactProblem& p_;
    const int n_, rows_;
    const double ended_;  // [m/s]
    std::vector<double> blocks_, u_, budget_, zeros_, goal_, rate_, change_;
    std::vector<char> moves_;
    bool expands_ = false;
};

void draw(std::uint64_t seed, std::size_t sample, std::vector<double>& numbers) {
    Random random(seed, sample);
    for (double& x : numbers) x = random.next();
}

// From a start, changes of some numbers that do not make d·P smaller.
class Ascent {
  public:
    Ascent(const ContactProblem& problem, int tries)
        : process_(problem), rows_(problem.rows()), tries_(tries), trial_(rows_) {}

    void climb(const double* direction, std::vector<double> best, Random random, double* P,
               double* work, std::int8_t* state) {
        const double share = std::min(1.0, 2.0 / static_cast<double>(best.size()));
        *state = process_.run(best.data(), P, work);
        double most = *state == kDone ? dot(direction, P, rows_) : -INFINITY;
        std::vector<double> changed;
        for (int k = 0; k < tries_; ++k) {
            changed = best;
            const double size = std::exp2(-10.0 * random.next());
            for (double& x : changed)
                if (random.next() < share)
                    x = std::clamp(x + size * (2.0 * random.next() - 1.0), 0.0, 1.0);
            double own = 0.0;
            if (process_.run(changed.data(), trial_.data(), &own) != kDone) continue;
            const double value = dot(direction, trial_.data(), rows_);
            if (!(value >= most)) continue;
            most = value;
            best.swap(changed);
            std::copy(trial_.begin(), trial_.end(), P);
            *work = own;
            *state = kDone;
        }
    }

  private:
    Process process_;
    const int rows_, tries_;
    std::vector<double> trial_;
};

}  // namespace

Outcomes find_outcomes(const ContactProblem& problem, int samples, const double* directions, int K,
                       int tries, std::uint64_t seed, int threads) {
    const std::size_t r = problem.rows(), S = samples, all = S + K;
    Outcomes found;
    found.impulses.resize(all * r);
    found.works.resize(all);
    found.states.resize(all);
    run_parallel(S, threads, [&] {
        return [&, process = Process(problem), x = std::vector<double>()](std::size_t k) mutable {
            x.resize(process.numbers());
            draw(seed, k, x);
            found.states[k] = process.run(x.data(), found.impulses.data() + k * r, &found.works[k]);
        };
    });
    const std::size_t size = Process(problem).numbers();
    run_parallel(K, threads, [&] {
        return [&, ascent = Ascent(problem, tries)](std::size_t k) mutable {
            const double* d = directions + k * r;
            std::size_t first = 0;
            double most = -INFINITY;
            for (std::size_t i = 0; i < S; ++i) {
                const double value = dot(d, found.impulses.data() + i * r, static_cast<int>(r));
                if (found.states[i] != kDone || !(value > most)) continue;
                first = i;
                most = value;
            }
            std::vector<double> start(size);
            draw(seed, first, start);
            const std::size_t at = S + k;
            ascent.climb(d, start, Random(seed, at), found.impulses.data() + at * r,
                         &found.works[at], &found.states[at]);
        };
    });
    return found;
}

}  // namespace impulsekit
