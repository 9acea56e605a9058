// Drift of what holds and rests is taken out, of places and of velocities.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// Bring constraints, and resting points where they push (or all their normals), back to where they
// belong, by as little as can be in the metric of M; whether anything moved. The tree with places
// and twists.
bool correct_drift(Motion& motion, bool all_normals);

}  // namespace impulsekit
