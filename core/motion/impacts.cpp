// Impacts on the way of a motion, and those without collision where friction jams.
#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "impact/scene_impact.hpp"
#include "linalg/arena.hpp"
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
constexpr double kStill = 1e-8;
// If friction jams, points are pressed in by this part of the slip, or of what it is a sum of.
constexpr double kPressed[] = {1e-12, 1e-8, 1e-6}, kPressedOfSum = 1e-14;
// Changes of velocity so many times the pressing, and of this share of the slip, are an impact's.
constexpr double kAnImpact = 1e3, kOfSlip = 1e-7;
// If no forces hold a resting contact, slip below this [m/s] is stopped.
constexpr double kSlowSlip = 1e-5;

double sum_of(const double* row, const double* v, int nv) {
    double sum = 0.0;
    for (int i = 0; i < nv; ++i) sum += row[i] * v[i];
    return sum;
}

}  // namespace

std::vector<RestingContact> Motion::points_of_gaps(const std::vector<int>& gaps) {
    std::vector<RestingContact> found = rest_.points;
    for (int gap : gaps) {
        std::vector<RestingContact> own;
        for (double margin : kContactMargins) {
            dynamics_.contact_gaps.find_points(dynamics_.tree, gap, margin, own);
            if (!own.empty()) break;
        }
        for (RestingContact& point : own) {
            const bool known =
                std::any_of(found.begin(), found.end(), [&](const RestingContact& p) {
                    return p.gap == gap && p.feature == point.feature;
                });
            point.since = t;
            if (!known) found.push_back(point);
        }
    }
    std::stable_sort(
        found.begin(), found.end(),
        [](const RestingContact& a, const RestingContact& b) { return a.gap < b.gap; });
    return found;
}

// (3 (points + turning), nv) rows of points at the tree's state, then of the turning of some.
void Motion::write_rows(const std::vector<RestingContact>& points, std::vector<double>& J,
                        std::vector<int>& turning, bool in_units) {
    turning.clear();
    for (std::size_t i = 0; i < points.size(); ++i)
        if (dynamics_.contact_gaps.gaps()[points[i].gap].turns)
            turning.push_back(static_cast<int>(i));
    J.assign(3 * (points.size() + turning.size()) * nv(), 0.0);
    std::size_t next = points.size();
    for (std::size_t i = 0; i < points.size(); ++i) {
        const bool turns = dynamics_.contact_gaps.gaps()[points[i].gap].turns;
        dynamics_.contact_gaps.rows(
            dynamics_.tree, points[i], y.data(), y.data() + nq(),
            {J.data() + 3 * i * nv(), turns ? J.data() + 3 * next * nv() : nullptr}, in_units);
        next += turns;
    }
}

// v⁺ of the points at the tree's place, from v; its status.
Status Motion::solve(const std::vector<RestingContact>& points, const double* v, bool soft,
                     double* after) {
    const Scene& scene = scene_->scene;
    const int m = impact_rows_.rows();
    StateRows rows;
    for (const RestingContact& point : points) {
        StateRows::Point own{};
        own.entry = dynamics_.contact_gaps.gaps()[point.gap].entry;
        dynamics_.contact_gaps.friction_axis(dynamics_.tree, point, own.ellipse);
        rows.points.push_back(own);
    }
    write_rows(points, rows.J, rows.turning_of, false);
    impact_rows_.fill_rows(dynamics_.tree, y.data());
    rows.A.assign(impact_rows_.A(), impact_rows_.A() + m * nv());
    rows.target.resize(m);
    rows.wider.assign(impact_rows_.wider(), impact_rows_.wider() + m);
    std::vector<double> rates(m);
    impact_rows_.speeds(t, rows.target.data(), rates.data());
    for (int r = 0; r < m; ++r)
        if (scene.kept[r]) rows.target[r] = sum_of(rows.A.data() + r * nv(), v, nv());
    for (const Held& held : scene.held) {
        if (held.stop < 0) continue;
        // A stop that turns a controlled joint back is stiffer than its control.
        for (std::size_t i = 0; i < points.size(); ++i)
            if (rows.points[i].entry == held.stop &&
                sum_of(rows.J.data() + (3 * i + 2) * nv(), v, nv()) < 0.0) {
                rows.target[held.row] = 0.0;
                std::fill_n(rows.A.begin() + held.row * nv(), nv(), 0.0);
            }
    }
    const std::vector<double> M = dynamics_.mass_matrix(), none(scene.contacts.size(), 0.0);
    ImpactProblem p = problem_of(scene, rows, scene_->law.law);
    p.M = M.data();
    p.v = v;
    coefficients_.set(scene_->law, rows, soft ? none.data() : nullptr, nullptr, p.v, p.contact);
    solve_impact(p, solution_);
    for (int i = 0; i < nv(); ++i) after[i] = v[i] + solution_.dv[i];
    return status_of(solution_);
}

