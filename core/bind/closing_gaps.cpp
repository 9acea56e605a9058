// Contacts of MuJoCo as Python hands them over, and the impact of some of them.
#include "batch/closing_gaps.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/tuple.h>

#include <algorithm>
#include <numeric>
#include <tuple>

#include "bind/fields.hpp"
#include "impact/impact.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// Fields of a simulator's list of contacts: whatever lies between them in its memory.
template <typename T, int dimensions>
using Field = nb::ndarray<const T, nb::ndim<dimensions>, nb::device::cpu>;

struct GivenListing {
    ContactListing contacts;
    int equalities = 0;  // rows, the first of all
};

template <typename... Fields>
void check_lengths(std::size_t count, const Fields&... fields) {
    if (((fields.shape(0) != count) || ...))
        throw nb::value_error("contacts: all fields must be of one length");
}

// Add what MuJoCo lists: contacts that are not excluded and have rows.
void add_contacts(GivenListing& to, const Field<int, 2>& geom, const Field<int, 1>& exclude,
                  const Field<int, 1>& address, const Field<int, 1>& dim,
                  const Field<double, 2>& position, const Field<double, 2>& frame,
                  const Field<double, 1>& distance, const Field<double, 1>& margin, double reach) {
    const std::size_t count = geom.shape(0);
    check_lengths(count, exclude, address, dim, position, frame, distance, margin);
    if (geom.shape(1) != 2 || position.shape(1) != 3 || frame.shape(1) != 9)
        throw nb::value_error("contacts: expected two geoms, a point and three axes of each");
    for (std::size_t i = 0; i < count; ++i) {
        if (exclude(i) != 0 || address(i) < 0) continue;
        ListedContact own;
        for (int k = 0; k < 2; ++k) own.pair[k] = geom(i, k);
        for (int k = 0; k < 3; ++k) own.position[k] = position(i, k);
        for (int k = 0; k < 9; ++k) own.frame[k] = frame(i, k);
        own.gap = distance(i) - margin(i) + reach;
        own.address = address(i);
        own.dimension = dim(i);
        own.number = static_cast<int>(i);
        to.contacts.push_back(own);
    }
}

void add_limits(GivenListing& to, int first, int count, const Integers& kinds,
                const Integers& numbers, const Array& positions, const Array& margins,
                double reach) {
    const std::size_t rows = kinds.size(), end = static_cast<std::size_t>(first + count);
    if (first < 0 || end > rows || numbers.size() < end || positions.size() < end ||
        margins.size() < end)
        throw nb::value_error("limits: expected as many rows as there are");
    for (int i = first; i < first + count; ++i) {
        ListedContact own;
        own.pair[0] = -1 - kinds.data()[i];
        own.pair[1] = numbers.data()[i];
        own.gap = positions.data()[i] - margins.data()[i] + reach;
        own.address = i;
        to.contacts.push_back(own);
    }
}

// Keys of all, and the speeds of their gaps by their first rows.
void finish(GivenListing& to, const Array& rows, const Array& v) {
    const std::size_t nv = v.size();
    for (ListedContact& own : to.contacts) {
        own.key = static_cast<std::int64_t>(own.pair[1]) * (std::int64_t{1} << 32) +
                  static_cast<std::uint32_t>(own.pair[0]);
        const std::size_t end = static_cast<std::size_t>(own.address + own.dimension) * nv;
        if (own.dimension < 1 || end > rows.size())
            throw nb::value_error("contacts: rows lie beyond the matrix");
        const double* row = rows.data() + static_cast<std::size_t>(own.address) * nv;
        own.speed = std::inner_product(row, row + nv, v.data(), 0.0);
    }
}

using Keys = std::vector<std::int64_t>;
using SortedKeys = nb::ndarray<const std::int64_t, nb::c_contig, nb::device::cpu>;

const ListedContact& entry(const GivenListing& listing, int i) {
    if (i < 0 || i >= static_cast<int>(listing.contacts.size()))
        throw nb::value_error("listing: expected numbers of entries");
    return listing.contacts[static_cast<std::size_t>(i)];
}

// Entries within a reach, and those that hit whatever their gap.
std::vector<int> within(const GivenListing& listing, double reach, const std::vector<int>& hits) {
    std::vector<int> found;
    for (int i = 0; i < static_cast<int>(listing.contacts.size()); ++i)
        if (listing.contacts[static_cast<std::size_t>(i)].gap <= reach ||
            std::find(hits.begin(), hits.end(), i) != hits.end())
            found.push_back(i);
    return found;
}

// The keys of contacts among some entries.
Keys keys(const GivenListing& listing, const std::vector<int>& which) {
    Keys found;
    for (int i : which)
        if (entry(listing, i).number >= 0) found.push_back(entry(listing, i).key);
    return found;
}

