// Scenes of motions, as Python sets them up.
#include "bind/motion_scene.hpp"

#include <nanobind/stl/optional.h>

#include <optional>

#include "bind/fields.hpp"
#include "motion/forces_of_motion.hpp"
#include "scene/joint_axes.hpp"

namespace nb = nanobind;

namespace impulsekit {

GivenMotionScene::GivenMotionScene(const GivenScene& own, const ContactLaw& law,
                                   const Array& gravity, const std::vector<bool>& places,
                                   const std::vector<bool>& speeds)
    : given(own) {
    const std::size_t contacts = own.scene.contacts.size();
    scene->scene = own.scene;
    scene->law = law;
    std::copy_n(data_of(gravity, 3, "gravity"), 3, scene->gravity);
    if (places.size() != speeds.size() || places.size() > own.scene.held.size())
        throw nb::value_error("driven: expected one flag for each constraint");
    if (law.contacts.size() != contacts)
        throw nb::value_error("law: must have coefficients for each contact");
    scene->entries = static_cast<int>(places.size());
    scene->driven_places.assign(places.begin(), places.end());
    scene->driven_speeds.assign(speeds.begin(), speeds.end());
    scene->conditional.assign(contacts, 0);
}

void check_state(const MotionScene& scene, const Array& q, const Array& v) {
    data_of(q, scene.scene.model->nq, "q");
    data_of(v, scene.scene.model->nv, "v");
}

namespace {

using Given = GivenMotionScene;

nb::object array(const double* from, int size) {
    return nb::cast(array_of(std::vector<double>(from, from + size)), nb::rv_policy::move);
}

// The (count) numbers that a function of Python's gives for arrays of so many and other arguments.
void call(const nb::object& function, int count, double* to, const nb::args& arguments) {
    const Array own = nb::cast<Array>(function(*arguments));
    const double* from = data_of(own, count, "what a function gives");
    std::copy(from, from + count, to);
}

// Functions of Python's, which take the lock of its interpreter.
struct Functions {
    int nq, nv;

    explicit Functions(const Given& self) : nq(self.given.model.nq), nv(self.given.model.nv) {}

