// Laws of contact, as Python calls them.
#include <nanobind/nanobind.h>

namespace nb = nanobind;

void bind_laws(nb::module_& module) { (void)module; }
