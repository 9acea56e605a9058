// Contacts come to rest, slide, keep still and let go.
#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"
#include "motion/motion.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {
namespace {

// The gap of a contact that was torn off may waver by this [m].
constexpr double kGrazed = tolerance::solved;
// Rounding of places, of their size.
constexpr double kRounded = 2.0 * tolerance::rounding;
constexpr int kMostSteps = 3;

}  // namespace

std::vector<GapAt> Motion::gaps_closed_at_start() {
    std::vector<GapAt> found;
    set_state();
    for (int i = 0; i < gap_count(); ++i) {
        const GapState state = gap_now(i);
        if (!(state.gap <= tolerance::alike)) continue;
        if (counts_now(i))
            found.push_back({i, gap(i).entry, state.gap, state.rate});
        else
            passing_[i] = state.gap < -tolerance::alike;
    }
    return found;
}

bool Motion::is_struck_at_start(const std::vector<int>& closed) {
    const double slow =
        std::max(kSlowShare * settings_.capture_speed, tolerance::at_rest * fastest());
    set_state();
    return std::any_of(closed.begin(), closed.end(),
                       [&](int i) { return gap_now(i).rate < -slow; }) ||
           is_driven_off();
}

// True if a constraint prescribes another velocity than it has; the tree with places.
bool Motion::is_driven_off() {
    const int m = dynamics_.constraints.rows();
    if (m == 0) return false;
    dynamics_.constraints.fill_rows(dynamics_.tree, now.q());
    std::vector<double> speed(m), rate(m);
    dynamics_.constraints.speeds(0.0, speed.data(), rate.data());
    double missing = 0.0, scale = 0.0;
    for (int r = 0; r < m; ++r) {
        const double* row = dynamics_.constraints.A() + r * nv();
        double sum = 0.0;
        for (int i = 0; i < nv(); ++i) sum += std::abs(row[i] * now.v()[i]);
        scale = std::max({scale, sum, std::abs(speed[r])});
        if (!scene_->scene.kept[r])
            missing = std::max(missing, std::abs(speed[r] - dot(row, now.v(), nv())));
    }
    return missing > tolerance::residual * scale;
}

void Motion::begin(const double* v, const std::vector<int>& contact_gaps) {
    std::copy(v, v + nv(), now.y.begin() + nq());
    set_state();
    if (dynamics_.constraints.rows() > 0)
        dynamics_.constraints.start(dynamics_.tree, now.q(), now.v());
    dynamics_.kinks.set_sides(dynamics_.tree, now.q(), now.v());
    rebase();
    // Slip that was given is kept, be it below the capture speed.
    find_resting_contacts(points_of_gaps(contact_gaps), false, kNoSlip);
    begun = true;
}

// The candidates that rest: those that part no faster than the capture speed; they stick
// where it slips no faster than `no_slip`.
bool Motion::find_resting_contacts(const std::vector<RestingContact>& candidates, bool lay,
                                   double no_slip) {
    set_state();
    const double slow = std::max(settings_.capture_speed, tolerance::at_rest * fastest());
    const std::vector<RestInterval> before = resting();
    std::vector<RestingContact> parted;
    now.rest.points.clear();
    for (const RestingContact& point : candidates) {
        const Gap& own = gap(point.gap);
        const double opening = velocity_of(point, now.q()).linear.z,
                     most = std::max(slow, chatters(point.gap) ? own.capture : own.rests);
        (opening <= most ? now.rest.points : parted).push_back(point);
    }
    for (RestingContact& point : now.rest.points) {
        point.pressed = true;
        for (const RestInterval& known : before)
            if (known.entry == gap(point.gap).entry)
                point.since = std::min(point.since, known.start);
    }
    end_rests(before);
    if (lay && !now.rest.points.empty()) correct_drift(true);
    rebase();
    dynamics_.kinks.set_sides(dynamics_.tree, now.q(), now.v());
    if (!find_slip_states(no_slip)) return false;
    const std::vector<RestingContact> low = micro_bounces(parted);
    if (low.empty()) return true;
    // A hop that cannot be told from rest would be followed by others without end.
    for (const RestingContact& point : low) now.rest.points.push_back(point);
    std::stable_sort(
        now.rest.points.begin(), now.rest.points.end(),
        [](const RestingContact& a, const RestingContact& b) { return a.gap < b.gap; });
    correct_drift(true);
    rebase();
    return find_slip_states(no_slip);
}

