#include "bind/lanes.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <algorithm>
#include <optional>
#include <string>
#include <vector>

namespace nb = nanobind;

namespace impulsekit {
namespace {

// Those for which this processor has a module, the widest last; "" is the core itself.
std::vector<std::string> instruction_sets() {
    std::vector<std::string> found{""};
#ifdef IMPULSEKIT_VARIANTS
    if (!__builtin_cpu_supports("avx2") || !__builtin_cpu_supports("fma")) return found;
    found.push_back("avx2");
    if (__builtin_cpu_supports("avx512f") && __builtin_cpu_supports("avx512dq") &&
        __builtin_cpu_supports("avx512vl"))
        found.push_back("avx512");
#endif
    return found;
}

// A variant's module is loaded when something first runs on lanes.
std::optional<LaneFunctions> in_use;

void use_instruction_set(const std::string& name) {
    const std::vector<std::string> all = instruction_sets();
    if (std::find(all.begin(), all.end(), name) == all.end())
        throw nb::value_error(("unknown instruction set \"" + name + "\"").c_str());
    if (name.empty()) {
        in_use = LaneFunctions{&solve_rows, &Derivation::check_rows, &Derivation::pull_back};
        return;
    }
    const nb::module_ variant = nb::module_::import_(("impulsekit._core_" + name).c_str());
    const nb::capsule functions(variant.attr("functions"));
    in_use = *static_cast<const LaneFunctions*>(functions.data("impulsekit.LaneFunctions"));
}

}  // namespace

const LaneFunctions& lanes() {
    if (!in_use) use_instruction_set(instruction_sets().back());
    return *in_use;
}

}  // namespace impulsekit

void bind_lanes(nb::module_& module) {
    using namespace impulsekit;
    module.def("instruction_sets", &instruction_sets,
               "Return those that batches are built for and this processor has, the widest last.");
    module.def("use_instruction_set", &use_instruction_set, nb::arg("name"),
               "Run batches and derivatives by the functions of one of instruction_sets().");
}
