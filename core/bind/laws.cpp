// Laws of contact, as Python calls them.
#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <optional>

#include "bind/arrays.hpp"
#include "laws/problem.hpp"
#include "laws/sequence.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// Friction of one contact: (kind, first, second, axis, axis, function of the slip speed or None).
Friction friction_of(const nb::tuple& given) {
    Friction f;
    f.kind = static_cast<Friction::Kind>(nb::cast<int>(given[0]));
    f.first = nb::cast<double>(given[1]);
    f.second = nb::cast<double>(given[2]);
    f.axis[0] = nb::cast<double>(given[3]);
    f.axis[1] = nb::cast<double>(given[4]);
    nb::object function = given[5];
    if (!function.is_none())
        f.at_speed = [function](double speed) { return nb::cast<double>(function(speed)); };
    return f;
}

// The arrays of a problem, kept alive for the call.
struct Given {
    Array W, before, free, restitution, friction, tangential;
    std::optional<Array> stiffness, adhesion;
    std::optional<Integers> turning_of;
    std::optional<Array> rolling, torsion;
    std::vector<Friction> models;

    ContactProblem problem() const {
        ContactProblem p;
        p.contacts = static_cast<int>(restitution.size());
        p.turning = turning_of ? static_cast<int>(turning_of->size()) : 0;
        const std::size_t n = restitution.size(), k = p.turning, rows = p.rows();
        p.W = data_of(W, rows * rows, "delassus");
        p.before = data_of(before, rows, "velocity_before");
        p.free = data_of(free, rows, "velocity_free");
        p.restitution = restitution.data();
        p.friction = data_of(friction, n, "friction");
        p.tangential = data_of(tangential, n, "tangential_restitution");
        if (stiffness) p.stiffness = data_of(*stiffness, n, "stiffness");
        if (adhesion) p.adhesion = data_of(*adhesion, n, "adhesion");
        if (k > 0) {
            if (!rolling || !torsion) throw nb::value_error("turning: rolling and torsion wanted");
            p.turning_of = turning_of->data();
            p.rolling = data_of(*rolling, k, "rolling");
            p.torsion = data_of(*torsion, k, "torsion");
            for (std::size_t i = 0; i < k; ++i)
                if (p.turning_of[i] < 0 || p.turning_of[i] >= p.contacts)
                    throw nb::value_error("turning: there is no such contact");
        }
        if (!models.empty()) {
            if (models.size() != n) throw nb::value_error("models: one of each contact");
            p.models = models.data();
        }
        return p;
    }
};

Given given_of(const nb::tuple& arrays, const std::vector<nb::tuple>& models) {
    Given given{nb::cast<Array>(arrays[0]),
                nb::cast<Array>(arrays[1]),
                nb::cast<Array>(arrays[2]),
                nb::cast<Array>(arrays[3]),
                nb::cast<Array>(arrays[4]),
                nb::cast<Array>(arrays[5]),
                nb::cast<std::optional<Array>>(arrays[6]),
                nb::cast<std::optional<Array>>(arrays[7]),
                nb::cast<std::optional<Integers>>(arrays[8]),
                nb::cast<std::optional<Array>>(arrays[9]),
                nb::cast<std::optional<Array>>(arrays[10]),
                {}};
    for (const nb::tuple& model : models) given.models.push_back(friction_of(model));
    return given;
}

Law law_of(int restitution, int slip, int order, double exponent) {
    if (restitution < 0 || restitution > 3 || slip < 0 || slip > 1 || order < 0 || order > 1)
        throw nb::value_error("law: there is no such law");
    return {static_cast<Restitution>(restitution), static_cast<Slip>(slip),
            static_cast<Order>(order), exponent};
}

}  // namespace
}  // namespace impulsekit

void bind_laws(nb::module_& module) {
    using namespace impulsekit;
    module.def(
        "solve_contacts",
        [](const nb::tuple& arrays, const std::vector<nb::tuple>& models, int restitution,
           int slip, int order, double exponent) {
            Given given = given_of(arrays, models);
            ContactProblem problem = given.problem();
            ContactSolution s =
                solve_contacts(problem, law_of(restitution, slip, order, exponent));
            return nb::make_tuple(array_of(s.impulse), array_of(s.after),
                                  static_cast<int>(s.status), s.residual, array_of(s.unique),
                                  array_of(s.start), array_of(s.normal_work),
                                  array_of(s.friction_work), s.iterations, s.tied,
                                  array_of(s.friction), s.refused);
        },
        nb::arg("arrays"), nb::arg("models"), nb::arg("restitution"), nb::arg("slip"),
        nb::arg("order"), nb::arg("exponent"),
        "Return the impulses of contacts: impulse, velocity after, code of the status, residual, "
        "unique, velocity from which works count, works of normals and friction, iterations, "
        "tied, friction, and what the law refuses.");
    module.def(
        "sequence_hits",
        [](const nb::tuple& arrays, int restitution, int slip) {
            Given given = given_of(arrays, {});
            std::vector<Hit> hits;
            solve_sequence(given.problem(), law_of(restitution, slip, 1, 1.5), &hits);
            nb::list found;
            for (const Hit& hit : hits)
                found.append(nb::make_tuple(hit.contact, hit.impulse[0], hit.impulse[1],
                                            hit.impulse[2]));
            return found;
        },
        nb::arg("arrays"), nb::arg("restitution"), nb::arg("slip"),
        "Return the hits of a sequence in order: contact and impulse.");
}