    // `of_time`: called with the time alone.
    ForceFunction force(const nb::object& function, int count, bool of_time) const {
        if (function.is_none()) return {};
        return [own = *this, count, function, of_time](double t, const double* q, const double* v,
                                                       double* to) {
            const nb::gil_scoped_acquire lock;
            const nb::tuple given =
                of_time ? nb::make_tuple(t) : nb::make_tuple(t, array(q, own.nq), array(v, own.nv));
            call(function, count, to, nb::borrow<nb::args>(given));
        };
    }
    auto of_place(const nb::object& function, int count) const {
        std::function<void(const double*, double*)> found;
        if (!function.is_none())
            found = [own = *this, count, function](const double* q, double* to) {
                const nb::gil_scoped_acquire lock;
                const nb::tuple given = nb::make_tuple(array(q, own.nq));
                call(function, count, to, nb::borrow<nb::args>(given));
            };
        return found;
    }
    auto of_state(const nb::object& function, int count) const {
        std::function<void(const double*, const double*, double*)> found;
        if (!function.is_none())
            found = [own = *this, count, function](const double* q, const double* v, double* to) {
                const nb::gil_scoped_acquire lock;
                const nb::tuple given = nb::make_tuple(array(q, own.nq), array(v, own.nv));
                call(function, count, to, nb::borrow<nb::args>(given));
            };
        return found;
    }
};

void check_v(const Given& self, int v, std::size_t count) {
    if (v < 0 || v + static_cast<int>(count) > self.given.model.nv)
        throw nb::value_error("v: expected the number of a degree of freedom");
}

// Add one more to a table of forces.
template <typename T>
void add(Given& self, ForceEntry::Kind kind, std::vector<T>& table, T force) {
    self.scene->forces.entries.push_back({kind, static_cast<int>(table.size())});
    table.push_back(std::move(force));
}

void add_constant(Given& self, const ConstantTorque& force) {
    check_v(self, force.v, force.torque.size());
    add(self, ForceEntry::constant, self.scene->forces.constants, force);
}

void add_joint(Given& self, const JointForce& force) {
    check_v(self, force.v, 1);
    if (force.q < 0 || force.q + (force.is_circle ? 2 : 1) > self.given.model.nq)
        throw nb::value_error("q: expected the number of a coordinate");
    add(self, ForceEntry::joint, self.scene->forces.joints, force);
}

// The points in the axes of joints.
void add_spring(Given& self, PointSpring force) {
    const Model& model = self.given.model;
    for (Site* site : {&force.first, &force.other}) {
        check_body(model, site->body);
        *site = in_body_axes(model, *site);
    }
    add(self, ForceEntry::spring, self.scene->forces.springs, force);
}

void add_applied(Given& self, AppliedForce force, const nb::object& function, bool of_time) {
    check_body(self.given.model, force.site.body);
    force.site = in_body_axes(self.given.model, force.site);
    force.function = Functions(self).force(function, 6, of_time);
    add(self, ForceEntry::applied, self.scene->forces.applied, std::move(force));
}

void add_timed(Given& self, const TimedTorque& force) {
    check_v(self, force.v, 1);
    add(self, ForceEntry::timed, self.scene->forces.timed, force);
}

void add_function(Given& self, int v, int count, const nb::object& function) {
    check_v(self, v, count);
    add(self, ForceEntry::function, self.scene->forces.functions,
        {v, count, Functions(self).force(function, count, false)});
}

// Several entries may share the friction of one joint, which is their sum.
void add_dry(Given& self, int v, double bound) {
    check_v(self, v, 1);
    std::vector<DryJoint>& dry = self.scene->dry;
    const auto known =
        std::find_if(dry.begin(), dry.end(), [v](const DryJoint& own) { return own.v == v; });
    const int index = static_cast<int>(known - dry.begin());
    self.scene->forces.entries.push_back({ForceEntry::dry, index, bound});
    if (known == dry.end())
        dry.push_back({v, bound});
    else
        known->bound += bound;
}

void set_constraints(Given& self, const nb::object& rows, const nb::object& bias,
                     const nb::object& values, const nb::object& speeds, const nb::object& place) {
    const Functions of(self);
    const int count = self.scene->scene.function_rows;
    ConstraintFunctions& own = self.scene->constraints;
    own.rows = of.of_place(rows, count * of.nv);
    own.bias = of.of_state(bias, count);
    own.values = of.of_place(values, count);
    int m = 0;
    for (int e = 0; e < self.scene->entries; ++e) m += self.scene->scene.held[e].count;
    if (!speeds.is_none())
        own.speeds = [speeds, m](double t, double* velocity, double* rate) {
            const nb::gil_scoped_acquire lock;
            const nb::object found = speeds(t);
            const auto rows = nb::cast<std::vector<int>>(found.attr("rows"));
            const auto first = nb::cast<std::vector<double>>(found.attr("velocity")),
                       second = nb::cast<std::vector<double>>(found.attr("rate"));
            for (std::size_t i = 0; i < rows.size() && i < first.size() && i < second.size(); ++i) {
                if (rows[i] < 0 || rows[i] >= m) continue;
                velocity[rows[i]] = first[i];
                rate[rows[i]] = second[i];
            }
        };
    if (!place.is_none())
        own.place = [place](int entry, double t) {
            const nb::gil_scoped_acquire lock;
            return nb::cast<double>(place(entry, t));
        };
}

void set_gap_functions(Given& self, const nb::object& rows, const nb::object& bias,
                       const nb::object& counts, const std::vector<int>& conditional) {
    const Functions of(self);
    GapFunctions& own = self.scene->contact_gaps;
    if (!rows.is_none()) {
        own.rows = [rows, of](int i, const double* q, double* to) {
            const nb::gil_scoped_acquire lock;
            const nb::tuple given = nb::make_tuple(i, array(q, of.nq));
            call(rows, 1 + 3 * of.nv, to, nb::borrow<nb::args>(given));
        };
        own.bias = [bias, of](int i, const double* q, const double* v, double* to) {
            const nb::gil_scoped_acquire lock;
            const nb::tuple given = nb::make_tuple(i, array(q, of.nq), array(v, of.nv));
            call(bias, 3, to, nb::borrow<nb::args>(given));
        };
    }
    if (!counts.is_none())
        own.counts = [counts, of](int entry, const double* q, const double* v) {
            const nb::gil_scoped_acquire lock;
            return nb::cast<bool>(counts(entry, array(q, of.nq), array(v, of.nv)));
        };
    for (int entry : conditional) self.scene->conditional.at(entry) = 1;
}

void set_pulls(Given& self, const std::vector<double>& pulls) {
    if (pulls.size() != self.scene->conditional.size())
        throw nb::value_error("pulls: must have one number for each contact");
    self.scene->pulls = pulls;
}

void bind_forces(nb::module_& module) {
    using J = JointForce;
    Record<J>(module, "JointForce", "A spring in a joint, or a PD law, which has a limit.")
        .fields("v", &J::v, "q", &J::q, "is_circle", &J::is_circle, "stiffness", &J::stiffness,
                "damping", &J::damping, "rest", &J::rest, "torque", &J::torque, "limit", &J::limit,
                "side", &J::side, "stores", &J::stores);
    using P = PointSpring;
    Record<P>(module, "PointSpring", "A spring between two points, in the axes of their joints.")
        .fields("first", &P::first, "other", &P::other, "stiffness", &P::stiffness, "damping",
                &P::damping, "rest", &P::rest, "side", &P::side);
    using A = AppliedForce;
    Record<A>(module, "AppliedForce", "A force and a couple on a body.")
        .fields("site", &A::site, "is_local", &A::is_local, "numbers", &A::numbers);
    Record<ConstantTorque>(module, "ConstantTorque", "Torques in a joint.")
        .fields("v", &ConstantTorque::v, "torque", &ConstantTorque::torque);
    Record<TimedTorque>(module, "TimedTorque", "A torque in a joint by a table over time.")
        .fields("v", &TimedTorque::v, "table", &TimedTorque::table);
}

}  // namespace
}  // namespace impulsekit

