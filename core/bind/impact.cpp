// One impact in generalized coordinates, as Python calls it.
#include <nanobind/stl/array.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include <optional>

#include "bind/fields.hpp"
#include "bind/given_scene.hpp"
#include "contact/tolerances.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// The impact of a scene at one state, whose rows say what has no direction there.
SceneImpact impact_of(const GivenScene& self, const ContactLaw& law, const Array& q, const Array& v,
                      const Array& impulses, const std::optional<GivenInputs>& inputs) {
    SceneImpact impact;
    impact.q.assign(q.data(), q.data() + q.size());
    impact.v.assign(v.data(), v.data() + v.size());
    impact.numbers.assign(impulses.data(), impulses.data() + impulses.size());
    const GivenInputs given = inputs.value_or(GivenInputs());
    given.check(self);
    check_impact(self, law, impact);
    const nb::gil_scoped_release release;
    fill_scene(self.scene, given.state(), impact);
    solve_scene(self.scene, law, nullptr, impact);
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

void bind_solutions(nb::module_& module) {
    using namespace impulsekit;
    using S = ImpactSolution;
    bind_enum<S::Failure>(module, "Failure", "none", S::Failure::none, "singular_mass",
                          S::Failure::singular_mass, "contradiction", S::Failure::contradiction,
                          "refused", S::Failure::refused);
    Result<S>(module, "ImpactSolution", "The result of an impact, in generalized coordinates.")
        .parts("dv", &S::dv, "multipliers", &S::multipliers, "unique", &S::unique,
               "nearly_dependent", &S::nearly_dependent, "contact", &S::contact, "failure",
               &S::failure, "failed", &S::failed, "apart", &S::apart, "momentum_residual",
               &S::momentum_residual, "constraint_residual", &S::constraint_residual,
               "contact_residual", &S::contact_residual, "status", &status_of);
    Result<SceneImpact>(module, "SceneImpact", "An impact, with all that it was solved from.")
        .parts("q", &SceneImpact::q, "v", &SceneImpact::v, "rows", &SceneImpact::rows, "solution",
               &SceneImpact::solution, "is_solved", &SceneImpact::is_solved)
        .def(
            "contact_impulses",
            [](const SceneImpact& s, const GivenScene& scene) {
                return array_of(contact_impulses(scene.scene, s));
            },
            nb::arg("scene"), nb::rv_policy::move, "(3 contacts) in world axes.");
}

}  // namespace

void bind_impact(nb::module_& module) {
    using namespace impulsekit;
    bind_solutions(module);
    module.attr("RESIDUAL_LIMIT") = tolerance::residual;
    module.def("judge", &judge, nb::arg("contacts"), nb::arg("residuals"),
               nb::arg("nearly_dependent"), "Return the status of an impact.");
    bind_constrained_mass(module);
    module.def("solve_scene", &impact_of, nb::arg("scene"), nb::arg("law"), nb::arg("q"),
               nb::arg("v"), nb::arg("impulses"), nb::arg("inputs") = nb::none(),
               "Return the impact of a scene at a state.");
}
