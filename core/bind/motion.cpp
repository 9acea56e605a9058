// Motions, as Python sets them up, runs them and reads them.
#include "motion/motion.hpp"

#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>
#include <nanobind/stl/tuple.h>

#include <memory>
#include <optional>

#include "bind/arrays.hpp"
#include "bind/given_scene.hpp"
#include "spatial/configuration.hpp"

namespace nb = nanobind;

void bind_motion(nb::module_& module);

namespace impulsekit {
namespace {

// Numbers by which a resting point is kept.
constexpr int kPacked = 21;

nb::object array(const double* from, std::size_t size) {
    return nb::cast(array_of(std::vector<double>(from, from + size)), nb::rv_policy::move);
}

void copy_to(nb::handle given, double* to, std::size_t size, const char* name) {
    const Array own = nb::cast<Array>(given);
    const double* from = data_of(own, size, name);
    std::copy(from, from + size, to);
}

// Functions of Python's; called with the lock of its interpreter.
struct Callbacks {
    int nq, nv;

    auto torque(nb::object function, int count) const {
        return [nq = nq, nv = nv, count, function](double t, const double* q, const double* v,
                                                   double* to) {
            nb::gil_scoped_acquire lock;
            copy_to(function(t, array(q, nq), array(v, nv)), to, count, "a force");
        };
    }
    auto of_place(nb::object function, int count) const {
        return [nq = nq, count, function](const double* q, double* to) {
            nb::gil_scoped_acquire lock;
            copy_to(function(array(q, nq)), to, count, "rows");
        };
    }
    auto of_state(nb::object function, int count) const {
        return [nq = nq, nv = nv, count, function](const double* q, const double* v, double* to) {
            nb::gil_scoped_acquire lock;
            copy_to(function(array(q, nq), array(v, nv)), to, count, "rates of rows");
        };
    }
};

struct GivenMotionScene {
    std::shared_ptr<MotionScene> scene = std::make_shared<MotionScene>();
    Callbacks calls{0, 0};
    const GivenScene* given = nullptr;

    GivenMotionScene(const GivenScene& own, const ContactLaw& law, const Array& gravity,
                     int entries, const std::vector<bool>& places, const std::vector<bool>& speeds)
        : given(&own) {
        scene->scene = own.scene;
        scene->law = law;
        copy_numbers(gravity, 3, scene->gravity);
        const int held = static_cast<int>(own.scene.held.size());
        if (entries < 0 || entries > held || static_cast<int>(places.size()) != entries ||
            static_cast<int>(speeds.size()) != entries)
            throw nb::value_error("entries: expected one flag for each constraint");
        if (law.contacts.size() != own.scene.contacts.size())
            throw nb::value_error("law: must have coefficients for each contact");
        scene->entries = entries;
        scene->driven_places.assign(places.begin(), places.end());
        scene->driven_speeds.assign(speeds.begin(), speeds.end());
        scene->bodies.resize(own.scene.contacts.size());
        scene->conditional.assign(own.scene.contacts.size(), 0);
        calls = {own.model.nq, own.model.nv};
    }

    static void copy_numbers(const Array& from, std::size_t size, double* to) {
        const double* own = data_of(from, size, "numbers");
        std::copy(own, own + size, to);
    }
    void check_v(int v, int count) const {
        if (v < 0 || v + count > calls.nv)
            throw nb::value_error("v: expected the number of a degree of freedom");
    }
    void check_q(int q, int count) const {
        if (q < 0 || q + count > calls.nq)
            throw nb::value_error("q: expected the number of a coordinate");
    }
    void add(ForceEntry::Kind kind, std::size_t index) {
        scene->forces.entries.push_back({kind, static_cast<int>(index)});
    }

