// Contacts one after the other: the fastest approach first, until none approaches.
#pragma once

#include "contact/problem.hpp"

namespace impulsekit {

// One hit of a sequence.
struct Hit {
    int contact;
    double impulse[3];                  // [N s]
    double normal_work, friction_work;  // [J]
};

// Known impulses act first; each hit starts from the velocities that the last one left. The fastest
// has the largest |u_n|/√W_nn, one unit [√J] for contacts and joint stops. Hits that shrink by a
// steady ratio without end are summed as a geometric series. `hits`: filled if given.
ContactSolution solve_sequence(const ContactProblem& problem, const Law& law,
                               std::vector<Hit>* hits = nullptr);

}  // namespace impulsekit
