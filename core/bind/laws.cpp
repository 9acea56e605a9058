// Laws of contact, as Python calls them.
#include "bind/laws.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <memory>

#include "bind/fields.hpp"
#include "contact/outcomes.hpp"
#include "contact/uniqueness.hpp"
#include "impact/coefficients.hpp"

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

// Threads share it: what counts references of Python's stands behind a pointer of its own.
std::function<double(double)> function_of(const nb::object& function) {
    if (function.is_none()) return {};
    auto own = std::make_shared<nb::object>(function);
    return [own](double x) {
        const nb::gil_scoped_acquire hold;
        return nb::cast<double>((*own)(x));
    };
}

// A function of Python's as a field that is written alone.
template <typename T>
void function_field(Record<T>& record, const char* name,
                    std::function<double(double)> T::* member) {
    record.custom(
        name, [](const T&) { return nb::none(); },
        [member](T& own, const nb::object& function) { own.*member = function_of(function); },
        nb::for_setter(nb::arg("function").none()));
}

void bind_enums(nb::module_& module) {
    bind_enum<Restitution>(module, "Restitution", "newton", Restitution::newton, "poisson",
                           Restitution::poisson, "stronge", Restitution::stronge, "lzb",
                           Restitution::lzb);
    bind_enum<Slip>(module, "Slip", "end", Slip::end, "path", Slip::path, "compliant",
                    Slip::compliant);
    bind_enum<Order>(module, "Order", "simultaneous", Order::simultaneous, "sequential",
                     Order::sequential);
    bind_enum<Status>(module, "Status", "solved", Status::solved, "inaccurate", Status::inaccurate,
                      "energy_gain", Status::energy_gain, "no_solution", Status::no_solution,
                      "not_converged", Status::not_converged, "not_finite", Status::not_finite,
                      "off_manifold", Status::off_manifold, "out_of_range", Status::out_of_range,
                      "singular_mass", Status::singular_mass, "contradiction",
                      Status::contradiction, "refused", Status::refused, "nearly_dependent",
                      Status::nearly_dependent);
    bind_enum<Friction::Kind>(module, "FrictionKind", "number", Friction::Kind::number,
                              "static_kinetic", Friction::Kind::static_kinetic, "by_speed",
                              Friction::Kind::by_speed, "elliptic", Friction::Kind::elliptic);
    bind_enum<Verdict>(module, "Verdict", "smooth", Verdict::smooth, "weak", Verdict::weak,
                       "all_tried", Verdict::all_tried, "searched", Verdict::searched,
                       "not_searched", Verdict::not_searched);
}

void bind_coefficients(nb::module_& module) {
    Record<Law>(module, "Law", "The meaning of restitution, slip and order.")
        .fields("restitution", &Law::restitution, "slip", &Law::slip, "order", &Law::order,
                "exponent", &Law::exponent);
    nb::class_<Table>(module, "Table", "Values by a number, linear between rising points.")
        .def(
            "__init__",
            [](Table* self, std::vector<double> points, std::vector<double> values) {
                if (points.empty() || points.size() != values.size())
                    throw nb::value_error("table: must have as many values as points");
                new (self) Table{std::move(points), std::move(values)};
            },
            nb::arg("points"), nb::arg("values"));
    Record<Friction> friction(module, "Friction", "Friction of a contact.");
    friction.fields("kind", &Friction::kind, "first", &Friction::first, "second", &Friction::second,
                    "axis", &Friction::axis, "table", &Friction::table);
    function_field(friction, "function", &Friction::function);
    Record<BySpeed> by_speed(module, "BySpeed", "A coefficient that may change with the speed.");
    by_speed.fields("value", &BySpeed::value, "capture", &BySpeed::capture, "table",
                    &BySpeed::table);
    function_field(by_speed, "function", &BySpeed::function);
    function_field(by_speed, "slope", &BySpeed::slope);
    using C = ContactCoefficients;
    Record<C>(module, "ContactCoefficients", "The coefficients of a contact of a scene.")
        .fields("restitution", &C::restitution, "friction", &C::friction, "tangential",
                &C::tangential, "stiffness", &C::stiffness, "stiffness_ratio", &C::stiffness_ratio,
                "tangential_damping", &C::tangential_damping, "adhesion", &C::adhesion, "rolling",
                &C::rolling, "torsion", &C::torsion, "model", &C::model);
    nb::class_<ContactLaw>(module, "ContactLaw", "A law, and the coefficients of each contact.")
        .def(nb::init<const Law&, std::vector<C>>(), nb::arg("law"), nb::arg("contacts"));
    using G = GivenContacts;
    Record<G>(module, "Contacts", "Coefficients of contacts at one instant, (contacts) each.")
        .fields("restitution", &G::restitution, "friction", &G::friction, "tangential",
                &G::tangential, "stiffness", &G::stiffness, "stiffness_ratio", &G::stiffness_ratio,
                "tangential_damping", &G::tangential_damping, "adhesion", &G::adhesion,
                "turning_of", &G::turning_of, "rolling", &G::rolling, "torsion", &G::torsion,
                "models", &G::models);
}

}  // namespace

