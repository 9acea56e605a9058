// Contacts whose impulses grow with their stored energies (Liu, Zhao & Brogliato 2008).
#pragma once

#include "contact/problem.hpp"

namespace impulsekit {

// Each contact has an indentation δ and a normal force F = k δ^n; dP = F dt. While it is compressed
// dδ/dt = −u_n, while it is restored −u_n/e², so that it regains e² of the work of its
// compressions; only ratios of stiffnesses count. Friction opposes the slip of each instant. A
// contact of infinite stiffness, or one with e = 0 whose compression has ended, is held: u_n = 0
// with the force that the equations of motion ask for, until that would pull.
ContactSolution solve_lzb(const ContactProblem& problem, double exponent);

}  // namespace impulsekit
