// Impacts on the way of a motion, and those without collision where friction jams.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// What rests, and the points at which these gaps touch; the tree with places.
std::vector<RestingContact> points_of_gaps(Motion& motion, const std::vector<int>& gaps);

// An impact of what closes, with all that rests taking part.
bool close_gaps(Motion& motion, const std::vector<int>& closing);

// If W_nn <= µ W_nt·s no force keeps a sliding contact from being pressed in (Painlevé 1895). It
// stops by an impact without collision (Lecornu 1905; Génot & Brogliato 1999): the limit of impacts
// whose approach goes to zero, without restitution.
bool impact_without_collision(Motion& motion);

}  // namespace impulsekit
