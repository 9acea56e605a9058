// One impact in generalized coordinates, as Python calls it.
#include "impact.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "bind/arrays.hpp"
#include "bind/laws.hpp"
#include "laws/bilateral.hpp"

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
    // Arrays own their copies: nothing refers to the solution.
    constexpr auto kCopy = nb::rv_policy::automatic;
    nb::class_<S>(module, "ImpactSolution", "What an impact did, in generalized coordinates.")
        .def_prop_ro(
            "dv", [](const S& s) { return array_of(s.dv); }, kCopy)
        .def_prop_ro(
            "multipliers", [](const S& s) { return array_of(s.multipliers); }, kCopy)
        .def_prop_ro(
            "unique", [](const S& s) { return array_of(s.unique); }, kCopy)
        .def_ro("nearly_dependent", &S::nearly_dependent)
        .def_prop_ro(
            "before", [](const S& s) { return array_of(s.before); }, kCopy)
        .def_prop_ro(
            "impulse", [](const S& s) { return array_of(s.contact.impulse); }, kCopy)
        .def_prop_ro(
            "after", [](const S& s) { return array_of(s.contact.after); }, kCopy)
        .def_prop_ro(
            "start", [](const S& s) { return array_of(s.contact.start); }, kCopy)
        .def_prop_ro(
            "normal_work", [](const S& s) { return array_of(s.contact.normal_work); }, kCopy)
        .def_prop_ro(
            "friction_work", [](const S& s) { return array_of(s.contact.friction_work); }, kCopy)
        .def_prop_ro(
            "friction", [](const S& s) { return array_of(s.contact.friction); }, kCopy)
        .def_prop_ro(
            "contact_unique", [](const S& s) { return array_of(s.contact.unique); }, kCopy)
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
    using Rows = BilateralRows;
    nb::class_<Rows>(module, "BilateralRows", "Half-solved bilateral rows and their rank.")
        .def("__init__",
             [](Rows* self, const Array& half, const Integers& vectors) {
                 if (half.ndim() != 2) throw nb::value_error("half: two dimensions are wanted");
                 const int m = static_cast<int>(half.shape(0)), nv = static_cast<int>(half.shape(1));
                 new (self) Rows(half.data(), m, nv, data_of(vectors, half.shape(0), "vectors"));
             },
             nb::arg("half"), nb::arg("vectors"))
        .def_prop_ro("rank", &Rows::rank)
        .def_prop_ro("nearly_dependent", &Rows::nearly_dependent)
        .def_prop_ro("order", &Rows::order)
        .def_prop_ro("unique", [](const Rows& r) { return array_of(r.unique()); }, kCopy)
        .def_prop_ro("rounding_of_span", &Rows::rounding_of_span)
        .def(
            "solve",
            [](const Rows& r, const Array& wanted) {
                std::vector<double> impulse(r.count()), lacking(r.count());
                r.solve(data_of(wanted, r.count(), "wanted"), impulse.data(), lacking.data());
                return nb::make_tuple(array_of(impulse), array_of(lacking));
            },
            nb::arg("wanted"),
            "Return the impulses of least norm, and what dependent rows lack of what is wanted.")
        .def(
            "project_off",
            [](const Rows& r, const Array& row) {
                const double* given = data_of(row, r.size(), "row");
                std::vector<double> left(given, given + r.size());
                r.project_off(left.data());
                return array_of(left);
            },
            nb::arg("row"), kCopy, "Return a half-solved row less its part in the span.");
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