ContactProblem GivenContacts::coefficients() const {
    ContactProblem p;
    const std::size_t n = restitution.size(), k = turning_of ? turning_of->size() : 0;
    p.contacts = static_cast<int>(n);
    p.turning = static_cast<int>(k);
    p.restitution = restitution.data();
    p.friction = data_of(friction, n, "friction");
    p.tangential = data_of(tangential, n, "tangential_restitution");
    if (stiffness) p.stiffness = data_of(*stiffness, n, "stiffness");
    if (stiffness_ratio) p.stiffness_ratio = data_of(*stiffness_ratio, n, "stiffness_ratio");
    if (tangential_damping) p.damping = data_of(*tangential_damping, n, "tangential_damping");
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

}  // namespace impulsekit

void bind_laws(nb::module_& module) {
    using namespace impulsekit;
    bind_enums(module);
    bind_coefficients(module);
    using S = ContactSolution;
    Result<S>(module, "ContactSolution", "The impulses of contacts.")
        .parts("impulse", &S::impulse, "after", &S::after, "start", &S::start, "normal_work",
               &S::normal_work, "friction_work", &S::friction_work, "friction", &S::friction,
               "unique", &S::unique, "status", &S::status, "residual", &S::residual, "iterations",
               &S::iterations, "tied", &S::tied, "refused", &S::refused);
    module.def(
        "solve_contacts",
        [](const Array& W, const Array& before, const Array& free, const GivenContacts& contacts,
           const Law& law) { return solve_contacts(posed(contacts, W, before, free), law); },
        nb::arg("W"), nb::arg("before"), nb::arg("free"), nb::arg("contacts"), nb::arg("law"),
        "Return the impulses of contacts.");
    nb::class_<Uniqueness>(module, "Uniqueness", "How other answers were looked for.")
        .def_ro("verdict", &Uniqueness::verdict)
        .def_prop_ro("impulses", [](const Uniqueness& found) {
            nb::list impulses;
            for (const std::vector<double>& own : found.impulses) impulses.append(array_of(own));
            return impulses;
        });
    module.def(
        "find_others",
        [](const Array& W, const Array& before, const Array& free, const GivenContacts& contacts,
           const Law& law, const Array& impulse) {
            const ContactProblem problem = posed(contacts, W, before, free);
            return find_others(problem, law, data_of(impulse, problem.rows(), "impulse"));
        },
        nb::arg("W"), nb::arg("before"), nb::arg("free"), nb::arg("contacts"), nb::arg("law"),
        nb::arg("impulse"), "Return the impulses of other answers, where that can be known.");
    using O = Outcomes;
    Result<O>(module, "Outcomes", "Outcomes one after the other: samples, then extremes.")
        .part("impulses", &O::impulses)
        .part("works", &O::works)
        .part("states", &O::states);
    module.def(
        "find_outcomes",
        [](const Array& W, const Array& free, const GivenContacts& contacts, int samples,
           const Array& directions, int tries, std::uint64_t seed, int threads) {
            const ContactProblem problem = posed(contacts, W, free, free);
            const std::size_t r = problem.rows();
            if (samples < 1 || r == 0 || directions.size() % r != 0)
                throw nb::value_error("samples, directions: expected samples, and rows of them");
            const int count = static_cast<int>(directions.size() / r);
            const nb::gil_scoped_release release;
            return find_outcomes(problem, samples, directions.data(), count, tries, seed, threads);
        },
        nb::arg("W"), nb::arg("free"), nb::arg("contacts"), nb::arg("samples"),
        nb::arg("directions"), nb::arg("tries"), nb::arg("seed"), nb::arg("threads"),
        "Return outcomes in any order and shares: samples, then the extreme of each direction.");
}
