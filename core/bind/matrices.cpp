// Impacts of systems that are given by their matrices, as Python calls them.
#include <nanobind/stl/vector.h>

#include <numeric>

#include "batch/problems.hpp"
#include "bind/fields.hpp"
#include "bind/laws.hpp"
#include "impact/impact.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// M Δv = Aᵀλ + JᵀP with A v⁺ = target and P by the law.
ImpactSolution solve_matrices(const Array& M, const Integers& parent, const Array& v,
                              const Array& A, const Array& target, const Array& J,
                              const GivenContacts& contacts, const Law& law) {
    ImpactProblem p;
    const std::size_t nv = v.size(), bilateral = target.size();
    p.nv = static_cast<int>(nv);
    p.M = data_of(M, nv * nv, "M");
    p.parent = data_of(parent, nv, "parent");
    for (std::size_t i = 0; i < nv; ++i)
        if (p.parent[i] < -1 || p.parent[i] >= static_cast<int>(i))
            throw nb::value_error("parent: each must be -1 or smaller than its own number");
    p.v = v.data();
    p.bilateral = static_cast<int>(bilateral);
    p.A = data_of(A, bilateral * nv, "A");
    p.target = target.data();
    std::vector<int> vectors(bilateral);
    std::iota(vectors.begin(), vectors.end(), 0);
    const std::vector<char> passive(bilateral, 1);
    p.vectors = vectors.data();
    p.passive = passive.data();
    p.contact = contacts.coefficients();
    p.J = data_of(J, p.contact.rows() * nv, "J");
    p.law = law;
    ImpactSolution solution;
    const nb::gil_scoped_release release;
    solve_impact(p, solution);
    return solution;
}

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
    module.def("solve_matrices", &solve_matrices, nb::arg("M"), nb::arg("parent"), nb::arg("v"),
               nb::arg("A"), nb::arg("target"), nb::arg("J"), nb::arg("contacts"), nb::arg("law"),
               "Return the impact of a system given by its matrices.");
    using S = ContactProblemSolutions;
    Result<S>(module, "ContactProblemSolutions", "Solutions of many contact problems.")
        .parts("impulse", &S::impulse, "after", &S::after, "residual", &S::residual, "status",
               &S::status);
    module.def("solve_problems", &solve, nb::arg("W"), nb::arg("before"), nb::arg("free"),
               nb::arg("restitution"), nb::arg("friction"), nb::arg("tangential"), nb::arg("law"),
               nb::arg("threads"), "Solve many contact problems of one size.");
}
