// Laws of contact, as Python calls them.
#include "bind/laws.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/vector.h>

#include <memory>

#include "bind/fields.hpp"
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
void function_field(nb::class_<T>& record, const char* name,
                    std::function<double(double)> T::* member) {
    record.def_prop_rw(
        name, [](const T&) { return nb::none(); },
        [member](T& own, const nb::object& function) { own.*member = function_of(function); },
        nb::for_setter(nb::arg("function").none()));
}

void bind_enums(nb::module_& module) {
    nb::enum_<Restitution>(module, "Restitution")
        .value("newton", Restitution::newton)
        .value("poisson", Restitution::poisson)
        .value("stronge", Restitution::stronge)
        .value("lzb", Restitution::lzb);
    nb::enum_<Slip>(module, "Slip").value("end", Slip::end).value("path", Slip::path);
    nb::enum_<Order>(module, "Order")
        .value("simultaneous", Order::simultaneous)
        .value("sequential", Order::sequential);
    nb::enum_<Status>(module, "Status", nb::is_arithmetic())
        .value("solved", Status::solved)
        .value("inaccurate", Status::inaccurate)
        .value("energy_gain", Status::energy_gain)
        .value("no_solution", Status::no_solution)
        .value("not_converged", Status::not_converged)
        .value("not_finite", Status::not_finite)
        .value("off_manifold", Status::off_manifold)
        .value("out_of_range", Status::out_of_range)
        .value("singular_mass", Status::singular_mass)
        .value("contradiction", Status::contradiction)
        .value("refused", Status::refused)
        .value("nearly_dependent", Status::nearly_dependent);
    nb::enum_<Friction::Kind>(module, "FrictionKind")
        .value("number", Friction::Kind::number)
        .value("static_kinetic", Friction::Kind::static_kinetic)
        .value("by_speed", Friction::Kind::by_speed)
        .value("elliptic", Friction::Kind::elliptic);
    nb::enum_<Verdict>(module, "Verdict")
        .value("smooth", Verdict::smooth)
        .value("weak", Verdict::weak)
        .value("all_tried", Verdict::all_tried)
        .value("searched", Verdict::searched)
        .value("not_searched", Verdict::not_searched);
}

void bind_coefficients(nb::module_& module) {
    Record<Law>(module, "Law", "The meaning of restitution, slip and order.")
        .field("restitution", &Law::restitution)
        .field("slip", &Law::slip)
        .field("order", &Law::order)
        .field("exponent", &Law::exponent);
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
    friction.field("kind", &Friction::kind)
        .field("first", &Friction::first)
        .field("second", &Friction::second)
        .field("axis", &Friction::axis)
        .field("table", &Friction::table);
    function_field(friction, "function", &Friction::function);
    Record<BySpeed> by_speed(module, "BySpeed", "A coefficient that may change with the speed.");
    by_speed.field("value", &BySpeed::value)
        .field("capture", &BySpeed::capture)
        .field("table", &BySpeed::table);
    function_field(by_speed, "function", &BySpeed::function);
    function_field(by_speed, "slope", &BySpeed::slope);
    using C = ContactCoefficients;
    Record<C>(module, "ContactCoefficients", "The coefficients of a contact of a scene.")
        .field("restitution", &C::restitution)
        .field("friction", &C::friction)
        .field("tangential", &C::tangential)
        .field("stiffness", &C::stiffness)
        .field("adhesion", &C::adhesion)
        .field("rolling", &C::rolling)
        .field("torsion", &C::torsion)
        .field("model", &C::model);
    nb::class_<ContactLaw>(module, "ContactLaw", "A law, and the coefficients of each contact.")
        .def(nb::init<const Law&, std::vector<C>>(), nb::arg("law"), nb::arg("contacts"));
    using G = GivenContacts;
    Record<G>(module, "Contacts", "Coefficients of contacts at one instant, (contacts) each.")
        .field("restitution", &G::restitution)
        .field("friction", &G::friction)
        .field("tangential", &G::tangential)
        .field("stiffness", &G::stiffness)
        .field("adhesion", &G::adhesion)
        .field("turning_of", &G::turning_of)
        .field("rolling", &G::rolling)
        .field("torsion", &G::torsion)
        .field("models", &G::models);
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
        .part("impulse", &S::impulse)
        .part("after", &S::after)
        .part("start", &S::start)
        .part("normal_work", &S::normal_work)
        .part("friction_work", &S::friction_work)
        .part("friction", &S::friction)
        .part("unique", &S::unique)
        .part("status", &S::status)
        .part("residual", &S::residual)
        .part("iterations", &S::iterations)
        .part("tied", &S::tied)
        .part("refused", &S::refused);
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
}
