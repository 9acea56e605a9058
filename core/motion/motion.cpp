#include "motion/motion.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "linalg/arena.hpp"
#include "linalg/dense.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {
namespace {

// Slip has grown when it is this many times as fast as slip that has no direction of its own.
constexpr double kGrown = 30.0;
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
// Speeds [m/s] whose squares may overflow.
constexpr double kHuge = 1e100;
// A motion begins with steps of this part of it.
constexpr double kFirstStep = 1e-3;

}  // namespace

Motion::Motion(std::shared_ptr<const MotionScene> scene, MotionSettings settings, const double* q,
               const double* v)
    : scene_(std::move(scene)),
      settings_(std::move(settings)),
      dynamics_(*scene_),
      stepper_(settings_.method, nq(), nq() + nv(), {settings_.rtol, settings_.atol},
               settings_.fixed_length) {
    now.y.assign(q, q + nq());
    now.y.insert(now.y.end(), v, v + nv());
    now.nq = nq();
    now.rate.assign(now.y.size(), 0.0);
    here_.assign(now.y.size(), 0.0);
    base_.assign(gap_count(), 0.0);
    passing_.assign(gap_count(), 0);
    soft_.assign(gap_count(), {0, -1.0});
    now.rest.dry.assign(scene_->dry.size(), 0);
    slow_ = std::max(kNoSlip, settings_.capture_speed);
    dynamics_.slow = kGrown * slow_;
}

// ẏ of y = (q, v). `is_known`: loads other than torques from outside are those of the last
// evaluation, if that was here.
bool Motion::rate(double at, const double* from, double* to, bool is_known) {
    Arena::Scope scope(scratch());
    const Model& model = *scene_->scene.model;
    const bool ends = ends_;
    ends_ = false;
    double* q = scratch().allocate(nq());
    std::copy(from, from + nq(), q);
    normalize_configuration(model, q);
    configuration_rate(model, from, from + nq(), to);
    at = std::min(std::max(at, from_), to_);
    const double* v = from + nq();
    const DynamicsFailure failure = is_known && dynamics_.is_known(at, q, v, now.rest)
                                        ? dynamics_.accelerate_again(now.rest, to + nq())
                                        : dynamics_.accelerate(at, q, v, now.rest, to + nq());
    if (failure != DynamicsFailure::none) {
        failure_ = failure;
        return false;
    }
    if (ends) {
        at_end_ = dynamics_;
        pressed_at_end_.clear();
        for (const RestingContact& point : now.rest.points)
            pressed_at_end_.push_back(point.pressed);
    }
    double sum = 0.0;
    for (int i = 0; i < nv(); ++i) sum += to[nq() + i];
    return std::isfinite(sum);
}

// The forces at the end of a step, which was evaluated before others within it.
void Motion::recall_end() {
    static_cast<RestForces&>(dynamics_) = at_end_;
    for (std::size_t i = 0; i < pressed_at_end_.size(); ++i)
        now.rest.points[i].pressed = pressed_at_end_[i];
}

bool Motion::set_state(const Step& step, double at) {
    step.at(at, here_.data());
    normalize_configuration(*scene_->scene.model, here_.data());
    dynamics_.set_state(here_.data(), here_.data() + nq());
    return true;
}

// The velocity of a resting point at a state (nq + nv), which the tree has.
Spatial<double> Motion::velocity_of(const RestingContact& point, const double* state) const {
    return dynamics_.contact_gaps.velocity(dynamics_.tree, point, state, state + nq());
}

// The largest velocity [m/s, rad/s].
double Motion::fastest() const { return largest(now.v(), nv()); }

// A gap now, and whether it counts; the tree with places and twists.
GapState Motion::gap_now(int i) const {
    return dynamics_.contact_gaps.measure(dynamics_.tree, gap(i), now.q(), now.v());
}

bool Motion::counts_now(int i) const {
    return dynamics_.contact_gaps.counts(gap(i), now.q(), now.v());
}

// Places and twists of now.
void Motion::set_state() { dynamics_.set_state(now.q(), now.v()); }

