// Accelerations: M a = τ − h + Aᵀλ + JᵀF with A a = ẇ − Ȧ v for what holds and Coulomb's law on
// J a + J̇ v for what rests (Chang & Huston 1995, eq. (17), with multipliers).
#pragma once

#include <vector>

#include "impact/constrained_mass.hpp"
#include "linalg/dense.hpp"
#include "motion/bilateral_constraints.hpp"
#include "motion/contact_gaps.hpp"
#include "motion/forces.hpp"
#include "motion/tolerances.hpp"

namespace impulsekit {

// A joint with dry friction τ_c.
struct DryJoint {
    int v = 0;
    double bound = 0.0;
};

// A robot, what acts on it, holds and touches it: all that does not change along a motion.
struct MotionScene {
    Scene scene;
    ContactLaw law;
    Forces forces;
    double gravity[3] = {};
    int entries = 0;  // of the scene's bilateral entries those that hold between impacts
    std::vector<char> driven_places, driven_speeds;
    ConstraintFunctions constraints;
    GapFunctions contact_gaps;
    std::vector<double> pulls;      // (contacts) force that holds it to what it touches [N]
    std::vector<char> conditional;  // (contacts)
    std::vector<DryJoint> dry;
};

// Changes of velocities along rows (count, nv), made by what is least in the metric of M.
struct Correction {
    std::vector<double> rows, change;

    void add(const double* row, int nv, double by) {
        rows.insert(rows.end(), row, row + nv);
        change.push_back(by);
    }
    // True if some are above rounding.
    bool is_needed() const {
        return largest(change.data(), static_cast<int>(change.size())) > tolerance::sums;
    }
};

enum class DynamicsFailure { none, singular_mass, contradiction, rest_not_solved };

// Forces of what rests and holds at a state: by point F and a (3n) and slip u (3n), in the axes of
// each; of those that resist turning moments, their rates and speeds (3k); of joints with dry
// friction what it gives and their acceleration; λ and which are determined.
struct RestForces {
    std::vector<double> F, rate, slip, moment, turn_rate, turning, dry_torque, dry_rate;
    std::vector<double> multipliers;
    std::vector<char> unique;
    std::vector<int> turning_points;
    double size = 0.0;  // the largest acceleration of what rests without its forces
};

// With those of the last evaluation.
class Dynamics : public RestForces {
  public:
    explicit Dynamics(const MotionScene& scene);

    const MotionScene& scene;
    Tree<double> tree;
    BilateralConstraints constraints;
    ContactGaps contact_gaps;
    Kinks kinks;
    // Slip below this [m/s] has no direction of its own.
    double slow = kNoSlip;
    int evaluations = 0;
    // True from an evaluation on in which a point that rests does not push.
    bool has_opened = false;

    // v̇ (nv) at a state under what rests; `pressed` of points is updated.
    DynamicsFailure accelerate(double t, const double* q, const double* v, RestingState& rest,
                               double* a);
    // The same where nothing but torques from outside and slip states changed since the last
    // evaluation; the tree is left as it is.
    DynamicsFailure accelerate_again(RestingState& rest, double* a);
    // True if the last evaluation was here, with the same rows.
    bool is_known(double t, const double* q, const double* v, const RestingState& rest) const;

    // Places and twists at a state, and with `rates` accelerations at no joint acceleration.
    void set_state(const double* q, const double* v, bool rates = false);
    // Add a correction to velocities (nv); false where there is none. The tree with places.
    bool correct(const Correction& correction, double* v);
    // M (nv, nv) at the tree's places.
    const std::vector<double>& mass_matrix();

    // µ of a contact that keeps still, and that slides at a speed.
    double static_friction(int entry) const;
    double sliding_friction(int entry, double speed) const;
    bool has_drop(int entry) const;  // whether friction falls where slip begins

  private:
    void write_load(double t, const double* q, const double* v, const RestingState& rest);
    bool hold(double* start);
    void write_rest_rows(const double* q, const double* v, const RestingState& rest);
    // By point or joint: see RestProblem; the pull [N] of each point, and whether it pushes.
    struct RestBounds {
        double *reach, *direction, *bound, *pull;
        char* pressed;
    };
    DynamicsFailure prepare(double t, const double* q, const double* v, const RestingState& rest);
    void condense(int threes);
    void write_bounds(const RestingState& rest, const RestBounds& bounds, double* free);
    DynamicsFailure rest_forces(RestingState& rest, double* start);

    ConstrainedMass mass_;
    std::vector<double> M_, load_, target_, demand_, J_, bias_, half_contacts_, left_, start_, W_;
    // The state of the last evaluation, and what rested in it; none where its rows have changed.
    bool is_prepared_ = false;
    double t_ = 0.0;
    std::vector<double> state_;
    RestingState rest_;
    int rows_ = 0;
    double squares_ = 0.0;  // what squares of velocities can make of rates of rows
};

}  // namespace impulsekit
