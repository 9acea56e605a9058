#include "motion/forces_of_motion.hpp"

#include <algorithm>
#include <optional>

#include "integrator/stepper.hpp"
#include "scene/wrenches.hpp"
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
    if (rest.acts()) found.turning_of = dynamics_.turning_points;
    found.dry = dynamics_.dry_torque;
    found.forces.resize(3 * rest.points.size());
    found.moments.resize(3 * found.turning_of.size());
    found.origin = dynamics_.tree.origin[0];
    for (const RestingContact& point : rest.points) {
        const Gap& gap = dynamics_.contact_gaps.gaps()[point.gap];
        ContactFrame<double>& own = found.points.emplace_back();
        own.of_bodies = gap.of_bodies() || gap.of_frames();
        if (own.of_bodies)
            static_cast<FramePairState<double>&>(own) =
                dynamics_.contact_gaps.spot(dynamics_.tree, point, false);
        own.entry = gap.entry;
        own.sign = gap.sign;
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

// What the scene's forces do, one by one.
void ForcesOfMotion::add_forces(double t, const double* q, const double* v, const ForcesAt& at,
                                OuterWrenches& outside, LoadsAt& found) {
    const Tree<double>& tree = dynamics_.tree;
    const Scene& scene = scene_->scene;
    const int nv = model_.nv, count = static_cast<int>(scene_->forces.entries.size()),
              before = static_cast<int>(scene.held.size() + scene.contacts.size());
    found.torques.resize(nv * count);
    for (int i = 0; i < count; ++i) {
        double* torques = found.torques.data() + nv * i;
        add_torques(scene_->forces, dynamics_.kinks, i, t, q, v, torques);
        const ForceEntry& entry = scene_->forces.entries[i];
        if (entry.kind == ForceEntry::dry && entry.bound > 0.0) {
            const DryJoint& joint = scene_->dry[entry.index];
            torques[joint.v] += entry.bound / joint.bound * at.dry[entry.index];
        }
        double power = dot<double>(torques, v, nv);
        std::optional<Spatial<double>> at_point;
        add_wrenches(scene_->forces, dynamics_.kinks, i, t, q, v, tree,
                     [&](const Site& site, const Spatial<double>& own) {
                         outside.add(before + i, site.body, site.frame, own);
                         power += dot(tree.twist[site.body], own);
                         const Vec3<double> arm =
                             tree.rotation[site.body] * vec3<double>(site.point);
                         if (!at_point) at_point = wrench_about(own, -arm);
                     });
        append(found.wrenches, at_point.value_or(Spatial<double>()));
        found.power.push_back(power);
    }
}

LoadsAt ForcesOfMotion::loads(const Links& links, double t, const double* q, const double* v,
                              const ForcesAt& at) {
    set_sides(q, v);
    dynamics_.set_state(q, v, true);
    Tree<double>& tree = dynamics_.tree;
    const Scene& scene = scene_->scene;
    OuterWrenches outside(
        tree, links, scene.held.size() + scene.contacts.size() + scene_->forces.entries.size());
    const std::vector<double> moments =
        moments_by_point(at.points.size(), at.turning_of, at.moments.data());
    for_wrenches<double>(scene, tree, at.points,
                         {nullptr, at.multipliers.data(), at.forces.data(), moments.data()},
                         [&](int entry, const Site& site, const Spatial<double>& wrench) {
                             outside.add(entry, site.body, site.frame, wrench);
                         });
    LoadsAt found;
    dynamics_.constraints.fill_rows(tree, q);
    for (int r = 0; r < dynamics_.constraints.rows(); ++r)
        found.row_velocities.push_back(
            dot(dynamics_.constraints.A() + r * model_.nv, v, model_.nv));
    add_forces(t, q, v, at, outside, found);
    std::vector<Spatial<double>> accelerations(tree.count());
    tree.move(at.acceleration.data(), accelerations);
    for (int k = 0; k < tree.count(); ++k) accelerations[k] += tree.rate[k];
    Spatial<double> weight;
    for (int k = 1; k < tree.count(); ++k) {
        const Inertia<double> own = tree.in_world(k, inertia_of<double>(model_.bodies[k]));
        const Spatial<double> falls{vec3<double>(scene_->gravity), {}};
        weight += wrench_about(own * falls, tree.world_place(tree.origin[k]));
    }
    append(found.weight, weight);
    found.loads = find_loads(outside, accelerations, true);
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

}  // namespace impulsekit