// The force that holds a contact to what it touches [N].
double Motion::pull_on(int entry) const {
    return scene_->pulls.empty() ? 0.0 : scene_->pulls[entry];
}

// The last piece of the path that begins no later than a time.
std::size_t Motion::piece_at(double at) const {
    std::size_t low = 0, high = path.size();
    while (high - low > 1) {
        const std::size_t middle = (low + high) / 2;
        (path[middle].step.start <= at ? low : high) = middle;
    }
    return low;
}

void Motion::sample(double at, double* found) const {
    if (path.empty() || !(at < now.t)) {
        std::copy(now.y.begin(), now.y.end(), found);
        return;
    }
    const Step& step = path[piece_at(at)].step;
    step.at(std::min(std::max(at, step.start), step.end), found);
}

void Motion::state(double at, double* q, double* v) const {
    std::vector<double> found(now.y.size());
    sample(at, found.data());
    normalize_configuration(*scene_->scene.model, found.data());
    std::copy(found.begin(), found.begin() + nq(), q);
    std::copy(found.begin() + nq(), found.end(), v);
}

const RestingState& Motion::resting_state_at(double at) const {
    return path.empty() || !(at < now.t) ? now.rest
                                         : resting_states[path[piece_at(at)].resting_state];
}

void Motion::forget(double before) {
    const std::size_t first = path.empty() ? 0 : piece_at(before);
    if (first == 0) return;
    path.erase(path.begin(), path.begin() + first);
    const int known = path.front().resting_state;
    resting_states.erase(resting_states.begin(), resting_states.begin() + known);
    for (Piece& piece : path) piece.resting_state -= known;
}

void Motion::rewind(double at) {
    if (path.empty() || !(at < now.t)) return;
    path.resize(piece_at(at) + 1);
    Step& last = path.back().step;
    now.rest = resting_states[path.back().resting_state];
    last.at(std::max(at, last.start), now.q());
    normalize_configuration(*scene_->scene.model, now.q());
    now.t = smooth_since_ = checked_t_ = at;
    if (last.start < at)
        last.end = at;
    else
        path.pop_back();
    const auto later = [at](const auto& impact) { return impact->t > at; };
    impacts.erase(std::find_if(impacts.begin(), impacts.end(), later), impacts.end());
    rests.erase(std::remove_if(rests.begin(), rests.end(),
                               [at](const RestInterval& rest) { return rest.end > at; }),
                rests.end());
    ended = Ended::not_yet;
    detail.clear();
    failure_ = DynamicsFailure::none;
    micro_bounce_ = 0.0;
    forget_stop();
    still_ = 0;
    for (auto& [count, last_met] : soft_)
        if (last_met > at) count = 0, last_met = -1.0;
    set_state();
    for (int i = 0; i < gap_count(); ++i)
        if (gap(i).has_condition) passing_[i] = !counts_now(i) && gap_now(i).gap < 0.0;
    rebase();
    dynamics_.kinks.set_sides(dynamics_.tree, now.q(), now.v());
    begin_stretch();
    restart();
}

void Motion::control(const double* torques) {
    if (ended != Ended::not_yet) return;
    now.rest.controls.assign(torques, torques + nv());
    smooth_since_ = now.t;
    stepper_.jump();
    forget_stop();
    update_rest(false, false);
}

void Motion::keep(const Step& step) {
    if (resting_states.empty() || !resting_states.back().is_same(now.rest))
        resting_states.push_back(now.rest);
    path.push_back({step, static_cast<int>(resting_states.size()) - 1});
}

// The time until the first slip stops if accelerations stay as they are: slip s with the rate a has
// nothing left along itself at t = −s²/(s·a).
double Motion::until_stopping() const {
    double soonest = INFINITY;
    for (std::size_t i = 0; i < now.rest.points.size(); ++i) {
        if (!now.rest.points[i].slip.moves || dynamics_.slip.size() < 3 * (i + 1)) continue;
        const double *s = dynamics_.slip.data() + 3 * i, *a = dynamics_.rate.data() + 3 * i;
        const double slows = -(s[0] * a[0] + s[1] * a[1]);
        if (slows > 0.0) soonest = std::min(soonest, (s[0] * s[0] + s[1] * s[1]) / slows);
    }
    return soonest > 0.0 ? soonest * (1.0 + kFurther) : INFINITY;
}

