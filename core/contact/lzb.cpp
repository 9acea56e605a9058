#include "contact/lzb.hpp"

#include <algorithm>
#include <cmath>

#include "contact/lzb_changes.hpp"
#include "integrator/stepper.hpp"
#include "integrator/zero.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

constexpr int kMostSteps = 20000;
// Searches within a step for the time of a change.
constexpr int kSearches = 60;

// The impulses of a state, followed in time.
class Waves {
  public:
    explicit Waves(LzbState& state)
        : y(state.size(), 0.0),
          state_(state),
          stepper_(Method::dop853, 0, state.size(),
                   {tolerance::solved, tolerance::solved, tolerance::implicit, 0.0}, 0.0),
          f_([&state](double, const double* at, double* dy) {
              state.rates(at, dy);
              return true;
          }) {
        stepper_.slopes = [&state](const double* at, double* J) { state.slopes(at, J); };
        stepper_.next = kAhead;
    }

    void follow() {
        begin_contacts(state_, y.data());
        std::vector<double> next, rate(y.size());
        for (; steps < kMostSteps; ++steps) {
            state_.rates(y.data(), rate.data());
            bool wedged = false;
            if (is_impact_over(state_, wedged)) {
                if (wedged) status = Status::no_solution;
                return;
            }
            Step step;
            next = y;
            // Nothing depends on time itself: each step begins at zero.
            if (!stepper_.step(f_, [](double*) {}, 0.0, next.data(), rate.data(), INFINITY, step))
                break;
            if (past(next) < -tolerance::solved) {
                shorten(step, next);
                stepper_.restart();
                stepper_.next = std::max(step.end, kAhead);
            }
            y = next;
            settle_contacts(state_, y.data());
            stepper_.is_stiff = state_.turns_fast(y.data());
        }
        status = Status::not_converged;
    }

    std::vector<double> y;
    int steps = 0;
    Status status = Status::solved;

  private:
    double past(const std::vector<double>& at) {
        state_.rates(at.data(), nullptr);
        return margin_of_change(state_, at.data());
    }

    // The step to just beyond the first change in it: the time at which the step's polynomial puts
    // it, corrected by what a step to there finds, or halved.
    void shorten(Step& step, std::vector<double>& next) {
        const double beyond = 2.0 * tolerance::solved;
        Step cut;
        double low = 0.0, high = step.end, correction = beyond, time = high;
        for (int count = 0; count < kSearches && high - low > tolerance::rounding * step.end;
             ++count) {
            double expected = 0.0;
            const auto on_polynomial = [&](double at) {
                step.at(at, next.data());
                return expected = past(next) + correction;
            };
            const double at_low = on_polynomial(low), at_high = on_polynomial(high);
            const double guess = at_low > 0.0 && at_high < 0.0 && count % 4 < 3
                                     ? zero_between(low, at_low, high, at_high, on_polynomial)
                                     : 0.5 * (low + high);
            time = low < guess && guess < high ? guess : 0.5 * (low + high);
            expected = on_polynomial(time);
            double here = NAN;
            if (stepper_.shortened(f_, step, time, cut)) {
                cut.at(time, next.data());
                here = past(next) + beyond;
            }
            (here < 0.0 ? high : low) = time;
            if (here < 0.0 && here > -tolerance::solved) break;
            correction += std::isfinite(here) ? here - expected : 0.0;
        }
        if (stepper_.shortened(f_, step, high, cut)) cut.at(high, next.data());
        step.end = high;
    }

    LzbState& state_;
    Stepper stepper_;
    Stepper::Rate f_;
};

ContactSolution unmoved(const ContactProblem& p) {
    ContactSolution s;
    s.impulse.assign(p.rows(), 0.0);
    s.after.assign(p.free, p.free + p.rows());
    s.start = s.after;
    s.normal_work.assign(p.contacts, 0.0);
    s.friction_work.assign(p.contacts, 0.0);
    s.unique.assign(p.contacts, 1);
    return s;
}

}  // namespace

ContactSolution solve_lzb(const ContactProblem& p, const Law& law) {
    ContactSolution s = unmoved(p);
    const int rows = p.rows();
    LzbState state(p, law);
    if (!(state.mobility > 0.0 && state.approach > tolerance::solved * state.speed)) return s;
    Waves waves(state);
    waves.follow();
    const double impulse = state.speed / state.mobility, work = state.speed * impulse;
    double total = 0.0, added = 0.0, size = 0.0;
    for (int i = 0; i < p.contacts; ++i) {
        const LzbContact& c = state.contacts[i];
        for (int k = c.rubs() ? 0 : 2; k < 3; ++k)
            s.impulse[3 * i + k] = waves.y[c.normal_row + k - 2] * impulse;
        s.normal_work[i] = c.normal_work * work;
        s.friction_work[i] = c.rubs() ? waves.y[c.work] * work : 0.0;
        total += s.normal_work[i] + s.friction_work[i];
    }
    multiply(p.W, rows, s.impulse.data(), p.free, s.after.data());
    for (int r = 0; r < rows; ++r) {
        added += 0.5 * s.impulse[r] * (p.free[r] + s.after[r]);
        size += std::abs(s.impulse[r]) * (std::abs(p.free[r]) + std::abs(s.after[r]));
    }
    s.status = waves.status;
    s.iterations = waves.steps;
    s.residual = size > 0.0 ? std::abs(added - total) / size : 0.0;
    if (waves.status == Status::not_converged || !std::isfinite(added)) s.residual = 1.0;
    for (int i = 0; i < p.contacts; ++i)
        if (std::isinf(state.contacts[i].stiffness) &&
            s.after[3 * i + 2] < -tolerance::residual * state.speed)
            s.refused = "contacts: contact " + std::to_string(i) +
                        " has an infinite stiffness, parts in this impact and is met again at " +
                        std::to_string(-s.after[3 * i + 2]) +
                        " m/s; such a stiffness is for supports that stay, give it a finite one";
    return s;
}

}  // namespace impulsekit
