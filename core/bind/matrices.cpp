// Stacked contact problems that are given by their matrices, as Python calls them.
#include <nanobind/stl/vector.h>

#include "batch/problems.hpp"
#include "bind/fields.hpp"
#include "bind/laws.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

SharedRows rows_of(const Array& given, std::size_t count, std::size_t width, const char* name) {
    if (given.size() == width) return {given.data(), 0};
    return {data_of(given, count * width, name), width};
}

ContactProblemSolutions solve(const Array& W, const Array& before, const Array& free,
                              const Array& restitution, const Array& friction,
                              const Array& tangential, const Law& law, int threads) {
    ContactProblems p;
    if (free.ndim() != 2 || free.shape(1) % 3 != 0)
        throw nb::value_error("free: expected rows of three numbers a contact");
    p.count = free.shape(0);
    const std::size_t r = free.shape(1), n = r / 3;
    p.contacts = static_cast<int>(n);
    p.W = data_of(W, p.count * r * r, "W");
    p.before = data_of(before, p.count * r, "before");
    p.free = free.data();
    p.restitution = rows_of(restitution, p.count, n, "restitution");
    p.friction = rows_of(friction, p.count, n, "friction");
    p.tangential = rows_of(tangential, p.count, n, "tangential");
    const nb::gil_scoped_release release;
    return solve_problems(p, law, threads);
}

}  // namespace
}  // namespace impulsekit

void bind_matrices(nb::module_& module) {
    using namespace impulsekit;
    using S = ContactProblemSolutions;
    Result<S>(module, "ContactProblemSolutions", "Solutions of many contact problems.")
        .parts("impulse", &S::impulse, "after", &S::after, "residual", &S::residual, "status",
               &S::status);
    module.def("solve_problems", &solve, nb::arg("W"), nb::arg("before"), nb::arg("free"),
               nb::arg("restitution"), nb::arg("friction"), nb::arg("tangential"), nb::arg("law"),
               nb::arg("threads"), "Solve many contact problems of one size.");
}
