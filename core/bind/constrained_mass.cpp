// The mass matrix under bilateral rows, as Python calls it.
#include "impact/constrained_mass.hpp"

#include <nanobind/stl/optional.h>

#include <memory>
#include <optional>

#include "bind/fields.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// With arrays of its own.
struct OwnConstrainedMass {
    std::vector<double> A, wider;
    std::vector<int> vectors;
    int nv = 0;
    ConstrainedMass held;
};

// Responses to unit impulses on rows of points.
struct Responses {
    std::vector<double> velocity_changes, multipliers, W;
};

OwnConstrainedMass* made(const Array& M, const std::vector<int>& parent, const Array& A,
                         const std::vector<int>& vectors, const std::optional<Array>& wider) {
    auto own = std::make_unique<OwnConstrainedMass>();
    const std::size_t nv = parent.size(), m = vectors.size();
    own->nv = static_cast<int>(nv);
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
    own->held.factor(data_of(M, nv * nv, "M"), parent.data(), own->nv,
                     {static_cast<int>(m), own->A.data(), own->vectors.data(),
                      wider ? own->wider.data() : nullptr});
    return own.release();
}

// Half-solved vectors (k, nv).
std::vector<double> half_of(const OwnConstrainedMass& own, const Array& given) {
    if (own.held.weak() >= 0) throw nb::value_error("M is singular");
    if (own.nv == 0 ? given.size() != 0 : given.size() % own.nv != 0)
        throw nb::value_error("vectors: must have as many entries as M has degrees of freedom");
    std::vector<double> x(given.data(), given.data() + given.size());
    for (std::size_t at = 0; at < x.size(); at += own.nv) own.held.mass().half(x.data() + at);
    return x;
}

Responses respond(const OwnConstrainedMass& own, const Array& points) {
    const std::vector<double> half = half_of(own, points);
    Responses found;
    own.held.respond(points.data(), static_cast<int>(half.size()) / std::max(own.nv, 1),
                     found.velocity_changes, found.multipliers, found.W);
    return found;
}

}  // namespace
}  // namespace impulsekit

void bind_constrained_mass(nb::module_& module) {
    using namespace impulsekit;
    using R = Responses;
    Result<R>(module, "Responses", "Responses to k unit impulses under bilateral rows.")
        .parts("velocity_changes", &R::velocity_changes, "multipliers", &R::multipliers, "W",
               &R::W);
    using H = OwnConstrainedMass;
    constexpr auto kCopy = nb::rv_policy::move;
    nb::class_<H>(module, "ConstrainedMass",
                  "M under bilateral rows, factored; vectors row by row.")
        .def(nb::new_(&made), nb::arg("M"), nb::arg("parent"), nb::arg("A"), nb::arg("vectors"),
             nb::arg("wider").none())
        .def_prop_ro("weak", [](const H& h) { return h.held.weak(); })
        .def(
            "half", [](const H& h, const Array& x) { return array_of(half_of(h, x)); },
            nb::arg("x"), kCopy, "Return half-solved vectors (k, nv): C with A M⁻¹ Aᵀ = Cᵀ C.")
        .def(
            "project_out",
            [](const H& h, const Array& x) {
                std::vector<double> half = half_of(h, x);
                for (std::size_t at = 0; at < half.size() && !h.vectors.empty(); at += h.nv)
                    h.held.rows().project_out(half.data() + at);
                return array_of(half);
            },
            nb::arg("x"), kCopy, "Return half-solved vectors (k, nv) less what the rows hold.")
        .def("respond", &respond, nb::arg("points"), "Respond to impulses on rows (k, nv).");
}