    void add_constant(int v, const std::vector<double>& torque) {
        check_v(v, static_cast<int>(torque.size()));
        add(ForceEntry::constant, scene->forces.constants.size());
        scene->forces.constants.push_back({v, torque});
    }
    void add_joint(int v, int q, bool is_circle, const Array& numbers, bool stores) {
        check_v(v, 1);
        check_q(q, is_circle ? 2 : 1);
        const double* x = data_of(numbers, 6, "numbers");
        add(ForceEntry::joint, scene->forces.joints.size());
        scene->forces.joints.push_back(
            {v, q, is_circle, x[0], x[1], x[2], x[3], x[4], x[5], stores});
    }
    void add_spring(const Site& first, const Site& other, const Array& numbers) {
        const double* x = data_of(numbers, 4, "numbers");
        const Site one = site_of(given->model, first), two = site_of(given->model, other);
        PointSpring spring;
        spring.first = one.body;
        spring.other = two.body;
        std::copy(one.point, one.point + 3, spring.point);
        std::copy(two.point, two.point + 3, spring.other_point);
        spring.stiffness = x[0];
        spring.damping = x[1];
        spring.rest = x[2];
        spring.side = x[3];
        add(ForceEntry::spring, scene->forces.springs.size());
        scene->forces.springs.push_back(spring);
    }
    void add_applied(const Site& site, bool is_local) {
        add(ForceEntry::applied, scene->forces.applied.size());
        scene->forces.applied.push_back({site_of(given->model, site), is_local});
    }
    void add_row(int v) {
        check_v(v, 1);
        add(ForceEntry::row, scene->forces.rows.size());
        scene->forces.rows.push_back(v);
    }
    void add_function(int v, int count, nb::object function) {
        check_v(v, count);
        add(ForceEntry::function, scene->forces.functions.size());
        scene->forces.functions.push_back({v, count, calls.torque(function, count)});
    }
    void add_dry(int v, double bound, bool is_first) {
        check_v(v, 1);
        add(ForceEntry::dry, scene->dry.size() - (is_first ? 0 : 1));
        if (is_first) scene->dry.push_back({v, bound});
    }
    void set_driven(const Array& at_start, nb::object function) {
        Forces& forces = scene->forces;
        const std::size_t count = 6 * forces.applied.size() + forces.rows.size();
        const double* from = data_of(at_start, count, "at_start");
        forces.at_start.assign(from, from + count);
        if (!function.is_none()) forces.driven = calls.torque(function, static_cast<int>(count));
    }
    void set_constraints(nb::object rows, nb::object bias, nb::object values, nb::object speeds,
                         nb::object place) {
        const int count = scene->scene.function_rows, nv = calls.nv;
        ConstraintFunctions& own = scene->constraints;
        if (!rows.is_none()) {
            own.rows = calls.of_place(rows, count * nv);
            own.bias = calls.of_state(bias, count);
            own.values = calls.of_place(values, count);
        }
        int m = 0;
        for (int e = 0; e < scene->entries; ++e) m += scene->scene.held[e].count;
        if (!speeds.is_none())
            own.speeds = [speeds, m](double t, double* velocity, double* rate) {
                nb::gil_scoped_acquire lock;
                const auto [rows, first, second] = nb::cast<
                    std::tuple<std::vector<int>, std::vector<double>, std::vector<double>>>(
                    speeds(t));
                for (std::size_t i = 0; i < rows.size() && i < first.size() && i < second.size();
                     ++i) {
                    if (rows[i] < 0 || rows[i] >= m) continue;
                    velocity[rows[i]] = first[i];
                    rate[rows[i]] = second[i];
                }
            };
        if (!place.is_none())
            own.place = [place](int entry, double t) {
                nb::gil_scoped_acquire lock;
                return nb::cast<double>(place(entry, t));
            };
    }
    void set_gap_functions(nb::object rows, nb::object bias, nb::object counts,
                           const std::vector<int>& conditional) {
        const int nv = calls.nv, nq = calls.nq;
        GapFunctions& own = scene->contact_gaps;
        if (!rows.is_none()) {
            own.rows = [rows, nq, nv](int i, const double* q, double* to) {
                nb::gil_scoped_acquire lock;
                copy_to(rows(i, array(q, nq)), to, 1 + 3 * nv, "a gap and its rows");
            };
            own.bias = [bias, nq, nv](int i, const double* q, const double* v, double* to) {
                nb::gil_scoped_acquire lock;
                copy_to(bias(i, array(q, nq), array(v, nv)), to, 3, "rates of rows");
            };
        }
        if (!counts.is_none())
            own.counts = [counts, nq, nv](int entry, const double* q, const double* v) {
                nb::gil_scoped_acquire lock;
                return nb::cast<bool>(counts(entry, array(q, nq), array(v, nv)));
            };
        for (int entry : conditional) scene->conditional.at(entry) = 1;
    }
    // The pieces of both bodies of a collision, in the axes of their joints.
    void set_bodies(int entry, const std::vector<Shape>& first, const std::vector<Shape>& other) {
        if (entry < 0 || entry >= static_cast<int>(scene->bodies.size()))
            throw nb::value_error("entry: expected the number of a contact");
        if (first.empty() || other.empty()) throw nb::value_error("a body without pieces");
        const Contact& contact = scene->scene.contacts[entry];
        // If the ball is the second of its entry, the frames are swapped.
        const bool turned = contact.kind == Contact::ball && contact.shape.sign < 0.0;
        const int one = turned ? contact.frames.other.body : contact.frames.first.body,
                  two = turned ? contact.frames.first.body : contact.frames.other.body;
        scene->bodies[entry] = {in_body(one, first), in_body(two, other), one, two, 0.0};
    }
    // Shapes in the axes of a body, which may not be those of its joint.
    std::vector<Shape> in_body(int body, std::vector<Shape> shapes) const {
        const Mat turn = mat3<double>(given->model.bodies[body].turn);
        for (Shape& s : shapes) {
            for (auto* own : {&s.points, &s.face_axes, &s.edge_axes})
                for (Vec& x : *own) x = back(turn, x);
            for (Shape::Circle& circle : s.circles) circle.centre = back(turn, circle.centre);
            for (Face& face : s.faces) face.normal = back(turn, face.normal);
            for (Vec* x : {&s.axis, &s.across, &s.centre, &s.axes.x, &s.axes.y, &s.axes.z})
                *x = back(turn, *x);
        }
        return shapes;
    }
    void set_pulls(const std::vector<double>& pulls) {
        if (pulls.size() != scene->bodies.size())
            throw nb::value_error("pulls: must have one number for each contact");
        scene->pulls = pulls;
    }
};

// A resting point as numbers, and back.
void pack(const RestingContact& p, std::vector<double>& to) {
    const Feature& f = p.feature;
    to.insert(to.end(), {double(p.gap), double(f.kind), double(f.piece[0]), double(f.piece[1])});
    for (int i = 0; i < 4; ++i) to.push_back(f.index[i]);
    for (int i = 0; i < 3; ++i) to.push_back(f.fixed[i]);
    to.push_back(p.since);
    for (const SlipState* slip_state : {&p.slip, &p.roll, &p.spin})
        to.insert(to.end(), {slip_state->moves ? 1.0 : 0.0, slip_state->direction[0],
                             slip_state->direction[1]});
}

RestingContact unpack(const double* x) {
    RestingContact p;
    Feature& f = p.feature;
    p.gap = static_cast<int>(x[0]);
    f.kind = static_cast<Feature::Kind>(std::clamp(static_cast<int>(x[1]), 0, 5));
    f.piece[0] = static_cast<int>(x[2]);
    f.piece[1] = static_cast<int>(x[3]);
    for (int i = 0; i < 4; ++i) f.index[i] = static_cast<int>(x[4 + i]);
    for (int i = 0; i < 3; ++i) f.fixed[i] = x[8 + i];
    p.since = x[11];
    x += 12;
    for (SlipState* slip_state : {&p.slip, &p.roll, &p.spin}) {
        *slip_state = {x[0] != 0.0, {x[1], x[2]}};
        x += 3;
    }
    return p;
}

// A resting state as Python keeps it: numbers of points, directions of joints, outer torques.
using RestingNumbers = std::tuple<Array, std::vector<int>, Array>;

RestingState rest_of(const RestingNumbers& given, const Dynamics& dynamics) {
    const auto& [points, dry, controls] = given;
    if (points.size() % kPacked != 0)
        throw nb::value_error("points: expected a whole number of packed points");
    RestingState rest;
    for (std::size_t i = 0; i < points.size(); i += kPacked) {
        rest.points.push_back(unpack(points.data() + i));
        const RestingContact& p = rest.points.back();
        if (p.gap < 0 || p.gap >= static_cast<int>(dynamics.contact_gaps.gaps().size()))
            throw nb::value_error("points: unknown gap");
        const Gap& gap = dynamics.contact_gaps.gaps()[p.gap];
        if (gap.kind != Contact::shapes && gap.kind != Contact::ball) continue;
        const Bodies& bodies = dynamics.contact_gaps.bodies_of(gap);
        if (!is_named(p.feature, bodies.first, bodies.other))
            throw nb::value_error("points: unknown feature of bodies");
    }
    for (int direction : dry) rest.dry.push_back(static_cast<signed char>(direction));
    if (rest.dry.size() != dynamics.scene.dry.size())
        throw nb::value_error("dry: must have one number for each joint with dry friction");
    if (controls.size() > 0) {
        const double* torques = data_of(controls, dynamics.scene.scene.model->nv, "controls");
        rest.controls.assign(torques, torques + controls.size());
    }
    return rest;
}

// All forces at a state of a motion.
class ForcesOfMotion {
  public:
    ForcesOfMotion(const GivenMotionScene& given, double slow)
        : scene_(given.scene), dynamics_(*scene_) {
        dynamics_.slow = slow;
    }

