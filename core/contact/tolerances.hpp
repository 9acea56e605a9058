// The tolerances of the laws of contact: each with meaning, unit and reason. All are relative
// unless a unit is given; rounding of a double is 2.2e-16.
#pragma once

namespace impulsekit::tolerance {

// Residual of the natural map beside the largest velocity, and of a finished impact beside its
// terms, that an answer must come down to. Rounding of 3n sums leaves some 1e-15, redundant rows
// some 1e-13.
inline constexpr double residual = 1e-9;
// Newton's iteration ends here: the residual is rounding.
inline constexpr double rounding = 1e-15;
// A pivot of the scaled Delassus matrix below this is that of a dependent row: 1e-6 of a length.
inline constexpr double dependent = 1e-12;
// Compliance of each contact beside its own mobility, with which redundant contacts are first
// solved; which of them press and slip is the same as in the limit of rigidity.
inline constexpr double compliance = 1e-6;
// A contact whose square in the null space of the loaded rows is above this shares its load.
inline constexpr double shared = 1e-9;
// W_nn below this share of the largest mobility is the square of a rounding error.
inline constexpr double immovable = 1e-24;
// Velocities below this share of all velocities are zero: rounding of sums over contacts.
inline constexpr double at_rest = 1e-12;
// A bilateral row of unit length that stands less than this [rad] out of the span of the others
// depends on them: loops closed by hand are off by about as much; of rounding it is the second.
inline constexpr double dependent_row = 1e-7;
inline constexpr double rounding_of_row = 1e-14;
// The part of a contact row outside the span of bilateral rows is rounding below this share of it.
inline constexpr double in_span = 1e-13;
// Dependent rows may disagree by this, relative to the velocities they speak of: loops closed by
// hand disagree by their digits.
inline constexpr double contradiction = 1e-6;
// J Δv beside W P, and A Δv beside what is asked: above this they are brought nearer by one step.
inline constexpr double refined = 1e-14;
// Work above this share of the energies in play is a gain.
inline constexpr double gain = 1e-10;
// Coefficients below this are zero: products with them would leave the doubles.
inline constexpr double negligible = 1e-150;

}  // namespace impulsekit::tolerance
