#include "motion/advance.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "motion/change_points.hpp"
#include "motion/events.hpp"
#include "motion/handling.hpp"
#include "motion/impacts.hpp"
#include "motion/path.hpp"
#include "motion/resting.hpp"
#include "motion/watching.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {
namespace {

// Steps go so much further than to where a slip is foreseen to stop, in parts of the way.
constexpr double kFurther = 0.02;
// So many events without time between them never end, nor do so many steps that take together less
// than this part of the time before them.
constexpr int kMostStill = 1000, kManySteps = 200;
constexpr double kNowhere = 1e-10;
// Steps that go further than this [m, rad] are short because speeds are high; hopeless where the
// rest of the motion would take so many times max_steps.
constexpr double kFarAhead = 1e-2, kHopeless = 100.0;
// Times of events change by less than this part of a step when they are sharpened.
constexpr double kSharpened = 1e-3;
// A motion begins with steps of this part of it.
constexpr double kFirstStep = 1e-3;

// The forces at the end of a step, which was evaluated before others within it.
void recall_end(Motion& motion) {
    static_cast<RestForces&>(motion.dynamics) = motion.last_end.forces;
    for (std::size_t i = 0; i < motion.last_end.pressed.size(); ++i)
        motion.now.rest.points[i].pressed = motion.last_end.pressed[i];
}

// Behind an event steps are as long as before a stop was foreseen.
void forget_stop(Motion& motion) {
    motion.stepper.next = std::max(motion.stepper.next, motion.stop.length_before);
    motion.stop.until = motion.stop.length_before = 0.0;
}

// From a time on up to the next stop.
void begin_stretch(Motion& motion) {
    MotionState& now = motion.now;
    const auto& stops = motion.settings.stop_times;
    const auto next = std::upper_bound(stops.begin(), stops.end(), now.t);
    const double from = next != stops.begin() && *(next - 1) == now.t
                            ? std::nextafter(now.t, INFINITY)
                            : -INFINITY,
                 to = next != stops.end() ? std::nextafter(*next, -INFINITY) : INFINITY;
    if (from == motion.stretch.from && to == motion.stretch.to) return;
    const bool jumps = from != -INFINITY && from != motion.stretch.from;
    motion.stretch.from = from;
    motion.stretch.to = to;
    if (jumps) {
        motion.smooth_since = now.t;
        forget_stop(motion);
        restart(motion);
    }
}

// The time until the first slip stops if accelerations stay as they are: slip s with the rate a has
// nothing left along itself at t = −s²/(s·a).
double until_stopping(const Motion& motion) {
    const Dynamics& dynamics = motion.dynamics;
    double soonest = INFINITY;
    for (std::size_t i = 0; i < motion.now.rest.points.size(); ++i) {
        if (!motion.now.rest.points[i].slip.moves || dynamics.slip.size() < 3 * (i + 1)) continue;
        const double *s = dynamics.slip.data() + 3 * i, *a = dynamics.rate.data() + 3 * i;
        const double slows = -(s[0] * a[0] + s[1] * a[1]);
        if (slows > 0.0) soonest = std::min(soonest, (s[0] * s[0] + s[1] * s[1]) / slows);
    }
    return soonest > 0.0 ? soonest * (1.0 + kFurther) : INFINITY;
}

// Slip turns ever faster as it comes to its stop: steps get shorter with the time to it.
void foresee_stop(Motion& motion) {
    const double stopping = until_stopping(motion);
    if (stopping < motion.stop.until) {
        if (!(motion.stop.length_before > 0.0)) motion.stop.length_before = motion.stepper.next;
        const double part = std::max(kLeast, stopping / motion.stop.until);
        motion.stepper.next =
            std::max(part * motion.stepper.next, std::min(motion.stepper.next, tolerance::alike));
    }
    motion.stop.until = stopping;
}

double longest_step(const Motion& motion, double until) {
    const MotionState& now = motion.now;
    double longest = until - now.t;
    for (double stop : motion.settings.stop_times)
        if (stop > now.t) {
            longest = std::min(longest, stop - now.t);
            break;
        }
    if (motion.settings.max_step > 0.0) longest = std::min(longest, motion.settings.max_step);
    if (motion.settings.method == Method::dop853) {
        longest = std::min(longest, std::max(until_stopping(motion), tolerance::alike));
        if (motion.micro_bounce > 0.0) longest = std::min(longest, 1.05 * motion.micro_bounce);
    }
    return longest;
}

// When a gap closes by a step that was made anew up to there, by one step of Newton's method: the
// polynomial by which the time was found is a hundred times less accurate.
double sharpened(Motion& motion, const Step& step, int gap) {
    set_state(motion, step, step.end);
    const GapState at = gap_here(motion, gap);
    const double change = at.rate < 0.0 ? at.gap / -at.rate : 0.0;
    return std::abs(change) < kSharpened * step.length ? step.end + change : step.end;
}

// End a motion whose last steps lead nowhere, or whose speeds need steps too short.
void refuse_hopeless(Motion& motion, int made) {
    const double speed = fastest(motion);
    const double took = motion.now.t - motion.progress.since, step = took / made,
                 left = motion.settings.scale_of_time - motion.now.t;
    char told[300];
    if (took <= kNowhere * motion.progress.since) {
        motion.ended = Ended::step_too_small;
        std::snprintf(told, sizeof told,
                      "%d steps took %.1e s, and speeds are up to %.1e: a linkage that is driven "
                      "into a dead centre, or a force without bound",
                      made, took, speed);
    } else if (speed * step >= kFarAhead && left >= kHopeless * motion.settings.max_steps * step) {
        motion.ended = Ended::too_many_steps;
        std::snprintf(told, sizeof told,
                      "at speeds of up to %.1e (m/s, rad/s) a step takes %.1e s: the %.3g s left "
                      "would take %.1e steps. Look at the units of the velocities, or shorten the "
                      "duration",
                      speed, step, left, left / step);
    } else {
        return;
    }
    motion.detail = told;
}

// End a motion that gets no further, or has made all its steps.
void check_progress(Motion& motion) {
    MotionState& now = motion.now;
    motion.progress.still = now.t == motion.progress.t ? motion.progress.still + 1 : 0;
    motion.progress.t = now.t;
    if (motion.progress.still >= kMostStill) {
        motion.ended = Ended::step_too_small;
        motion.detail = "events follow each other at one time";
    } else if (motion.stepper.steps - motion.progress.counted >= motion.settings.max_steps) {
        motion.ended = Ended::too_many_steps;
        motion.detail = "max_steps is " + std::to_string(motion.settings.max_steps);
    } else if (motion.stepper.steps - motion.progress.steps >= kManySteps) {
        refuse_hopeless(motion, motion.stepper.steps - motion.progress.steps);
        motion.progress.steps = motion.stepper.steps;
        motion.progress.since = now.t;
    }
}

// ẏ of a motion, as steps ask for it.
Stepper::Rate rate_of(Motion& motion) {
    return
        [&](double at, const double* from, double* to) { return find_rate(motion, at, from, to); };
}

// One step, to whose end the state goes; false where none is short enough, the state as it was.
bool make_step(Motion& motion, double until, Step& step) {
    MotionState& now = motion.now;
    Stepper& stepper = motion.stepper;
    const MotionState before = now;
    if (stepper.next <= 0.0) stepper.next = kFirstStep * motion.settings.scale_of_time;
    const auto settle = [&](double* x) {
        normalize_configuration(*motion.scene->scene.model, x);
        motion.last_end.is_next = true;
    };
    if (motion.settings.method == Method::dop853) foresee_stop(motion);
    double longest = longest_step(motion, until);
    motion.dynamics.has_opened =
        std::any_of(now.rest.points.begin(), now.rest.points.end(),
                    [](const RestingContact& point) { return !point.pressed; });
    while (stepper.step(rate_of(motion), settle, now.t, now.q(), now.rate.data(), longest, step)) {
        const double shorter = shorter_step(motion, step);
        if (!(shorter > 0.0)) return true;
        now = before;
        longest = shorter;
    }
    now = before;
    return false;
}

// Where no step is short enough: an impact without collision, or past a change point; else the
// motion ends.
bool goes_on_without_step(Motion& motion, double until) {
    MotionState& now = motion.now;
    if (!now.rest.points.empty() && impact_without_collision(motion)) return true;
    if (motion.ended == Ended::not_yet && pass_change_point(motion, until)) return true;
    motion.failure = DynamicsFailure::none;
    find_rate(motion, now.t, now.q(), now.rate.data());
    return fail(motion);
}

// A step ends at an event within it; it is made anew up to there where its polynomial is not as
// accurate as its end.
void cut_step(Motion& motion, const Event& event, Step& step) {
    Step cut;
    if (event.t > step.start && event.t < step.end && !motion.stepper.is_accurate_within() &&
        motion.stepper.shortened(rate_of(motion), step, event.t, cut)) {
        step = cut;
        if (event.what.kind == EventFunction::gap_closes)
            step.end = sharpened(motion, step, event.what.index);
    } else {
        step.end = std::max(event.t, step.start);
    }
}

}  // namespace

