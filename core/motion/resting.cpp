#include "motion/resting.hpp"

#include <algorithm>
#include <cmath>

#include "motion/drift.hpp"
#include "motion/impacts.hpp"

namespace impulsekit {
namespace {

// The gap of a contact that was torn off may waver by this [m].
constexpr double kGrazed = tolerance::solved;
// Rounding of places, of their size.
constexpr double kRounded = 2.0 * tolerance::rounding;

// Take those out of points that do not belong there any more.
template <typename Belongs>
std::vector<RestingContact> split_off(std::vector<RestingContact>& points, Belongs belongs) {
    const auto others = std::stable_partition(points.begin(), points.end(), belongs);
    std::vector<RestingContact> found(others, points.end());
    points.erase(others, points.end());
    return found;
}

// Looks at how soon what has parted comes down again; takes out those that do at once, or that rise
// by less than rounding of their places.
std::vector<RestingContact> micro_bounces(Motion& motion, std::vector<RestingContact>& parted) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    motion.micro_bounce = 0.0;
    if (parted.empty()) return {};
    dynamics.set_state(now.q(), now.v(), true);
    return split_off(parted, [&](const RestingContact& point) {
        const Gap& gap = motion.gap(point.gap);
        const double speed = velocity_of(motion, point, now.q()).linear.z,
                     pull = acceleration_of(motion, point, now.rate.data() + motion.nq()).z;
        if (!(pull < 0.0 && speed > 0.0)) return true;
        const double duration = -2.0 * speed / pull, height = -0.5 * speed * speed / pull;
        const bool is_told = gap.of_frames() || gap.kind == Contact::stop;
        double size = std::abs(gap.limit);
        if (gap.of_frames()) {
            const Vec place = dynamics.tree.world_place(
                dynamics.contact_gaps.spot(dynamics.tree, point, false).place);
            size = std::max({std::abs(place.x), std::abs(place.y), std::abs(place.z)});
        }
        if (is_told && (height <= kRounded * size || duration <= motion.settings.together))
            return false;
        motion.micro_bounce =
            std::max(motion.micro_bounce > 0.0 ? std::min(motion.micro_bounce, duration) : duration,
                     motion.settings.together);
        return true;
    });
}

// Set the slip states of points and the directions of joints from here on; drift is taken out.
bool find_slip_states(Motion& motion, double no_slip) {
    MotionState& now = motion.now;
    double* v = now.v();
    motion.dynamics.set_state(now.q(), v);
    for (RestingContact& point : now.rest.points) {
        const Spatial<double> u = velocity_of(motion, point, now.q());
        point.slip = SlipState::of(u.linear.x, u.linear.y, no_slip);
        if (!motion.gap(point.gap).turns) continue;
        point.roll = SlipState::of(u.angular.x, u.angular.y, kNoSlip);
        point.spin = SlipState::of(u.angular.z, 0.0, kNoSlip);
    }
    for (std::size_t j = 0; j < now.rest.dry.size(); ++j) {
        const double own = v[motion.scene->dry[j].v];
        now.rest.dry[j] =
            std::abs(own) > tolerance::at_rest * fastest(motion) ? (own > 0.0 ? 1 : -1) : 0;
    }
    return update_rest(motion);
}

// Contacts that rested before and do no more have ended their rest.
void end_rests(Motion& motion, const std::vector<RestInterval>& before) {
    const std::vector<RestInterval> after = rests_now(motion);
    for (const RestInterval& known : before)
        if (std::none_of(after.begin(), after.end(),
                         [&](const RestInterval& own) { return own.entry == known.entry; }))
            motion.rests.push_back({known.entry, known.start, motion.now.t});
}

// Points that neither push nor stay are let go of; the tree with places and twists.
void release_contacts(Motion& motion) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    std::vector<RestingContact> stays;
    std::vector<int> torn_gaps;
    for (std::size_t i = 0; i < now.rest.points.size(); ++i) {
        double inside = INFINITY;
        if (motion.gap(now.rest.points[i].gap).of_bodies())
            dynamics.contact_gaps.gap_of(dynamics.tree, now.rest.points[i], now.q(), &inside);
        const bool torn = pull_on(motion, motion.gap(now.rest.points[i].gap).entry) > 0.0 &&
                          dynamics.rate.size() == 3 * now.rest.points.size() &&
                          dynamics.rate[3 * i + 2] > kPartedAtEvent * dynamics.size;
        const bool lifts =
            torn || (!now.rest.points[i].pressed &&
                     velocity_of(motion, now.rest.points[i], now.q()).linear.z > kLiftedAtEvent);
        if (torn) torn_gaps.push_back(now.rest.points[i].gap);
        if (!lifts && inside > -kLeftAtEvent) stays.push_back(now.rest.points[i]);
    }
    if (stays.size() == now.rest.points.size()) return;
    // Points that have left their faces may touch beside them.
    retain_contacts(motion, stays);
    // A contact that was torn off has no speed yet: rounding alone would close it again.
    for (int gap : torn_gaps) motion.memory[gap].base -= kGrazed;
}

