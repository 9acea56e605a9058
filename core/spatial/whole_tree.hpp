// Placements, matrices and responses of a whole tree at one state, in Pinocchio's axes of joints.
#pragma once

#include <vector>

#include "spatial/model.hpp"

namespace impulsekit {

// (bodies, 12) rotations, row by row, and origins of joints in the world.
std::vector<double> placements(const Model& model, const double* q);
// (6, nv) columns of the joints about the origin of the world.
std::vector<double> jacobian(const Model& model, const double* q);
// (nv, nv) M.
std::vector<double> mass_matrix(const Model& model, const double* q);
// (nv) c(q, v).
std::vector<double> bias(const Model& model, const double* q, const double* v,
                         const double* gravity);

// (8) kinetic energy and that of weight, zero at the world's origin [J]; linear momentum, and
// angular about there.
std::vector<double> energies(const Model& model, const double* q, const double* v,
                             const double* gravity);

// Impulses in joints (nv), and wrenches (count, 6) on some bodies in the axes of their joints.
struct TreeImpulses {
    const double* impulse = nullptr;
    const int* bodies = nullptr;
    const double* wrenches = nullptr;
    std::size_t count = 0;
};

// The answer to impulses in joints and on bodies: Δv; of each body but the world the twist after
// and the wrench that its parent gives it, in world axes.
struct AppliedImpulses {
    std::vector<double> dv, twists, reactions;
};

// For trees without joints that follow others, and without ellipsoids.
AppliedImpulses apply_impulses(const Model& model, const double* q, const double* v,
                               const TreeImpulses& given);

}  // namespace impulsekit
