// One impact in generalized coordinates, as Python calls it.
#include "impact.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "bind/arrays.hpp"
#include "bind/laws.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

using Bytes = nb::ndarray<const char, nb::c_contig, nb::device::cpu>;

// What of an impact does not change from state to state.
struct Plan {
    std::vector<int> parent, vectors, locks;
    std::vector<char> passive;
    Law law;

    ImpactSolution solve(const Array& M, const Array& v, const std::optional<Array>& impulse,
                         const std::optional<Array>& A, const std::optional<Array>& target,
                         const std::optional<Array>& J, const nb::tuple& contacts,
                         const std::vector<nb::tuple>& models) const {
        ImpactProblem p;
        const std::size_t nv = parent.size(), m = vectors.size();
        p.nv = static_cast<int>(nv);
        p.M = data_of(M, nv * nv, "M");
        p.v = data_of(v, nv, "v");
        p.parent = parent.data();
        if (impulse) p.impulse = data_of(*impulse, nv, "impulse");
        p.law = law;
        if (m > 0) {
            if (!A || !target) throw nb::value_error("A and target are wanted");
            p.bilateral = static_cast<int>(m);
            p.A = data_of(*A, m * nv, "A");
            p.target = data_of(*target, m, "target");
            p.vectors = vectors.data();
            p.passive = passive.data();
            p.locks = locks.data();
        }
        GivenContacts given;
        if (J) {
            given = contacts_of(contacts, models);
            p.contact = given.coefficients();
            p.J = data_of(*J, p.contact.rows() * nv, "J");
        }
        ImpactSolution solution;
        solve_impact(p, solution);
        return solution;
    }
};

Plan plan_of(std::vector<int> parent, std::vector<int> vectors, std::vector<int> locks,
             std::vector<bool> passive, int restitution, int slip, int order, double exponent) {
    if (locks.size() != vectors.size() || passive.size() != vectors.size())
        throw nb::value_error("vectors, locks and passive: one of each row");
    for (std::size_t k = 0; k < parent.size(); ++k)
        if (parent[k] < -1 || parent[k] >= static_cast<int>(k))
            throw nb::value_error("parent: must come before its child");
    for (int k : locks)
        if (k < -1 || k >= static_cast<int>(parent.size()))
            throw nb::value_error("locks: there is no such degree of freedom");
    Plan plan{std::move(parent),
              std::move(vectors),
              std::move(locks),
              {},
              law_of(restitution, slip, order, exponent)};
    plan.passive.assign(passive.begin(), passive.end());
    return plan;
}

}  // namespace
}  // namespace impulsekit

void bind_impact(nb::module_& module) {
    using namespace impulsekit;
    using S = ImpactSolution;
    nb::class_<S>(module, "ImpactSolution", "What an impact did, in generalized coordinates.")
        .def_prop_ro("dv", [](const S& s) { return array_of(s.dv); })
        .def_prop_ro("multipliers", [](const S& s) { return array_of(s.multipliers); })
        .def_prop_ro("unique", [](const S& s) { return array_of(s.unique); })
        .def_ro("nearly_dependent", &S::nearly_dependent)
        .def_prop_ro("before", [](const S& s) { return array_of(s.before); })
        .def_prop_ro("impulse", [](const S& s) { return array_of(s.contact.impulse); })
        .def_prop_ro("after", [](const S& s) { return array_of(s.contact.after); })
        .def_prop_ro("start", [](const S& s) { return array_of(s.contact.start); })
        .def_prop_ro("normal_work", [](const S& s) { return array_of(s.contact.normal_work); })
        .def_prop_ro("friction_work", [](const S& s) { return array_of(s.contact.friction_work); })
        .def_prop_ro("friction", [](const S& s) { return array_of(s.contact.friction); })
        .def_prop_ro("contact_unique", [](const S& s) { return array_of(s.contact.unique); })
        .def_prop_ro("status", [](const S& s) { return static_cast<int>(s.contact.status); })
        .def_prop_ro("residual", [](const S& s) { return s.contact.residual; })
        .def_prop_ro("iterations", [](const S& s) { return s.contact.iterations; })
        .def_prop_ro("tied", [](const S& s) { return s.contact.tied; })
        .def_prop_ro("refused", [](const S& s) { return s.contact.refused; })
        .def_prop_ro("failure", [](const S& s) { return static_cast<int>(s.failure); })
        .def_ro("failed", &S::failed)
        .def_ro("apart", &S::apart)
        .def_ro("momentum_residual", &S::momentum_residual)
        .def_ro("constraint_residual", &S::constraint_residual)
        .def_ro("contact_residual", &S::contact_residual);
    nb::class_<Plan>(module, "ImpactPlan", "What of an impact does not change with the state.")
        .def(
            "__init__",
            [](Plan* self, std::vector<int> parent, std::vector<int> vectors,
               std::vector<int> locks, std::vector<bool> passive, int restitution, int slip,
               int order, double exponent) {
                new (self) Plan(plan_of(std::move(parent), std::move(vectors), std::move(locks),
                                        std::move(passive), restitution, slip, order, exponent));
            },
            nb::arg("parent"), nb::arg("vectors"), nb::arg("locks"), nb::arg("passive"),
            nb::arg("restitution"), nb::arg("slip"), nb::arg("order"), nb::arg("exponent"))
        .def("solve", &Plan::solve, nb::arg("M"), nb::arg("v"), nb::arg("impulse").none(),
             nb::arg("A").none(), nb::arg("target").none(), nb::arg("J").none(),
             nb::arg("contacts"), nb::arg("models"));
}
