// The start of a motion: what is closed, what strikes, what rests.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// The gaps that are closed at the start, and their values and rates.
std::vector<GapAt> gaps_closed_at_start(Motion& motion);

// True if there is an impact at the start without known impulses: one of these gaps closes, or
// a constraint prescribes another velocity than it has.
bool is_struck_at_start(Motion& motion, const std::vector<int>& closed);

// The motion begins with this velocity, after what strikes at the start.
void begin_motion(Motion& motion, const double* v, const std::vector<int>& contact_gaps);

}  // namespace impulsekit
