// The answer of redundant contacts in the limit of rigidity.
#pragma once

#include "contact/cone_newton.hpp"

namespace impulsekit {

// P of A + g D in the limit g → 0, D the mobility ratios: what equally stiff springs carry. With
// ξ = ξ₀ + g η there, a row either moves in the limit, and ξ₀ obeys its cone, or it is still,
// ξ₀ = 0, and η does:
//     P = Π(z),   ξ = (P − z)/ρ where rows move,   η = P − z, ξ = 0 and N (D P − η) = 0 where
//                                                 they are still,
// N the projector onto the null space of the still rows H of A (in coordinates D^½ P), on which
// ξ₀ has no part: η = A P₁ + D P for some P₁ just if that holds. So z is a zero of
//     ξ + (z − P)/ρ,   and   ξ_H + D^½ N (D^½ P − D^-½ (P − z)),
// the normal map of Robinson (1992), for both parts of the second are at right angles.
//
// `still` (count) are the rows H, `projector` (count, count) N. On entry P is the answer of the
// compliance g, near the limit; true if the limit was found.
bool solve_rigid_limit(const ConeSystem& s, double compliance, const int* still, int count,
                       const double* projector, double* P, int& steps, Arena& arena);

}  // namespace impulsekit
