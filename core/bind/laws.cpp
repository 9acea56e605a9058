// Laws of contact, as Python calls them.
#include "bind/laws.hpp"

#include <nanobind/nanobind.h>
#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <functional>
#include <memory>
#include <optional>

#include "contact/path.hpp"
#include "contact/sequence.hpp"
#include "contact/uniqueness.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

ContactProblem posed(const GivenContacts& given, const Array& W, const Array& before,
                     const Array& free) {
    ContactProblem problem = given.coefficients();
    const std::size_t rows = problem.rows();
    problem.W = data_of(W, rows * rows, "W");
    problem.before = data_of(before, rows, "before");
    problem.free = data_of(free, rows, "free");
    return problem;
}

}  // namespace

// Threads share it: what counts references of Python's stands behind a pointer of its own.
std::function<double(double)> function_of(const nb::object& function) {
    auto own = std::make_shared<nb::object>(function);
    return [own](double x) {
        const nb::gil_scoped_acquire hold;
        return nb::cast<double>((*own)(x));
    };
}

Friction friction_of(const nb::tuple& given) {
    if (given.size() != 6) throw nb::value_error("friction: expected six entries");
    Friction f;
    f.kind = static_cast<Friction::Kind>(nb::cast<int>(given[0]));
    f.first = nb::cast<double>(given[1]);
    f.second = nb::cast<double>(given[2]);
    f.axis[0] = nb::cast<double>(given[3]);
    f.axis[1] = nb::cast<double>(given[4]);
    if (!given[5].is_none()) f.at_speed = function_of(given[5]);
    return f;
}

ContactProblem GivenContacts::coefficients() const {
    ContactProblem p;
    const std::size_t n = restitution.size(), k = turning_of ? turning_of->size() : 0;
    p.contacts = static_cast<int>(n);
    p.turning = static_cast<int>(k);
    p.restitution = restitution.data();
    p.friction = data_of(friction, n, "friction");
    p.tangential = data_of(tangential, n, "tangential_restitution");
    if (stiffness) p.stiffness = data_of(*stiffness, n, "stiffness");
    if (adhesion) p.adhesion = data_of(*adhesion, n, "adhesion");
    if (k > 0) {
        if (!rolling || !torsion)
            throw nb::value_error("turning: must come with rolling and torsion");
        p.turning_of = turning_of->data();
        p.rolling = data_of(*rolling, k, "rolling");
        p.torsion = data_of(*torsion, k, "torsion");
        for (std::size_t i = 0; i < k; ++i)
            if (p.turning_of[i] < 0 || p.turning_of[i] >= p.contacts)
                throw nb::value_error("turning: expected numbers of contacts");
    }
    if (!models.empty()) {
        if (models.size() != n) throw nb::value_error("models: one of each contact");
        p.models = models.data();
    }
    return p;
}

GivenContacts contacts_of(const nb::tuple& given, const std::vector<nb::tuple>& models) {
    if (given.size() != 8) throw nb::value_error("contacts: expected eight arrays");
    GivenContacts contacts{nb::cast<Array>(given[0]),
                           nb::cast<Array>(given[1]),
                           nb::cast<Array>(given[2]),
                           nb::cast<std::optional<Array>>(given[3]),
                           nb::cast<std::optional<Array>>(given[4]),
                           nb::cast<std::optional<Integers>>(given[5]),
                           nb::cast<std::optional<Array>>(given[6]),
                           nb::cast<std::optional<Array>>(given[7]),
                           {}};
    for (const nb::tuple& model : models) contacts.models.push_back(friction_of(model));
    return contacts;
}

Law law_of(int restitution, int slip, int order, double exponent) {
    if (restitution < 0 || restitution > 3 || slip < 0 || slip > 1 || order < 0 || order > 1)
        throw nb::value_error("law: unknown restitution, slip or order");
    return {static_cast<Restitution>(restitution), static_cast<Slip>(slip),
            static_cast<Order>(order), exponent};
}

}  // namespace impulsekit

void bind_laws(nb::module_& module) {
    using namespace impulsekit;
    module.def(
        "solve_contacts",
        [](const Array& W, const Array& before, const Array& free, const nb::tuple& contacts,
           const std::vector<nb::tuple>& models, int restitution, int slip, int order,
           double exponent) {
            GivenContacts given = contacts_of(contacts, models);
            ContactProblem problem = posed(given, W, before, free);
            ContactSolution s = solve_contacts(problem, law_of(restitution, slip, order, exponent));
            return nb::make_tuple(
                array_of(s.impulse), array_of(s.after), static_cast<int>(s.status), s.residual,
                array_of(s.unique), array_of(s.start), array_of(s.normal_work),
                array_of(s.friction_work), s.iterations, s.tied, array_of(s.friction), s.refused);
        },
        nb::arg("W"), nb::arg("before"), nb::arg("free"), nb::arg("contacts"), nb::arg("models"),
        nb::arg("restitution"), nb::arg("slip"), nb::arg("order"), nb::arg("exponent"),
        "Return the impulses of contacts: impulse, velocity after, code of the status, residual, "
        "unique, velocity from which works count, works of normals and friction, iterations, "
        "tied, friction, and what the law refuses.");
    module.def(
        "find_others",
        [](const Array& W, const Array& before, const Array& free, const nb::tuple& contacts,
           int restitution, const Array& impulse) {
            GivenContacts given = contacts_of(contacts, {});
            ContactProblem problem = posed(given, W, before, free);
            Uniqueness found = find_others(problem, law_of(restitution, 0, 0, 1.5),
                                           data_of(impulse, problem.rows(), "impulse"));
            nb::list impulses;
            for (const std::vector<double>& own : found.impulses) impulses.append(array_of(own));
            return nb::make_tuple(static_cast<int>(found.verdict), impulses);
        },
        nb::arg("W"), nb::arg("before"), nb::arg("free"), nb::arg("contacts"),
        nb::arg("restitution"), nb::arg("impulse"),
        "Return how other answers were looked for, and the impulses of those found.");
    module.def(
        "follow_path",
        [](const Array& W, double before, const Array& free, double e, double mu, int restitution) {
            PathImpact found = follow_path(data_of(W, 9, "W"), before, data_of(free, 3, "free"), e,
                                           mu, law_of(restitution, 1, 0, 1.5).restitution);
            return nb::make_tuple(found.impulse[0], found.impulse[1], found.impulse[2],
                                  static_cast<int>(found.status));
        },
        nb::arg("W"), nb::arg("before"), nb::arg("free"), nb::arg("e"), nb::arg("mu"),
        nb::arg("restitution"),
        "Return the impulse of one contact followed along its path, and the code of its status.");
}
