// One impact in generalized coordinates, as Python calls it.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/tuple.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "bind/given_scene.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// The impact of a scene at one state, whose rows say what has no direction there.
SceneImpact impact_of(const GivenScene& self, const ContactLaw& law, const Array& q, const Array& v,
                      const Array& impulses, const GivenArrays& given) {
    SceneImpact impact;
    impact.q.assign(q.data(), q.data() + q.size());
    impact.v.assign(v.data(), v.data() + v.size());
    impact.numbers.assign(impulses.data(), impulses.data() + impulses.size());
    check_given(self, given);
    check_impact(self, law, impact);
    const nb::gil_scoped_release release;
    solve_scene(self.scene, law, given.state(), impact);
    return impact;
}

}  // namespace

void check_impact(const GivenScene& self, const ContactLaw& law, const SceneImpact& impact) {
    const Scene& scene = self.scene;
    const auto check = [](std::size_t size, std::size_t expected, const char* name) {
        if (size != expected)
            throw nb::value_error((std::string(name) + ": expected " + std::to_string(expected) +
                                   " numbers, got " + std::to_string(size))
                                      .c_str());
    };
    check(impact.q.size(), self.model.nq, "q");
    check(impact.v.size(), self.model.nv, "v");
    check(impact.numbers.size(), 6 * scene.blows.size() + scene.kicks.size(), "impulses");
    check(law.contacts.size(), scene.contacts.size(), "law: contacts");
}

}  // namespace impulsekit

void bind_constrained_mass(nb::module_& module);

namespace {

void bind_impact_solution(nb::module_& module) {
    using namespace impulsekit;
    using S = ImpactSolution;
    // Arrays own their copies: nothing refers to the solution.
    constexpr auto kCopy = nb::rv_policy::automatic;
    nb::class_<S>(module, "ImpactSolution", "The result of an impact, in generalized coordinates.")
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
}

}  // namespace

void bind_impact(nb::module_& module) {
    using namespace impulsekit;
    constexpr auto kCopy = nb::rv_policy::automatic;
    bind_impact_solution(module);
    bind_constrained_mass(module);
    nb::class_<SceneImpact>(module, "SceneImpact",
                            "An impact of a scene, with the rows of its state.")
        .def_ro("rows", &SceneImpact::rows)
        .def_ro("solution", &SceneImpact::solution)
        .def_prop_ro(
            "dv", [](const SceneImpact& s) { return array_of(s.solution.dv); }, kCopy)
        .def_prop_ro("failure",
                     [](const SceneImpact& s) { return static_cast<int>(s.solution.failure); })
        .def_prop_ro("has_directions", &SceneImpact::has_directions,
                     "False if nothing was solved: a line or an ellipse has no direction here.")
        .def_prop_ro(
            "code", [](const SceneImpact& s) { return code_of(s.solution); }, "Of its Status.")
        .def(
            "contact_impulses",
            [](const SceneImpact& s, const GivenScene& scene) {
                return array_of(contact_impulses(scene.scene, s));
            },
            nb::arg("scene"), kCopy, "(3 contacts) in world axes.");
    module.def(
        "solve_scene",
        [](const GivenScene& scene, const ContactLaw& law, const Array& q, const Array& v,
           const Array& impulses, const std::optional<Array>& function_rows,
           const std::optional<Array>& function_contacts,
           const std::optional<std::vector<bool>>& only,
           std::optional<std::vector<std::pair<int, Feature>>> features) {
            GivenArrays given = given_of(function_rows, function_contacts, only);
            given.features = std::move(features);
            return impact_of(scene, law, q, v, impulses, given);
        },
        nb::arg("scene"), nb::arg("law"), nb::arg("q"), nb::arg("v"), nb::arg("impulses"),
        nb::arg("function_rows") = nb::none(), nb::arg("function_contacts") = nb::none(),
        nb::arg("only") = nb::none(), nb::arg("features") = nb::none(),
        "Return the impact of a scene at a state.");
}
