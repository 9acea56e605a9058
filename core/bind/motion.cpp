// Motions, as Python runs and reads them.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/shared_ptr.h>

#include <chrono>
#include <optional>

#include "bind/fields.hpp"
#include "bind/motion_scene.hpp"
#include "bind/points.hpp"
#include "motion/advance.hpp"
#include "motion/columns.hpp"
#include "motion/forces_of_motion.hpp"
#include "motion/path.hpp"
#include "motion/start.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// Refuse what does not rest in a scene.
void check_rest(const RestingState& rest, const Dynamics& dynamics) {
    const std::vector<Gap>& gaps = dynamics.contact_gaps.gaps();
    for (const RestingContact& point : rest.points) {
        if (point.gap < 0 || point.gap >= static_cast<int>(gaps.size()))
            throw nb::value_error("points: unknown gap");
        const Gap& gap = gaps[point.gap];
        const Contact& contact = dynamics.scene.scene.contacts[gap.entry];
        if (gap.of_bodies() && !is_named(point.feature, contact.first, contact.other))
            throw nb::value_error("points: unknown feature of bodies");
    }
    if (rest.dry.size() != dynamics.scene.dry.size())
        throw nb::value_error("dry: must have one number for each joint with dry friction");
    if (!rest.controls.empty() &&
        rest.controls.size() != static_cast<std::size_t>(dynamics.scene.scene.model->nv))
        throw nb::value_error("controls: must have one number for each degree of freedom");
}

void check_gap(const Dynamics& dynamics, int gap) {
    if (gap < 0 || gap >= static_cast<int>(dynamics.contact_gaps.gaps().size()))
        throw nb::value_error("gaps: unknown gap");
}

// Forces of a motion behind checks of what Python gives.
struct GivenForces {
    ForcesOfMotion own;

    GivenForces(const GivenMotionScene& given, double slow) : own(given.scene, slow) {}
    const Dynamics& dynamics() const { return own.dynamics(); }
    void check(const Array& q, const Array& v) const { check_state(dynamics().scene, q, v); }
};

void bind_forces_at(nb::module_& module) {
    bind_enum<DynamicsFailure>(module, "DynamicsFailure", "none", DynamicsFailure::none,
                               "singular_mass", DynamicsFailure::singular_mass, "contradiction",
                               DynamicsFailure::contradiction, "rest_not_solved",
                               DynamicsFailure::rest_not_solved);
    using A = ForcesAt;
    Result<A>(module, "ForcesAt", "All forces at a state of a motion.")
        .parts("failure", &A::failure, "acceleration", &A::acceleration, "multipliers",
               &A::multipliers, "unique", &A::unique, "turning_of", &A::turning_of, "forces",
               &A::forces, "slip", &A::slip, "moments", &A::moments, "turning", &A::turning)
        .part("entries", [](const A& a) { return of_each(a.points, &Point::entry); })
        .part("signs", [](const A& a) { return of_each(a.points, &Point::sign); })
        .part("axes", [](const A& a) { return axes_of(a.points); })
        .part("places", [](const A& a) { return places_of(a.points, a.origin); });
    Result<GapAt>(module, "GapAt", "A gap at a state.")
        .parts("gap", &GapAt::gap, "entry", &GapAt::entry, "value", &GapAt::value, "rate",
               &GapAt::rate);
    using L = LoadsAt;
    Result<L>(module, "LoadsAt", "What forces make of joints and links, and each does.")
        .parts("loads", &L::loads, "weight", &L::weight, "row_velocities", &L::row_velocities,
               "torques", &L::torques, "wrenches", &L::wrenches, "power", &L::power);
}