void rewind_to(Motion& motion, double at) {
    MotionState& now = motion.now;
    if (motion.path.empty() || !(at < now.t)) return;
    motion.path.resize(piece_at(motion, at) + 1);
    Step& last = motion.path.back().step;
    now.rest = motion.resting_states[motion.path.back().resting_state];
    last.at(std::max(at, last.start), now.q());
    normalize_configuration(*motion.scene->scene.model, now.q());
    now.t = motion.smooth_since = motion.progress.t = at;
    if (last.start < at)
        last.end = at;
    else
        motion.path.pop_back();
    const auto later = [at](const auto& impact) { return impact->t > at; };
    motion.impacts.erase(std::find_if(motion.impacts.begin(), motion.impacts.end(), later),
                         motion.impacts.end());
    motion.rests.erase(std::remove_if(motion.rests.begin(), motion.rests.end(),
                                      [at](const RestInterval& rest) { return rest.end > at; }),
                       motion.rests.end());
    motion.ended = Ended::not_yet;
    motion.detail.clear();
    motion.failure = DynamicsFailure::none;
    motion.micro_bounce = 0.0;
    forget_stop(motion);
    motion.progress.still = 0;
    for (GapMemory& known : motion.memory)
        if (known.last_soft > at) known.soft = 0, known.last_soft = -1.0;
    set_state(motion);
    for (int i = 0; i < motion.gap_count(); ++i)
        if (motion.gap(i).has_condition)
            motion.memory[i].passes = !counts_now(motion, i) && gap_now(motion, i).gap < 0.0;
    rebase(motion);
    motion.dynamics.kinks.set_sides(motion.dynamics.tree, now.q(), now.v());
    begin_stretch(motion);
    restart(motion);
}

