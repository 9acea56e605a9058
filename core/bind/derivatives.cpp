// Derivatives of one impact, as Python calls them.
#include <nanobind/stl/pair.h>

#include <memory>

#include "bind/fields.hpp"
#include "bind/given_scene.hpp"
#include "bind/lanes.hpp"
#include "derivatives/scene_derivation.hpp"
#include "spatial/joints.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

SceneDerivation* derive(const GivenScene& self, const ContactLaw& law, const SceneImpact& impact,
                        int inertia_of) {
    check_impact(self, law, impact);
    bool is_own = impact.rows.target.size() == self.scene.velocity.size();
    for (const ContactFrame<double>& point : impact.rows.points)
        is_own = is_own && point.entry < static_cast<int>(self.scene.contacts.size());
    if (!is_own) throw nb::value_error("impact: expected one of this scene");
    if (inertia_of >= 0) check_body(self.model, inertia_of);
    const LaneFunctions& functions = lanes();
    const nb::gil_scoped_release release;
    auto own = std::make_unique<SceneDerivation>(self.scene, law, impact, inertia_of);
    (own->derivation.*functions.check_rows)();
    return own.release();
}

nb::ndarray<nb::numpy, double, nb::ndim<2>> pull_back(
    const SceneDerivation& own, const nb::ndarray<const double, nb::ndim<2>, nb::c_contig>& given) {
    const Derivation& d = own.derivation;
    const int results = d.results(), slopes = d.slopes();
    const std::size_t count = given.shape(0);
    if (given.shape(1) != static_cast<std::size_t>(results))
        throw nb::value_error("weights: must have a column for each result");
    if (d.unavailable != Unavailable::none) throw nb::value_error("there are no derivatives");
    auto* found = new double[std::max<std::size_t>(count * slopes, 1)];
    nb::capsule owner(found, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    (d.*lanes().pull_back)(given.data(), static_cast<int>(count), found);
    return nb::ndarray<nb::numpy, double, nb::ndim<2>>(
        found, {count, static_cast<std::size_t>(slopes)}, owner);
}

void bind_enums(nb::module_& module) {
    bind_enum<Existence>(module, "Existence", "exists", Existence::exists, "by_differences",
                         Existence::by_differences, "mode_edge", Existence::mode_edge,
                         "rank_changes", Existence::rank_changes, "not_available",
                         Existence::not_available, "no_impact", Existence::no_impact);
    bind_enum<Unavailable>(module, "Unavailable", "none", Unavailable::none, "drawn_in",
                           Unavailable::drawn_in, "too_many_hits", Unavailable::too_many_hits,
                           "coupled", Unavailable::coupled, "no_closed_form",
                           Unavailable::no_closed_form, "no_compression",
                           Unavailable::no_compression, "no_waves", Unavailable::no_waves,
                           "functions", Unavailable::functions, "singular", Unavailable::singular);
    bind_enum<Edge>(module, "Edge", "hardly_presses", Edge::hardly_presses, "edge_of_cone",
                    Edge::edge_of_cone, "hardly_slips", Edge::hardly_slips, "out_of_proportion",
                    Edge::out_of_proportion, "at_table_point", Edge::at_table_point, "at_capture",
                    Edge::at_capture, "hardly_approaches", Edge::hardly_approaches, "just_as_fast",
                    Edge::just_as_fast, "hardly_parts", Edge::hardly_parts, "stuck_at_edge",
                    Edge::stuck_at_edge, "slip_ends_with_phase", Edge::slip_ends_with_phase,
                    "hardly_slips_first", Edge::hardly_slips_first, "differences_disagree",
                    Edge::differences_disagree);
}

}  // namespace
}  // namespace impulsekit

void bind_derivatives(nb::module_& module) {
    using namespace impulsekit;
    bind_enums(module);
    Result<ModeEdge>(module, "ModeEdge", "A contact on the edge of its mode.")
        .parts("kind", &ModeEdge::kind, "contact", &ModeEdge::contact, "other", &ModeEdge::other);
    using P = Parameters;
    Result<P>(module, "Parameters", "Where the slopes by each kind of parameter begin.")
        .parts("q", &P::q, "v", &P::v, "impulses", &P::impulses, "blow_points", &P::blow_points,
               "restitution", &P::restitution, "friction", &P::friction, "points", &P::points,
               "normals", &P::normals, "masses", &P::masses)
        .def(
            "__init__", [](P* self, const GivenScene& scene) { new (self) P(scene.scene); },
            nb::arg("scene"));
    using D = SceneDerivation;
    Result<D>(module, "Derivation", "An impact made linear in its modes.")
        .part("existence", [](const D& d) { return d.derivation.existence; })
        .part("unavailable", [](const D& d) { return d.derivation.unavailable; })
        .part("contact", [](const D& d) { return d.derivation.contact; })
        .part("edges", [](const D& d) { return d.derivation.edges; })
        .def(nb::new_(&derive), nb::arg("scene"), nb::arg("law"), nb::arg("impact"),
             nb::arg("inertia_of") = -1, nb::keep_alive<0, 1>(), nb::keep_alive<0, 2>(),
             nb::keep_alive<0, 3>())
        .def("pull_back", &pull_back, nb::arg("weights"),
             "Return (k, slopes) of weights (k, results) of v⁺, λ and contact impulses.");
    module.def("unit_parts", &units_of, nb::arg("model"),
               "Return first entry and number of each unit vector in q.");
    module.def(
        "slopes_by_entries",
        [](const Model& model, const Array& q, const Array& slopes) {
            const std::size_t nq = model.nq, nv = model.nv, B = q.size() / std::max(model.nq, 1);
            const double *at = data_of(q, B * nq, "q"), *g = data_of(slopes, B * nv, "slopes");
            std::vector<double> to(B * nq);
            for (std::size_t i = 0; i < B; ++i)
                slopes_by_entries(model, at + i * nq, g + i * nv, to.data() + i * nq);
            return array_of(to);
        },
        nb::arg("model"), nb::arg("q"), nb::arg("slopes"), nb::rv_policy::automatic,
        "Return (B nq) slopes by the entries of q, of those (B, nv) on its tangent.");
}
