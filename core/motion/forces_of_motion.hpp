// All forces at a state of a motion, and short flows of it without events.
#pragma once

#include <memory>
#include <optional>
#include <vector>

#include "impact/loads.hpp"
#include "motion/dynamics.hpp"

namespace impulsekit {

// Forces that act at a state: of the resting points (n) F (3) and slip (3) in their axes; of those
// that resist turning moments (3k) and speeds.
struct ForcesAt {
    DynamicsFailure failure = DynamicsFailure::none;
    std::vector<double> acceleration, multipliers;  // (nv), (rows)
    std::vector<char> unique;                       // (rows) whether each λ is determined
    std::vector<ContactFrame<double>> points;
    Vec3<double> origin;  // of the world, as places are seen
    std::vector<int> turning_of;
    std::vector<double> forces, slip, moments, turning;
    std::vector<double> dry;  // torques of joints with dry friction
};

// What forces make of joints and links, bilateral constraints, contacts and forces counted in this
// order; the weight of all that moves (6) about the world's origin, and the velocities of the rows
// of constraints. By force its torques (nv), its wrench (6) about its point on its first body in
// world axes, and its power [W].
struct LoadsAt {
    Loads loads;
    std::vector<double> weight, row_velocities, torques, wrenches, power;
};

// The state (nq + nv) at a time, as far as a motion is followed.
using FlowEnd = std::optional<std::vector<double>>;

class ForcesOfMotion {
  public:
    // `slow`: slip below it [m/s] has no direction of its own.
    ForcesOfMotion(std::shared_ptr<const MotionScene> scene, double slow);

    const Dynamics& dynamics() const { return dynamics_; }
    ForcesAt at(double t, const double* q, const double* v, RestingState rest);
    // Follow from `start` to `end` while the same rests, whatever happens on the way; none where
    // there is no acceleration, or no step is short enough.
    FlowEnd flow(double start, double end, const double* q, const double* v, RestingState rest,
                 double rtol, double atol);
    LoadsAt loads(const Links& links, double t, const double* q, const double* v,
                  const ForcesAt& at);
    std::vector<GapAt> gaps(const double* q, const double* v);
    // (nv) the row of a gap's rate.
    std::vector<double> gap_row(int gap, const double* q, const double* v);
    double spring_energy(const double* q);

  private:
    void set_sides(const double* q, const double* v);
    void add_forces(double t, const double* q, const double* v, const ForcesAt& at,
                    OuterWrenches& outside, LoadsAt& found);

    std::shared_ptr<const MotionScene> scene_;
    const Model& model_;
    Dynamics dynamics_;
};

}  // namespace impulsekit