// (contacts, 3) the impulses that were just solved, on first bodies in the world, summed over the
// points of a contact; of joint stops in their joints, first.
std::vector<double> Motion::impulses_at(const std::vector<RestingContact>& points) {
    std::vector<double> found(3 * scene_->scene.contacts.size());
    // A problem that was refused has none.
    if (solution_.contact.impulse.size() < 3 * points.size()) return found;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const Gap& gap = dynamics_.contact_gaps.gaps()[points[i].gap];
        const double* P = solution_.contact.impulse.data() + 3 * i;
        const bool has_place = gap.kind != Contact::stop && gap.kind != Contact::functions;
        const Mat axes = has_place ? dynamics_.contact_gaps.spot(dynamics_.tree, points[i]).axes
                                   : FramePairMotion().axes;
        const Vec world = gap.kind == Contact::stop ? Vec{gap.sign * P[2], 0.0, 0.0}
                                                    : axes * Vec{P[0], P[1], P[2]};
        double* own = found.data() + 3 * gap.entry;
        own[0] += world.x, own[1] += world.y, own[2] += world.z;
    }
    return found;
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
    const std::vector<RestingContact> points = points_of_gaps(closing);
    std::vector<double> J;
    std::vector<int> turning;
    write_rows(points, J, turning);
    double approach = -INFINITY, capture = settings_.capture_speed;
    for (std::size_t i = 0; i < points.size(); ++i) {
        if (std::find(closing.begin(), closing.end(), points[i].gap) == closing.end()) continue;
        approach =
            std::max(approach, -sum_of(J.data() + (3 * i + 2) * nv(), y.data() + nq(), nv()));
        capture = std::max(capture, dynamics_.contact_gaps.gaps()[points[i].gap].capture);
    }
    for (int gap : closing) count_soft_impact(gap, approach < capture);
    if (!(approach > 0.0)) {
        // Nothing meets: a distance wavers, or what rests has its points elsewhere now.
        bool rests = false;
        for (const RestingContact& point : rest_.points)
            rests = rests || std::find(closing.begin(), closing.end(), point.gap) != closing.end();
        if (rests) return find_resting_contacts(points, true, slow_);
        for (int gap : closing) base_[gap] -= kWaver;
        restart();
        return ended == Ended::not_yet;
    }
    return apply_impact(points, approach, capture);
}

// The time, place and points of an impact at the tree's state.
MotionImpact Motion::impact_of(const std::vector<RestingContact>& points) const {
    MotionImpact impact;
    impact.t = t;
    impact.q.assign(y.begin(), y.begin() + nq());
    for (const RestingContact& point : points) {
        const Gap& gap = dynamics_.contact_gaps.gaps()[point.gap];
        if (impact.entries.empty() || impact.entries.back() != gap.entry)
            impact.entries.push_back(gap.entry);
        if (gap.kind != Contact::shapes) continue;
        impact.features.emplace_back(gap.entry, point.feature);
    }
    return impact;
}

// Counts impacts below the capture speed in quick succession.
void Motion::count_soft_impact(int gap, bool soft) {
    auto& [count, last] = soft_[gap];
    count = !soft ? 0 : t - last <= kQuick ? count + 1 : 1;
    last = t;
}

bool Motion::chatters(int gap) const { return soft_[gap].first >= kChatter; }

bool Motion::apply_impact(std::vector<RestingContact> points, double approach, double capture) {
    MotionImpact impact = impact_of(points);
    impact.is_soft = approach < capture;
    impact.after.resize(nv());
    impact.v.assign(y.begin() + nq(), y.end());
    impact.status = solve(points, impact.v.data(), impact.is_soft, impact.after.data());
    if (!is_valid(impact.status)) {
        // Points that lie still but for rounding lie still: restitution would ask what cannot be.
        std::vector<double> J, rows, change, dv(nv());
        std::vector<int> turning;
        write_rows(points, J, turning);
        for (std::size_t i = 0; i < points.size(); ++i) {
            const double* row = J.data() + (3 * i + 2) * nv();
            const double speed = sum_of(row, impact.v.data(), nv());
            if (!(std::abs(speed) < kStill) || speed == 0.0) continue;
            rows.insert(rows.end(), row, row + nv());
            change.push_back(-speed);
        }
        if (!change.empty() &&
            dynamics_.velocity_correction(rows.data(), static_cast<int>(change.size()),
                                          change.data(), dv.data())) {
            for (int i = 0; i < nv(); ++i) impact.v[i] += dv[i];
            impact.status = solve(points, impact.v.data(), impact.is_soft, impact.after.data());
        }
    }
    impact.impulses = impulses_at(points);
    const bool valid = is_valid(impact.status);
    // A captured contact makes no impact: another writing of the scene has another rounding there.
    if (!valid || approach >= settings_.capture_speed) impacts.push_back(impact);
    if (!valid) {
        ended = Ended::impact_not_valid;
        return false;
    }
    std::copy(impact.after.begin(), impact.after.end(), y.begin() + nq());
    stepper_.restart();
    return find_resting_contacts(points, true, slow_);
}