    nb::dict at(double t, const Array& q, const Array& v, const RestingNumbers& resting) {
        const Model& model = *scene_->scene.model;
        const double *own_q = data_of(q, model.nq, "q"), *own_v = data_of(v, model.nv, "v");
        RestingState rest = rest_of(resting, dynamics_);
        dynamics_.set_state(own_q, own_v);
        dynamics_.kinks.set_sides(dynamics_.tree, own_q, own_v);
        std::vector<double> a(model.nv);
        const DynamicsFailure failure = dynamics_.accelerate(t, own_q, own_v, rest, a.data());
        nb::dict found;
        found["failure"] = static_cast<int>(failure);
        found["acceleration"] = nb::cast(array_of(a), nb::rv_policy::move);
        found["multipliers"] = nb::cast(array_of(dynamics_.multipliers), nb::rv_policy::move);
        found["unique"] = std::vector<bool>(dynamics_.unique.begin(), dynamics_.unique.end());
        found["forces"] = nb::cast(array_of(dynamics_.F), nb::rv_policy::move);
        found["slip"] = nb::cast(array_of(dynamics_.slip), nb::rv_policy::move);
        found["moments"] = nb::cast(array_of(dynamics_.moment), nb::rv_policy::move);
        found["turning"] = nb::cast(array_of(dynamics_.turning), nb::rv_policy::move);
        found["turning_of"] = dynamics_.turning_points;
        found["dry"] = nb::cast(array_of(dynamics_.dry_torque), nb::rv_policy::move);
        std::vector<int> entries;
        std::vector<double> axes, places, signs;
        for (const RestingContact& point : rest.points) {
            const Gap& gap = dynamics_.contact_gaps.gaps()[point.gap];
            entries.push_back(gap.entry);
            signs.push_back(gap.sign);
            const bool has_place = gap.kind != Contact::stop && gap.kind != Contact::functions;
            const FramePairMotion b =
                has_place ? dynamics_.contact_gaps.spot(dynamics_.tree, point) : FramePairMotion();
            const Vec place = dynamics_.tree.world_place(b.place);
            axes.insert(axes.end(), {b.axes.x.x, b.axes.y.x, b.axes.z.x, b.axes.x.y, b.axes.y.y,
                                     b.axes.z.y, b.axes.x.z, b.axes.y.z, b.axes.z.z});
            places.insert(places.end(), {place.x, place.y, place.z});
        }
        found["entries"] = entries;
        found["axes"] = nb::cast(array_of(axes), nb::rv_policy::move);
        found["places"] = nb::cast(array_of(places), nb::rv_policy::move);
        found["signs"] = nb::cast(array_of(signs), nb::rv_policy::move);
        return found;
    }