void bind_motion_scene(nb::module_& module) {
    using namespace impulsekit;
    bind_forces(module);
    nb::class_<Given>(module, "MotionScene", "A scene with what acts between impacts.")
        .def(nb::init<const GivenScene&, const ContactLaw&, const Array&, const std::vector<bool>&,
                      const std::vector<bool>&>(),
             nb::arg("scene"), nb::arg("law"), nb::arg("gravity"), nb::arg("driven_places"),
             nb::arg("driven_speeds"), nb::keep_alive<1, 2>())
        .def("add", &add_constant, nb::arg("force"))
        .def("add", &add_joint, nb::arg("force"))
        .def("add", &add_spring, nb::arg("force"))
        .def("add", &add_timed, nb::arg("force"))
        .def("add", &add_applied, nb::arg("force"), nb::arg("function").none(), nb::arg("of_time"))
        .def("add_function", &add_function, nb::arg("v"), nb::arg("count"), nb::arg("function"))
        .def("add_dry", &add_dry, nb::arg("v"), nb::arg("bound"))
        .def("set_constraints", &set_constraints, nb::arg("rows").none(), nb::arg("bias").none(),
             nb::arg("values").none(), nb::arg("speeds").none(), nb::arg("place").none())
        .def("set_gap_functions", &set_gap_functions, nb::arg("rows").none(),
             nb::arg("bias").none(), nb::arg("counts").none(), nb::arg("conditional"))
        .def("set_pulls", &set_pulls, nb::arg("pulls"));
}