// The pair of each of some entries, and how fast its gap grows.
std::vector<std::tuple<int, int, double>> pairs(const GivenListing& listing,
                                                const std::vector<int>& which) {
    std::vector<std::tuple<int, int, double>> found;
    for (int i : which) {
        const ListedContact& own = entry(listing, i);
        found.emplace_back(own.pair[0], own.pair[1], own.speed);
    }
    return found;
}

// The place and the axes of each of some entries.
std::vector<double> places(const GivenListing& listing, const std::vector<int>& which) {
    std::vector<double> found;
    for (int i : which) {
        const ListedContact& own = entry(listing, i);
        found.insert(found.end(), own.position, own.position + 3);
        found.insert(found.end(), own.frame, own.frame + 9);
    }
    return found;
}

// Friction of each contact by five numbers of MuJoCo, and what resists rolling and spin.
struct ListedFriction {
    std::vector<double> mu, rolling, torsion;
    std::vector<Friction> models;
    std::vector<int> turning;
};

ListedFriction friction_of(const GivenListing& listing, const std::vector<int>& which,
                           const Field<double, 2>& friction, const std::optional<double>& mu) {
    ListedFriction found;
    bool is_elliptic = false;
    for (std::size_t i = 0; i < which.size(); ++i) {
        const ListedContact& own = entry(listing, which[i]);
        double slides[2] = {0.0, 0.0};
        if (own.number >= static_cast<int>(friction.shape(0)) || friction.shape(1) != 5)
            throw nb::value_error("friction: expected five numbers of each contact");
        const std::size_t at = static_cast<std::size_t>(std::max(own.number, 0));
        for (int k = 0; k < 2 && own.number >= 0 && own.dimension > 1; ++k)
            slides[k] = mu ? *mu : friction(at, k);
        found.mu.push_back(std::max(slides[0], slides[1]));
        Friction model;
        model.kind = slides[0] != slides[1] ? Friction::Kind::elliptic : Friction::Kind::number;
        model.first = slides[0];
        model.second = slides[1];
        found.models.push_back(model);
        is_elliptic = is_elliptic || slides[0] != slides[1];
        if (own.number < 0 || own.dimension <= 3) continue;
        found.turning.push_back(static_cast<int>(i));
        found.torsion.push_back(friction(at, 2));
        const bool rolls = own.dimension == 6;
        found.rolling.push_back(rolls ? 0.5 * (friction(at, 3) + friction(at, 4)) : 0.0);
    }
    if (!is_elliptic) found.models.clear();
    return found;
}

// An impact, with J and the contacts that resist turning.
struct ListedImpact {
    ImpactSolution solution;
    std::vector<double> J;
    std::vector<int> turning;
};

// (3 (which + turning), nv): t₁, t₂ and the normal of each, then rolling and spin; 0 where a
// contact has no such row.
std::vector<double> jacobian_of(const GivenListing& listing, const std::vector<int>& which,
                                const std::vector<int>& turning, const double* rows,
                                std::size_t nv) {
    std::vector<double> J(3 * (which.size() + turning.size()) * nv, 0.0);
    double* to = J.data();
    const auto add = [&](const ListedContact& own, int row) {
        if (row < own.dimension) std::copy_n(rows + (own.address + row) * nv, nv, to);
        to += nv;
    };
    for (int i : which)
        for (int row : {1, 2, 0}) add(entry(listing, i), row);
    for (int point : turning)
        for (int row : {4, 5, 3}) add(entry(listing, which[static_cast<std::size_t>(point)]), row);
    return J;
}

// M Δv = Aᵀλ + JᵀP with A Δv = 0 for equalities and P by the law.
ListedImpact solve_listed(const GivenListing& listing, const std::vector<int>& which,
                          const Array& rows, const Array& M, const Integers& parent, const Array& v,
                          const std::vector<double>& restitution, const Field<double, 2>& friction,
                          const std::optional<double>& mu, const Law& law) {
    const std::size_t nv = v.size(), n = which.size(),
                      m = static_cast<std::size_t>(listing.equalities);
    if (rows.size() < m * nv) throw nb::value_error("rows: expected those of all equalities");
    ListedFriction own = friction_of(listing, which, friction, mu);
    ListedImpact found;
    found.turning = own.turning;
    found.J = jacobian_of(listing, which, own.turning, rows.data(), nv);
    std::vector<double> target(m), tangential(n, 0.0);
    for (std::size_t r = 0; r < m; ++r)
        target[r] = std::inner_product(v.data(), v.data() + nv, rows.data() + r * nv, 0.0);
    std::vector<int> vectors(m);
    std::iota(vectors.begin(), vectors.end(), 0);
    const std::vector<char> passive(m, 1);
    ImpactProblem p;
    p.nv = static_cast<int>(nv);
    p.M = data_of(M, nv * nv, "M");
    p.parent = data_of(parent, nv, "parent");
    for (std::size_t i = 0; i < nv; ++i)
        if (p.parent[i] < -1 || p.parent[i] >= static_cast<int>(i))
            throw nb::value_error("parent: each must be -1 or smaller than its own number");
    p.v = v.data();
    p.bilateral = listing.equalities;
    p.A = rows.data();
    p.target = target.data();
    p.vectors = vectors.data();
    p.passive = passive.data();
    p.J = found.J.data();
    p.law = law;
    p.contact.contacts = static_cast<int>(n);
    p.contact.turning = static_cast<int>(own.turning.size());
    if (restitution.size() != n) throw nb::value_error("restitution: expected one of each entry");
    p.contact.restitution = restitution.data();
    p.contact.friction = own.mu.data();
    p.contact.tangential = tangential.data();
    p.contact.turning_of = own.turning.data();
    p.contact.rolling = own.rolling.data();
    p.contact.torsion = own.torsion.data();
    if (!own.models.empty()) p.contact.models = own.models.data();
    const nb::gil_scoped_release release;
    solve_impact(p, found.solution);
    return found;
}