    // q and v at another time while the same rests, whatever happens on the way; none where there
    // is no acceleration, or no step is short enough.
    std::optional<std::pair<nb::object, nb::object>> flow(double start, double end, const Array& q,
                                                          const Array& v,
                                                          const RestingNumbers& resting,
                                                          double rtol, double atol) {
        const Model& model = *scene_->scene.model;
        RestingState rest = rest_of(resting, dynamics_);
        const double *own_q = data_of(q, model.nq, "q"), *own_v = data_of(v, model.nv, "v");
        std::vector<double> y(own_q, own_q + model.nq), trial(model.nq);
        y.insert(y.end(), own_v, own_v + model.nv);
        dynamics_.set_state(own_q, own_v);
        dynamics_.kinks.set_sides(dynamics_.tree, own_q, own_v);
        const auto f = [&](double t, const double* from, double* to) {
            std::copy(from, from + model.nq, trial.begin());
            normalize_configuration(model, trial.data());
            configuration_rate(model, from, from + model.nq, to);
            return dynamics_.accelerate(t, trial.data(), from + model.nq, rest, to + model.nq) ==
                   DynamicsFailure::none;
        };
        Stepper stepper(Method::dop853, model.nq, model.nq + model.nv, {rtol, atol}, 0.0);
        stepper.next = 1e-3 * (end - start);
        std::vector<double> rate(y.size());
        bool sound = f(start, y.data(), rate.data());
        Step step;
        // Rounding of times may leave less than any step.
        for (double t = start; sound && end - t > shortest_step(t); t = step.end)
            sound = stepper.step(
                f, [&](double* x) { normalize_configuration(model, x); }, t, y.data(), rate.data(),
                end - t, step);
        if (!sound) return std::nullopt;
        return std::make_pair(array(y.data(), model.nq), array(y.data() + model.nq, model.nv));
    }