// A sticking contact that is not held begins to slip along its acceleration; a slipping one has its
// direction from its slip.
bool update_slip_states(Motion& motion) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    bool changed = false;
    const std::size_t n = now.rest.points.size();
    if (dynamics.rate.size() != 3 * n) return false;
    const double torn = tolerance::torn * dynamics.size;
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
            if (!(speed > (slip.begins() ? dynamics.slow : none))) return;
            const SlipState turned = SlipState::of(u[0], ahead, 0.0);
            // Friction of slow slip has this direction.
            if (speed <= dynamics.slow && !(turned == slip)) changed = true;
            slip = turned;
        } else if (pressed && tears) {
            slip = begins ? SlipState{true, {}} : SlipState::of(a[0], aside, 0.0);
            changed = true;
        }
    };
    std::size_t next = 0;
    for (std::size_t i = 0; i < n; ++i) {
        RestingContact& p = now.rest.points[i];
        const Gap& gap = motion.gap(p.gap);
        if (dynamics.static_friction(gap.entry) > 0.0 || dynamics.has_drop(gap.entry))
            update(p.slip, p.pressed, &dynamics.slip[3 * i], &dynamics.rate[3 * i], 2, motion.slow,
                   true);
        if (!gap.turns) continue;
        const ContactCoefficients& own = motion.scene->law.contacts[gap.entry];
        const double *u = &dynamics.turning[3 * next], *a = &dynamics.turn_rate[3 * next];
        if (own.rolling > 0.0) update(p.roll, p.pressed, u, a, 2, kNoSlip * 1e2, false);
        if (own.torsion > 0.0) update(p.spin, p.pressed, u + 2, a + 2, 1, kNoSlip * 1e2, false);
        ++next;
    }
    for (std::size_t j = 0; j < now.rest.dry.size(); ++j)
        if (now.rest.dry[j] == 0 && dynamics.dry_rate[j] != 0.0) {
            if (!(std::abs(dynamics.dry_rate[j]) > torn)) continue;
            now.rest.dry[j] = dynamics.dry_rate[j] > 0.0 ? 1 : -1;
            changed = true;
        }
    return changed;
}

}  // namespace

bool find_resting_contacts(Motion& motion, const std::vector<RestingContact>& candidates, bool lay,
                           double no_slip) {
    MotionState& now = motion.now;
    set_state(motion);
    const double slow =
        std::max(motion.settings.capture_speed, tolerance::at_rest * fastest(motion));
    const std::vector<RestInterval> before = rests_now(motion);
    std::vector<RestingContact> parted = candidates, &all = now.rest.points;
    all.clear();
    const auto parts_fast = [&](const RestingContact& point) {
        const Gap& own = motion.gap(point.gap);
        return velocity_of(motion, point, now.q()).linear.z >
               std::max(slow, chatters(motion, point.gap) ? own.capture : own.rests);
    };
    // What is laid down may still others with it, as the last corner of a face.
    const auto rest = [&](std::vector<RestingContact> points, bool laid) {
        while (!points.empty()) {
            all.insert(all.end(), points.begin(), points.end());
            std::stable_sort(
                all.begin(), all.end(),
                [](const RestingContact& a, const RestingContact& b) { return a.gap < b.gap; });
            if (!laid) return;
            correct_drift(motion, true);
            set_state(motion);
            points = split_off(parted, parts_fast);
        }
    };
    rest(split_off(parted, parts_fast), lay);
    for (RestingContact& point : all) {
        point.pressed = true;
        for (const RestInterval& known : before)
            if (known.entry == motion.gap(point.gap).entry)
                point.since = std::min(point.since, known.start);
    }
    end_rests(motion, before);
    rebase(motion);
    motion.dynamics.kinks.set_sides(motion.dynamics.tree, now.q(), now.v());
    if (!find_slip_states(motion, no_slip)) return false;
    const std::vector<RestingContact> low = micro_bounces(motion, parted);
    if (low.empty()) return true;
    // A hop that cannot be told from rest would be followed by others without end.
    rest(low, true);
    rebase(motion);
    return find_slip_states(motion, no_slip);
}

void retain_contacts(Motion& motion, std::vector<RestingContact> stays) {
    const std::vector<RestInterval> before = rests_now(motion);
    motion.now.rest.points = std::move(stays);
    end_rests(motion, before);
    rebase(motion);
}

bool update_rest(Motion& motion, bool is_known, bool has_moved) {
    MotionState& now = motion.now;
    motion.failure = DynamicsFailure::none;
    bool is_here = !has_moved;
    const auto evaluate = [&] {
        if (find_rate(motion, now.t, now.q(), now.rate.data(), is_here)) return true;
        if (motion.failure == DynamicsFailure::rest_not_solved && !now.rest.points.empty())
            return false;
        return fail(motion);
    };
    const auto jam = [&] {
        return motion.ended == Ended::not_yet && (impact_without_collision(motion) || fail(motion));
    };
    if (!is_known && !evaluate()) return jam();
    is_here = true;
    const std::size_t before = now.rest.points.size();
    set_state(motion);
    if (before > 0) release_contacts(motion);
    if (now.rest.points.size() != before && !evaluate()) return jam();
    bool changed = update_slip_states(motion);
    const bool corrected = has_moved && correct_drift(motion, false);
    if (corrected || changed) {
        if (!evaluate()) return jam();
        // Once more: what was found to slide may change the loads of the others.
        if (update_slip_states(motion) && !evaluate()) return jam();
    }
    return true;
}

}  // namespace impulsekit
