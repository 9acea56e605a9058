#include "motion/watching.hpp"

#include <algorithm>
#include <cmath>

#include "motion/interpolation.hpp"

namespace impulsekit {
namespace {

// So many times a motion functions are looked at: what acts for a thousandth of it is met.
constexpr double kLooks = 2000.0;
// Beyond this part of the largest value seen a force is not what the step takes it for: what a step
// within tolerance makes of a smooth force is a thousand times nearer.
constexpr double kUnlike = 1e-3;

// All numbers that functions give at a time of a step.
void function_values(Motion& motion, const Step& step, double at, std::vector<double>& found) {
    const Forces& forces = motion.scene->forces;
    at = std::min(std::max(at, motion.stretch.from), motion.stretch.to);
    found.clear();
    step.at(at, motion.here.data());
    const double *q = motion.here.data(), *v = q + motion.nq();
    for (const AppliedForce& own : forces.applied) {
        found.insert(found.end(), own.numbers, own.numbers + 6);
        if (own.function) own.function(at, q, v, found.data() + found.size() - 6);
    }
    for (const TimedTorque& own : forces.timed) found.push_back(own.table.at(at));
    for (const TorqueFunction& own : forces.functions) {
        found.resize(found.size() + own.count);
        own.function(at, q, v, found.data() + found.size() - own.count);
    }
}

}  // namespace

double shorter_step(Motion& motion, const Step& step) {
    const Forces& forces = motion.scene->forces;
    const double spacing = motion.settings.scale_of_time / kLooks, span = step.end - step.start;
    if (!forces.are_watched() || !(span > 2.0 * spacing)) return 0.0;
    const Interpolation through(step.start, step.end);
    std::vector<double> values[Interpolation::count], seen;
    const auto look = [&](double at, std::vector<double>& found) {
        function_values(motion, step, at, found);
        motion.largest.resize(found.size(), 0.0);
        for (std::size_t k = 0; k < found.size(); ++k)
            if (std::isfinite(found[k]))
                motion.largest[k] = std::max(motion.largest[k], std::abs(found[k]));
    };
    for (int i = 0; i < Interpolation::count; ++i) look(through.nodes[i], values[i]);
    // The components of a force count as one.
    const std::size_t threes = 6 * forces.applied.size();
    for (double at = (std::floor(step.start / spacing) + 1.0) * spacing; at < step.end;
         at += spacing) {
        look(at, seen);
        double shares[Interpolation::count];
        through.shares(at, shares);
        for (std::size_t k = 0; k < seen.size(); ++k) {
            double told = 0.0, most = motion.largest[k];
            for (int i = 0; i < Interpolation::count; ++i) told += shares[i] * values[i][k];
            if (k < threes)
                for (std::size_t j = k / 3 * 3; j < k / 3 * 3 + 3; ++j)
                    most = std::max(most, motion.largest[j]);
            if (!(std::abs(seen[k] - told) > kUnlike * most)) continue;
            return std::max(spacing, std::min(at - spacing - step.start, 0.5 * span));
        }
    }
    return 0.0;
}

}  // namespace impulsekit
