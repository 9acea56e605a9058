// A motion goes on by steps, each as far as nothing happens within it, and what happens then.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// Back to a time of the path: what came later has not been.
void rewind_to(Motion& motion, double at);

// Torques (nv) from outside, from now on.
void control(Motion& motion, const double* torques);

// One step, and what happens in it, but not past a time; false where the motion has ended.
bool advance(Motion& motion, double until);

}  // namespace impulsekit