    // (nv) torques, and (bodies, 6) wrenches about the origins of bodies in world axes, of an
    // entry of the scene's forces.
    std::pair<nb::object, nb::object> force(int entry, double t, const Array& q, const Array& v) {
        const Model& model = *scene_->scene.model;
        const double *own_q = data_of(q, model.nq, "q"), *own_v = data_of(v, model.nv, "v");
        if (entry < 0 || entry >= static_cast<int>(scene_->forces.entries.size()))
            throw nb::value_error("entry: expected the number of a force");
        dynamics_.set_state(own_q, own_v);
        dynamics_.kinks.set_sides(dynamics_.tree, own_q, own_v);
        std::vector<double> torque(model.nv), wrenches;
        auto& wrench = dynamics_.tree.wrench;
        std::fill(wrench.begin(), wrench.end(), Spatial<double>{});
        add_forces(scene_->forces, dynamics_.kinks, entry, t, own_q, own_v, dynamics_.tree,
                   torque.data());
        for (const Spatial<double>& own : wrench)
            wrenches.insert(wrenches.end(), {own.linear.x, own.linear.y, own.linear.z,
                                             own.angular.x, own.angular.y, own.angular.z});
        return {nb::cast(array_of(torque), nb::rv_policy::move),
                nb::cast(array_of(wrenches), nb::rv_policy::move)};
    }

    // (gap, contact, value, rate) of all gaps at a state.
    std::vector<std::tuple<int, int, double, double>> gaps(const Array& q, const Array& v) {
        set_state(q, v);
        std::vector<std::tuple<int, int, double, double>> found;
        const auto& gaps = dynamics_.contact_gaps.gaps();
        for (std::size_t i = 0; i < gaps.size(); ++i) {
            const GapState at =
                dynamics_.contact_gaps.measure(dynamics_.tree, gaps[i], q.data(), v.data());
            found.emplace_back(static_cast<int>(i), gaps[i].entry, at.gap, at.rate);
        }
        return found;
    }

    // (nv) the row of a gap's rate at a state.
    nb::object gap_row(int gap, const Array& q, const Array& v) {
        if (gap < 0 || gap >= static_cast<int>(dynamics_.contact_gaps.gaps().size()))
            throw nb::value_error("gap: unknown gap");
        set_state(q, v);
        RestingContact point;
        point.gap = gap;
        const int nv = scene_->scene.model->nv;
        std::vector<double> J(3 * nv), turning(3 * nv);
        dynamics_.contact_gaps.rows(dynamics_.tree, point, q.data(), v.data(), J.data(),
                                    turning.data(), nullptr, nullptr);
        return array(J.data() + 2 * nv, nv);
    }

    double spring_energy(const Array& q) {
        const Model& model = *scene_->scene.model;
        const double* own = data_of(q, model.nq, "q");
        const std::vector<double> still(model.nv);
        dynamics_.set_state(own, still.data());
        return impulsekit::spring_energy(scene_->forces, dynamics_.tree, own);
    }

    // (rows) velocities of the constraints' rows.
    nb::object row_velocities(const Array& q, const Array& v) {
        const Model& model = *scene_->scene.model;
        const double *own_q = data_of(q, model.nq, "q"), *own_v = data_of(v, model.nv, "v");
        dynamics_.set_state(own_q, own_v);
        dynamics_.constraints.fill_rows(dynamics_.tree, own_q);
        std::vector<double> found(dynamics_.constraints.rows());
        for (std::size_t r = 0; r < found.size(); ++r)
            for (int i = 0; i < model.nv; ++i)
                found[r] += dynamics_.constraints.A()[r * model.nv + i] * own_v[i];
        return nb::cast(array_of(found), nb::rv_policy::move);
    }

  private:
    void set_state(const Array& q, const Array& v) {
        const Model& model = *scene_->scene.model;
        dynamics_.set_state(data_of(q, model.nq, "q"), data_of(v, model.nv, "v"));
    }

