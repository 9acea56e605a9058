// One contact with springs along its normal and its tangents.
#pragma once

#include "contact/path.hpp"

namespace impulsekit {

// The impact of one contact that gives way along its normal and along its tangents (Maw, Barber &
// Fawcett 1976; Stronge 2000, ch. 5). With δ and ζ the springs' deflections,
//     F_n = k δ, δ' = −u_n while it is compressed and −u_n/e² while it is restored,
//     F_t = −κ k ζ, |F_t| <= µ F_n, and u_t − ζ' is the slip, opposite to F_t where |F_t| = µ F_n.
// κ is the `ratio` of stiffnesses; k itself does not matter. Sticking is in closed form, of three
// modes; slip, whose way turns, is integrated. Several contacts, whose modes change with whatever
// any of them does, are followed as waves (lzb.hpp).
PathImpact follow_compliant(const double* W, const double* free, double e, double mu, double ratio);

}  // namespace impulsekit
