// Change points: linkages that pass a configuration at which their constraints lose rank.
//
// A parallelogram is flat twice a turn. Its rows depend on each other there, and next to it
// rounding divided by their smallest singular value is larger than any tolerance: steps shrink, and
// end at rows that cannot hold together. Nothing happens to the motion itself, whose velocity goes
// on along the branch on which it came. So the polynomial through states well before is followed to
// the other side, and taken if it obeys constraints and accelerations there. At a dead centre,
// where a driven linkage cannot go on, it does not.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// Go past a change point of what is held; false where none is near.
bool pass_change_point(Motion& motion, double until);

}  // namespace impulsekit