void bind_forces_of_motion(nb::module_& module) {
    using F = GivenForces;
    nb::class_<F>(module, "ForcesOfMotion", "All forces at a state of a motion.")
        .def(nb::init<const GivenMotionScene&, double>(), nb::arg("scene"), nb::arg("slow"),
             nb::keep_alive<1, 2>())
        .def(
            "at",
            [](F& f, double t, const Array& q, const Array& v, const RestingState& rest) {
                f.check(q, v);
                check_rest(rest, f.dynamics());
                return f.own.at(t, q.data(), v.data(), rest);
            },
            nb::arg("t"), nb::arg("q"), nb::arg("v"), nb::arg("resting_state"))
        .def(
            "flow",
            [](F& f, double start, double end, const Array& q, const Array& v,
               const RestingState& rest, double rtol, double atol) {
                f.check(q, v);
                check_rest(rest, f.dynamics());
                const FlowEnd y = f.own.flow(start, end, q.data(), v.data(), rest, rtol, atol);
                using State = decltype(array_of(*y));
                return y ? std::optional<State>(array_of(*y)) : std::nullopt;
            },
            nb::arg("start"), nb::arg("end"), nb::arg("q"), nb::arg("v"), nb::arg("resting_state"),
            nb::arg("rtol"), nb::arg("atol"), "Return (nq + nv) the state at the end, or None.")
        .def(
            "loads",
            [](F& f, const Links& links, double t, const Array& q, const Array& v,
               const ForcesAt& at) {
                f.check(q, v);
                return f.own.loads(links, t, q.data(), v.data(), at);
            },
            nb::arg("links"), nb::arg("t"), nb::arg("q"), nb::arg("v"), nb::arg("forces"))
        .def(
            "gaps",
            [](F& f, const Array& q, const Array& v) {
                f.check(q, v);
                return f.own.gaps(q.data(), v.data());
            },
            nb::arg("q"), nb::arg("v"))
        .def(
            "gap_row",
            [](F& f, int gap, const Array& q, const Array& v) {
                f.check(q, v);
                check_gap(f.dynamics(), gap);
                return array_of(f.own.gap_row(gap, q.data(), v.data()));
            },
            nb::arg("gap"), nb::arg("q"), nb::arg("v"), nb::rv_policy::move)
        .def(
            "spring_energy",
            [](F& f, const Array& q) {
                return f.own.spring_energy(data_of(q, f.dynamics().scene.scene.model->nq, "q"));
            },
            nb::arg("q"));
}

void bind_resting_states(nb::module_& module) {
    Record<SlipState>(module, "SlipState", "Slip, rolling or spin of a contact.")
        .fields("moves", &SlipState::moves, "direction", &SlipState::direction);
    using C = RestingContact;
    Record<C>(module, "RestingContact", "A point that rests.")
        .fields("gap", &C::gap, "feature", &C::feature, "since", &C::since, "slip", &C::slip,
                "roll", &C::roll, "spin", &C::spin);
    using R = RestingState;
    Record<R>(module, "RestingState", "What rests, and torques from outside meanwhile.")
        .fields("points", &R::points, "dry", &R::dry)
        .array("controls", &R::controls);
}

void bind_settings(nb::module_& module) {
    bind_enum<Method>(module, "Method", "dop853", Method::dop853, "radau", Method::radau, "rk4",
                      Method::rk4, "semi_implicit", Method::semi_implicit);
    using S = MotionSettings;
    Record<S>(module, "MotionSettings", "How a motion is followed.")
        .fields("method", &S::method, "rtol", &S::rtol, "atol", &S::atol, "fixed_length",
                &S::fixed_length, "max_step", &S::max_step, "capture_speed", &S::capture_speed,
                "together", &S::together, "scale_of_time", &S::scale_of_time, "stop_times",
                &S::stop_times, "max_impacts", &S::max_impacts, "max_steps", &S::max_steps);
    bind_enum<Ended>(module, "Ended", "not_yet", Ended::not_yet, "finished", Ended::finished,
                     "event_storm", Ended::event_storm, "too_many_steps", Ended::too_many_steps,
                     "step_too_small", Ended::step_too_small, "not_finite", Ended::not_finite,
                     "impact_not_valid", Ended::impact_not_valid, "interrupted", Ended::interrupted,
                     "contradiction", Ended::contradiction, "rest_not_solved",
                     Ended::rest_not_solved, "penetration", Ended::penetration);
}

using Clock = std::chrono::steady_clock;

// Time between two looks at Ctrl-C: each takes Python's lock, for which threads wait.
constexpr Clock::duration kBetweenLooks = std::chrono::milliseconds(20);

// Steps, none beyond a horizon, while a condition holds; `on_time` is called with the time now and
// then, or after each step.
template <typename Condition>
void run_while(Motion& motion, double horizon, const nb::object& on_time, bool each_step,
               const Condition& goes_on) {
    motion.progress.counted = motion.stepper.steps;
    const bool has_callback = !on_time.is_none();
    const nb::gil_scoped_release free;
    Clock::time_point last = Clock::now();
    while (goes_on() && advance(motion, horizon)) {
        if (!each_step && Clock::now() - last < kBetweenLooks) continue;
        last = Clock::now();
        const nb::gil_scoped_acquire lock;
        if (PyErr_CheckSignals() != 0) throw nb::python_error();
        if (has_callback) on_time(motion.now.t);
    }
}

// On to a time, at least; whether it goes on from there.
bool run(Motion& motion, double until, double horizon, const nb::object& on_time, bool each_step) {
    run_while(motion, horizon, on_time, each_step, [&] { return motion.now.t < until; });
    return motion.ended == Ended::not_yet;
}

void run_to_impact(Motion& motion, double until, double horizon) {
    const std::size_t known = motion.impacts.size();
    run_while(motion, horizon, nb::none(), false,
              [&] { return motion.impacts.size() == known && motion.now.t < until; });
}