    std::shared_ptr<const MotionScene> scene_;
    Dynamics dynamics_;
};

MotionSettings settings_of(const std::string& method, const Array& numbers,
                           const std::vector<double>& stop_times, int max_impacts, int max_steps) {
    const double* x = data_of(numbers, 7, "numbers");
    MotionSettings s;
    s.method = method == "rk4"             ? Method::rk4
               : method == "radau"         ? Method::radau
               : method == "semi-implicit" ? Method::semi_implicit
                                           : Method::dop853;
    s.rtol = x[0];
    s.atol = x[1];
    s.fixed_length = x[2];
    s.max_step = x[3];
    s.capture_speed = x[4];
    s.together = x[5];
    s.scale_of_time = x[6];
    s.stop_times = stop_times;
    s.max_impacts = max_impacts;
    s.max_steps = max_steps;
    return s;
}

// Steps between two looks at Ctrl-C where nobody asks for more.
constexpr int kBetweenChecks = 16;

// Steps, none beyond a horizon, while a condition holds; `look` is called with the time after so
// many of them.
template <typename Condition>
void run_while(Motion& motion, double horizon, nb::object on_time, int every,
               const Condition& goes_on) {
    if (every < 1) throw nb::value_error("every: must be >= 1");
    motion.go_on();
    const bool has_callback = !on_time.is_none();
    nb::gil_scoped_release free;
    for (int count = 1; goes_on() && motion.advance(horizon); ++count) {
        if (count % every != 0) continue;
        nb::gil_scoped_acquire lock;
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
        if (has_callback) on_time(motion.t);
    }
}

// On to a time, at least.
void run(Motion& motion, double until, double horizon, nb::object on_time, int every) {
    run_while(motion, horizon, on_time, every, [&] { return motion.t < until; });
}

nb::tuple impact_of(const MotionImpact& impact) {
    return nb::make_tuple(impact.t, array(impact.q.data(), impact.q.size()),
                          array(impact.v.data(), impact.v.size()),
                          array(impact.after.data(), impact.after.size()), impact.entries,
                          impact.features, impact.is_soft, static_cast<int>(impact.status));
}

nb::tuple numbers_of(const RestingState& rest) {
    std::vector<double> points;
    for (const RestingContact& point : rest.points) pack(point, points);
    return nb::make_tuple(nb::cast(array_of(points), nb::rv_policy::move),
                          std::vector<int>(rest.dry.begin(), rest.dry.end()),
                          nb::cast(array_of(rest.controls), nb::rv_policy::move));
}

// The path as arrays: start, end, begin, length (pieces, 4), y at the beginning, coefficients, and
// which resting state each has.
nb::dict path_of(const Motion& motion) {
    std::vector<double> times, before, shape;
    std::vector<int> resting;
    for (const Piece& piece : motion.path) {
        const Step& s = piece.step;
        times.insert(times.end(), {s.start, s.end, s.begin, s.length});
        before.insert(before.end(), s.before.begin(), s.before.end());
        shape.insert(shape.end(), s.shape.begin(), s.shape.end());
        resting.push_back(piece.resting_state);
    }
    nb::list resting_states;
    for (const RestingState& rest : motion.resting_states) resting_states.append(numbers_of(rest));
    nb::dict found;
    found["times"] = nb::cast(array_of(times), nb::rv_policy::move);
    found["before"] = nb::cast(array_of(before), nb::rv_policy::move);
    found["shape"] = nb::cast(array_of(shape), nb::rv_policy::move);
    found["resting_state"] = resting;
    found["resting_states"] = resting_states;
    return found;
}

void bind_motion_scene(nb::module_& module) {
    using Given = GivenMotionScene;
    nb::class_<Given>(module, "MotionScene", "A scene with what acts between impacts.")
        .def(nb::init<const GivenScene&, const ContactLaw&, const Array&, int,
                      const std::vector<bool>&, const std::vector<bool>&>(),
             nb::arg("scene"), nb::arg("law"), nb::arg("gravity"), nb::arg("entries"),
             nb::arg("driven_places"), nb::arg("driven_speeds"), nb::keep_alive<1, 2>())
        .def("add_constant", &Given::add_constant, nb::arg("v"), nb::arg("torque"))
        .def("add_joint", &Given::add_joint, nb::arg("v"), nb::arg("q"), nb::arg("is_circle"),
             nb::arg("numbers"), nb::arg("stores"))
        .def("add_spring", &Given::add_spring, nb::arg("first"), nb::arg("other"),
             nb::arg("numbers"))
        .def("add_applied", &Given::add_applied, nb::arg("site"), nb::arg("is_local"))
        .def("add_row", &Given::add_row, nb::arg("v"))
        .def("add_function", &Given::add_function, nb::arg("v"), nb::arg("count"),
             nb::arg("function"))
        .def("add_dry", &Given::add_dry, nb::arg("v"), nb::arg("bound"), nb::arg("is_first"))
        .def("set_driven", &Given::set_driven, nb::arg("at_start"), nb::arg("function").none())
        .def("set_constraints", &Given::set_constraints, nb::arg("rows").none(),
             nb::arg("bias").none(), nb::arg("values").none(), nb::arg("speeds").none(),
             nb::arg("place").none())
        .def("set_gap_functions", &Given::set_gap_functions, nb::arg("rows").none(),
             nb::arg("bias").none(), nb::arg("counts").none(), nb::arg("conditional"))
        .def("set_bodies", &Given::set_bodies, nb::arg("entry"), nb::arg("first"), nb::arg("other"))
        .def("set_pulls", &Given::set_pulls, nb::arg("pulls"));
}

void bind_forces_of_motion(nb::module_& module) {
    nb::class_<ForcesOfMotion>(module, "ForcesOfMotion", "All forces at a state of a motion.")
        .def(nb::init<const GivenMotionScene&, double>(), nb::arg("scene"), nb::arg("slow"),
             nb::keep_alive<1, 2>())
        .def("at", &ForcesOfMotion::at, nb::arg("t"), nb::arg("q"), nb::arg("v"),
             nb::arg("resting_state"))
        .def("flow", &ForcesOfMotion::flow, nb::arg("start"), nb::arg("end"), nb::arg("q"),
             nb::arg("v"), nb::arg("resting_state"), nb::arg("rtol"), nb::arg("atol"))
        .def("force", &ForcesOfMotion::force, nb::arg("entry"), nb::arg("t"), nb::arg("q"),
             nb::arg("v"))
        .def("gaps", &ForcesOfMotion::gaps, nb::arg("q"), nb::arg("v"))
        .def("gap_row", &ForcesOfMotion::gap_row, nb::arg("gap"), nb::arg("q"), nb::arg("v"))
        .def("spring_energy", &ForcesOfMotion::spring_energy, nb::arg("q"))
        .def("row_velocities", &ForcesOfMotion::row_velocities, nb::arg("q"), nb::arg("v"));
}

void bind_progress(nb::class_<Motion>& motion) {
    motion
        .def(
            "control",
            [](Motion& self, const Array& torques) {
                self.control(data_of(torques, self.nv(), "torques"));
            },
            nb::arg("torques"))
        .def(
            "state",
            [](const Motion& self, double at) {
                std::vector<double> q(self.nq()), v(self.nv());
                self.state(at, q.data(), v.data());
                return std::make_pair(array_of(q), array_of(v));
            },
            nb::arg("at"))
        // (times, nq + nv) y at times as the steps have it; from the end on the state there.
        .def(
            "samples",
            [](const Motion& self, const Array& times) {
                const std::size_t size = self.nq() + self.nv();
                std::vector<double> found(times.size() * size);
                for (std::size_t i = 0; i < times.size(); ++i)
                    self.sample(times.data()[i], found.data() + i * size);
                return nb::cast(array_of(found), nb::rv_policy::move);
            },
            nb::arg("times"))
        .def(
            "resting_state",
            [](const Motion& self, double at) { return numbers_of(self.resting_state_at(at)); },
            nb::arg("at"))
        .def(
            "run_to_impact",
            [](Motion& self, double until, double horizon) {
                const std::size_t known = self.impacts.size();
                run_while(self, horizon, nb::none(), kBetweenChecks,
                          [&] { return self.impacts.size() == known && self.t < until; });
            },
            nb::arg("until"), nb::arg("horizon"))
        .def("run", &run, nb::arg("until"), nb::arg("horizon"), nb::arg("on_time").none(),
             nb::arg("every"));
}

void bind_results(nb::class_<Motion>& motion) {
    motion
        .def_prop_ro("impact_times",
                     [](const Motion& self) {
                         std::vector<double> times;
                         for (const MotionImpact& impact : self.impacts) times.push_back(impact.t);
                         return times;
                     })
        .def_ro("t", &Motion::t)
        .def_ro("detail", &Motion::detail)
        .def_ro("begun", &Motion::begun)
        .def_prop_ro("ended", [](const Motion& self) { return static_cast<int>(self.ended); })
        .def_prop_ro("steps", &Motion::steps)
        .def_prop_ro("evaluations", [](Motion& self) { return self.dynamics().evaluations; })
        .def_prop_ro("q", [](const Motion& self) { return array(self.y.data(), self.nq()); })
        .def_prop_ro("v",
                     [](const Motion& self) { return array(self.y.data() + self.nq(), self.nv()); })
        .def_prop_ro("impacts",
                     [](const Motion& self) {
                         nb::list found;
                         for (const MotionImpact& impact : self.impacts)
                             found.append(impact_of(impact));
                         return found;
                     })
        // For all impacts: times, codes, v before and after, the contacts that touched, impulses.
        .def_prop_ro(
            "impact_table",
            [](const Motion& self) {
                const std::size_t contacts = self.scene().scene.contacts.size();
                std::vector<double> times, before, after, contact_gaps, impulses;
                std::vector<int> codes;
                for (const MotionImpact& impact : self.impacts) {
                    times.push_back(impact.t);
                    codes.push_back(static_cast<int>(impact.status));
                    before.insert(before.end(), impact.v.begin(), impact.v.end());
                    after.insert(after.end(), impact.after.begin(), impact.after.end());
                    std::vector<double> own(contacts);
                    for (int entry : impact.entries) own[entry] = 1.0;
                    contact_gaps.insert(contact_gaps.end(), own.begin(), own.end());
                    impulses.insert(impulses.end(), impact.impulses.begin(), impact.impulses.end());
                }
                return nb::make_tuple(array_of(times), codes, array_of(before), array_of(after),
                                      array_of(contact_gaps), array_of(impulses));
            })
        .def_prop_ro("rests",
                     [](const Motion& self) {
                         std::vector<std::tuple<int, double, double>> found;
                         for (const RestInterval& r : self.rests)
                             found.emplace_back(r.entry, r.start, r.end);
                         for (const RestInterval& r : self.resting())
                             found.emplace_back(r.entry, r.start, r.end);
                         return found;
                     })
        .def_prop_ro("path", &path_of);
}

}  // namespace
}  // namespace impulsekit