// Let go of points that are not pressed in without their forces; whether there were any. Sliding
// on, they would need forces without bound (Génot & Brogliato 1999, the singular point).
bool Motion::release_unloaded() {
    RestingState free = rest_;
    free.points.clear();
    std::vector<double> a(nv()), J(3 * nv()), turning(3 * nv());
    const double* v = y.data() + nq();
    if (dynamics_.accelerate(t, y.data(), v, free, a.data()) != DynamicsFailure::none) return false;
    std::vector<double> opening;
    double size = 0.0;
    for (const RestingContact& point : rest_.points) {
        double bias[3], more[3];
        dynamics_.contact_gaps.rows(dynamics_.tree, point, y.data(), v,
                                    {J.data(), turning.data(), bias, more});
        for (int j = 0; j < 3; ++j) bias[j] += sum_of(J.data() + j * nv(), a.data(), nv());
        size = std::max({size, std::abs(bias[0]), std::abs(bias[1]), std::abs(bias[2])});
        opening.push_back(bias[2]);
    }
    std::vector<RestingContact> stays;
    for (std::size_t i = 0; i < opening.size(); ++i)
        if (opening[i] < -tolerance::torn * size) stays.push_back(rest_.points[i]);
    if (stays.size() == opening.size()) return false;
    retain_contacts(stays);
    return true;
}

// Press points in by ever more until their impulses are those of an impact; `fastest` of slip and
// the sums that velocities of points consist of. False where none is.
bool Motion::press_in(const std::vector<RestingContact>& points, const std::vector<double>& J,
                      double fastest, double sums) {
    const int n = static_cast<int>(points.size());
    double* v = y.data() + nq();
    std::vector<double> rows, change, dv(nv()), trial(nv()), after(nv());
    for (double share : kPressed) {
        const double pressed = std::max(share * fastest, kPressedOfSum * sums);
        if (!(pressed > 0.0)) return false;
        rows.clear(), change.clear();
        for (int i = 0; i < n; ++i) {
            const double* row = J.data() + (3 * i + 2) * nv();
            rows.insert(rows.end(), row, row + nv());
            change.push_back(-sum_of(row, v, nv()) - pressed);
        }
        if (!dynamics_.velocity_correction(rows.data(), n, change.data(), dv.data())) return false;
        for (int i = 0; i < nv(); ++i) trial[i] = v[i] + dv[i];
        const Status status = solve(points, trial.data(), true, after.data());
        double most = 0.0;
        for (int r = 0; r < 3 * n; ++r)
            most = std::max(most, std::abs(sum_of(J.data() + r * nv(), after.data(), nv()) -
                                           sum_of(J.data() + r * nv(), trial.data(), nv())));
        if (!(most > std::max(kAnImpact * pressed, kOfSlip * fastest))) continue;
        MotionImpact impact = impact_of(points);
        impact.v = trial;
        impact.after = after;
        impact.is_soft = true;
        impact.status = status;
        impact.impulses = impulses_at(points);
        impacts.push_back(impact);
        if (!is_valid(status)) {
            ended = Ended::impact_not_valid;
            return false;
        }
        std::copy(after.begin(), after.end(), v);
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
    dynamics_.set_state(y.data(), y.data() + nq());
    const std::vector<RestingContact> points = rest_.points;
    const int n = static_cast<int>(points.size());
    double* v = y.data() + nq();
    std::vector<double> J, rows, change, dv(nv());
    std::vector<int> turning;
    write_rows(points, J, turning);
    double fastest = 0.0, sums = 0.0, slowest = 0.0;
    for (int i = 0; i < n; ++i) {
        const double* row = J.data() + 3 * i * nv();
        const double s0 = sum_of(row, v, nv()), s1 = sum_of(row + nv(), v, nv()),
                     speed = std::hypot(s0, s1), un = sum_of(row + 2 * nv(), v, nv());
        fastest = std::max({fastest, std::abs(s0), std::abs(s1)});
        double sum = 0.0, most = kSlowSlip;
        for (int k = 0; k < nv(); ++k) sum += std::abs(row[2 * nv() + k] * v[k]);
        sums = std::max(sums, sum);
        if (static_cast<int>(dynamics_.rate.size()) == 3 * n)
            most = std::max(most, tolerance::alike *
                                      std::hypot(dynamics_.rate[3 * i], dynamics_.rate[3 * i + 1]));
        rows.insert(rows.end(), row + 2 * nv(), row + 3 * nv());
        change.push_back(-un);
        if (!(speed > 0.0 && speed < most)) continue;
        slowest = std::max(slowest, speed);
        rows.insert(rows.end(), row, row + 2 * nv());
        change.insert(change.end(), {-s0, -s1});
    }
    if (slowest > tolerance::sums &&
        dynamics_.velocity_correction(rows.data(), static_cast<int>(change.size()), change.data(),
                                      dv.data())) {
        for (int i = 0; i < nv(); ++i) v[i] += dv[i];
        return find_resting_contacts(points, false, slow_);
    }
    return press_in(points, J, fastest, sums);
}

}  // namespace impulsekit
