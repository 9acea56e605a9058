#include "motion/impacts.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/dense.hpp"
#include "motion/drift.hpp"
#include "motion/resting.hpp"

namespace impulsekit {
namespace {

// Bodies touch at points so near [m]; where they are told less well, at the nearest of these.
constexpr double kContactMargins[] = {1e-8, 1e-7, 1e-6, 1e-5};
// Impacts in quick succession come no later than this after the one before [s].
constexpr double kQuick = 1e-3;
// Points that touch and move more slowly against each other lie still [m/s].
constexpr double kStill = 2.0 * kLifted;
// If friction jams, points are pressed in by this part of the slip, or by rounding of what it is a
// sum of.
constexpr double kPressed[] = {1e-12, 1e-8, 1e-6};
// Changes of velocity so many times the pressing, and beyond the edge of the slip, are an impact's.
constexpr double kAnImpact = 1e3;

// The impact of points at this place, from v.
SceneImpact solve_impact(const Motion& motion, const std::vector<RestingContact>& points,
                         const std::vector<double>& v, bool soft) {
    const MotionState& now = motion.now;
    const Scene& scene = motion.scene->scene;
    SceneImpact impact;
    impact.q.assign(now.y.begin(), now.y.begin() + motion.nq());
    impact.v = v;
    std::vector<char> only(scene.contacts.size());
    std::vector<std::pair<int, Feature>> features;
    for (const RestingContact& point : points) {
        const Gap& gap = motion.gap(point.gap);
        only[gap.entry] = 1;
        if (gap.kind == Contact::shapes) features.emplace_back(gap.entry, point.feature);
    }
    const int block = 1 + 3 * motion.nv();
    std::vector<double> rows(scene.function_rows * motion.nv()),
        gaps(scene.function_contacts * block);
    if (scene.function_rows > 0) motion.scene->constraints.rows(impact.q.data(), rows.data());
    for (int i = 0; i < scene.function_contacts; ++i)
        motion.scene->contact_gaps.rows(i, impact.q.data(), gaps.data() + i * block);
    fill_scene(scene, {rows.data(), gaps.data(), nullptr, only.data(), &features}, impact);
    // Velocities that are driven in time are those of now.
    const int m = motion.dynamics.constraints.rows();
    std::vector<double> speeds(m), rates(m);
    motion.dynamics.constraints.speeds(now.t, speeds.data(), rates.data());
    for (int r = 0; r < m; ++r)
        if (!scene.kept[r]) impact.rows.target[r] = speeds[r];
    const std::vector<double> none(scene.contacts.size());
    solve_scene(scene, motion.scene->law, soft ? none.data() : nullptr, impact);
    return impact;
}

// Keep an impact, unless it is none, and go on with v⁺; false where it is not valid.
bool go_on_after(Motion& motion, SceneImpact impact, bool soft, bool is_kept) {
    const bool valid = is_valid(status_of(impact.solution));
    for (int i = 0; valid && i < motion.nv(); ++i)
        motion.now.v()[i] = impact.v[i] + impact.solution.dv[i];
    if (!valid) motion.ended = Ended::impact_not_valid;
    if (!valid || is_kept)
        motion.impacts.push_back(std::make_shared<const MotionImpact>(
            MotionImpact{motion.now.t, soft, std::move(impact)}));
    return valid;
}

// False where the motion has had all its impacts, which ends it.
bool has_impacts_left(Motion& motion) {
    if (static_cast<int>(motion.impacts.size()) < motion.settings.max_impacts) return true;
    motion.ended = Ended::event_storm;
    motion.detail = "max_impacts is " + std::to_string(motion.settings.max_impacts);
    return false;
}

// Counts impacts below the capture speed in quick succession.
void count_soft_impact(Motion& motion, int gap, bool soft) {
    GapMemory& known = motion.memory[gap];
    known.soft = !soft ? 0 : motion.now.t - known.last_soft <= kQuick ? known.soft + 1 : 1;
    known.last_soft = motion.now.t;
}

bool apply_impact(Motion& motion, std::vector<RestingContact> points, double approach,
                  double capture) {
    const bool soft = approach < capture;
    std::vector<double> v(motion.now.y.begin() + motion.nq(), motion.now.y.end());
    SceneImpact impact = solve_impact(motion, points, v, soft);
    if (!is_valid(status_of(impact.solution))) {
        // Points that lie still but for rounding lie still: restitution would ask what cannot be.
        const std::vector<double> J = rows_of(motion, points);
        Correction still;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double *row = J.data() + (3 * i + 2) * motion.nv(),
                         speed = dot<double>(row, v.data(), motion.nv());
            if (std::abs(speed) < kStill && speed != 0.0) still.add(row, motion.nv(), -speed);
        }
        if (!still.change.empty() && motion.dynamics.correct(still, v.data()))
            impact = solve_impact(motion, points, v, soft);
    }
    // A captured contact makes no impact: another writing of the scene has another rounding there.
    if (!go_on_after(motion, std::move(impact), soft, approach >= motion.settings.capture_speed))
        return false;
    motion.stepper.restart();
    return find_resting_contacts(motion, points, true, motion.slow);
}

// Let go of points that are not pressed in without their forces; whether there were any. Sliding
// on, they would need forces without bound (Génot & Brogliato 1999, the singular point).
bool release_unloaded(Motion& motion) {
    MotionState& now = motion.now;
    RestingState free = now.rest;
    free.points.clear();
    std::vector<double> a(motion.nv()), opening;
    if (motion.dynamics.accelerate(now.t, now.q(), now.v(), free, a.data()) !=
        DynamicsFailure::none)
        return false;
    double size = 0.0;
    for (const RestingContact& point : now.rest.points) {
        const Vec own = acceleration_of(motion, point, a.data());
        size = std::max({size, std::abs(own.x), std::abs(own.y), std::abs(own.z)});
        opening.push_back(own.z);
    }
    std::vector<RestingContact> stays;
    for (std::size_t i = 0; i < opening.size(); ++i)
        if (opening[i] < -tolerance::torn * size) stays.push_back(now.rest.points[i]);
    if (stays.size() == opening.size()) return false;
    retain_contacts(motion, stays);
    return true;
}

// Press points in by ever more until their impulses are those of an impact; `fastest` of slip and
// the sums that velocities of points consist of. False where none is.
bool press_in(Motion& motion, const std::vector<RestingContact>& points,
              const std::vector<double>& J, double fastest, double sums) {
    MotionState& now = motion.now;
    const int n = static_cast<int>(points.size());
    for (double share : kPressed) {
        const double pressed = std::max(share * fastest, tolerance::sums * sums);
        if (!(pressed > 0.0)) return false;
        Correction press;
        for (int i = 0; i < n; ++i) {
            const double* row = J.data() + (3 * i + 2) * motion.nv();
            press.add(row, motion.nv(), -dot<double>(row, now.v(), motion.nv()) - pressed);
        }
        std::vector<double> trial(now.v(), now.v() + motion.nv());
        if (!motion.dynamics.correct(press, trial.data())) return false;
        SceneImpact impact = solve_impact(motion, points, trial, true);
        double most = 0.0;
        for (int r = 0; r < 3 * n; ++r)
            most = std::max(most, std::abs(dot(J.data() + r * motion.nv(),
                                               impact.solution.dv.data(), motion.nv())));
        if (!(most > std::max(kAnImpact * pressed, tolerance::edge * fastest))) continue;
        if (!go_on_after(motion, std::move(impact), true, true)) return false;
        return find_resting_contacts(motion, points, false, motion.slow);
    }
    return false;
}

}  // namespace