void bind_motion(nb::module_& module) {
    using namespace impulsekit;
    using Given = GivenMotionScene;
    bind_motion_scene(module);
    bind_forces_of_motion(module);
    nb::class_<Motion> motion(module, "Motion", "A motion on its way.");
    motion
        .def(
            "__init__",
            [](Motion* self, const Given& given, const std::string& method, const Array& numbers,
               const std::vector<double>& stop_times, int max_impacts, int max_steps,
               const Array& q, const Array& v) {
                const Model& model = *given.scene->scene.model;
                new (self) Motion(given.scene,
                                  settings_of(method, numbers, stop_times, max_impacts, max_steps),
                                  data_of(q, model.nq, "q"), data_of(v, model.nv, "v"));
            },
            nb::arg("scene"), nb::arg("method"), nb::arg("numbers"), nb::arg("stop_times"),
            nb::arg("max_impacts"), nb::arg("max_steps"), nb::arg("q"), nb::arg("v"),
            nb::keep_alive<1, 2>())
        .def("gaps_closed_at_start",
             [](Motion& self) {
                 std::vector<std::tuple<int, int, double, double>> found;
                 for (const auto& [gap, state] : self.gaps_closed_at_start())
                     found.emplace_back(gap, self.dynamics().contact_gaps.gaps()[gap].entry,
                                        state.gap, state.rate);
                 return found;
             })
        .def("is_driven_off", &Motion::is_driven_off)
        .def(
            "begin",
            [](Motion& self, const Array& v, const std::vector<int>& contact_gaps) {
                const int gaps = static_cast<int>(self.dynamics().contact_gaps.gaps().size());
                for (int gap : contact_gaps)
                    if (gap < 0 || gap >= gaps) throw nb::value_error("gaps: unknown gap");
                self.begin(data_of(v, self.nv(), "v"), contact_gaps);
            },
            nb::arg("v"), nb::arg("gaps"))
        .def(
            "copy", [](const Motion& self) { return Motion(self); }, nb::keep_alive<0, 1>())
        .def("rewind", &Motion::rewind, nb::arg("at"))
        .def("forget", &Motion::forget, nb::arg("before"));
    bind_progress(motion);
    bind_results(motion);
}
