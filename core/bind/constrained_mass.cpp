// The mass matrix under bilateral rows, as Python calls it.
#include "impact/constrained_mass.hpp"

#include <nanobind/stl/optional.h>

#include <memory>
#include <optional>

#include "bind/arrays.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// With arrays of its own.
struct OwnConstrainedMass {
    std::vector<double> A, wider;
    std::vector<int> vectors;
    int nv, count;
    std::unique_ptr<ConstrainedMass> held;
};

OwnConstrainedMass* made(const Array& M, const std::vector<int>& parent, const Array& A,
                         const std::vector<int>& vectors, const std::optional<Array>& wider) {
    auto own = std::make_unique<OwnConstrainedMass>();
    own->nv = static_cast<int>(parent.size());
    own->count = static_cast<int>(vectors.size());
    const std::size_t nv = parent.size(), m = vectors.size();
    for (std::size_t k = 0; k < nv; ++k)
        if (parent[k] < -1 || parent[k] >= static_cast<int>(k))
            throw nb::value_error("parent: must come before its child");
    const double* rows = data_of(A, m * nv, "A");
    own->A.assign(rows, rows + m * nv);
    own->vectors = vectors;
    if (wider) {
        const double* given = data_of(*wider, m, "wider");
        own->wider.assign(given, given + m);
    }
    own->held = std::make_unique<ConstrainedMass>(
        data_of(M, nv * nv, "M"), parent.data(), own->nv,
        ConstraintRows{own->count, own->A.data(), own->vectors.data(),
                       wider ? own->wider.data() : nullptr});
    return own.release();
}

// Copy the vectors (nv) of an array.
std::vector<double> columns_of(const OwnConstrainedMass& own, const Array& given) {
    if (own.held->weak() >= 0) throw nb::value_error("M is singular");
    if (own.nv == 0 ? given.size() != 0 : given.size() % own.nv != 0)
        throw nb::value_error("vectors: must have as many entries as M has degrees of freedom");
    return std::vector<double>(given.data(), given.data() + given.size());
}

template <typename Use>
auto each(const OwnConstrainedMass& own, const Array& given, Use use) {
    std::vector<double> x = columns_of(own, given);
    for (std::size_t at = 0; at < x.size(); at += own.nv) use(x.data() + at);
    return array_of(x);
}

nb::tuple respond(const OwnConstrainedMass& own, const Array& points) {
    const std::vector<double> rows = columns_of(own, points);
    std::vector<double> velocity_changes, unit_multipliers, W;
    own.held->respond(rows.data(), static_cast<int>(rows.size()) / std::max(own.nv, 1),
                      velocity_changes, unit_multipliers, W);
    return nb::make_tuple(array_of(velocity_changes), array_of(unit_multipliers), array_of(W));
}

constexpr auto kCopy = nb::rv_policy::automatic;

void bind_bilateral_rows(nb::module_& module) {
    using Rows = BilateralRows;
    nb::class_<Rows>(module, "BilateralRows", "Half-solved bilateral rows and their rank.")
        .def(
            "__init__",
            [](Rows* self, const Array& half, const Integers& vectors) {
                if (half.ndim() != 2) throw nb::value_error("half: must have two dimensions");
                const int m = static_cast<int>(half.shape(0)), nv = static_cast<int>(half.shape(1));
                new (self) Rows(half.data(), m, nv, data_of(vectors, half.shape(0), "vectors"));
            },
            nb::arg("half"), nb::arg("vectors"))
        .def_prop_ro("rank", &Rows::rank)
        .def_prop_ro("nearly_dependent", &Rows::nearly_dependent)
        .def_prop_ro("order", &Rows::order)
        .def_prop_ro(
            "unique", [](const Rows& r) { return array_of(r.unique()); }, kCopy)
        .def_prop_ro("rounding_of_span", &Rows::rounding_of_span)
        .def(
            "solve",
            [](const Rows& r, const Array& target) {
                std::vector<double> impulse(r.count()), shortfall(r.count());
                r.solve(data_of(target, r.count(), "target"), impulse.data(), shortfall.data());
                return nb::make_tuple(array_of(impulse), array_of(shortfall));
            },
            nb::arg("target"),
            "Return the impulses of least norm, and what dependent rows miss of the target.")
        .def(
            "project_out",
            [](const Rows& r, const Array& row) {
                const double* given = data_of(row, r.size(), "row");
                std::vector<double> left(given, given + r.size());
                r.project_out(left.data());
                return array_of(left);
            },
            nb::arg("row"), kCopy, "Return a half-solved row less its part in the span.");
}

}  // namespace
}  // namespace impulsekit

void bind_constrained_mass(nb::module_& module) {
    using namespace impulsekit;
    bind_bilateral_rows(module);
    using H = OwnConstrainedMass;
    nb::class_<H>(module, "ConstrainedMass",
                  "M under bilateral rows, factored; vectors row by row.")
        .def(nb::new_(&made), nb::arg("M"), nb::arg("parent"), nb::arg("A"), nb::arg("vectors"),
             nb::arg("wider").none())
        .def_prop_ro("weak", [](const H& h) { return h.held->weak(); })
        .def_prop_ro("is_filled", [](const H& h) { return h.held->is_filled(); })
        .def(
            "solve",
            [](const H& h, const Array& x) {
                return each(h, x, [&](double* own) { h.held->mass().solve(own); });
            },
            nb::arg("x"), kCopy, "Return M⁻¹ x of vectors (k, nv).")
        .def(
            "half",
            [](const H& h, const Array& x) {
                return each(h, x, [&](double* own) { h.held->mass().half(own); });
            },
            nb::arg("x"), kCopy, "Return half-solved vectors (k, nv): C with A M⁻¹ Aᵀ = Cᵀ C.")
        .def(
            "project_out",
            [](const H& h, const Array& x) {
                return each(h, x, [&](double* own) {
                    h.held->mass().half(own);
                    if (h.count > 0) h.held->rows()->project_out(own);
                });
            },
            nb::arg("x"), kCopy, "Return half-solved vectors (k, nv) less what the rows hold.")
        .def(
            "fill",
            [](const H& h, const Array& target) {
                std::vector<double> impulse(h.nv);
                h.held->fill(data_of(target, h.count, "target"), impulse.data());
                return array_of(impulse);
            },
            nb::arg("target"), kCopy, "Return (nv) what goes with A Δv = target where M is filled.")
        .def("respond", &respond, nb::arg("points"),
             "Return Δv and λ of unit impulses on points' rows (k, nv), and W (k, k).");
}
