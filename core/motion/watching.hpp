// Forces that are functions of time or state are looked at between the stages of a step: a short
// pulse falls between them where a quiet flight lets steps be long.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// The length with which a step is to be made again, or 0 where it will do: where a force is not
// what the polynomial through eight of its values says (Berrut & Trefethen 2004).
double shorter_step(Motion& motion, const Step& step);

}  // namespace impulsekit
