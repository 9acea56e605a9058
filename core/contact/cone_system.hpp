// The cones' problem in units of its own, and the natural map whose zeros are its answers.
#pragma once

#include "contact/cones.hpp"

namespace impulsekit {

// The used rows alone, each contact and group in units in which its own mobility is 1, velocities
// in units of the largest: then P and ξ have one unit, and the natural map has no parameter.
struct ConeSystem {
    int rows = 0, contacts = 0, groups = 0;
    double* A = nullptr;               // (rows, rows)
    double* mobility = nullptr;        // (rows, rows) A without friction of what slides, symmetric
    double* b = nullptr;               // (rows)
    int* source = nullptr;             // (rows) row of the given problem
    double* unit = nullptr;            // (rows) P_given = unit · P · velocity
    double* mobility_ratio = nullptr;  // (rows) the largest mobility in any direction of a group
    int* normal = nullptr;             // (contacts)
    int* owner = nullptr;              // (contacts) number of the given contact
    double* floor = nullptr;           // (contacts)
    double* adhesion = nullptr;        // (contacts)
    int* first = nullptr;              // (groups)
    int* size = nullptr;               // (groups)
    int* contact = nullptr;            // (groups)
    double* friction = nullptr;        // (groups)
    double* even = nullptr;            // (groups) ones, the balance of what is measured
    double* balance = nullptr;         // (groups) that of steps, which follows them
    double velocity = 1.0;
    bool blocked = false;
};

ConeSystem build_system(const double* W, int rows, const double* b, double scale,
                        const Cones& cones, Arena& arena);

double hypot_of(const double* x, int size);

// The largest |P_g| of a group: µ times A and the normal impulse that P − ξ is projected to.
double radius_of(const ConeSystem& s, int group, const double* P, const double* xi);

// F of the natural map (Alart & Curnier 1991): P − Π(P − ρ ξ), zero where P obeys the law. ρ > 0
// is 1 along normals, and of each group that of `balance` (groups).
void natural_map_residual(const ConeSystem& s, const double* balance, const double* P,
                          const double* xi, double* F);

// A derivative of F by P, with `A` the matrix of ξ.
void natural_map_jacobian(const ConeSystem& s, const double* A, const double* balance,
                          const double* P, const double* xi, double* J);

// The largest entry of F in units of the largest velocity: where no answer is, impulses grow until
// what is left is nothing beside them, but not beside the velocities.
double residual_of(const ConeSystem& s, const double* P, Arena& arena);

}  // namespace impulsekit