bool is_struck(Motion& motion, const std::vector<int>& gaps) {
    for (int gap : gaps) check_gap(motion.dynamics, gap);
    return is_struck_at_start(motion, gaps);
}

void begin(Motion& motion, const Array& v, const std::vector<int>& gaps) {
    for (int gap : gaps) check_gap(motion.dynamics, gap);
    begin_motion(motion, data_of(v, motion.nv(), "v"), gaps);
}

// q and v, normalized, at a time of the path.
auto arrays_at(const Motion& motion, double at) {
    std::vector<double> q(motion.nq()), v(motion.nv());
    state_at(motion, at, q.data(), v.data());
    return std::make_pair(array_of(q), array_of(v));
}

void bind_results(nb::module_& module) {
    using I = MotionImpact;
    Result<I>(module, "MotionImpact", "An impact on the way.")
        .parts("t", &I::t, "is_soft", &I::is_soft, "solved", &I::solved);
    Result<RestInterval>(module, "RestInterval", "From when to when a contact rested.")
        .parts("entry", &RestInterval::entry, "start", &RestInterval::start, "end",
               &RestInterval::end);
    Result<Path>(module, "Path", "The steps of a motion.")
        .parts("times", &Path::times, "before", &Path::before, "shape", &Path::shape,
               "resting_state", &Path::resting_state, "resting_states", &Path::resting_states);
    using C = ImpactColumns;
    Result<C>(module, "ImpactColumns", "Impacts by columns.")
        .parts("times", &C::times, "status", &C::status, "before", &C::before, "after", &C::after,
               "touching", &C::touching, "impulses", &C::impulses);
    using M = MotionColumns;
    Result<M>(module, "MotionColumns", "A motion that has ended.")
        .parts("t", &M::t, "evaluations", &M::evaluations, "end", &M::end, "samples", &M::samples,
               "impacts", &M::impacts, "rests", &M::rests);
}

}  // namespace
}  // namespace impulsekit

void bind_motion_scene(nb::module_& module);

void bind_motion(nb::module_& module) {
    using namespace impulsekit;
    bind_motion_scene(module);
    bind_resting_states(module);
    bind_forces_at(module);
    bind_forces_of_motion(module);
    bind_settings(module);
    bind_results(module);
    Result<Motion>(module, "Motion", "A motion on its way.")
        .part("t", [](const Motion& m) { return m.now.t; })
        .parts("detail", &Motion::detail, "begun", &Motion::begun, "ended", &Motion::ended,
               "impacts", &Motion::impacts, "rests", &rests_of)
        .part("steps", [](const Motion& m) { return m.stepper.steps; })
        .part("evaluations", [](const Motion& m) { return m.dynamics.evaluations; })
        .part("path", [](const Motion& m) { return Path(m); })
        .part("impact_times",
              [](const Motion& m) {
                  nb::list times;
                  for (const auto& impact : m.impacts) times.append(impact->t);
                  return times;
              })
        .def(
            "__init__",
            [](Motion* self, const GivenMotionScene& given, const MotionSettings& settings,
               const Array& q, const Array& v) {
                check_state(*given.scene, q, v);
                new (self) Motion(given.scene, settings, q.data(), v.data());
            },
            nb::arg("scene"), nb::arg("settings"), nb::arg("q"), nb::arg("v"),
            nb::keep_alive<1, 2>())
        .def("gaps_closed_at_start", &gaps_closed_at_start)
        .def("is_struck_at_start", &is_struck, nb::arg("gaps"))
        .def("begin", &begin, nb::arg("v"), nb::arg("gaps"))
        .def(
            "copy", [](const Motion& self) { return Motion(self); }, nb::keep_alive<0, 1>())
        .def("forget", &forget_before, nb::arg("before"))
        .def(
            "control",
            [](Motion& m, double at, const Array& torques) {
                const double* own = data_of(torques, m.nv(), "torques");
                rewind_to(m, at);
                control(m, own);
            },
            nb::arg("at"), nb::arg("torques"),
            "Set torques from a time on; what came after is lost.")
        .def("state", &arrays_at, nb::arg("at"))
        .def(
            "columns",
            [](const Motion& m, const Array& times) {
                const nb::gil_scoped_release free;
                return MotionColumns(m, times.data(), times.size());
            },
            nb::arg("times"), "Return all that is kept of it, with its states at times.")
        .def("resting_state", &resting_state_at, nb::arg("at"))
        .def("run_to_impact", &run_to_impact, nb::arg("until"), nb::arg("horizon"))
        .def("run", &run, nb::arg("until"), nb::arg("horizon"), nb::arg("on_time").none(),
             nb::arg("each_step"));
}
