// The tolerances of the laws of contact: each with meaning, unit and reason. All are relative
// unless a unit is given; rounding of a double is 2.2e-16.
#pragma once

#include "linalg/tolerances.hpp"

namespace impulsekit::tolerance {

// Residual of the natural map beside the largest velocity, and of a finished impact beside its
// terms, that an answer must come down to. Rounding of 3n sums leaves some 1e-15, redundant rows
// some 1e-13.
inline constexpr double residual = 1e-9;
// A pivot of the scaled Delassus matrix below this is that of a dependent row: 1e-6 of a length.
inline constexpr double dependent = 1e-12;
// Compliance of each contact beside its own mobility, with which redundant contacts are first
// solved on the way to the limit of rigidity.
inline constexpr double compliance = 1e-6;
// A contact whose square in the null space of the loaded rows is above this shares its load.
inline constexpr double shared = 1e-9;
// W_nn below this share of the largest mobility is the square of a rounding error.
inline constexpr double immovable = 1e-24;
// A bilateral row of unit length that stands less than this [rad] out of the span of the others
// depends on them: loops closed by hand are off by about as much.
inline constexpr double dependent_row = 1e-7;
// Dependent rows may disagree by this, relative to the velocities they speak of: loops closed by
// hand disagree by their digits.
inline constexpr double contradiction = 1e-6;
// Answers whose velocities differ by less are one; velocities farther than this from W P have lost
// digits.
inline constexpr double same = 1e-8;
// A velocity this small beside others is at an edge between two modes.
inline constexpr double edge = 1e-7;
// Rounding that the hits of a sequence, or the rounds of a law, hand on: shares below are none.
inline constexpr double handed_on = 1e-11;
// Friction this near to all that there can be, or a pull this near to what holds, is at its end.
inline constexpr double torn = 1e-8;
// Work above this share of the energies in play is a gain.
inline constexpr double gain = 1e-10;
// Tangential springs that slip keep their ways while they have less than this of their depth, where
// they would turn ever faster: what that misses of the impulse is the square.
inline constexpr double shallow = 1e-5;
// Steps of Radau along springs may have an estimate so many times the error that is allowed: it is
// of lower order than they are.
inline constexpr double implicit = 1e3;
// Coefficients below this are zero: products with them would leave the doubles.
inline constexpr double negligible = 1e-150;

}  // namespace impulsekit::tolerance
