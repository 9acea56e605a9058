// A motion on its way as plain data, and what can be said of it now; the functions that move it on
// stand in files of their own, from start.hpp and advance.hpp on.
#pragma once

#include <cmath>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "impact/coefficients.hpp"
#include "impact/scene_impact.hpp"
#include "integrator/stepper.hpp"
#include "motion/dynamics.hpp"
#include "motion/tolerances.hpp"

namespace impulsekit {

struct MotionSettings {
    Method method = Method::dop853;
    double rtol = 1e-8, atol = 1e-12, fixed_length = 1e-3, max_step = 0.0;
    double capture_speed = 1e-7, together = tolerance::alike;
    double scale_of_time = 1.0;      // the length of the whole motion [s]
    std::vector<double> stop_times;  // rising
    int max_impacts = 10000, max_steps = 100000;
};

// The end of a motion.
enum class Ended {
    not_yet = -1,
    finished,
    event_storm,
    too_many_steps,
    step_too_small,
    not_finite,
    impact_not_valid,
    interrupted,
    contradiction,
    rest_not_solved,
    penetration,
};

// An impact on the way.
struct MotionImpact {
    double t = 0.0;
    bool is_soft = false;  // met without restitution
    SceneImpact solved;
};

// From when to when a contact rested.
struct RestInterval {
    int entry = 0;
    double start = 0.0, end = 0.0;
};

// One step of the path and what rested in it.
struct Piece {
    Step step;
    int resting_state = 0;
};

// What is remembered of a gap.
struct GapMemory {
    double base = 0.0;    // it counts from here: where it is closed, or overlaps by rounding [m]
    bool passes = false;  // a contact that does not count is within
    int soft = 0;         // impacts below the capture speed in quick succession
    double last_soft = -1.0;  // [s]
};

// Forces at the end of the last step, which was evaluated before others within it.
struct StepEnd {
    RestForces forces;
    std::vector<char> pressed;  // by resting point
    bool is_next = false;       // whether the next rate is that of the end of a step
};

// Forces that jump at a stop have their values on this side of it [s].
struct Stretch {
    double from = -INFINITY, to = INFINITY;
};

// A stop of slip that is foreseen.
struct SlipStop {
    double until = 0.0;          // time to it at the last step [s]
    double length_before = 0.0;  // of steps before it was foreseen [s]
};

// How far a motion has come by so many steps.
struct Progress {
    double t = 0.0;  // at the last look [s]
    int still = 0;   // looks without time between them
    int steps = 0;   // at the last look for hopeless ones
    double since = 0.0;
    int counted = 0;  // before those that count
};

// A motion on its way: where it is, how it came here, and what its steps remember.
struct Motion {
    Motion(std::shared_ptr<const MotionScene> scene, MotionSettings settings, const double* q,
           const double* v);

    std::shared_ptr<const MotionScene> scene;
    MotionSettings settings;
    MotionState now;
    bool begun = false;

    // The way up to now.
    std::vector<Piece> path;
    std::vector<RestingState> resting_states;
    std::vector<std::shared_ptr<const MotionImpact>> impacts;
    std::vector<RestInterval> rests;
    Ended ended = Ended::not_yet;
    std::string detail;
    DynamicsFailure failure = DynamicsFailure::none;  // of the last evaluation that failed

    Dynamics dynamics;
    Stepper stepper;
    std::vector<GapMemory> memory;  // by gap
    StepEnd last_end;
    Stretch stretch;
    SlipStop stop;
    Progress progress;
    double slow = kNoSlip;        // slip below it is none after an impact [m/s]
    double smooth_since = 0.0;    // nothing has happened from then on [s]
    double micro_bounce = 0.0;    // how soon what was struck comes down again [s]; 0 for never
    std::vector<double> largest;  // of the numbers that functions of time and state gave so far
    std::vector<double> here;     // (nq + nv) the state within a step that is looked at

    int nq() const { return scene->scene.model->nq; }
    int nv() const { return scene->scene.model->nv; }
    const Gap& gap(int i) const { return dynamics.contact_gaps.gaps()[i]; }
    int gap_count() const { return static_cast<int>(dynamics.contact_gaps.gaps().size()); }
};

// ẏ of y = (q, v). `is_known`: loads other than torques from outside are those of the last
// evaluation, if that was here.
bool find_rate(Motion& motion, double at, const double* from, double* to, bool is_known = false);

// Places and twists of a step at a time, whose state is `here`.
void set_state(Motion& motion, const Step& step, double at);

// The velocity of a resting point at a state (nq + nv), which the tree has.
Spatial<double> velocity_of(const Motion& motion, const RestingContact& point, const double* state);

// The largest velocity [m/s, rad/s].
double fastest(const Motion& motion);

// A gap now, and whether it counts; the tree with places and twists.
GapState gap_now(const Motion& motion, int i);

bool counts_now(const Motion& motion, int i);

// Places and twists of now.
void set_state(Motion& motion);

// True if impacts of a gap below the capture speed follow each other in quick succession.
bool chatters(const Motion& motion, int gap);

// The force that holds a contact to what it touches [N].
double pull_on(const Motion& motion, int entry);

// The rate at y, after anything has changed.
void restart(Motion& motion);

// The motion ends here, with the reason why it cannot go on.
bool fail(Motion& motion);

// The contacts that rest now, and since when.
std::vector<RestInterval> rests_now(const Motion& motion);

// Gaps that are closed, or overlap by rounding, count as zero.
void rebase(Motion& motion);

// (3 (points + turning), nv) rows of points at the tree's state, then of the turning of some.
std::vector<double> rows_of(Motion& motion, const std::vector<RestingContact>& points);

// The acceleration of a point in its axes, of a; the tree with rates at no joint acceleration.
Vec acceleration_of(const Motion& motion, const RestingContact& point, const double* a);

}  // namespace impulsekit
