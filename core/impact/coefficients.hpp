// The law of a scene and the coefficients of its contacts, and those of the points that touch.
#pragma once

#include <functional>
#include <vector>

#include "impact/impact.hpp"
#include "scene/contact_frame.hpp"

namespace impulsekit {

// A coefficient that is a number, or one that changes with the speed: zero below a capture speed,
// by a table, linear between its points, or by a function.
struct BySpeed {
    double value = 0.0, capture = 0.0;
    Table table;
    std::function<double(double)> function, slope;  // its derivative, if it is known

    double at(double speed) const;
    bool is_constant() const { return !function && table.empty() && capture == 0.0; }
};

// The coefficients of one contact of a scene.
struct ContactCoefficients {
    BySpeed restitution;
    double friction = 0.0, tangential = 0.0, stiffness = 0.0, adhesion = 0.0;
    double stiffness_ratio = 0.0, tangential_damping = 0.0;
    double rolling = 0.0, torsion = 0.0;
    Friction model;
};

struct ContactLaw {
    ContactLaw() = default;
    ContactLaw(const Law& own, std::vector<ContactCoefficients> coefficients);

    Law law;
    std::vector<ContactCoefficients> contacts;
    bool has_models = false, has_adhesion = false, has_damping = false;
};

// Coefficients of the points of one state, as a contact problem takes them.
class PointCoefficients {
  public:
    // Those of `rows` for their problem, with its velocities before or with J and v⁻ (nv).
    // `restitution`, `friction`: of each contact of the scene in place of the law's own; null where
    // these hold.
    void set(const ContactLaw& law, const StateRows& rows, const double* restitution,
             const double* friction, const double* v, ContactProblem& problem);

  private:
    std::vector<double> numbers_;
    std::vector<Friction> models_;
};

}  // namespace impulsekit
