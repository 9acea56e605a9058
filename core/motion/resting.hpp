// Contacts come to rest, slide, keep still and let go.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// The candidates that rest: those that part no faster than the capture speed; they stick
// where it slips no faster than `no_slip`.
bool find_resting_contacts(Motion& motion, const std::vector<RestingContact>& candidates, bool lay,
                           double no_slip);

// These of the resting points stay.
void retain_contacts(Motion& motion, std::vector<RestingContact> stays);

// At the end of a step: what rests does from here on; drift of what holds is taken out. `is_known`:
// whether the last evaluation was here; `has_moved`: since drift was taken out.
bool update_rest(Motion& motion, bool is_known = false, bool has_moved = true);

}  // namespace impulsekit
