#include "motion/start.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/dense.hpp"
#include "motion/impacts.hpp"
#include "motion/resting.hpp"

namespace impulsekit {
namespace {

// True if a constraint prescribes another velocity than it has; the tree with places.
bool is_driven_off(Motion& motion) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    const int m = dynamics.constraints.rows();
    if (m == 0) return false;
    dynamics.constraints.fill_rows(dynamics.tree, now.q());
    std::vector<double> speed(m), rate(m);
    dynamics.constraints.speeds(0.0, speed.data(), rate.data());
    double missing = 0.0, scale = 0.0;
    for (int r = 0; r < m; ++r) {
        const double* row = dynamics.constraints.A() + r * motion.nv();
        double sum = 0.0;
        for (int i = 0; i < motion.nv(); ++i) sum += std::abs(row[i] * now.v()[i]);
        scale = std::max({scale, sum, std::abs(speed[r])});
        if (!motion.scene->scene.kept[r])
            missing = std::max(missing, std::abs(speed[r] - dot(row, now.v(), motion.nv())));
    }
    return missing > tolerance::residual * scale;
}

}  // namespace

std::vector<GapAt> gaps_closed_at_start(Motion& motion) {
    std::vector<GapAt> found;
    set_state(motion);
    for (int i = 0; i < motion.gap_count(); ++i) {
        const GapState state = gap_now(motion, i);
        if (!(state.gap <= tolerance::alike)) continue;
        if (counts_now(motion, i))
            found.push_back({i, motion.gap(i).entry, state.gap, state.rate});
        else
            motion.memory[i].passes = state.gap < -tolerance::alike;
    }
    return found;
}

bool is_struck_at_start(Motion& motion, const std::vector<int>& closed) {
    const double slow =
        std::max(kSlowShare * motion.settings.capture_speed, tolerance::at_rest * fastest(motion));
    set_state(motion);
    return std::any_of(closed.begin(), closed.end(),
                       [&](int i) { return gap_now(motion, i).rate < -slow; }) ||
           is_driven_off(motion);
}

void begin_motion(Motion& motion, const double* v, const std::vector<int>& contact_gaps) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    std::copy(v, v + motion.nv(), now.y.begin() + motion.nq());
    set_state(motion);
    if (dynamics.constraints.rows() > 0)
        dynamics.constraints.start(dynamics.tree, now.q(), now.v());
    dynamics.kinks.set_sides(dynamics.tree, now.q(), now.v());
    rebase(motion);
    // Slip that was given is kept, be it below the capture speed.
    find_resting_contacts(motion, points_of_gaps(motion, contact_gaps), false, kNoSlip);
    motion.begun = true;
}

}  // namespace impulsekit
