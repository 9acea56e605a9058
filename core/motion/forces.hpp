// Forces on a robot between impacts: springs, dampers, PD laws, torques and forces.
#pragma once

#include <functional>
#include <utility>
#include <vector>

#include "linalg/table.hpp"
#include "scene/scene.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

// A spring in a joint, τ = τ₀ − k (q − rest) − c v, or a PD law, which has a limit.
struct JointForce {
    int v = 0, q = 0;
    bool is_circle = false;  // of a joint that turns without end
    double stiffness = 0.0, damping = 0.0, rest = 0.0, torque = 0.0, limit = 0.0;
    double side = 0.0;  // acts on one side of its rest alone: 1 above, −1 below, 0 both
    bool stores = true;
};

// A spring between two points: tension k (l − l₀) + c dl/dt.
struct PointSpring {
    Site first, other;
    double stiffness = 0.0, damping = 0.0, rest = 0.0;
    double side = 0.0;  // 1 pulls only, −1 pushes only, 0 both
};

// Numbers by time [s] and state.
using ForceFunction = std::function<void(double t, const double* q, const double* v, double* to)>;

// A force and a couple on a body: six numbers, or those that a function gives.
struct AppliedForce {
    Site site;
    bool is_local = false;
    double numbers[6] = {};
    ForceFunction function;
};

// Torques in joints, on entries of v from the first: numbers, a table over time, a function.
struct ConstantTorque {
    int v = 0;
    std::vector<double> torque;
};
struct TimedTorque {
    int v = 0;
    Table table;
};
struct TorqueFunction {
    int v = 0, count = 0;
    ForceFunction function;
};

// One entry of a scene's forces, by kind and place in its table.
struct ForceEntry {
    enum Kind { constant, joint, spring, applied, timed, function, dry } kind = constant;
    int index = 0;
    double bound = 0.0;  // of dry friction, of which a joint may have several
};

// The side of a force with a kink: a one-sided spring out of its zone, within, or there without
// force since its damper would pull what it pushes; a PD law below its limit, or at one of both.
enum class Side : signed char { lower = -1, out = 0, acts = 1, upper = 2, slack = 3 };

struct Forces {
    std::vector<ConstantTorque> constants;
    std::vector<JointForce> joints;
    std::vector<PointSpring> springs;
    std::vector<AppliedForce> applied;
    std::vector<TimedTorque> timed;
    std::vector<TorqueFunction> functions;
    std::vector<ForceEntry> entries;

    bool on_bodies() const { return !springs.empty() || !applied.empty(); }
    // True if some change with time, or by functions of the state.
    bool are_watched() const;
};

// The forces with a kink, joints first, and how each acts now.
class Kinks {
  public:
    explicit Kinks(const Forces& forces);
    int count() const { return static_cast<int>(joints_.size() + springs_.size()); }
    // Sides as a state has them; the tree with places and twists.
    void set_sides(const Tree<double>& tree, const double* q, const double* v);
    // Change those that are at a kink and go on beyond it.
    void change(const Tree<double>& tree, const double* q, const double* v);
    // Positive while the k-th keeps its side for where it stands, and how fast that falls; and for
    // the force of its damper, or its limit.
    std::pair<double, double> zone(int k, const Tree<double>& tree, const double* q,
                                   const double* v) const;
    double margin(int k, const Tree<double>& tree, const double* q, const double* v) const;
    Side of_joint(int i) const { return side_of_joint_[i]; }
    Side of_spring(int i) const { return side_of_spring_[i]; }

  private:
    // A force at a state: of a one-sided spring towards its side, else its torque and its limit;
    // by how much it goes beyond its kink; and how far a spring is within its zone.
    struct Kinked {
        bool is_one_sided, is_damped;
        double force, limit, beyond, zone, rate;

        // The action of a spring within its zone.
        Side inside() const { return is_damped && force < 0.0 ? Side::slack : Side::acts; }
    };
    Kinked at(int k, const Tree<double>& tree, const double* q, const double* v) const;
    Side& side(int k);
    Side side(int k) const { return const_cast<Kinks*>(this)->side(k); }

    const Forces* forces_;
    std::vector<int> joints_, springs_;
    std::vector<Side> side_of_joint_, side_of_spring_;
};

// Add to torques (nv) what the i-th entry, or all (i < 0), gives along the joints.
void add_torques(const Forces& forces, const Kinks& kinks, int entry, double t, const double* q,
                 const double* v, double* torques);

// Takes a wrench on a body, about the body's origin in world axes.
using AddWrench = std::function<void(const Site& site, const Spatial<double>& wrench)>;

// Give what the i-th entry, or all (i < 0), does on bodies: of a spring first the first. The tree
// with places and twists.
void add_wrenches(const Forces& forces, const Kinks& kinks, int entry, double t, const double* q,
                  const double* v, const Tree<double>& tree, const AddWrench& add);

// The energy in the springs [J]; the tree with places.
double spring_energy(const Forces& forces, const Tree<double>& tree, const double* q);

}  // namespace impulsekit
