// The path of a motion: its steps, and what rested in each.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// The last piece of the path that begins no later than a time.
std::size_t piece_at(const Motion& motion, double at);

// y (nq + nv) at a time of the path, as its steps have it: q off unit length by rounding.
void sample(const Motion& motion, double at, double* found);

// q and v (normalized) at a time of the path.
void state_at(const Motion& motion, double at, double* q, double* v);

// The resting state then.
const RestingState& resting_state_at(const Motion& motion, double at);

// Forget steps of the path that end before a time.
void forget_before(Motion& motion, double before);

// Add a step to the path, with what rests now.
void keep_step(Motion& motion, const Step& step);

}  // namespace impulsekit
