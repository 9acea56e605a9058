#include "motion/forces_of_motion.hpp"

#include <algorithm>

#include "integrator/stepper.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {

ForcesOfMotion::ForcesOfMotion(std::shared_ptr<const MotionScene> scene, double slow)
    : scene_(std::move(scene)), model_(*scene_->scene.model), dynamics_(*scene_) {
    dynamics_.slow = slow;
}

void ForcesOfMotion::set_sides(const double* q, const double* v) {
    dynamics_.set_state(q, v);
    dynamics_.kinks.set_sides(dynamics_.tree, q, v);
}

ForcesAt ForcesOfMotion::at(double t, const double* q, const double* v, RestingState rest) {
    set_sides(q, v);
    ForcesAt found;
    found.acceleration.resize(model_.nv);
    found.failure = dynamics_.accelerate(t, q, v, rest, found.acceleration.data());
    found.multipliers = dynamics_.multipliers;
    found.unique = dynamics_.unique;
    found.forces = dynamics_.F;
    found.slip = dynamics_.slip;
    found.moments = dynamics_.moment;
    found.turning = dynamics_.turning;
    found.turning_of = dynamics_.turning_points;
    found.dry = dynamics_.dry_torque;
    for (const RestingContact& point : rest.points) {
        const Gap& gap = dynamics_.contact_gaps.gaps()[point.gap];
        found.entries.push_back(gap.entry);
        found.signs.push_back(gap.sign);
        const bool has_place = gap.of_bodies() || gap.of_frames();
        const FramePairMotion b = has_place
                                      ? dynamics_.contact_gaps.spot(dynamics_.tree, point, false)
                                      : FramePairMotion();
        const Vec place = dynamics_.tree.world_place(b.place);
        double axes[9];
        to_rows(b.axes, axes);
        found.axes.insert(found.axes.end(), axes, axes + 9);
        found.places.insert(found.places.end(), {place.x, place.y, place.z});
    }
    return found;
}

FlowEnd ForcesOfMotion::flow(double start, double end, const double* q, const double* v,
                             RestingState rest, double rtol, double atol) {
    const int nq = model_.nq, nv = model_.nv;
    std::vector<double> y(q, q + nq), trial(nq);
    y.insert(y.end(), v, v + nv);
    set_sides(q, v);
    const auto f = [&](double t, const double* from, double* to) {
        std::copy(from, from + nq, trial.begin());
        normalize_configuration(model_, trial.data());
        configuration_rate(model_, from, from + nq, to);
        return dynamics_.accelerate(t, trial.data(), from + nq, rest, to + nq) ==
               DynamicsFailure::none;
    };
    Stepper stepper(Method::dop853, nq, nq + nv, {rtol, atol}, 0.0);
    stepper.next = 1e-3 * (end - start);
    std::vector<double> rate(y.size());
    bool sound = f(start, y.data(), rate.data());
    Step step;
    // Rounding of times may leave less than any step.
    for (double t = start; sound && end - t > shortest_step(t); t = step.end)
        sound = stepper.step(
            f, [&](double* x) { normalize_configuration(model_, x); }, t, y.data(), rate.data(),
            end - t, step);
    return sound ? FlowEnd(std::move(y)) : std::nullopt;
}

ForceShare ForcesOfMotion::force(int entry, double t, const double* q, const double* v) {
    set_sides(q, v);
    ForceShare found;
    found.torques.resize(model_.nv);
    auto& wrench = dynamics_.tree.wrench;
    std::fill(wrench.begin(), wrench.end(), Spatial<double>{});
    add_forces(scene_->forces, dynamics_.kinks, entry, t, q, v, dynamics_.tree,
               found.torques.data());
    for (const Spatial<double>& own : wrench)
        found.wrenches.insert(found.wrenches.end(), {own.linear.x, own.linear.y, own.linear.z,
                                                     own.angular.x, own.angular.y, own.angular.z});
    return found;
}

std::vector<GapAt> ForcesOfMotion::gaps(const double* q, const double* v) {
    dynamics_.set_state(q, v);
    std::vector<GapAt> found;
    const auto& gaps = dynamics_.contact_gaps.gaps();
    for (std::size_t i = 0; i < gaps.size(); ++i) {
        const GapState at = dynamics_.contact_gaps.measure(dynamics_.tree, gaps[i], q, v);
        found.push_back({static_cast<int>(i), gaps[i].entry, at.gap, at.rate});
    }
    return found;
}

std::vector<double> ForcesOfMotion::gap_row(int gap, const double* q, const double* v) {
    dynamics_.set_state(q, v);
    RestingContact point;
    point.gap = gap;
    std::vector<double> J(3 * model_.nv), turning(3 * model_.nv);
    dynamics_.contact_gaps.rows(dynamics_.tree, point, q, v, {J.data(), turning.data()});
    return std::vector<double>(J.end() - model_.nv, J.end());
}

double ForcesOfMotion::spring_energy(const double* q) {
    const std::vector<double> still(model_.nv);
    dynamics_.set_state(q, still.data());
    return impulsekit::spring_energy(scene_->forces, dynamics_.tree, q);
}

std::vector<double> ForcesOfMotion::row_velocities(const double* q, const double* v) {
    dynamics_.set_state(q, v);
    dynamics_.constraints.fill_rows(dynamics_.tree, q);
    std::vector<double> found(dynamics_.constraints.rows());
    for (std::size_t r = 0; r < found.size(); ++r)
        found[r] = dot(dynamics_.constraints.A() + r * model_.nv, v, model_.nv);
    return found;
}

}  // namespace impulsekit