std::vector<RestingContact> points_of_gaps(Motion& motion, const std::vector<int>& gaps) {
    std::vector<RestingContact> found = motion.now.rest.points;
    for (int gap : gaps) {
        std::vector<RestingContact> own;
        for (double margin : kContactMargins) {
            motion.dynamics.contact_gaps.find_points(motion.dynamics.tree, gap, margin, own);
            if (!own.empty()) break;
        }
        for (RestingContact& point : own) {
            const bool known =
                std::any_of(found.begin(), found.end(),
                            [&](const RestingContact& p) { return p.is_same_point(point); });
            point.since = motion.now.t;
            if (!known) found.push_back(point);
        }
    }
    std::stable_sort(
        found.begin(), found.end(),
        [](const RestingContact& a, const RestingContact& b) { return a.gap < b.gap; });
    return found;
}

bool close_gaps(Motion& motion, const std::vector<int>& closing) {
    MotionState& now = motion.now;
    if (!has_impacts_left(motion)) return false;
    // The polynomial within a step knows nothing of what holds and motion.rests.
    if (now.rest.acts() || motion.dynamics.constraints.rows() > 0) correct_drift(motion, false);
    const std::vector<RestingContact> points = points_of_gaps(motion, closing);
    double approach = -INFINITY, capture = motion.settings.capture_speed;
    for (const RestingContact& point : points) {
        if (std::find(closing.begin(), closing.end(), point.gap) == closing.end()) continue;
        approach = std::max(approach, -velocity_of(motion, point, now.q()).linear.z);
        capture = std::max(capture, motion.gap(point.gap).capture);
    }
    for (int gap : closing) count_soft_impact(motion, gap, approach < capture);
    if (!(approach > 0.0)) {
        // Nothing meets: a distance wavers, or what motion.rests has its points elsewhere now.
        if (std::any_of(closing.begin(), closing.end(),
                        [&](int gap) { return now.rest.rests_on(gap); }))
            return find_resting_contacts(motion, points, true, motion.slow);
        for (int gap : closing) motion.memory[gap].base -= kWaver;
        restart(motion);
        return motion.ended == Ended::not_yet;
    }
    return apply_impact(motion, points, approach, capture);
}

