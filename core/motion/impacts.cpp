// Impacts on the way of a motion, and those without collision where friction jams.
#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "motion/motion.hpp"

namespace impulsekit {
namespace {

// Bodies touch at points so near [m]; where they are told less well, at the nearest of these.
constexpr double kContactMargins[] = {1e-8, 1e-7, 1e-6, 1e-5};
// So many impacts below the capture speed, none later than this [s] after the one before, are
// chatter: two ends of an edge that rests lift each other in turn, by ever the same speed.
constexpr int kChatter = 8;
constexpr double kQuick = 1e-3;
// Points that touch and move more slowly against each other lie still [m/s].
constexpr double kStill = 2.0 * kLifted;
// If friction jams, points are pressed in by this part of the slip, or by rounding of what it is a
// sum of.
constexpr double kPressed[] = {1e-12, 1e-8, 1e-6};
// Changes of velocity so many times the pressing, and beyond the edge of the slip, are an impact's.
constexpr double kAnImpact = 1e3;

}  // namespace

std::vector<RestingContact> Motion::points_of_gaps(const std::vector<int>& gaps) {
    std::vector<RestingContact> found = now.rest.points;
    for (int gap : gaps) {
        std::vector<RestingContact> own;
        for (double margin : kContactMargins) {
            dynamics_.contact_gaps.find_points(dynamics_.tree, gap, margin, own);
            if (!own.empty()) break;
        }
        for (RestingContact& point : own) {
            const bool known =
                std::any_of(found.begin(), found.end(),
                            [&](const RestingContact& p) { return p.is_same_point(point); });
            point.since = now.t;
            if (!known) found.push_back(point);
        }
    }
    std::stable_sort(
        found.begin(), found.end(),
        [](const RestingContact& a, const RestingContact& b) { return a.gap < b.gap; });
    return found;
}

// (3 (points + turning), nv) rows of points at the tree's state, then of the turning of some.
std::vector<double> Motion::rows_of(const std::vector<RestingContact>& points) {
    const auto turning = std::count_if(points.begin(), points.end(),
                                       [&](const RestingContact& p) { return gap(p.gap).turns; });
    const std::size_t block = 3 * nv();
    std::vector<double> J((points.size() + turning) * block);
    double *to = J.data(), *turns = to + points.size() * block;
    for (const RestingContact& point : points) {
        dynamics_.contact_gaps.rows(dynamics_.tree, point, now.q(), now.v(),
                                    {to, gap(point.gap).turns ? turns : nullptr});
        to += block;
        if (gap(point.gap).turns) turns += block;
    }
    return J;
}

// The acceleration of a point in its axes, of a; the tree with rates at no joint acceleration.
Vec Motion::acceleration_of(const RestingContact& point, const double* a) const {
    std::vector<double> J(6 * nv());
    double bias[6];
    dynamics_.contact_gaps.rows(dynamics_.tree, point, now.q(), now.v(),
                                {J.data(), J.data() + 3 * nv(), bias, bias + 3});
    for (int j = 0; j < 3; ++j) bias[j] += dot(J.data() + j * nv(), a, nv());
    return vec3<double>(bias);
}

// The impact of points at this place, from v.
SceneImpact Motion::solve(const std::vector<RestingContact>& points, const std::vector<double>& v,
                          bool soft) const {
    const Scene& scene = scene_->scene;
    SceneImpact impact;
    impact.q.assign(now.y.begin(), now.y.begin() + nq());
    impact.v = v;
    std::vector<char> only(scene.contacts.size());
    std::vector<std::pair<int, Feature>> features;
    for (const RestingContact& point : points) {
        const Gap& gap = this->gap(point.gap);
        only[gap.entry] = 1;
        if (gap.kind == Contact::shapes) features.emplace_back(gap.entry, point.feature);
    }
    const int block = 1 + 3 * nv();
    std::vector<double> rows(scene.function_rows * nv()), gaps(scene.function_contacts * block);
    if (scene.function_rows > 0) scene_->constraints.rows(impact.q.data(), rows.data());
    for (int i = 0; i < scene.function_contacts; ++i)
        scene_->contact_gaps.rows(i, impact.q.data(), gaps.data() + i * block);
    fill_scene(scene, {rows.data(), gaps.data(), nullptr, only.data(), &features}, impact);
    // Velocities that are driven in time are those of now.
    const int m = dynamics_.constraints.rows();
    std::vector<double> speeds(m), rates(m);
    dynamics_.constraints.speeds(now.t, speeds.data(), rates.data());
    for (int r = 0; r < m; ++r)
        if (!scene.kept[r]) impact.rows.target[r] = speeds[r];
    const std::vector<double> none(scene.contacts.size());
    solve_scene(scene, scene_->law, soft ? none.data() : nullptr, impact);
    return impact;
}

// Keep an impact, unless it is none, and go on with v⁺; false where it is not valid.
bool Motion::go_on_after(SceneImpact impact, bool soft, bool is_kept) {
    const bool valid = is_valid(status_of(impact.solution));
    for (int i = 0; valid && i < nv(); ++i) now.v()[i] = impact.v[i] + impact.solution.dv[i];
    if (!valid) ended = Ended::impact_not_valid;
    if (!valid || is_kept)
        impacts.push_back(
            std::make_shared<const MotionImpact>(MotionImpact{now.t, soft, std::move(impact)}));
    return valid;
}

// False where the motion has had all its impacts, which ends it.
bool Motion::has_impacts_left() {
    if (static_cast<int>(impacts.size()) < settings_.max_impacts) return true;
    ended = Ended::event_storm;
    detail = "max_impacts is " + std::to_string(settings_.max_impacts);
    return false;
}

// An impact of what closes, with all that rests taking part.
bool Motion::close_gaps(const std::vector<int>& closing) {
    if (!has_impacts_left()) return false;
    // The polynomial within a step knows nothing of what holds and rests.
    if (now.rest.acts() || dynamics_.constraints.rows() > 0) correct_drift(false);
    const std::vector<RestingContact> points = points_of_gaps(closing);
    double approach = -INFINITY, capture = settings_.capture_speed;
    for (const RestingContact& point : points) {
        if (std::find(closing.begin(), closing.end(), point.gap) == closing.end()) continue;
        approach = std::max(approach, -velocity_of(point, now.q()).linear.z);
        capture = std::max(capture, gap(point.gap).capture);
    }
    for (int gap : closing) count_soft_impact(gap, approach < capture);
    if (!(approach > 0.0)) {
        // Nothing meets: a distance wavers, or what rests has its points elsewhere now.
        if (std::any_of(closing.begin(), closing.end(),
                        [this](int gap) { return now.rest.rests_on(gap); }))
            return find_resting_contacts(points, true, slow_);
        for (int gap : closing) base_[gap] -= kWaver;
        restart();
        return ended == Ended::not_yet;
    }
    return apply_impact(points, approach, capture);
}

// Counts impacts below the capture speed in quick succession.
void Motion::count_soft_impact(int gap, bool soft) {
    auto& [count, last] = soft_[gap];
    count = !soft ? 0 : now.t - last <= kQuick ? count + 1 : 1;
    last = now.t;
}

bool Motion::chatters(int gap) const { return soft_[gap].first >= kChatter; }

bool Motion::apply_impact(std::vector<RestingContact> points, double approach, double capture) {
    const bool soft = approach < capture;
    std::vector<double> v(now.y.begin() + nq(), now.y.end());
    SceneImpact impact = solve(points, v, soft);
    if (!is_valid(status_of(impact.solution))) {
        // Points that lie still but for rounding lie still: restitution would ask what cannot be.
        const std::vector<double> J = rows_of(points);
        Correction still;
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double *row = J.data() + (3 * i + 2) * nv(),
                         speed = dot<double>(row, v.data(), nv());
            if (std::abs(speed) < kStill && speed != 0.0) still.add(row, nv(), -speed);
        }
        if (!still.change.empty() && dynamics_.correct(still, v.data()))
            impact = solve(points, v, soft);
    }
    // A captured contact makes no impact: another writing of the scene has another rounding there.
    if (!go_on_after(std::move(impact), soft, approach >= settings_.capture_speed)) return false;
    stepper_.restart();
    return find_resting_contacts(points, true, slow_);
}

