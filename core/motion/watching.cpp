// Forces that are functions of time or state are looked at between the stages of a step: a short
// pulse falls between them where a quiet flight lets steps be long.
#include <algorithm>
#include <cmath>

#include "motion/interpolation.hpp"
#include "motion/motion.hpp"

namespace impulsekit {
namespace {

// So many times a motion functions are looked at: what acts for a thousandth of it is met.
constexpr double kLooks = 2000.0;
// Beyond this part of the largest value seen a force is not what the step takes it for: what a step
// within tolerance makes of a smooth force is a thousand times nearer.
constexpr double kUnlike = 1e-3;

}  // namespace

// All numbers that functions give at a time of a step.
void Motion::forces_at(const Step& step, double at, std::vector<double>& found) {
    const Forces& forces = scene_->forces;
    at = std::min(std::max(at, from_), to_);
    found.clear();
    step.at(at, here_.data());
    const double *q = here_.data(), *v = q + nq();
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

// The length with which a step is to be made again, or 0 where it will do: where a force is not
// what the polynomial through eight of its values says (Berrut & Trefethen 2004).
double Motion::shorter_step(const Step& step) {
    const Forces& forces = scene_->forces;
    const double spacing = settings_.scale_of_time / kLooks, span = step.end - step.start;
    if (!forces.are_watched() || !(span > 2.0 * spacing)) return 0.0;
    const Interpolation through(step.start, step.end);
    std::vector<double> values[Interpolation::count], seen;
    const auto look = [&](double at, std::vector<double>& found) {
        forces_at(step, at, found);
        largest_force_.resize(found.size(), 0.0);
        for (std::size_t k = 0; k < found.size(); ++k)
            if (std::isfinite(found[k]))
                largest_force_[k] = std::max(largest_force_[k], std::abs(found[k]));
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
            double told = 0.0, most = largest_force_[k];
            for (int i = 0; i < Interpolation::count; ++i) told += shares[i] * values[i][k];
            if (k < threes)
                for (std::size_t j = k / 3 * 3; j < k / 3 * 3 + 3; ++j)
                    most = std::max(most, largest_force_[j]);
            if (!(std::abs(seen[k] - told) > kUnlike * most)) continue;
            return std::max(spacing, std::min(at - spacing - step.start, 0.5 * span));
        }
    }
    return 0.0;
}

}  // namespace impulsekit
