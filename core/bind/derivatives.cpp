// Derivatives of one impact, as Python calls them.
#include "derivatives/derivatives.hpp"

#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <memory>

#include "bind/given_scene.hpp"
#include "bind/lanes.hpp"
#include "impact/scene_impact.hpp"
#include "scene/blows.hpp"
#include "scene/frame_pair_states.hpp"
#include "spatial/configuration.hpp"

namespace nb = nanobind;

namespace impulsekit {

// With arrays of its own.
struct OwnDerivation {
    Tree<double> tree;
    std::vector<double> v, M, numbers, impulse;
    StateRows rows;
    std::vector<int> entries;
    std::vector<FramePairState<double>> pairs;
    PointCoefficients coefficients;
    ImpactProblem problem;
    ImpactSolution solution;
    Derivation derivation;

    OwnDerivation(const Scene& scene, const ContactLaw& law)
        : tree(*scene.model), derivation(scene, law) {}
};

namespace {

// A point that differs from the one found by less than this [m] is the same.
constexpr double kSamePoint = 1e-5;

// The points of a state in the order in which an impact has them; false where one is not there.
bool choose_points(const Scene& scene, const StateRows& all, const std::vector<int>& entries,
                   const double* places, OwnDerivation& own, std::vector<int>& chosen) {
    std::vector<char> is_taken(all.points.size(), 0);
    for (std::size_t i = 0; i < entries.size(); ++i) {
        int found = -1;
        for (std::size_t j = 0; j < all.points.size() && found < 0; ++j) {
            const StateRows::Point& point = all.points[j];
            if (point.entry != entries[i] || is_taken[j]) continue;
            double apart = 0.0;
            if (scene.contacts[point.entry].kind == Contact::shapes)
                for (int k = 0; k < 3; ++k)
                    apart = std::max(apart, std::abs(point.place[k] - places[3 * i + k]));
            if (apart < kSamePoint) found = static_cast<int>(j);
        }
        if (found < 0) return false;
        is_taken[found] = 1;
        chosen.push_back(found);
    }
    const std::size_t block = 3 * scene.model->nv;
    own.rows = all;
    own.rows.turning_of.clear();
    own.rows.J.clear();
    own.rows.points.clear();
    own.rows.contact_frame_of.clear();
    for (int j : chosen) {
        own.rows.points.push_back(all.points[j]);
        own.rows.contact_frame_of.push_back(all.contact_frame_of[j]);
        own.rows.J.insert(own.rows.J.end(), all.J.begin() + j * block,
                          all.J.begin() + (j + 1) * block);
    }
    return true;
}

// dv, λ, whether each λ is determined, P, and whether each P is.
using Found = std::tuple<Array, Array, Array, Array, Array>;

void copy_solution(const Found& found, int nv, int m, int n, ImpactSolution& s) {
    const auto& [dv, multipliers, unique, impulse, contact_unique] = found;
    const auto numbers = [](const Array& a, int size, const char* name) {
        const double* data = data_of(a, size, name);
        return std::vector<double>(data, data + size);
    };
    const auto flags = [&](const Array& a, int size, const char* name) {
        const std::vector<double> all = numbers(a, size, name);
        return std::vector<char>(all.begin(), all.end());
    };
    s.dv = numbers(dv, nv, "dv");
    s.multipliers = numbers(multipliers, m, "multipliers");
    s.unique = flags(unique, m, "unique");
    s.contact.impulse = numbers(impulse, 3 * n, "impulse");
    s.contact.unique = flags(contact_unique, n, "contact_unique");
}

// Fill rows, and choose the points of an impact among them; false where they are not there.
bool find_points(const std::vector<int>& entries, const double* points, const double* at,
                 OwnDerivation& own, Rows<double>& rows) {
    const Scene& scene = rows.scene;
    const int nv = scene.model->nv;
    StateRows all;
    std::vector<double> function_rows(scene.function_rows * nv),
        function_contacts(scene.function_contacts * (1 + 3 * nv));
    GivenState given;
    given.function_rows = function_rows.data();
    given.function_contacts = function_contacts.data();
    std::vector<char> only(scene.contacts.size(), 0);
    for (int entry : entries) only[entry] = 1;
    std::vector<int> chosen;
    // In a motion some of the contacts take part, whatever their gaps.
    for (const char* part :
         {static_cast<const char*>(nullptr), static_cast<const char*>(only.data())}) {
        given.only = part;
        rows.fill(own.tree, at, own.v.data(), &given);
        rows.extract(own.tree, 0, all);
        chosen.clear();
        if (all.points.size() >= entries.size() &&
            choose_points(scene, all, entries, points, own, chosen))
            return true;
    }
    return false;
}

// The known impulses of an impact in generalized coordinates.
void set_impulse(const Scene& scene, OwnDerivation& own) {
    if (own.numbers.empty()) return;
    own.impulse.resize(scene.model->nv);
    add_blow_wrenches(scene, own.numbers.data(), own.tree);
    own.tree.gather(own.impulse.data());
    for (std::size_t i = 0; i < scene.kicks.size(); ++i)
        own.impulse[scene.kicks[i]] += own.numbers[6 * scene.blows.size() + i];
    own.problem.impulse = own.impulse.data();
}

OwnDerivation* derive(const GivenScene& self, const ContactLaw& law, const Array& q, const Array& v,
                      const Array& impulses, const std::vector<int>& entries, const Array& places,
                      const Found& found, int inertia_of) {
    const Scene& scene = self.scene;
    const int nv = self.model.nv, n = static_cast<int>(entries.size());
    if (law.contacts.size() != scene.contacts.size())
        throw nb::value_error("law: must have coefficients for each contact");
    if (inertia_of >= 0) check_body(self.model, inertia_of);
    auto own = std::make_unique<OwnDerivation>(scene, law);
    const double *at = data_of(q, self.model.nq, "q"), *speeds = data_of(v, nv, "v"),
                 *points = data_of(places, 3 * n, "places");
    const std::size_t count = 6 * scene.blows.size() + scene.kicks.size();
    const double* p = data_of(impulses, count, "impulses");
    own->v.assign(speeds, speeds + nv);
    own->numbers.assign(p, p + count);
    copy_solution(found, nv, scene.rows(), n, own->solution);
    for (int entry : entries)
        if (entry < 0 || entry >= static_cast<int>(scene.contacts.size()))
            throw nb::value_error("entries: expected numbers of the scene's contacts");
    const nb::gil_scoped_release release;
    own->tree.place(at);
    own->tree.weigh();
    own->M.resize(nv * nv);
    own->tree.mass_matrix(own->M.data());
    Rows<double> rows(scene);
    const bool is_there = find_points(entries, points, at, *own, rows);
    own->entries = entries;
    Differentiated d;
    if (is_there)
        d.is_closed = find_frame_pair_states(rows, own->tree, 0, own->rows, own->pairs,
                                             own->derivation.contact);
    own->problem = problem_of(scene, own->rows, law.law);
    own->problem.M = own->M.data();
    own->problem.v = own->v.data();
    set_impulse(scene, *own);
    d.is_closed = d.is_closed && is_there;
    own->coefficients.set(law, own->rows, nullptr, nullptr, own->problem);
    d.tree = &own->tree;
    d.problem = &own->problem;
    d.solution = &own->solution;
    d.entries = own->entries.data();
    d.pairs = own->pairs.data();
    d.impulses = own->numbers.data();
    d.inertia_of = inertia_of;
    own->derivation.set(d);
    return own.release();
}

nb::ndarray<nb::numpy, double, nb::ndim<2>> pull_back(
    const OwnDerivation& own, const nb::ndarray<const double, nb::ndim<2>, nb::c_contig>& given) {
    const Derivation& d = own.derivation;
    const int results = d.results(), slopes = d.slopes();
    const std::size_t count = given.shape(0);
    if (given.shape(1) != static_cast<std::size_t>(results))
        throw nb::value_error("weights: must have a column for each result");
    if (d.unavailable != Unavailable::none) throw nb::value_error("there are no derivatives");
    auto* found = new double[std::max<std::size_t>(count * slopes, 1)];
    nb::capsule owner(found, [](void* p) noexcept { delete[] static_cast<double*>(p); });
    const double* weights = given.data();
    lanes().pull_back_all(d, weights, static_cast<int>(count), found);
    return nb::ndarray<nb::numpy, double, nb::ndim<2>>(
        found, {count, static_cast<std::size_t>(slopes)}, owner);
}

}  // namespace
}  // namespace impulsekit