// Let go of points that are not pressed in without their forces; whether there were any. Sliding
// on, they would need forces without bound (Génot & Brogliato 1999, the singular point).
bool Motion::release_unloaded() {
    RestingState free = now.rest;
    free.points.clear();
    std::vector<double> a(nv()), opening;
    if (dynamics_.accelerate(now.t, now.q(), now.v(), free, a.data()) != DynamicsFailure::none)
        return false;
    double size = 0.0;
    for (const RestingContact& point : now.rest.points) {
        const Vec own = acceleration_of(point, a.data());
        size = std::max({size, std::abs(own.x), std::abs(own.y), std::abs(own.z)});
        opening.push_back(own.z);
    }
    std::vector<RestingContact> stays;
    for (std::size_t i = 0; i < opening.size(); ++i)
        if (opening[i] < -tolerance::torn * size) stays.push_back(now.rest.points[i]);
    if (stays.size() == opening.size()) return false;
    retain_contacts(stays);
    return true;
}

// Press points in by ever more until their impulses are those of an impact; `fastest` of slip and
// the sums that velocities of points consist of. False where none is.
bool Motion::press_in(const std::vector<RestingContact>& points, const std::vector<double>& J,
                      double fastest, double sums) {
    const int n = static_cast<int>(points.size());
    for (double share : kPressed) {
        const double pressed = std::max(share * fastest, tolerance::sums * sums);
        if (!(pressed > 0.0)) return false;
        Correction press;
        for (int i = 0; i < n; ++i) {
            const double* row = J.data() + (3 * i + 2) * nv();
            press.add(row, nv(), -dot<double>(row, now.v(), nv()) - pressed);
        }
        std::vector<double> trial(now.v(), now.v() + nv());
        if (!dynamics_.correct(press, trial.data())) return false;
        SceneImpact impact = solve(points, trial, true);
        double most = 0.0;
        for (int r = 0; r < 3 * n; ++r)
            most =
                std::max(most, std::abs(dot(J.data() + r * nv(), impact.solution.dv.data(), nv())));
        if (!(most > std::max(kAnImpact * pressed, tolerance::edge * fastest))) continue;
        if (!go_on_after(std::move(impact), true, true)) return false;
        return find_resting_contacts(points, false, slow_);
    }
    return false;
}

