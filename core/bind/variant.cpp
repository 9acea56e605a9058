// The module of one instruction set: batches alone, on the types of impulsekit._core.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

void bind_solve_batch(nb::module_& module);

NB_MODULE(IMPULSEKIT_VARIANT, module) {
    module.doc() = "The batches of impulsekit's core for one instruction set.";
    bind_solve_batch(module);
}
