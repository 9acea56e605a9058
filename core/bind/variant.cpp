// The module of one instruction set: what runs on lanes, for impulsekit._core to call.
#include <nanobind/nanobind.h>

#include "batch/lane_functions.hpp"

NB_MODULE(IMPULSEKIT_VARIANT, module) {
    using namespace impulsekit;
    static const LaneFunctions functions{&solve_rows, &Derivation::check_rows,
                                         &Derivation::pull_back};
    module.doc() = "Batches and derivatives of impulsekit's core for one instruction set.";
    module.attr("functions") = nanobind::capsule(&functions, "impulsekit.LaneFunctions");
}
