// Change points: linkages that pass a configuration at which their constraints lose rank.
//
// A parallelogram is flat twice a turn. Its rows depend on each other there, and next to it
// rounding divided by their smallest singular value is larger than any tolerance: steps shrink, and
// end at rows that cannot hold together. Nothing happens to the motion itself, whose velocity goes
// on along the branch on which it came. So the polynomial through states well before is followed to
// the other side, and taken if it obeys constraints and accelerations there. At a dead centre,
// where a driven linkage cannot go on, it does not.
#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"
#include "motion/interpolation.hpp"
#include "motion/motion.hpp"
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

}  // namespace

// The polynomial through states of the path before a time, from there on.
Step Motion::extrapolation(double start, double length) const {
    const int n = static_cast<int>(now.y.size());
    const Interpolation through(start - kFitted * length, start);
    std::vector<double> values(Interpolation::count * n);
    for (int i = 0; i < Interpolation::count; ++i) {
        state(through.nodes[i], values.data() + i * n, values.data() + i * n + nq());
        if (i > 0)
            choose_signs(*scene_->scene.model, values.data() + (i - 1) * n, values.data() + i * n);
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
double Motion::error_behind(const Step& jump) {
    const int m = dynamics_.constraints.rows();
    const double length = jump.end - jump.start, apart = kApart * length;
    set_state(jump, jump.end);
    const double* v = here_.data() + nq();
    dynamics_.constraints.fill_rows(dynamics_.tree, here_.data());
    std::vector<double> speed(m), rate(m), terms(m), off;
    std::vector<int> rows;
    dynamics_.constraints.speeds(jump.end, speed.data(), rate.data());
    const double fastest = largest(v, nv());
    double worst = 0.0;
    for (int r = 0; r < m; ++r) {
        const double* row = dynamics_.constraints.A() + r * nv();
        for (int i = 0; i < nv(); ++i) terms[r] += std::abs(row[i]) * fastest;
        terms[r] += std::abs(speed[r]);
        if (terms[r] > 0.0)
            worst = std::max(worst, std::abs(dot(row, v, nv()) - speed[r]) / terms[r]);
    }
    dynamics_.constraints.drift(dynamics_.tree, here_.data(), jump.end, off, rows);
    for (std::size_t i = 0; i < off.size(); ++i)
        if (terms[rows[i]] > 0.0)
            worst = std::max(worst, std::abs(off[i]) / length / terms[rows[i]]);
    if (!(worst < tolerance::contradiction)) return worst;
    const std::vector<double> after = here_;
    set_state(jump, jump.end - apart);
    const std::vector<double> before = here_;
    std::vector<double> middle(now.y.size()), found(now.y.size());
    jump.at(jump.end - 0.5 * apart, middle.data());
    if (!this->rate(jump.end - 0.5 * apart, middle.data(), found.data())) return INFINITY;
    for (int i = nq(); i < nq() + nv(); ++i)
        worst = std::max(worst, std::abs((after[i] - before[i]) / apart - found[i]) * length /
                                    std::max(fastest, tolerance::tiny));
    return worst;
}

// Go past a change point of what is held; false where none is near.
bool Motion::pass_change_point(double until) {
    if (dynamics_.constraints.rows() == 0 || now.rest.acts() || path.empty()) return false;
    const std::size_t first = path.size() > kMostBack ? path.size() - kMostBack : 0;
    double longest = 0.0, least = INFINITY;
    for (std::size_t i = first; i < path.size(); ++i)
        longest = std::max(longest, path[i].step.end - path[i].step.start);
    std::size_t kept = 0;
    Step best;
    for (std::size_t i = first; i < path.size(); ++i) {
        const double start = path[i].step.start,
                     length = std::max(kJumpReach * (now.t - start), kLeastReach * longest);
        if (start - kFitted * length < smooth_since_ || start + length > until) continue;
        const Step step = extrapolation(start, length);
        const double off = error_behind(step);
        if (!(off < std::min(least, tolerance::contradiction))) continue;
        least = off;
        best = step;
        kept = i;
    }
    if (!(least < INFINITY)) return false;
    path.resize(kept);
    keep(best);
    best.at(best.end, now.q());
    normalize_configuration(*scene_->scene.model, now.q());
    now.t = best.end;
    stepper_.next = best.length;
    return update_rest();
}

}  // namespace impulsekit