void control(Motion& motion, const double* torques) {
    if (motion.ended != Ended::not_yet) return;
    motion.now.rest.controls.assign(torques, torques + motion.nv());
    motion.smooth_since = motion.now.t;
    forget_stop(motion);
    motion.stepper.jump();
    update_rest(motion, false, false);
}

bool advance(Motion& motion, double until) {
    MotionState& now = motion.now;
    if (motion.ended != Ended::not_yet || !(now.t < until)) return false;
    if (!(until - now.t > shortest_step(now.t))) {
        now.t = until;
        return false;
    }
    motion.failure = DynamicsFailure::none;
    begin_stretch(motion);
    const MotionState before = now;
    Step step;
    if (!make_step(motion, until, step)) return goes_on_without_step(motion, until);
    motion.micro_bounce = 0.0;
    const Event event = first_event(motion, step);
    if (event.what.kind != EventFunction::none) {
        now = before;
        cut_step(motion, event, step);
        step.at(step.end, now.q());
        normalize_configuration(*motion.scene->scene.model, now.q());
        now.t = step.end;
        keep_step(motion, step);
        motion.smooth_since = now.t;
        forget_stop(motion);
        if (!handle_event(motion, event)) return motion.ended == Ended::not_yet && fail(motion);
    } else {
        keep_step(motion, step);
        now.t = step.end;
        if (now.rest.acts() || motion.dynamics.constraints.rows() > 0) {
            recall_end(motion);
            update_rest(motion, true);
        }
    }
    if (motion.ended == Ended::not_yet) check_progress(motion);
    return motion.ended == Ended::not_yet;
}

}  // namespace impulsekit
