#include "motion/motion.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/arena.hpp"
#include "linalg/dense.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {
namespace {

// Slip has grown when it is this many times as fast as slip that has no direction of its own.
constexpr double kGrown = 30.0;
// So many impacts below the capture speed in quick succession are chatter: two ends of an edge that
// rests lift each other in turn, by ever the same speed.
constexpr int kChatter = 8;
// Speeds [m/s] whose squares may overflow.
constexpr double kHuge = 1e100;

}  // namespace

Motion::Motion(std::shared_ptr<const MotionScene> given, MotionSettings chosen, const double* q,
               const double* v)
    : scene(std::move(given)),
      settings(std::move(chosen)),
      dynamics(*scene),
      stepper(settings.method, nq(), nq() + nv(), {settings.rtol, settings.atol},
              settings.fixed_length),
      memory(gap_count()),
      slow(std::max(kNoSlip, settings.capture_speed)),
      here(nq() + nv()) {
    now.y.assign(q, q + nq());
    now.y.insert(now.y.end(), v, v + nv());
    now.nq = nq();
    now.rate.assign(now.y.size(), 0.0);
    now.rest.dry.assign(scene->dry.size(), 0);
    dynamics.slow = kGrown * slow;
}

bool find_rate(Motion& motion, double at, const double* from, double* to, bool is_known) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    Arena::Scope scope(scratch());
    const Model& model = *motion.scene->scene.model;
    const bool ends = motion.last_end.is_next;
    motion.last_end.is_next = false;
    double* q = scratch().allocate(motion.nq());
    std::copy(from, from + motion.nq(), q);
    normalize_configuration(model, q);
    configuration_rate(model, from, from + motion.nq(), to);
    at = std::min(std::max(at, motion.stretch.from), motion.stretch.to);
    const double* v = from + motion.nq();
    const DynamicsFailure failure = is_known && dynamics.is_known(at, q, v, now.rest)
                                        ? dynamics.accelerate_again(now.rest, to + motion.nq())
                                        : dynamics.accelerate(at, q, v, now.rest, to + motion.nq());
    if (failure != DynamicsFailure::none) {
        motion.failure = failure;
        return false;
    }
    if (ends) {
        motion.last_end.forces = dynamics;
        motion.last_end.pressed.clear();
        for (const RestingContact& point : now.rest.points)
            motion.last_end.pressed.push_back(point.pressed);
    }
    double sum = 0.0;
    for (int i = 0; i < motion.nv(); ++i) sum += to[motion.nq() + i];
    return std::isfinite(sum);
}

void set_state(Motion& motion, const Step& step, double at) {
    step.at(at, motion.here.data());
    normalize_configuration(*motion.scene->scene.model, motion.here.data());
    motion.dynamics.set_state(motion.here.data(), motion.here.data() + motion.nq());
}

Spatial<double> velocity_of(const Motion& motion, const RestingContact& point,
                            const double* state) {
    return motion.dynamics.contact_gaps.velocity(motion.dynamics.tree, point, state,
                                                 state + motion.nq());
}

double fastest(const Motion& motion) { return largest(motion.now.v(), motion.nv()); }

GapState gap_now(const Motion& motion, int i) {
    return motion.dynamics.contact_gaps.measure(motion.dynamics.tree, motion.gap(i), motion.now.q(),
                                                motion.now.v());
}

bool counts_now(const Motion& motion, int i) {
    return motion.dynamics.contact_gaps.counts(motion.gap(i), motion.now.q(), motion.now.v());
}

void set_state(Motion& motion) { motion.dynamics.set_state(motion.now.q(), motion.now.v()); }

bool chatters(const Motion& motion, int gap) { return motion.memory[gap].soft >= kChatter; }

double pull_on(const Motion& motion, int entry) {
    return motion.scene->pulls.empty() ? 0.0 : motion.scene->pulls[entry];
}

void restart(Motion& motion) {
    MotionState& now = motion.now;
    motion.stepper.restart();
    if (!find_rate(motion, now.t, now.q(), now.rate.data())) fail(motion);
}

bool fail(Motion& motion) {
    MotionState& now = motion.now;
    if (motion.ended != Ended::not_yet) return false;
    if (motion.failure == DynamicsFailure::rest_not_solved)
        motion.ended = Ended::rest_not_solved;
    else if (motion.failure == DynamicsFailure::contradiction)
        motion.ended = Ended::contradiction;
    else if (motion.failure == DynamicsFailure::singular_mass || !(fastest(motion) < kHuge) ||
             !find_rate(motion, now.t, now.q(), now.rate.data()))
        motion.ended = Ended::not_finite;
    else
        motion.ended = Ended::step_too_small;
    return false;
}

std::vector<RestInterval> rests_now(const Motion& motion) {
    std::vector<RestInterval> found;
    for (const RestingContact& point : motion.now.rest.points) {
        const int entry = motion.gap(point.gap).entry;
        const auto known = std::find_if(found.begin(), found.end(),
                                        [&](const RestInterval& r) { return r.entry == entry; });
        if (known == found.end())
            found.push_back({entry, point.since, INFINITY});
        else
            known->start = std::min(known->start, point.since);
    }
    return found;
}

void rebase(Motion& motion) {
    set_state(motion);
    for (int i = 0; i < motion.gap_count(); ++i)
        motion.memory[i].base =
            motion.memory[i].passes ? 0.0 : std::min(gap_now(motion, i).gap, 0.0);
}

std::vector<double> rows_of(Motion& motion, const std::vector<RestingContact>& points) {
    const auto turning = std::count_if(points.begin(), points.end(), [&](const RestingContact& p) {
        return motion.gap(p.gap).turns;
    });
    const std::size_t block = 3 * motion.nv();
    std::vector<double> J((points.size() + turning) * block);
    double *to = J.data(), *turns = to + points.size() * block;
    for (const RestingContact& point : points) {
        motion.dynamics.contact_gaps.rows(motion.dynamics.tree, point, motion.now.q(),
                                          motion.now.v(),
                                          {to, motion.gap(point.gap).turns ? turns : nullptr});
        to += block;
        if (motion.gap(point.gap).turns) turns += block;
    }
    return J;
}

Vec acceleration_of(const Motion& motion, const RestingContact& point, const double* a) {
    std::vector<double> J(6 * motion.nv());
    double bias[6];
    motion.dynamics.contact_gaps.rows(motion.dynamics.tree, point, motion.now.q(), motion.now.v(),
                                      {J.data(), J.data() + 3 * motion.nv(), bias, bias + 3});
    for (int j = 0; j < 3; ++j) bias[j] += dot(J.data() + j * motion.nv(), a, motion.nv());
    return vec3<double>(bias);
}

}  // namespace impulsekit
