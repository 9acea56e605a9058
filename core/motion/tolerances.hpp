// The tolerances of motions: when contacts let go, and distances that rounding of places makes.
#pragma once

#include "contact/tolerances.hpp"

namespace impulsekit {

// Thresholds of events: a resting point that opens faster has lifted [m/s]; one held by a pull
// that accelerates away by more than this share of what it would without forces is torn off; one
// further beside its face, or beyond its edge, has left it [m]. At the event itself rounding may
// leave a little less: from the second of each on, points are let go of there.
inline constexpr double kLifted = 0.5e-8, kLiftedAtEvent = 0.9 * kLifted;
inline constexpr double kParted = 1e-10, kPartedAtEvent = 0.5 * kParted;
inline constexpr double kLeft = 2e-6, kLeftAtEvent = 0.95 * kLeft;
// Slip without a capture speed, and turning, that have no direction [m/s, rad/s].
inline constexpr double kNoSlip = 1e-9;
// Bodies that part more slowly rest: they would hop 5e-12 m high. Where no forces hold a resting
// contact, slip below this is stopped [m/s].
inline constexpr double kCreeps = 1e-5;
// Gaps that close more slowly than this share of the capture speed are closed at the start of a
// motion: rounding of a state at rest makes as much.
inline constexpr double kSlowShare = 1e-3;
// Distances waver by so much where bodies have just parted, and a body that rests, or has parted,
// has come down elsewhere this deep [m].
inline constexpr double kWaver = 1e-10;

}  // namespace impulsekit