// Looks at how soon what has parted comes down again; those that do at once, or that rise by less
// than rounding of their places.
std::vector<RestingContact> Motion::micro_bounces(const std::vector<RestingContact>& parted) {
    micro_bounce_ = 0.0;
    std::vector<RestingContact> low;
    if (parted.empty()) return low;
    dynamics_.set_state(now.q(), now.v(), true);
    for (const RestingContact& point : parted) {
        const Gap& gap = this->gap(point.gap);
        const double speed = velocity_of(point, now.q()).linear.z,
                     pull = acceleration_of(point, now.rate.data() + nq()).z;
        if (!(pull < 0.0 && speed > 0.0)) continue;
        const double duration = -2.0 * speed / pull, height = -0.5 * speed * speed / pull;
        const bool is_told = gap.of_frames() || gap.kind == Contact::stop;
        double size = std::abs(gap.limit);
        if (gap.of_frames()) {
            const Vec place = dynamics_.tree.world_place(
                dynamics_.contact_gaps.spot(dynamics_.tree, point, false).place);
            size = std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)});
        }
        if (is_told && (height <= kRounded * size || duration <= settings_.together))
            low.push_back(point);
        else
            micro_bounce_ =
                std::max(micro_bounce_ > 0.0 ? std::min(micro_bounce_, duration) : duration,
                         settings_.together);
    }
    return low;
}

// Set the slip states of points and the directions of joints from here on; drift is taken out.
bool Motion::find_slip_states(double no_slip) {
    double* v = now.v();
    dynamics_.set_state(now.q(), v);
    for (RestingContact& point : now.rest.points) {
        const Spatial<double> u = velocity_of(point, now.q());
        point.slip = SlipState::of(u.linear.x, u.linear.y, no_slip);
        if (!gap(point.gap).turns) continue;
        point.roll = SlipState::of(u.angular.x, u.angular.y, kNoSlip);
        point.spin = SlipState::of(u.angular.z, 0.0, kNoSlip);
    }
    for (std::size_t j = 0; j < now.rest.dry.size(); ++j) {
        const double own = v[scene_->dry[j].v];
        now.rest.dry[j] = std::abs(own) > tolerance::at_rest * fastest() ? (own > 0.0 ? 1 : -1) : 0;
    }
    return update_rest();
}

// Contacts that rested before and do no more have ended their rest.
void Motion::end_rests(const std::vector<RestInterval>& before) {
    const std::vector<RestInterval> after = resting();
    for (const RestInterval& known : before)
        if (std::none_of(after.begin(), after.end(),
                         [&](const RestInterval& own) { return own.entry == known.entry; }))
            rests.push_back({known.entry, known.start, now.t});
}

// These of the resting points stay.
void Motion::retain_contacts(std::vector<RestingContact> stays) {
    const std::vector<RestInterval> before = resting();
    now.rest.points = std::move(stays);
    end_rests(before);
    rebase();
}

// Points that neither push nor stay are let go of; the tree with places and twists.
void Motion::release_contacts() {
    std::vector<RestingContact> stays;
    std::vector<int> torn_gaps;
    for (std::size_t i = 0; i < now.rest.points.size(); ++i) {
        double inside = INFINITY;
        if (gap(now.rest.points[i].gap).of_bodies())
            dynamics_.contact_gaps.gap_of(dynamics_.tree, now.rest.points[i], now.q(), &inside);
        const bool torn = pull_on(gap(now.rest.points[i].gap).entry) > 0.0 &&
                          dynamics_.rate.size() == 3 * now.rest.points.size() &&
                          dynamics_.rate[3 * i + 2] > kPartedAtEvent * dynamics_.size;
        const bool lifts =
            torn || (!now.rest.points[i].pressed &&
                     velocity_of(now.rest.points[i], now.q()).linear.z > kLiftedAtEvent);
        if (torn) torn_gaps.push_back(now.rest.points[i].gap);
        if (!lifts && inside > -kLeftAtEvent) stays.push_back(now.rest.points[i]);
    }
    if (stays.size() == now.rest.points.size()) return;
    // Points that have left their faces may touch beside them.
    retain_contacts(stays);
    // A contact that was torn off has no speed yet: rounding alone would close it again.
    for (int gap : torn_gaps) base_[gap] -= kGrazed;
}

