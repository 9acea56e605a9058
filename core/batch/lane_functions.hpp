// The functions that run on lanes, which are compiled once for each instruction set.
#pragma once

#include "batch/batch.hpp"
#include "derivatives/derivatives.hpp"

namespace impulsekit {

struct LaneFunctions {
    decltype(&impulsekit::solve_rows) solve_rows;
    decltype(&Derivation::check_rows) check_rows;
    decltype(&Derivation::pull_back) pull_back;
};

}  // namespace impulsekit
