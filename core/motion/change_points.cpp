#include "motion/change_points.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/dense.hpp"
#include "motion/interpolation.hpp"
#include "motion/path.hpp"
#include "motion/resting.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {
namespace {

// So many steps are looked back: where they shrink, they do so by a fifth at least.
constexpr std::size_t kMostBack = 100;
// A jump reaches so many lengths of the way to the change point, and at least of those of the
// longest step; from how many times as long it is learnt.
constexpr double kJumpReach = 1.5, kLeastReach = 1e-2, kFitted = 4.0;
// Accelerations of the polynomial behind are told from values of it this part of the jump apart.
constexpr double kApart = 1e-3;

// The basis of a step's shape at a part of it.
void basis(double x, double* to) {
    double product = 1.0;
    for (int i = 0; i < 7; ++i) {
        product *= i % 2 == 0 ? x : 1.0 - x;
        to[i] = product;
    }
}

// The polynomial through states of the path before a time, from there on.
Step extrapolation(const Motion& motion, double start, double length) {
    const int n = static_cast<int>(motion.now.y.size());
    const Interpolation through(start - kFitted * length, start);
    std::vector<double> values(Interpolation::count * n);
    for (int i = 0; i < Interpolation::count; ++i) {
        state_at(motion, through.nodes[i], values.data() + i * n,
                 values.data() + i * n + motion.nq());
        if (i > 0)
            choose_signs(*motion.scene->scene.model, values.data() + (i - 1) * n,
                         values.data() + i * n);
    }
    Step step;
    step.start = step.begin = start;
    step.end = start + length;
    step.length = length;
    step.before.assign(values.end() - n, values.end());
    step.shape.assign(7 * n, 0.0);
    double A[49], trial[7];
    int pivot[7];
    std::vector<double> change(7 * n);
    for (int r = 0; r < 7; ++r) {
        const double part = (r + 1) / 7.0, at = start + part * length;
        basis(part, trial);
        std::copy(trial, trial + 7, A + 7 * r);
        double shares[Interpolation::count];
        through.shares(at, shares);
        for (int j = 0; j < n; ++j) change[r * n + j] = -step.before[j];
        for (int i = 0; i < Interpolation::count; ++i)
            for (int j = 0; j < n; ++j) change[r * n + j] += shares[i] * values[i * n + j];
    }
    if (!factor_lu(A, 7, pivot)) return step;
    for (int j = 0; j < n; ++j) {
        for (int r = 0; r < 7; ++r) trial[r] = change[r * n + j];
        solve_lu(A, pivot, 7, trial);
        for (int r = 0; r < 7; ++r) step.shape[r * n + j] = trial[r];
    }
    return step;
}

// The relative error of velocities, places and accelerations behind a jump.
double error_behind(Motion& motion, const Step& jump) {
    Dynamics& dynamics = motion.dynamics;
    const int m = dynamics.constraints.rows();
    const double length = jump.end - jump.start, apart = kApart * length;
    set_state(motion, jump, jump.end);
    const double* v = motion.here.data() + motion.nq();
    dynamics.constraints.fill_rows(dynamics.tree, motion.here.data());
    std::vector<double> speed(m), rate(m), terms(m), off;
    std::vector<int> rows;
    dynamics.constraints.speeds(jump.end, speed.data(), rate.data());
    const double fastest = largest(v, motion.nv());
    double worst = 0.0;
    for (int r = 0; r < m; ++r) {
        const double* row = dynamics.constraints.A() + r * motion.nv();
        for (int i = 0; i < motion.nv(); ++i) terms[r] += std::abs(row[i]) * fastest;
        terms[r] += std::abs(speed[r]);
        if (terms[r] > 0.0)
            worst = std::max(worst, std::abs(dot(row, v, motion.nv()) - speed[r]) / terms[r]);
    }
    dynamics.constraints.drift(dynamics.tree, motion.here.data(), jump.end, off, rows);
    for (std::size_t i = 0; i < off.size(); ++i)
        if (terms[rows[i]] > 0.0)
            worst = std::max(worst, std::abs(off[i]) / length / terms[rows[i]]);
    if (!(worst < tolerance::contradiction)) return worst;
    const std::vector<double> after = motion.here;
    set_state(motion, jump, jump.end - apart);
    const std::vector<double> before = motion.here;
    std::vector<double> middle(motion.now.y.size()), found(motion.now.y.size());
    jump.at(jump.end - 0.5 * apart, middle.data());
    if (!find_rate(motion, jump.end - 0.5 * apart, middle.data(), found.data())) return INFINITY;
    for (int i = motion.nq(); i < motion.nq() + motion.nv(); ++i)
        worst = std::max(worst, std::abs((after[i] - before[i]) / apart - found[i]) * length /
                                    std::max(fastest, tolerance::tiny));
    return worst;
}

}  // namespace

bool pass_change_point(Motion& motion, double until) {
    MotionState& now = motion.now;
    if (motion.dynamics.constraints.rows() == 0 || now.rest.acts() || motion.path.empty())
        return false;
    const std::size_t first = motion.path.size() > kMostBack ? motion.path.size() - kMostBack : 0;
    double longest = 0.0, least = INFINITY;
    for (std::size_t i = first; i < motion.path.size(); ++i)
        longest = std::max(longest, motion.path[i].step.end - motion.path[i].step.start);
    std::size_t kept = 0;
    Step best;
    for (std::size_t i = first; i < motion.path.size(); ++i) {
        const double start = motion.path[i].step.start,
                     length = std::max(kJumpReach * (now.t - start), kLeastReach * longest);
        if (start - kFitted * length < motion.smooth_since || start + length > until) continue;
        const Step step = extrapolation(motion, start, length);
        const double off = error_behind(motion, step);
        if (!(off < std::min(least, tolerance::contradiction))) continue;
        least = off;
        best = step;
        kept = i;
    }
    if (!(least < INFINITY)) return false;
    motion.path.resize(kept);
    keep_step(motion, best);
    best.at(best.end, now.q());
    normalize_configuration(*motion.scene->scene.model, now.q());
    now.t = best.end;
    motion.stepper.next = best.length;
    return update_rest(motion);
}

}  // namespace impulsekit
