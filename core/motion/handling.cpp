#include "motion/handling.hpp"

#include <algorithm>
#include <cmath>

#include "motion/impacts.hpp"
#include "motion/resting.hpp"

namespace impulsekit {
namespace {

// Slip that has stopped at y keeps still, unless the law of rest lets it go.
void stop_slips(Motion& motion) {
    MotionState& now = motion.now;
    const double *v = now.v(), none = tolerance::residual * std::max(1.0, fastest(motion));
    const auto stop = [&](SlipState& slip_state, double a, double b) {
        if (!slip_state.moves || slip_state.begins()) return;
        // Slip that has turned away goes on.
        if (!(slip_state.along(a, b) > none))
            slip_state = SlipState::of(a, b, std::max(none, motion.dynamics.slow));
    };
    for (RestingContact& point : now.rest.points) {
        const Spatial<double> u = velocity_of(motion, point, now.q());
        stop(point.slip, u.linear.x, u.linear.y);
        if (!motion.gap(point.gap).turns) continue;
        stop(point.roll, u.angular.x, u.angular.y);
        stop(point.spin, u.angular.z, 0.0);
    }
    for (std::size_t j = 0; j < now.rest.dry.size(); ++j)
        if (now.rest.dry[j] * v[motion.scene->dry[j].v] <= none) now.rest.dry[j] = 0;
}

// The gaps that close now together with one; passing contacts begin or end.
std::vector<int> gaps_that_close(Motion& motion, int gap) {
    std::vector<int> closing;
    for (int i = 0; i < motion.gap_count(); ++i) {
        if (motion.now.rest.rests_on(i)) continue;
        const GapState found = gap_now(motion, i);
        const double sign = motion.memory[i].passes ? -1.0 : 1.0, rate = sign * found.rate;
        // Corners of a face that bounces flat part by rounding, and would be caught one by one.
        const bool closes =
            rate < 0.0 && sign * (found.gap - motion.memory[i].base) <=
                              std::max(found.noise(), -rate * motion.settings.together);
        if (i != gap && !closes) continue;
        if (!motion.memory[i].passes && counts_now(motion, i)) {
            closing.push_back(i);
            continue;
        }
        motion.memory[i].passes = !motion.memory[i].passes;
        motion.memory[i].base = 0.0;
    }
    return closing;
}

}  // namespace

bool handle_event(Motion& motion, const Event& event) {
    set_state(motion);
    const EventFunction& what = event.what;
    if (what.kind == EventFunction::touches_elsewhere) return close_gaps(motion, {what.index});
    if (what.kind == EventFunction::gap_closes) {
        const std::vector<int> closing = gaps_that_close(motion, what.index);
        if (!closing.empty()) return close_gaps(motion, closing);
        restart(motion);
        return motion.ended == Ended::not_yet;
    }
    if (what.kind != EventFunction::unsure) {
        motion.dynamics.kinks.change(motion.dynamics.tree, motion.now.q(), motion.now.v());
        stop_slips(motion);
    }
    return update_rest(motion);
}

}  // namespace impulsekit
