// Derivatives of rows and laws, as Python calls them.
#include "derivatives.hpp"

#include <nanobind/stl/optional.h>

#include "bind/given_scene.hpp"
#include "laws/path.hpp"

namespace nb = nanobind;

void bind_derive_rows(nb::module_& module);

void bind_derive_rows(nb::module_& module) {
    using namespace impulsekit;
    module.def(
        "derive_rows",
        [](const GivenScene& self, const Array& q, const std::optional<std::vector<bool>>& only) {
            const GivenArrays given = given_of({}, {}, only);
            check_given(self, given);
            return derive_rows(self.scene, data_of(q, self.model.nq, "q"), given.state());
        },
        nb::arg("scene"), nb::arg("q"), nb::arg("only").none(),
        "Return M and the rows of a scene without functions, these with their derivatives.");
    module.def(
        "momentum_by_q",
        [](const Model& model, const Array& q, const Array& x) {
            return array_of(
                momentum_by_q(model, data_of(q, model.nq, "q"), data_of(x, model.nv, "x")));
        },
        nb::arg("model"), nb::arg("q"), nb::arg("x"), nb::rv_policy::automatic,
        "Return (nv, nv) the derivatives of M x by q, row by row along each direction.");
}

void bind_derivatives(nb::module_& module) {
    using namespace impulsekit;
    using D = DerivedRows;
    constexpr auto kCopy = nb::rv_policy::automatic;
    nb::class_<D>(module, "DerivedRows", "Rows and mass matrix with their derivatives by q.")
        .def_prop_ro(
            "M", [](const D& d) { return array_of(d.M); }, kCopy)
        .def_prop_ro(
            "G", [](const D& d) { return array_of(d.G); }, kCopy)
        .def_prop_ro(
            "dG", [](const D& d) { return array_of(d.dG); }, kCopy)
        .def_prop_ro(
            "axes", [](const D& d) { return array_of(d.axes); }, kCopy)
        .def_prop_ro(
            "daxes", [](const D& d) { return array_of(d.daxes); }, kCopy)
        .def_ro("entries", &D::entries);
    bind_derive_rows(module);
    module.def(
        "inertia_regressor",
        [](const Model& model, const Array& q, const Array& x, int body) {
            check_body(model, body);
            return array_of(inertia_regressor(model, data_of(q, model.nq, "q"),
                                              data_of(x, model.nv, "x"), body));
        },
        nb::arg("model"), nb::arg("q"), nb::arg("x"), nb::arg("body"), kCopy,
        "Return (nv, 10) the derivatives of M x by the inertia of a body.");
    module.def(
        "derive_path",
        [](const Array& W, double before, const Array& free, double e, double mu, int restitution) {
            const PathDerivative found =
                derive_path(data_of(W, 9, "W"), before, data_of(free, 3, "free"), e, mu,
                            static_cast<Restitution>(restitution));
            return nb::make_tuple(
                array_of(std::vector<double>(found.impulse, found.impulse + 3)),
                array_of(std::vector<double>(found.by, found.by + 3 * kPathParameters)),
                found.edges, found.is_drawn_in);
        },
        nb::arg("W"), nb::arg("before"), nb::arg("free"), nb::arg("e"), nb::arg("mu"),
        nb::arg("restitution"),
        "Return the impulse of one contact along its path, its derivatives by W (t1t1, t1t2, "
        "t2t2, t1n, t2n, nn), the velocity at the start, that before, e and mu, the edges it is "
        "on, and whether friction draws the contact in.");
}
