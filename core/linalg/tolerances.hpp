// Tolerances of rounding that all rooms share: relative, unless a unit is given. Rounding of a
// double is 2.2e-16.
#pragma once

namespace impulsekit::tolerance {

// A few operations on one number: what is closer is the same.
inline constexpr double last_bits = 4e-16;
// Sums of a few terms.
inline constexpr double rounding = 1e-15;
// Sums over rows, bodies and places.
inline constexpr double sums = 1e-14;
// Numbers that have been solved for.
inline constexpr double solved = 1e-13;
// A velocity, or another part, that is nothing beside the whole.
inline constexpr double at_rest = 1e-12;
// Points nearer than this have no direction between them [m].
inline constexpr double no_length = 1e-12;
// Two of a kind, such as axes, points or states of hits: what differs by less is alike.
inline constexpr double alike = 1e-9;
// Edges or axes at a smaller angle are parallel (sine); pivots below this share are rounding.
inline constexpr double parallel = 1e-10;
// No divisor is smaller.
inline constexpr double tiny = 1e-300;

}  // namespace impulsekit::tolerance
