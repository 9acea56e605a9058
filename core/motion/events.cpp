#include "motion/events.hpp"

#include <algorithm>
#include <cmath>
#include <tuple>

#include "integrator/zero.hpp"

namespace impulsekit {
namespace {

// Gaps may close between the nodes of a step so many times as fast as at them.
constexpr double kFaster = 1.3;
// So often in a step bodies that rest are looked at for other points, and all else that is not
// followed: rounding of the polynomial within a step is no event.
constexpr int kLooksElsewhere = 8, kLooks = 4;
// Bodies turn no further than this [rad] between two looks at them.
constexpr double kSeen = 0.7;
constexpr int kMostAdvances = 400;
// So much of the time in which a gap surely stays open is gone at once: a step that ended just
// where it closes would not see on which side it is.
constexpr double kShort = 0.9;
// Below this distance [m] nothing is thin enough to be passed.
constexpr double kNear = 1e-7;

// The first zero of a gap before `until` in a part of a step, from its states at both ends.
template <typename Measure>
double advance_to_zero(Measure measure, double begin, const GapState& left, double end,
                       const GapState& right, bool smooth, double until, double& unsure) {
    double at = begin;
    GapState now = left;
    const bool is_rough = left.is_rough || right.is_rough;
    // By how much the rate seems to change in a second; a smooth one surely does no more.
    const double change =
        is_rough ? INFINITY : 2.0 * std::abs(right.rate - left.rate) / (end - begin);
    const double bend = smooth && !is_rough ? change : 0.0, least = 1e-5 * (until - at),
                 fastest = kFaster * std::max(left.bound, right.bound) + tolerance::tiny;
    double last = 0.0;
    for (int count = 0; at < until; ++count) {
        if (count == kMostAdvances) {
            unsure = at;
            return INFINITY;
        }
        const double value = std::max(now.gap, 0.0);
        // Closed, and closing on: from when that can be told, at the rate and its change.
        const double rounding = now.noise();
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
        const GapState there = next == end ? right : measure(next);
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

// When a gap falls to zero; time advances by what is surely free of it, part by part: no gap closes
// faster than the bodies' points move, and one with a smooth rate no faster than g + ġ s − A s²/2.
// `unsure` says from when on nothing is known, if that gets nowhere. `nodes`: the gap at the
// start, the middle and the end; `start`: at the start as `measure` has it.
template <typename Measure>
double first_zero(const Step& step, double until, bool smooth, const GapState* nodes,
                  const GapState& start, Measure measure, double& unsure) {
    const double span = step.end - step.start;
    // Bodies that turn often in a step are seen as often.
    const double turning = std::max({nodes[0].turning, nodes[1].turning, nodes[2].turning});
    const int parts = static_cast<int>(std::min(std::max(4.0, turning * span / kSeen), 1e5));
    const double length = span / parts;
    GapState left = start;
    for (int i = 0; i < parts; ++i) {
        const double begin = step.start + i * length, end = begin + length;
        if (begin >= until) break;
        const GapState right = measure(end);
        const double found =
            advance_to_zero(measure, begin, left, end, right, smooth, std::min(end, until), unsure);
        if (found < INFINITY || unsure < INFINITY) return found;
        left = right;
    }
    return INFINITY;
}

// True if a gap is too wide to close within a step.
bool stays_open(const GapState* nodes, double span) {
    const double bound = std::max({nodes[0].bound, nodes[1].bound, nodes[2].bound});
    return nodes[0].gap > kFaster * bound * span;
}

// A function that is followed at the tree's state.
GapState value_of(Motion& motion, const EventFunction& f, Ahead* ahead = nullptr) {
    if (f.kind == EventFunction::gap_closes) return gap_here(motion, f.index, ahead);
    GapState found;
    std::tie(found.gap, found.rate) = motion.dynamics.kinks.zone(
        f.index, motion.dynamics.tree, motion.here.data(), motion.here.data() + motion.nq());
    found.bound = std::abs(found.rate);
    return found;
}

// When a function falls to zero, followed from its values at the start, the middle and the end.
double first_zero_of(Motion& motion, const EventFunction& f, const Step& step,
                     const GapState* nodes, double until, double& unsure) {
    const double span = step.end - step.start;
    if (stays_open(nodes, span)) return INFINITY;
    const ContactGaps& gaps = motion.dynamics.contact_gaps;
    const bool smooth = f.kind == EventFunction::force_enters || !gaps.gaps()[f.index].of_bodies();
    Ahead ahead{0.0, 0.0};
    for (int i = 0; i < 2 && !smooth; ++i)
        ahead.acceleration = std::max(
            ahead.acceleration, bound_of_acceleration(nodes[i].motion, nodes[i + 1].motion,
                                                      gaps.gaps()[f.index].reach, 0.5 * span));
    const auto measure = [&](double at) {
        set_state(motion, step, at);
        return value_of(motion, f, &ahead);
    };
    return first_zero(step, until, smooth, nodes, smooth ? nodes[0] : measure(step.start), measure,
                      unsure);
}

// All that may happen in a step from here.
std::vector<EventFunction> event_functions(const Motion& motion) {
    const Dynamics& dynamics = motion.dynamics;
    const MotionState& now = motion.now;
    std::vector<EventFunction> found;
    const auto add = [&](EventFunction::Kind kind, std::size_t index) {
        found.push_back({kind, static_cast<int>(index)});
    };
    for (int i = 0; i < motion.gap_count(); ++i) {
        if (!now.rest.rests_on(i))
            add(EventFunction::gap_closes, i);
        else if (motion.gap(i).of_bodies())
            add(EventFunction::touches_elsewhere, i);
    }
    for (int k = 0; k < dynamics.kinks.count(); ++k) {
        add(EventFunction::force_enters, k);
        add(EventFunction::force_bends, k);
    }
    for (std::size_t j = 0; j < now.rest.dry.size(); ++j)
        add(now.rest.dry[j] == 0 ? EventFunction::joint_starts : EventFunction::joint_stops, j);
    for (std::size_t i = 0; i < now.rest.points.size(); ++i) {
        const RestingContact& point = now.rest.points[i];
        const int entry = motion.gap(point.gap).entry;
        const bool turns = motion.gap(point.gap).turns;
        if (pull_on(motion, entry) > 0.0 || (dynamics.has_drop(entry) && !point.slip.moves))
            add(EventFunction::point_tears, i);
        if (point.slip.moves) add(EventFunction::slip_stops, i);
        if (dynamics.has_opened || !point.pressed) add(EventFunction::point_lifts, i);
        if (motion.gap(point.gap).of_bodies()) add(EventFunction::point_leaves, i);
        if (turns && point.roll.moves) add(EventFunction::roll_stops, i);
        if (turns && point.spin.moves) add(EventFunction::spin_stops, i);
    }
    return found;
}

// The value of a function at the tree's state; `u`: velocity of its point.
double margin(Motion& motion, const EventFunction& f, const Spatial<double>& u) {
    Dynamics& dynamics = motion.dynamics;
    const double *q = motion.here.data(), *v = q + motion.nq(),
                 torn = tolerance::torn * dynamics.size;
    const RestingContact* point = f.is_of_point() ? &motion.now.rest.points[f.index] : nullptr;
    switch (f.kind) {
        case EventFunction::force_bends:
            return dynamics.kinks.margin(f.index, dynamics.tree, q, v);
        case EventFunction::touches_elsewhere:
            return gap_here(motion, f.index).gap + kWaver;
        case EventFunction::joint_stops:
            return motion.now.rest.dry[f.index] * v[motion.scene->dry[f.index].v];
        case EventFunction::joint_starts:
            return torn - std::abs(dynamics.dry_rate[f.index]);
        case EventFunction::slip_stops:
            return point->slip.along(u.linear.x, u.linear.y);
        case EventFunction::roll_stops:
            return point->roll.along(u.angular.x, u.angular.y);
        case EventFunction::spin_stops:
            return point->spin.along(u.angular.z, 0.0);
        case EventFunction::point_lifts:
            return kLifted - u.linear.z;
        case EventFunction::point_leaves: {
            double inside = INFINITY;
            dynamics.contact_gaps.gap_of(dynamics.tree, *point, q, &inside);
            return inside + kLeft;
        }
        case EventFunction::point_tears: {
            const double* rate = dynamics.rate.data() + 3 * f.index;
            const int entry = motion.gap(point->gap).entry;
            const bool drops = dynamics.has_drop(entry) && !point->slip.moves;
            return std::min(drops ? torn - std::hypot(rate[0], rate[1]) : 1.0,
                            pull_on(motion, entry) > 0.0 ? kParted * dynamics.size - rate[2] : 1.0);
        }
        default:
            return INFINITY;
    }
}

// The values of several at a time of a step; what needs accelerations is not seen without them.
void margins(Motion& motion, const std::vector<EventFunction>& functions, const Step& step,
             double at, std::vector<double>& found) {
    set_state(motion, step, at);
    bool has_rates = true;
    if (std::any_of(functions.begin(), functions.end(),
                    [](const EventFunction& f) { return f.needs_rates(); })) {
        RestingState rest = motion.now.rest;
        std::vector<double> a(motion.nv());
        has_rates =
            motion.dynamics.accelerate(at, motion.here.data(), motion.here.data() + motion.nq(),
                                       rest, a.data()) == DynamicsFailure::none;
    }
    found.clear();
    int known = -1;
    Spatial<double> u;
    for (const EventFunction& f : functions) {
        if (f.is_of_point() && f.index != known) {
            u = velocity_of(motion, motion.now.rest.points[f.index], motion.here.data());
            known = f.index;
        }
        found.push_back(f.needs_rates() && !has_rates ? INFINITY : margin(motion, f, u));
    }
}

// The first of several functions that falls to zero between so many looks before `until`.
Event first_change(Motion& motion, const std::vector<EventFunction>& functions, int looks,
                   const Step& step, double until) {
    Event first{{}, INFINITY};
    if (functions.empty()) return first;
    std::vector<double> before, after, trial;
    double left = step.start;
    margins(motion, functions, step, left, before);
    for (int i = 1; i <= looks && first.t == INFINITY; ++i) {
        const double right = step.start + i * (until - step.start) / looks;
        margins(motion, functions, step, right, after);
        for (std::size_t k = 0; k < after.size(); ++k) {
            if (!(after[k] < 0.0) || std::isinf(before[k])) continue;
            double at = INFINITY;
            if (before[k] > 0.0)
                at = zero_between(left, before[k], std::min(right, first.t), after[k],
                                  [&](double x) {
                                      margins(motion, {functions[k]}, step, x, trial);
                                      return trial[0];
                                  });
            else if (i == 1 && after[k] < before[k])
                at = left;  // A margin that began at zero has turned the other way.
            if (at < first.t) first = {functions[k], at};
        }
        left = right;
        before.swap(after);
    }
    return first;
}

// True if bodies that rest surely touch nowhere else within a step.
bool stays_free(Motion& motion, int gap, const Step& step) {
    const Contact& contact = motion.scene->scene.contacts[motion.gap(gap).entry];
    const CornersOnFace corners(contact, gap, motion.now.rest.points);
    if (corners.side < 0) return false;
    const double half = 0.5 * (step.end - step.start);
    RelativeMotion last;
    double acceleration = 0.0;
    for (int i = 2; i >= 0; --i) {
        set_state(motion, step, step.start + i * half);
        const RelativeMotion own =
            relative_motion(motion.dynamics.tree, corners.body(contact), corners.ground(contact));
        if (i < 2)
            acceleration =
                std::max(acceleration, bound_of_acceleration(own, last, corners.reach, half));
        last = own;
    }
    return corners.free_time(contact, motion.dynamics.tree, last, acceleration) > 2.0 * half;
}

}  // namespace

GapState gap_here(Motion& motion, int i, Ahead* ahead) {
    if (ahead) ahead->base = motion.memory[i].base;
    GapState found = motion.dynamics.contact_gaps.measure(motion.dynamics.tree, motion.gap(i),
                                                          motion.here.data(),
                                                          motion.here.data() + motion.nq(), ahead);
    found.gap -= motion.memory[i].base;
    if (motion.memory[i].passes) found.gap = -found.gap, found.rate = -found.rate, found.free = 0.0;
    return found;
}

Event first_event(Motion& motion, const Step& step) {
    Event event{{}, step.end};
    std::vector<EventFunction> followed, elsewhere, changes;
    for (const EventFunction& f : event_functions(motion))
        (f.is_followed()                              ? followed
         : f.kind == EventFunction::touches_elsewhere ? elsewhere
                                                      : changes)
            .push_back(f);
    std::vector<GapState> nodes(3 * followed.size());
    for (int i = 0; i < 3 && !followed.empty(); ++i) {
        set_state(motion, step, step.start + 0.5 * i * (step.end - step.start));
        for (std::size_t k = 0; k < followed.size(); ++k)
            nodes[3 * k + i] = value_of(motion, followed[k]);
    }
    const auto surely_not = [&](const EventFunction& f) {
        return stays_free(motion, f.index, step);
    };
    elsewhere.erase(std::remove_if(elsewhere.begin(), elsewhere.end(), surely_not),
                    elsewhere.end());
    for (std::size_t k = 0; k < followed.size(); ++k) {
        double unsure = INFINITY;
        const double at = first_zero_of(motion, followed[k], step, &nodes[3 * k], event.t, unsure);
        if (unsure < event.t) event = {{EventFunction::unsure, -1}, unsure};
        if (at < event.t || (at == event.t && event.what.kind == EventFunction::none))
            event = {followed[k], at};
    }
    const Event touch = first_change(motion, elsewhere, kLooksElsewhere, step, event.t);
    if (touch.t < event.t) event = touch;
    const Event change = first_change(motion, changes, kLooks, step, event.t);
    return change.t < event.t ? change : event;
}

}  // namespace impulsekit