// Slip turns ever faster as it comes to its stop: steps get shorter with the time to it.
void Motion::foresee_stop() {
    const double stopping = until_stopping();
    if (stopping < stopping_) {
        if (!(smooth_next_ > 0.0)) smooth_next_ = stepper_.next;
        const double part = std::max(kLeast, stopping / stopping_);
        stepper_.next = std::max(part * stepper_.next, std::min(stepper_.next, tolerance::alike));
    }
    stopping_ = stopping;
}

// Behind an event steps are as long as before a stop was foreseen.
void Motion::forget_stop() {
    stepper_.next = std::max(stepper_.next, smooth_next_);
    stopping_ = smooth_next_ = 0.0;
}

double Motion::longest_step(double until) const {
    double longest = until - now.t;
    for (double stop : settings_.stop_times)
        if (stop > now.t) {
            longest = std::min(longest, stop - now.t);
            break;
        }
    if (settings_.max_step > 0.0) longest = std::min(longest, settings_.max_step);
    if (settings_.method == Method::dop853) {
        longest = std::min(longest, std::max(until_stopping(), tolerance::alike));
        if (micro_bounce_ > 0.0) longest = std::min(longest, 1.05 * micro_bounce_);
    }
    return longest;
}

// The rate at y, after anything has changed.
void Motion::restart() {
    stepper_.restart();
    if (!rate(now.t, now.q(), now.rate.data())) fail();
}

// The motion ends here, with the reason why it cannot go on.
bool Motion::fail() {
    if (ended != Ended::not_yet) return false;
    if (failure_ == DynamicsFailure::rest_not_solved)
        ended = Ended::rest_not_solved;
    else if (failure_ == DynamicsFailure::contradiction)
        ended = Ended::contradiction;
    else if (failure_ == DynamicsFailure::singular_mass || !(fastest() < kHuge) ||
             !rate(now.t, now.q(), now.rate.data()))
        ended = Ended::not_finite;
    else
        ended = Ended::step_too_small;
    return false;
}

// From a time on up to the next stop.
void Motion::begin_stretch() {
    const auto& stops = settings_.stop_times;
    const auto next = std::upper_bound(stops.begin(), stops.end(), now.t);
    const double from = next != stops.begin() && *(next - 1) == now.t
                            ? std::nextafter(now.t, INFINITY)
                            : -INFINITY,
                 to = next != stops.end() ? std::nextafter(*next, -INFINITY) : INFINITY;
    if (from == from_ && to == to_) return;
    const bool jumps = from != -INFINITY && from != from_;
    from_ = from;
    to_ = to;
    if (jumps) {
        smooth_since_ = now.t;
        forget_stop();
        restart();
    }
}

// When a gap closes by a step that was made anew up to there, by one step of Newton's method: the
// polynomial by which the time was found is a hundred times less accurate.
double Motion::sharpened(const Step& step, int gap) {
    set_state(step, step.end);
    const GapState at = gap_here(gap);
    const double change = at.rate < 0.0 ? at.gap / -at.rate : 0.0;
    return std::abs(change) < kSharpened * step.length ? step.end + change : step.end;
}

// End a motion that gets no further, or has made all its steps.
void Motion::check_progress() {
    still_ = now.t == checked_t_ ? still_ + 1 : 0;
    checked_t_ = now.t;
    if (still_ >= kMostStill) {
        ended = Ended::step_too_small;
        detail = "events follow each other at one time";
    } else if (stepper_.steps - counted_ >= settings_.max_steps) {
        ended = Ended::too_many_steps;
        detail = "max_steps is " + std::to_string(settings_.max_steps);
    } else if (stepper_.steps - checked_steps_ >= kManySteps) {
        refuse_hopeless(stepper_.steps - checked_steps_);
        checked_steps_ = stepper_.steps;
        still_since_ = now.t;
    }
}

