// Events that end a step: gaps that close, and functions of the state that fall to zero.
#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "integrator/zero.hpp"
#include "motion/motion.hpp"

namespace impulsekit {
namespace {

// Gaps may close between the nodes of a step so many times as fast as at them.
constexpr double kFaster = 1.3;
// Parts of a step at which it is looked at.
constexpr double kNodes[] = {0.0, 0.25, 0.5, 0.75, 1.0};
// Bodies turn no further than this [rad] between two looks at them.
constexpr double kSeen = 0.7;
constexpr int kMostAdvances = 400;
// So much of the time in which a gap surely stays open is gone at once: a step that ended just
// where it closes would not see on which side it is.
constexpr double kShort = 0.9;
// Below this distance [m] nothing is thin enough to be passed.
constexpr double kNear = 1e-7;

// The first zero of a gap from `at` to `until`, see `first_closing`. `bend`: of a smooth rate; 0
// for none. `change`: by how much the rate seems to change in a second.
template <typename Measure>
double advance_to_zero(Measure measure, double at, double until, GapState now, double fastest,
                       double bend, double change, double& unsure) {
    const double least = 1e-5 * (until - at);
    double last = 0.0;
    for (int count = 0; at < until; ++count) {
        if (count == kMostAdvances) {
            unsure = at;
            return INFINITY;
        }
        const double value = std::max(now.gap, 0.0);
        // Closed, and closing on: from when that can be told, at the rate and its change.
        const double rounding = 4.0 * std::max(tolerance::rounding, now.rounding);
        const double told =
            now.gap <= 0.0 && now.rate < 0.0 && change < INFINITY
                ? 2.0 * rounding /
                      (-now.rate + std::sqrt(now.rate * now.rate + 2.0 * change * rounding))
                : 0.0;
        if (told > 0.0 && at + told < until && measure(at + told).gap < now.gap - 0.25 * rounding)
            return at;
        double by = std::max({value / fastest, told, kShort * now.free});
        if (bend > 0.0)
            by = std::max(by,
                          (now.rate + std::sqrt(now.rate * now.rate + 2.0 * bend * value)) / bend);
        // If the rate hardly changes any more the zero is near; the last bit is gone beyond.
        double ahead = !now.is_rough && now.rate < 0.0 ? value / -now.rate : 0.0;
        if (value < kNear) ahead *= 1.2;
        if (ahead * change < 0.3 * -now.rate) by = std::max(by, ahead);
        // A gap that is as good as closed and stays so, sliding on or parting slowly, is looked at
        // ever less often: its distance says nothing of when it comes down, a fall shows at the
        // next look.
        by = std::max({by, least, now.gap <= kWaver ? 2.0 * last : 0.0});
        last = now.gap <= kWaver ? by : 0.0;
        const double next = std::min(at + by, until);
        const GapState there = measure(next);
        if (there.gap < 0.0 && now.gap > 0.0)
            return zero_between(at, now.gap, next, there.gap,
                                [&](double x) { return measure(x).gap; });
        // A gap that began closed may have opened by less than can be seen, and closed again.
        if (there.gap < -kWaver && now.gap > -kWaver)
            return zero_between(at, now.gap + kWaver, next, there.gap + kWaver,
                                [&](double x) { return measure(x).gap + kWaver; });
        at = next;
        now = there;
    }
    return INFINITY;
}

// When a measure falls to zero; time advances by what is surely free of it, part_of_step by
// part_of_step: no gap closes faster than the bodies' points move, and one with a smooth rate no
// faster than g + ġ s − A s²/2. Where that gets nowhere, `unsure` says from when on nothing is
// known.
template <typename Measure, typename Prepare>
double first_zero(const Step& step, double until, bool smooth, Measure measure, Prepare prepare,
                  double& unsure) {
    const double span = step.end - step.start;
    // Bodies that turn often in a step are seen as often.
    const GapState nodes[] = {measure(step.start), measure(step.start + 0.5 * span),
                              measure(step.end)};
    double turning = 0.0, bound = 0.0;
    for (const GapState& node : nodes) {
        turning = std::max(turning, node.turning);
        bound = std::max(bound, node.bound);
    }
    if (nodes[0].gap > kFaster * bound * span) return INFINITY;
    prepare(nodes, 0.5 * span);
    GapState left = measure(step.start);
    const int parts = static_cast<int>(std::min(std::max(4.0, turning * span / kSeen), 1e5));
    const double part_of_step = span / parts;
    for (int i = 0; i < parts; ++i) {
        const double begin = step.start + i * part_of_step, end = begin + part_of_step;
        if (begin >= until) break;
        const GapState right = measure(end);
        const double fastest = kFaster * std::max(left.bound, right.bound) + tolerance::tiny,
                     bend = left.is_rough || right.is_rough
                                ? 0.0
                                : 2.0 * std::abs(right.rate - left.rate) / part_of_step;
        const double found = advance_to_zero(
            measure, begin, std::min(end, until), left, fastest, smooth ? bend : 0.0,
            left.is_rough || right.is_rough ? INFINITY : bend, unsure);
        if (found < INFINITY || unsure < INFINITY) return found;
        left = right;
    }
    return INFINITY;
}

}  // namespace

GapState Motion::gap_at(const Step& step, int gap, double at, Ahead* ahead) {
    set_state(step, at);
    if (ahead) ahead->base = base_[gap];
    GapState found =
        dynamics_.contact_gaps.measure(dynamics_.tree, dynamics_.contact_gaps.gaps()[gap],
                                       here_.data(), here_.data() + nq(), ahead);
    found.gap -= base_[gap];
    if (passing_[gap]) found.gap = -found.gap, found.rate = -found.rate, found.free = 0.0;
    return found;
}

double Motion::first_closing(const Step& step, int gap, double until, double& unsure) {
    const bool smooth = !dynamics_.contact_gaps.gaps()[gap].of_bodies();
    Ahead ahead{0.0, INFINITY};
    return first_zero(
        step, until, smooth, [&](double at) { return gap_at(step, gap, at, &ahead); },
        [&](const GapState* nodes, double apart) {
            const ContactGaps& contact_gaps = dynamics_.contact_gaps;
            ahead.acceleration = 0.0;
            for (int i = 0; i < 2 && !smooth; ++i)
                ahead.acceleration = std::max(
                    ahead.acceleration, contact_gaps.acceleration(contact_gaps.gaps()[gap],
                                                                  nodes[i], nodes[i + 1], apart));
        },
        unsure);
}

// When bodies that rest on each other come down elsewhere: their gap, which is none where they
// rest, is below that.
double Motion::first_elsewhere(const Step& step, int gap, double until) {
    const double base = base_[gap];
    base_[gap] = std::min(base, 0.0) - kWaver;
    double left = step.start, value = gap_at(step, gap, left).gap, found = INFINITY;
    for (int i = 1; i < 9 && left < until && found == INFINITY; ++i) {
        const double right = std::min(step.start + 0.125 * i * (step.end - step.start), until);
        const double next = gap_at(step, gap, right).gap;
        if (value > 0.0 && next < 0.0)
            found = zero_between(left, value, right, next,
                                 [&](double at) { return gap_at(step, gap, at).gap; });
        left = right;
        value = next;
    }
    base_[gap] = base;
    return found;
}

// Functions of the state that are positive while nothing changes: forces with a kink, slip along
// its way, points that do not lift or leave their faces, joints that move.
void Motion::margins(const Step& step, double at, std::vector<double>& found) {
    found.clear();
    set_state(step, at);
    const double *q = here_.data(), *v = q + nq();
    const Tree<double>& tree = dynamics_.tree;
    for (int k = 0; k < dynamics_.kinks.count(); ++k)
        found.push_back(dynamics_.kinks.margin(k, tree, q, v));
    for (std::size_t j = 0; j < rest_.dry.size(); ++j)
        found.push_back(rest_.dry[j] == 0 ? INFINITY : rest_.dry[j] * v[scene_->dry[j].v]);
    std::vector<double> J(3 * nv()), turning(3 * nv()), tears;
    const auto along = [&](const double* row) {
        double sum = 0.0;
        for (int i = 0; i < nv(); ++i) sum += row[i] * v[i];
        return sum;
    };
    write_tears(at, q, v, tears);
    found.insert(found.end(), tears.begin(), tears.end());
    for (const RestingContact& point : rest_.points) {
        const bool turns = dynamics_.contact_gaps.gaps()[point.gap].turns;
        dynamics_.contact_gaps.rows(tree, point, q, v,
                                    {J.data(), turns ? turning.data() : nullptr});
        const double first = along(J.data()), second = along(J.data() + nv());
        found.push_back(point.slip.moves
                            ? point.slip.direction[0] * first + point.slip.direction[1] * second
                            : INFINITY);
        found.push_back(kLifted - along(J.data() + 2 * nv()));
        double inside = INFINITY;
        dynamics_.contact_gaps.gap_of(tree, point, q, &inside);
        found.push_back(inside + kLeft);
        if (!turns) continue;
        found.push_back(point.roll.moves
                            ? point.roll.direction[0] * along(turning.data()) +
                                  point.roll.direction[1] * along(turning.data() + nv())
                            : INFINITY);
        found.push_back(point.spin.moves
                            ? point.spin.direction[0] * along(turning.data() + 2 * nv())
                            : INFINITY);
    }
}

// Margins of contacts that stick as long as they can: by the accelerations that are left.
void Motion::write_tears(double at, const double* q, const double* v, std::vector<double>& found) {
    const auto pulls = [&](const RestingContact& p) {
        return !scene_->pulls.empty() &&
               scene_->pulls[dynamics_.contact_gaps.gaps()[p.gap].entry] > 0.0;
    };
    const auto drops = [&](const RestingContact& p) {
        return dynamics_.has_drop(dynamics_.contact_gaps.gaps()[p.gap].entry) && !p.slip.moves;
    };
    bool may_tear = std::any_of(rest_.dry.begin(), rest_.dry.end(),
                                [](signed char direction) { return direction == 0; });
    for (const RestingContact& point : rest_.points)
        may_tear = may_tear || pulls(point) || drops(point);
    if (!may_tear) return;
    RestingState rest = rest_;
    std::vector<double> a(nv());
    if (dynamics_.accelerate(at, q, v, rest, a.data()) != DynamicsFailure::none) return;
    for (std::size_t i = 0; i < rest_.points.size(); ++i) {
        const RestingContact& point = rest_.points[i];
        if (!pulls(point) && !drops(point)) continue;
        const double* rate = dynamics_.rate.data() + 3 * i;
        const double slips =
            drops(point) ? std::hypot(rate[0], rate[1]) - tolerance::torn * dynamics_.size : -1.0;
        const double parts = pulls(point) ? rate[2] - kParted * dynamics_.size : -1.0;
        found.push_back(-std::max(slips, parts));
    }
    for (std::size_t j = 0; j < rest_.dry.size(); ++j)
        if (rest_.dry[j] == 0)
            found.push_back(tolerance::torn * dynamics_.size - std::abs(dynamics_.dry_rate[j]));
}

double Motion::first_change(const Step& step, double until) {
    if (dynamics_.kinks.empty() && rest_.points.empty() && rest_.dry.empty()) return INFINITY;
    double zone = INFINITY;
    for (int k = 0; k < dynamics_.kinks.count(); ++k) {
        const auto measure = [&](double at) {
            set_state(step, at);
            const auto [value, rate] =
                dynamics_.kinks.zone(k, dynamics_.tree, here_.data(), here_.data() + nq());
            GapState found;
            found.gap = value, found.rate = rate, found.bound = std::abs(rate);
            return found;
        };
        double unsure = INFINITY;
        if (measure(step.start).gap < INFINITY)
            zone =
                std::min({zone,
                          first_zero(
                              step, until, true, measure, [](const GapState*, double) {}, unsure),
                          unsure});
    }
    until = std::min(until, zone);
    std::vector<double> before, after, trial;
    double left = step.start;
    margins(step, left, before);
    for (int i = 1; i < 5; ++i) {
        const double right = step.start + kNodes[i] * (until - step.start);
        margins(step, right, after);
        double first = INFINITY;
        for (std::size_t k = 0; k < after.size(); ++k) {
            if (!(after[k] < 0.0)) continue;
            if (!(before[k] > 0.0)) {
                // A margin that began at zero has turned the other way.
                if (i == 1 && after[k] < before[k]) first = std::min(first, left);
                continue;
            }
            if (std::isinf(before[k])) continue;
            first = std::min(first, zero_between(left, before[k], std::min(right, first), after[k],
                                                 [&](double x) {
                                                     margins(step, x, trial);
                                                     return trial[k];
                                                 }));
        }
        if (first < INFINITY) return first;
        left = right;
        before.swap(after);
    }
    return zone;
}

Motion::Event Motion::first_event(const Step& step) {
    Event event;
    event.t = step.end;
    const std::size_t gaps = dynamics_.contact_gaps.gaps().size();
    std::vector<char> rests(gaps, 0);
    for (const RestingContact& point : rest_.points) rests[point.gap] = 1;
    for (std::size_t i = 0; i < gaps; ++i) {
        if (rests[i] && !dynamics_.contact_gaps.gaps()[i].of_bodies()) continue;
        double unsure = INFINITY;
        const int gap = static_cast<int>(i);
        const double at = rests[i] ? first_elsewhere(step, gap, event.t)
                                   : first_closing(step, gap, event.t, unsure);
        if (unsure < event.t) {
            event.kind = Event::cut;
            event.t = unsure;
        }
        if (at < event.t || (at == event.t && event.kind == Event::nothing && at < INFINITY)) {
            event.kind = rests[i] ? Event::elsewhere : Event::closing;
            event.t = at;
            event.gap = static_cast<int>(i);
        }
    }
    const double change = first_change(step, event.t);
    if (change < event.t) {
        event.kind = Event::change;
        event.t = change;
    }
    return event;
}

// Slip that has stopped at y keeps still, unless the law of rest lets it go.
void Motion::stop_slips() {
    std::vector<double> J(3 * nv()), turning(3 * nv());
    const double* v = y.data() + nq();
    const auto along = [&](const double* row) {
        double sum = 0.0;
        for (int i = 0; i < nv(); ++i) sum += row[i] * v[i];
        return sum;
    };
    double fastest = 1.0;
    for (int i = 0; i < nv(); ++i) fastest = std::max(fastest, std::abs(v[i]));
    const double none = tolerance::residual * fastest;
    for (RestingContact& point : rest_.points) {
        const bool turns = dynamics_.contact_gaps.gaps()[point.gap].turns;
        dynamics_.contact_gaps.rows(dynamics_.tree, point, y.data(), v,
                                    {J.data(), turns ? turning.data() : nullptr});
        const auto stop = [&](SlipState& slip_state, const double* row, int size) {
            if (!slip_state.moves || slip_state.begins()) return;
            const double a = along(row), b = size == 2 ? along(row + nv()) : 0.0,
                         speed = std::hypot(a, b);
            if (slip_state.direction[0] * a + slip_state.direction[1] * b > none) return;
            // Slip that has turned away goes on.
            slip_state = speed > std::max(none, dynamics_.slow)
                             ? SlipState{true, {a / speed, b / speed}}
                             : SlipState();
        };
        stop(point.slip, J.data(), 2);
        stop(point.roll, turning.data(), 2);
        stop(point.spin, turning.data() + 2 * nv(), 1);
    }
    for (std::size_t j = 0; j < rest_.dry.size(); ++j)
        if (rest_.dry[j] * v[scene_->dry[j].v] <= none) rest_.dry[j] = 0;
}

// The gaps that close at y together with that of an event; passing contacts begin or end.
std::vector<int> Motion::gaps_that_close(const Event& event) {
    std::vector<int> closing;
    const auto& gaps = dynamics_.contact_gaps.gaps();
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        bool rests = false;
        for (const RestingContact& point : rest_.points)
            rests = rests || point.gap == static_cast<int>(i);
        if (rests) continue;
        const GapState now =
            dynamics_.contact_gaps.measure(dynamics_.tree, gaps[i], y.data(), y.data() + nq());
        const double sign = passing_[i] ? -1.0 : 1.0;
        const bool closes = static_cast<int>(i) == event.gap ||
                            (sign * now.rate < 0.0 &&
                             sign * (now.gap - base_[i]) <= -sign * now.rate * settings_.together);
        if (!closes) continue;
        if (passing_[i]) {
            passing_[i] = 0;
            base_[i] = 0.0;
        } else if (dynamics_.contact_gaps.counts(gaps[i], y.data(), y.data() + nq())) {
            closing.push_back(static_cast<int>(i));
        } else {
            passing_[i] = 1;
            base_[i] = 0.0;
        }
    }
    return closing;
}

// Deal with the event that ends a step at y; false where the motion cannot go on.
bool Motion::handle(const Event& event) {
    dynamics_.set_state(y.data(), y.data() + nq());
    if (event.kind == Event::cut) return update_rest();
    if (event.kind == Event::change) {
        if (!dynamics_.kinks.empty())
            dynamics_.kinks.change(dynamics_.tree, y.data(), y.data() + nq());
        stop_slips();
        return update_rest();
    }
    if (event.kind == Event::elsewhere) return close_gaps({event.gap});
    const std::vector<int> closing = gaps_that_close(event);
    if (!closing.empty()) return close_gaps(closing);
    restart();
    return ended == Ended::not_yet;
}

}  // namespace impulsekit