void bind_derivatives(nb::module_& module) {
    using namespace impulsekit;
    using D = OwnDerivation;
    nb::class_<D>(module, "Derivation", "An impact made linear in its modes.")
        .def_prop_ro("existence",
                     [](const D& d) { return static_cast<int>(d.derivation.existence); })
        .def_prop_ro("unavailable",
                     [](const D& d) { return static_cast<int>(d.derivation.unavailable); })
        .def_prop_ro("contact", [](const D& d) { return d.derivation.contact; })
        .def_prop_ro(
            "determined", [](const D& d) { return array_of(d.derivation.determined); },
            nb::rv_policy::automatic)
        .def_prop_ro("edges", [](const D& d) {
            std::vector<std::tuple<int, int, int>> found;
            for (const ModeEdge& e : d.derivation.edges)
                found.emplace_back(e.kind, e.contact, e.other);
            return found;
        });
    module.def("derive", &derive, nb::arg("scene"), nb::arg("law"), nb::arg("q"), nb::arg("v"),
               nb::arg("impulses"), nb::arg("entries"), nb::arg("places"), nb::arg("found"),
               nb::arg("inertia_of"), nb::rv_policy::take_ownership, nb::keep_alive<0, 1>(),
               nb::keep_alive<0, 2>(), "Return an impact made linear in its modes.");
    module.def("pull_back", &pull_back, nb::arg("derivation"), nb::arg("weights"),
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
