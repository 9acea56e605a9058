// Redundant contacts share their load as equally stiff springs do in the limit of rigidity.
#pragma once

#include "contact/sticking.hpp"

namespace impulsekit {

// Redundant contacts share their load as equally stiff springs do in the limit of rigidity: from
// answers of two small compliances, which tell the rows that are still there, to the limit itself.
bool solve_redundant(const ConeSystem& s, HeldRows& held, double* P, int& steps, Arena& arena);

// P of velocities without what rounding of a motion left of them, as a start: where several answers
// are lawful the one of a symmetric impact is symmetric.
void start_without_noise(const ConeSystem& s, HeldRows& held, double* P, int& steps, Arena& arena);

}  // namespace impulsekit