// A sticking contact that is not held begins to slip along its acceleration; a slipping one has its
// direction from its slip.
bool Motion::update_slip_states() {
    bool changed = false;
    const std::size_t n = now.rest.points.size();
    if (dynamics_.rate.size() != 3 * n) return false;
    const double torn = tolerance::torn * dynamics_.size;
    // `begins`: it has no direction of its own at first.
    const auto update = [&](SlipState& slip, bool pressed, const double* u, const double* a,
                            int size, double none, bool begins) {
        const double ahead = size == 2 ? u[1] : 0.0, aside = size == 2 ? a[1] : 0.0;
        const bool tears = std::hypot(a[0], aside) > torn;
        if (slip.begins() && !tears) {
            slip = SlipState();
            changed = true;
        } else if (slip.moves) {
            const double speed = std::hypot(u[0], ahead);
            if (!(speed > (slip.begins() ? dynamics_.slow : none))) return;
            const SlipState turned = SlipState::of(u[0], ahead, 0.0);
            // Friction of slow slip has this direction.
            if (speed <= dynamics_.slow && !(turned == slip)) changed = true;
            slip = turned;
        } else if (pressed && tears) {
            slip = begins ? SlipState{true, {}} : SlipState::of(a[0], aside, 0.0);
            changed = true;
        }
    };
    std::size_t next = 0;
    for (std::size_t i = 0; i < n; ++i) {
        RestingContact& p = now.rest.points[i];
        const Gap& gap = this->gap(p.gap);
        if (dynamics_.static_friction(gap.entry) > 0.0 || dynamics_.has_drop(gap.entry))
            update(p.slip, p.pressed, &dynamics_.slip[3 * i], &dynamics_.rate[3 * i], 2, slow_,
                   true);
        if (!gap.turns) continue;
        const ContactCoefficients& own = scene_->law.contacts[gap.entry];
        const double *u = &dynamics_.turning[3 * next], *a = &dynamics_.turn_rate[3 * next];
        if (own.rolling > 0.0) update(p.roll, p.pressed, u, a, 2, kNoSlip * 1e2, false);
        if (own.torsion > 0.0) update(p.spin, p.pressed, u + 2, a + 2, 1, kNoSlip * 1e2, false);
        ++next;
    }
    for (std::size_t j = 0; j < now.rest.dry.size(); ++j)
        if (now.rest.dry[j] == 0 && dynamics_.dry_rate[j] != 0.0) {
            if (!(std::abs(dynamics_.dry_rate[j]) > torn)) continue;
            now.rest.dry[j] = dynamics_.dry_rate[j] > 0.0 ? 1 : -1;
            changed = true;
        }
    return changed;
}

// At the end of a step: what rests does from here on; drift of what holds is taken out. `is_known`:
// whether the last evaluation was here; `has_moved`: since drift was taken out.
bool Motion::update_rest(bool is_known, bool has_moved) {
    failure_ = DynamicsFailure::none;
    bool is_here = !has_moved;
    const auto evaluate = [&] {
        if (rate(now.t, now.q(), now.rate.data(), is_here)) return true;
        if (failure_ == DynamicsFailure::rest_not_solved && !now.rest.points.empty()) return false;
        return fail();
    };
    const auto jam = [&] {
        return ended == Ended::not_yet && (impact_without_collision() || fail());
    };
    if (!is_known && !evaluate()) return jam();
    is_here = true;
    const std::size_t before = now.rest.points.size();
    set_state();
    if (before > 0) release_contacts();
    if (now.rest.points.size() != before && !evaluate()) return jam();
    bool changed = update_slip_states();
    const bool corrected = has_moved && correct_drift(false);
    if (corrected || changed) {
        if (!evaluate()) return jam();
        // Once more: what was found to slide may change the loads of the others.
        if (update_slip_states() && !evaluate()) return jam();
    }
    return true;
}

