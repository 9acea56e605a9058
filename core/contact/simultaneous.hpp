// All contacts at once, friction by the slip at the end: Newton's and Poisson's restitution.
#pragma once

#include "contact/cones.hpp"
#include "contact/problem.hpp"

namespace impulsekit {

// ξ = u⁺ + e min(u⁻, 0) along normals and u_t⁺ + e_t u_t⁻ along tangents obey the cones (Moreau
// 1988; Glocker 2001); or compression to ξ = u⁺, then expansion with P_n >= e P_n of the
// compression (Glocker & Pfeiffer 1995).
ContactSolution solve_simultaneous(const ContactProblem& problem, const Law& law);

// The cones of a problem, in scratch memory, with floors of zero.
Cones cones_of(const ContactProblem& problem);

// e min(u_n⁻, 0) and e_t u_t⁻: what Newton's law adds to u⁺ (r) [m/s].
void add_newtons_shift(const ContactProblem& problem, double* xi);

// The size of u⁻ and u_free in the rows that the law uses [m/s].
double velocity_scale(const ContactProblem& problem);

// True if impulses raised the energy by more than rounding. Blows act in the same instant: a gain
// is one from the velocities before them and from those that they alone would leave.
bool gains_energy(const double* impulse, const double* start, const double* free, int rows,
                  double work, double work_size);

}  // namespace impulsekit
