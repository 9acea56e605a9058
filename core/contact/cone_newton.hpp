// Newton's method on the natural map of the cones' problem, and what leads to its start.
#pragma once

#include "contact/cone_system.hpp"

namespace impulsekit {

// True where F of a P has come down to rounding, by the square of its norm.
template <typename S>
auto is_rounding(const S& norm, const S* P, int rows) {
    const S size = larger(number<S>(1.0), largest(P, rows));
    return norm <= tolerance::rounding * tolerance::rounding * size * size;
}

// Newton's method on the natural map of ξ = A P + b, P its start and the best that it met; whether
// F came down to rounding or near it.
bool newton(const ConeSystem& s, const double* A, double* P, int& steps, Arena& arena);

// ρ of each group (groups) comes nearer to what it carries over its slip: their geometric mean.
// The zeros of the natural map are the same for any ρ > 0, but where P hides ξ in P − ρ ξ, a step
// of Newton's method hardly turns the slip.
void balance_groups(const ConeSystem& s, const double* P, const double* xi);

// A of a compliance of each contact beside its own mobility.
void add_to_diagonal(const ConeSystem& s, double compliance, double* A);

// Newton's method, and where it stalls again from what proximal steps or sweeps come to: a
// compliance that falls from 1 leads along a path of well-posed problems to the one at hand.
bool solve_from(const ConeSystem& s, const double* A, double* P, int& steps, Arena& arena);

}  // namespace impulsekit