void bind_listing(nb::module_& module) {
    nb::class_<GivenListing>(module, "ContactListing", "Contacts and limits at a state of MuJoCo.")
        .def(
            "__init__",
            [](GivenListing* self, const Field<int, 2>& geom, const Field<int, 1>& exclude,
               const Field<int, 1>& address, const Field<int, 1>& dim,
               const Field<double, 2>& position, const Field<double, 2>& frame,
               const Field<double, 1>& distance, const Field<double, 1>& margin, double reach,
               int equalities) {
                auto* made = new (self) GivenListing{{}, equalities};
                add_contacts(*made, geom, exclude, address, dim, position, frame, distance, margin,
                             reach);
            },
            nb::arg("geom"), nb::arg("exclude"), nb::arg("address"), nb::arg("dim"),
            nb::arg("position"), nb::arg("frame"), nb::arg("distance"), nb::arg("margin"),
            nb::arg("reach"), nb::arg("equalities"))
        .def("add_limits", &add_limits, nb::arg("first"), nb::arg("count"), nb::arg("kinds"),
             nb::arg("numbers"), nb::arg("positions"), nb::arg("margins"), nb::arg("reach"))
        .def("finish", &finish, nb::arg("rows"), nb::arg("v"))
        .def("within", &within, nb::arg("reach"), nb::arg("hits"))
        .def_prop_ro("limits",
                     [](const GivenListing& l) {
                         return static_cast<int>(l.contacts.size()) - contacts_of(l.contacts);
                     })
        .def("keys", &keys, nb::arg("which"))
        .def("pairs", &pairs, nb::arg("which"))
        .def(
            "places",
            [](const GivenListing& l, const std::vector<int>& which) {
                return array_of(places(l, which));
            },
            nb::arg("which"), nb::rv_policy::move);
}

}  // namespace
}  // namespace impulsekit

void bind_closing_gaps(nb::module_& module) {
    using namespace impulsekit;
    bind_listing(module);
    nb::class_<ClosingGaps>(module, "ClosingGaps", "Gaps that close in the course of a step.")
        .def(
            "__init__",
            [](ClosingGaps* self, const GivenListing& listing, const Keys& known, int limits,
               const std::optional<SortedKeys>& handled, double threshold) {
                Keys own;
                if (handled) own.assign(handled->data(), handled->data() + handled->size());
                new (self) ClosingGaps(listing.contacts, known, limits, handled ? &own : nullptr,
                                       threshold);
            },
            nb::arg("listing"), nb::arg("known"), nb::arg("limits"), nb::arg("handled").none(),
            nb::arg("threshold"))
        .def_prop_ro("count", &ClosingGaps::count)
        .def_prop_ro("fastest", &ClosingGaps::fastest)
        .def_prop_ro("least", &ClosingGaps::least)
        .def(
            "follow",
            [](ClosingGaps& self, const GivenListing& listing, double t) {
                self.follow(listing.contacts, t);
            },
            nb::arg("listing"), nb::arg("t"))
        .def("hits", &ClosingGaps::hits, nb::arg("reach"), nb::arg("threshold"))
        .def("drop", &ClosingGaps::drop, nb::arg("reach"))
        .def("closing_time", &ClosingGaps::closing_time, nb::arg("low"), nb::arg("high"),
             nb::arg("half_closed"));
    Result<ListedImpact>(module, "ListedImpact", "An impact of listed contacts.")
        .parts("solution", &ListedImpact::solution, "J", &ListedImpact::J)
        .def_ro("turning", &ListedImpact::turning);
    module.def("solve_listed", &solve_listed, nb::arg("listing"), nb::arg("which"), nb::arg("rows"),
               nb::arg("M"), nb::arg("parent"), nb::arg("v"), nb::arg("restitution"),
               nb::arg("friction"), nb::arg("mu").none(), nb::arg("law"),
               "Return the impact of some entries of a listing.");
}