bool Motion::advance(double until) {
    if (ended != Ended::not_yet || !(now.t < until)) return false;
    if (!(until - now.t > shortest_step(now.t))) {
        now.t = until;
        return false;
    }
    failure_ = DynamicsFailure::none;
    begin_stretch();
    const MotionState before = now;
    const auto f = [this](double at, const double* from, double* to) { return rate(at, from, to); };
    if (stepper_.next <= 0.0) stepper_.next = kFirstStep * settings_.scale_of_time;
    Step step;
    const auto settle = [this](double* x) {
        normalize_configuration(*scene_->scene.model, x);
        ends_ = true;
    };
    if (settings_.method == Method::dop853) foresee_stop();
    double longest = longest_step(until);
    dynamics_.has_opened = std::any_of(now.rest.points.begin(), now.rest.points.end(),
                                       [](const RestingContact& point) { return !point.pressed; });
    while (true) {
        if (!stepper_.step(f, settle, now.t, now.q(), now.rate.data(), longest, step)) {
            now = before;
            if (!now.rest.points.empty() && impact_without_collision()) return true;
            if (ended == Ended::not_yet && pass_change_point(until)) return true;
            failure_ = DynamicsFailure::none;
            rate(now.t, now.q(), now.rate.data());
            return fail();
        }
        const double shorter = shorter_step(step);
        if (!(shorter > 0.0)) break;
        now = before;
        longest = shorter;
    }
    micro_bounce_ = 0.0;
    const Event event = first_event(step);
    if (event.what.kind != EventFunction::none) {
        Step cut;
        now = before;
        if (event.t > step.start && event.t < step.end && !stepper_.is_accurate_within() &&
            stepper_.shortened(f, step, event.t, cut)) {
            step = cut;
            if (event.what.kind == EventFunction::gap_closes)
                step.end = sharpened(step, event.what.index);
        } else {
            step.end = std::max(event.t, step.start);
        }
        step.at(step.end, now.q());
        normalize_configuration(*scene_->scene.model, now.q());
        now.t = step.end;
        keep(step);
        smooth_since_ = now.t;
        forget_stop();
        if (!handle(event)) return ended == Ended::not_yet && fail();
    } else {
        keep(step);
        now.t = step.end;
        if (now.rest.acts() || dynamics_.constraints.rows() > 0) {
            recall_end();
            update_rest(true);
        }
    }
    if (ended == Ended::not_yet) check_progress();
    return ended == Ended::not_yet;
}

// End a motion whose last steps lead nowhere, or whose speeds need steps too short.
void Motion::refuse_hopeless(int made) {
    const double speed = fastest();
    const double took = now.t - still_since_, step = took / made,
                 left = settings_.scale_of_time - now.t;
    char told[300];
    if (took <= kNowhere * still_since_) {
        ended = Ended::step_too_small;
        std::snprintf(told, sizeof told,
                      "%d steps took %.1e s, and speeds are up to %.1e: a linkage that is driven "
                      "into a dead centre, or a force without bound",
                      made, took, speed);
    } else if (speed * step >= kFarAhead && left >= kHopeless * settings_.max_steps * step) {
        ended = Ended::too_many_steps;
        std::snprintf(told, sizeof told,
                      "at speeds of up to %.1e (m/s, rad/s) a step takes %.1e s: the %.3g s left "
                      "would take %.1e steps. Look at the units of the velocities, or shorten the "
                      "duration",
                      speed, step, left, left / step);
    } else {
        return;
    }
    detail = told;
}

std::vector<RestInterval> Motion::resting() const {
    std::vector<RestInterval> found;
    for (const RestingContact& point : now.rest.points) {
        const int entry = gap(point.gap).entry;
        const auto known = std::find_if(found.begin(), found.end(),
                                        [&](const RestInterval& r) { return r.entry == entry; });
        if (known == found.end())
            found.push_back({entry, point.since, INFINITY});
        else
            known->start = std::min(known->start, point.since);
    }
    return found;
}

}  // namespace impulsekit
