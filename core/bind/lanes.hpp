// The instruction set of batches and derivatives.
#pragma once

#include "batch/lane_functions.hpp"

namespace impulsekit {

// The functions in use: of the widest instruction set here, unless another was chosen.
const LaneFunctions& lanes();

}  // namespace impulsekit
