// Derivatives of one impact, as Python calls them.
#include <nanobind/stl/tuple.h>

#include <memory>

#include "bind/given_scene.hpp"
#include "bind/lanes.hpp"
#include "derivatives/scene_derivation.hpp"
#include "spatial/configuration.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

SceneDerivation* derive(const GivenScene& self, const ContactLaw& law, const SceneImpact& impact,
                        int inertia_of) {
    check_impact(self, law, impact);
    bool is_own = impact.rows.target.size() == self.scene.velocity.size();
    for (const StateRows::Point& point : impact.rows.points)
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

}  // namespace
}  // namespace impulsekit

void bind_derivatives(nb::module_& module) {
    using namespace impulsekit;
    using D = SceneDerivation;
    nb::class_<D>(module, "Derivation", "An impact made linear in its modes.")
        .def(nb::new_(&derive), nb::arg("scene"), nb::arg("law"), nb::arg("impact"),
             nb::arg("inertia_of") = -1, nb::keep_alive<0, 1>(), nb::keep_alive<0, 2>(),
             nb::keep_alive<0, 3>())
        .def_prop_ro("existence",
                     [](const D& d) { return static_cast<int>(d.derivation.existence); })
        .def_prop_ro("unavailable",
                     [](const D& d) { return static_cast<int>(d.derivation.unavailable); })
        .def_prop_ro("contact", [](const D& d) { return d.derivation.contact; })
        .def_prop_ro("edges",
                     [](const D& d) {
                         std::vector<std::tuple<int, int, int>> found;
                         for (const ModeEdge& e : d.derivation.edges)
                             found.emplace_back(e.kind, e.contact, e.other);
                         return found;
                     })
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
    module.def(
        "parameter_places",
        [](const GivenScene& self) {
            const Parameters p(self.scene);
            return std::vector<int>{p.q,        p.v,      p.impulses, p.blow_points, p.restitution,
                                    p.friction, p.points, p.normals,  p.masses,      p.count};
        },
        nb::arg("scene"), "Where the slopes by each kind of parameter begin.");
}