// If W_nn <= µ W_nt·s no force keeps a sliding contact from being pressed in (Painlevé 1895). It
// stops by an impact without collision (Lecornu 1905; Génot & Brogliato 1999): the limit of impacts
// whose approach goes to zero, without restitution.
bool Motion::impact_without_collision() {
    if (!has_impacts_left()) return false;
    if (release_unloaded()) return update_rest();
    set_state();
    const std::vector<RestingContact> points = now.rest.points;
    const int n = static_cast<int>(points.size());
    const double* v = now.v();
    const std::vector<double> J = rows_of(points);
    Correction stop;
    double fastest = 0.0, sums = 0.0, slowest = 0.0;
    for (int i = 0; i < n; ++i) {
        const double* row = J.data() + 3 * i * nv();
        const double s0 = dot(row, v, nv()), s1 = dot(row + nv(), v, nv()),
                     speed = std::hypot(s0, s1);
        fastest = std::max({fastest, std::abs(s0), std::abs(s1)});
        double sum = 0.0, most = kCreeps;
        for (int k = 0; k < nv(); ++k) sum += std::abs(row[2 * nv() + k] * v[k]);
        sums = std::max(sums, sum);
        if (static_cast<int>(dynamics_.rate.size()) == 3 * n)
            most = std::max(most, tolerance::alike *
                                      std::hypot(dynamics_.rate[3 * i], dynamics_.rate[3 * i + 1]));
        stop.add(row + 2 * nv(), nv(), -dot(row + 2 * nv(), v, nv()));
        if (!(speed > 0.0 && speed < most)) continue;
        slowest = std::max(slowest, speed);
        stop.add(row, nv(), -s0);
        stop.add(row + nv(), nv(), -s1);
    }
    if (slowest > tolerance::sums && dynamics_.correct(stop, now.v()))
        return find_resting_contacts(points, false, slow_);
    return press_in(points, J, fastest, sums);
}

}  // namespace impulsekit
