// The module impulsekit._core: only files of this folder know Python.
#include <nanobind/nanobind.h>

#include "bind/arrays.hpp"
#include "linalg/poll.hpp"

namespace nb = nanobind;

void bind_laws(nb::module_& module);
void bind_impact(nb::module_& module);
void bind_known_impulses(nb::module_& module);
void bind_tree(nb::module_& module);
void bind_scene(nb::module_& module);
void bind_loads(nb::module_& module);
void bind_batch(nb::module_& module);
void bind_lanes(nb::module_& module);
void bind_matrices(nb::module_& module);
void bind_closing_gaps(nb::module_& module);
void bind_derivatives(nb::module_& module);
void bind_geometry(nb::module_& module);
void bind_motion(nb::module_& module);

NB_MODULE(_core, module) {
    // Scenes with functions of Python's may live until the interpreter ends.
    nb::set_leak_warnings(false);
    impulsekit::set_signal_check(impulsekit::raise_signals);
    module.doc() = "The compiled core of impulsekit.";
    bind_laws(module);
    bind_impact(module);
    bind_tree(module);
    bind_scene(module);
    bind_known_impulses(module);
    bind_loads(module);
    bind_batch(module);
    bind_lanes(module);
    bind_matrices(module);
    bind_closing_gaps(module);
    bind_derivatives(module);
    bind_geometry(module);
    bind_motion(module);
}
