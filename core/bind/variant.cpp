// The module of one instruction set: what runs on lanes, on the types of impulsekit._core.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

void bind_solve_batch(nb::module_& module);
void bind_derive(nb::module_& module);

NB_MODULE(IMPULSEKIT_VARIANT, module) {
    module.doc() = "Batches and derivatives of impulsekit's core for one instruction set.";
    bind_solve_batch(module);
    bind_derive(module);
}