// Bring constraints, and resting points where they push (or all their normals), back to where they
// belong, by as little as can be in the metric of M; whether anything moved. The tree with places
// and twists.
bool Motion::correct_drift(bool all_normals) {
    std::vector<double> J;
    const bool in_places = correct_places(all_normals, J);
    return correct_velocities(all_normals, J) || in_places;
}

// The same of places alone, by Newton's method; `J` are the rows of resting points there.
bool Motion::correct_places(bool all_normals, std::vector<double>& J) {
    std::vector<double> off;
    std::vector<int> of_rows;
    const BilateralConstraints& held = dynamics_.constraints;
    for (int step = 0;; ++step) {
        J = rows_of(now.rest.points);
        if (step == kMostSteps) return true;
        Correction back;
        if (held.rows() > 0) {
            dynamics_.constraints.fill_rows(dynamics_.tree, now.q());
            held.drift(dynamics_.tree, now.q(), now.t, off, of_rows);
            for (std::size_t i = 0; i < off.size(); ++i)
                back.add(held.A() + of_rows[i] * nv(), nv(), -off[i]);
        }
        for (std::size_t i = 0; i < now.rest.points.size(); ++i) {
            const RestingContact& point = now.rest.points[i];
            if (point.pressed || all_normals)
                back.add(J.data() + (3 * i + 2) * nv(), nv(),
                         -dynamics_.contact_gaps.gap_of(dynamics_.tree, point, now.q(), nullptr));
        }
        std::vector<double> dq(nv()), shift(nq());
        if (!back.is_needed() || !dynamics_.correct(back, dq.data())) return step > 0;
        configuration_rate(*scene_->scene.model, now.q(), dq.data(), shift.data());
        for (int i = 0; i < nq(); ++i) now.y[i] += shift[i];
        normalize_configuration(*scene_->scene.model, now.q());
        set_state();
    }
}

// The same of velocities alone.
bool Motion::correct_velocities(bool all_normals, const std::vector<double>& J) {
    const double* v = now.v();
    Correction back;
    const auto still = [&](const double* row) { back.add(row, nv(), -dot(row, v, nv())); };
    if (const int m = dynamics_.constraints.rows(); m > 0) {
        std::vector<double> speed(m), rate(m);
        dynamics_.constraints.fill_rows(dynamics_.tree, now.q());
        dynamics_.constraints.speeds(now.t, speed.data(), rate.data());
        for (int r = 0; r < m; ++r) {
            const double* row = dynamics_.constraints.A() + r * nv();
            back.add(row, nv(), speed[r] - dot(row, v, nv()));
        }
    }
    const double *row = J.data(), *turn = row + 3 * nv() * now.rest.points.size();
    for (const RestingContact& point : now.rest.points) {
        const Gap& gap = this->gap(point.gap);
        const ContactCoefficients& own = scene_->law.contacts[gap.entry];
        const double *second = row + nv(), *normal = second + nv();
        // A chattering contact does not slip either: friction of so little slip would tip it.
        const bool sticks =
            all_normals
                ? chatters(point.gap) &&
                      std::hypot(dot(row, v, nv()), dot(second, v, nv())) < gap.capture
                : point.pressed && !point.slip.moves && dynamics_.static_friction(gap.entry) > 0.0;
        const bool turns = gap.turns && point.pressed && !all_normals;
        if (point.pressed || all_normals) still(normal);
        if (sticks) still(row), still(second);
        if (turns && !point.roll.moves && own.rolling > 0.0) still(turn), still(turn + nv());
        if (turns && !point.spin.moves && own.torsion > 0.0) still(turn + 2 * nv());
        row += 3 * nv();
        if (gap.turns) turn += 3 * nv();
    }
    for (std::size_t j = 0; j < now.rest.dry.size() && !all_normals; ++j)
        if (now.rest.dry[j] == 0) {
            std::vector<double> joint(nv());
            joint[scene_->dry[j].v] = 1.0;
            still(joint.data());
        }
    return back.is_needed() && dynamics_.correct(back, now.v());
}

// Gaps that are closed, or overlap by rounding, count as zero.
void Motion::rebase() {
    set_state();
    for (int i = 0; i < gap_count(); ++i)
        base_[i] = passing_[i] ? 0.0 : std::min(gap_now(i).gap, 0.0);
}

}  // namespace impulsekit