bool impact_without_collision(Motion& motion) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    if (!has_impacts_left(motion)) return false;
    if (release_unloaded(motion)) return update_rest(motion);
    set_state(motion);
    const std::vector<RestingContact> points = now.rest.points;
    const int n = static_cast<int>(points.size());
    const double* v = now.v();
    const std::vector<double> J = rows_of(motion, points);
    Correction stop;
    double fastest = 0.0, sums = 0.0, slowest = 0.0;
    for (int i = 0; i < n; ++i) {
        const double* row = J.data() + 3 * i * motion.nv();
        const double s0 = dot(row, v, motion.nv()), s1 = dot(row + motion.nv(), v, motion.nv()),
                     speed = std::hypot(s0, s1);
        fastest = std::max({fastest, std::abs(s0), std::abs(s1)});
        double sum = 0.0, most = kCreeps;
        for (int k = 0; k < motion.nv(); ++k) sum += std::abs(row[2 * motion.nv() + k] * v[k]);
        sums = std::max(sums, sum);
        if (static_cast<int>(dynamics.rate.size()) == 3 * n)
            most = std::max(most, tolerance::alike *
                                      std::hypot(dynamics.rate[3 * i], dynamics.rate[3 * i + 1]));
        stop.add(row + 2 * motion.nv(), motion.nv(), -dot(row + 2 * motion.nv(), v, motion.nv()));
        if (!(speed > 0.0 && speed < most)) continue;
        slowest = std::max(slowest, speed);
        stop.add(row, motion.nv(), -s0);
        stop.add(row + motion.nv(), motion.nv(), -s1);
    }
    if (slowest > tolerance::sums && dynamics.correct(stop, now.v()))
        return find_resting_contacts(motion, points, false, motion.slow);
    return press_in(motion, points, J, fastest, sums);
}

}  // namespace impulsekit
