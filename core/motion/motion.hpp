// A motion: steps cut at what happens within them, impacts, and what rests between.
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
#include "motion/events.hpp"
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

class Motion {
  public:
    Motion(std::shared_ptr<const MotionScene> scene, MotionSettings settings, const double* q,
           const double* v);

    // The gaps that are closed at the start, and their values and rates.
    std::vector<GapAt> gaps_closed_at_start();
    // True if there is an impact at the start without known impulses: one of these gaps closes, or
    // a constraint prescribes another velocity than it has.
    bool is_struck_at_start(const std::vector<int>& closed);
    // The motion begins with this velocity, after what strikes at the start.
    void begin(const double* v, const std::vector<int>& contact_gaps);
    // Steps count anew.
    void go_on() { counted_ = stepper_.steps; }
    // One step, and what happens in it, but not past a time; false where the motion has ended.
    bool advance(double until);
    // Back to a time of the path: what came later has not been.
    void rewind(double at);
    // Torques (nv) from outside, from now on.
    void control(const double* torques);

    MotionState now;
    std::vector<Piece> path;
    std::vector<RestingState> resting_states;
    std::vector<std::shared_ptr<const MotionImpact>> impacts;
    std::vector<RestInterval> rests;
    Ended ended = Ended::not_yet;
    bool begun = false;
    std::string detail;

    int nq() const { return scene_->scene.model->nq; }
    int nv() const { return scene_->scene.model->nv; }
    int steps() const { return stepper_.steps; }
    Dynamics& dynamics() { return dynamics_; }
    const Dynamics& dynamics() const { return dynamics_; }
    const MotionScene& scene() const { return *scene_; }
    // q and v (normalized) at a time of the path.
    void state(double at, double* q, double* v) const;
    // y (nq + nv) at a time of the path, as its steps have it: q off unit length by rounding.
    void sample(double at, double* found) const;
    // The resting state then.
    const RestingState& resting_state_at(double at) const;
    // Forget steps of the path that end before a time.
    void forget(double before);
    // The contacts that rest now, and since when.
    std::vector<RestInterval> resting() const;

  private:
    std::size_t piece_at(double at) const;
    bool rate(double at, const double* y, double* rate, bool is_known = false);
    void recall_end();
    bool set_state(const Step& step, double at);
    Spatial<double> velocity_of(const RestingContact& point, const double* state) const;
    const Gap& gap(int i) const { return dynamics_.contact_gaps.gaps()[i]; }
    int gap_count() const { return static_cast<int>(dynamics_.contact_gaps.gaps().size()); }
    GapState gap_now(int i) const;
    bool counts_now(int i) const;
    double fastest() const;
    void set_state();
    void keep(const Step& step);
    void restart();
    void begin_stretch();
    bool pass_change_point(double until);
    Step extrapolation(double start, double length) const;
    double error_behind(const Step& jump);
    void check_progress();
    void refuse_hopeless(int made);
    double longest_step(double until) const;
    double until_stopping() const;
    void foresee_stop();
    void forget_stop();
    bool fail();
    void forces_at(const Step& step, double at, std::vector<double>& found);
    double shorter_step(const Step& step);

    // Events.
    Event first_event(const Step& step);
    double sharpened(const Step& step, int gap);
    bool stays_free(int gap, const Step& step);
    GapState gap_here(int gap, Ahead* ahead = nullptr);
    GapState followed(const EventFunction& f, Ahead* ahead = nullptr);
    double first_zero_of(const EventFunction& f, const Step& step, const GapState* nodes,
                         double until, double& unsure);
    std::vector<EventFunction> event_functions() const;
    double margin(const EventFunction& f, const Spatial<double>& u);
    void margins(const std::vector<EventFunction>& functions, const Step& step, double at,
                 std::vector<double>& found);
    Event first_change(const std::vector<EventFunction>& functions, int looks, const Step& step,
                       double until);
    bool handle(const Event& event);
    void stop_slips();
    std::vector<int> gaps_that_close(int gap);

    // Impacts.
    bool is_driven_off();
    bool close_gaps(const std::vector<int>& closing);
    bool apply_impact(std::vector<RestingContact> points, double approach, double capture);
    bool impact_without_collision();
    bool has_impacts_left();
    bool press_in(const std::vector<RestingContact>& points, const std::vector<double>& J,
                  double fastest, double sums);
    void count_soft_impact(int gap, bool soft);
    bool chatters(int gap) const;
    Vec acceleration_of(const RestingContact& point, const double* a) const;
    std::vector<double> rows_of(const std::vector<RestingContact>& points);
    SceneImpact solve(const std::vector<RestingContact>& points, const std::vector<double>& v,
                      bool soft) const;
    bool go_on_after(SceneImpact impact, bool soft, bool is_kept);
    std::vector<RestingContact> points_of_gaps(const std::vector<int>& gaps);

    // Rest.
    bool find_resting_contacts(const std::vector<RestingContact>& candidates, bool lay,
                               double no_slip);
    std::vector<RestingContact> micro_bounces(const std::vector<RestingContact>& parted);
    bool find_slip_states(double no_slip);
    bool update_rest(bool is_known = false, bool has_moved = true);
    bool correct_drift(bool all_normals);
    bool correct_places(bool all_normals, std::vector<double>& J);
    bool correct_velocities(bool all_normals, const std::vector<double>& J);
    bool update_slip_states();
    void release_contacts();
    void rebase();
    void end_rests(const std::vector<RestInterval>& before);
    void retain_contacts(std::vector<RestingContact> stays);
    bool release_unloaded();
    double pull_on(int entry) const;

    std::shared_ptr<const MotionScene> scene_;
    MotionSettings settings_;
    Dynamics dynamics_;
    Stepper stepper_;
    DynamicsFailure failure_ = DynamicsFailure::none;
    std::vector<double> here_, base_, largest_force_;
    RestForces at_end_;  // of the last step
    std::vector<char> pressed_at_end_;
    bool ends_ = false;  // whether the next rate is that of the end of a step
    // Forces that jump at a stop have their values on this side of it [s].
    double from_ = -INFINITY, to_ = INFINITY;
    std::vector<char> passing_;
    std::vector<std::pair<int, double>> soft_;  // by gap
    double slow_ = kNoSlip;                     // slip below it is none after an impact [m/s]
    double stopping_ = 0.0;                     // time to a stop of slip at the last step [s]
    double smooth_next_ = 0.0;                  // length of steps before one was foreseen [s]
    double smooth_since_ = 0.0;                 // nothing has happened from then on [s]
    double micro_bounce_ = 0.0;  // how soon what was struck comes down again [s]; 0 for never
    double still_since_ = 0.0;
    int still_ = 0, checked_steps_ = 0, counted_ = 0;
    double checked_t_ = 0.0;
};

}  // namespace impulsekit
