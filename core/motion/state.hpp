// The state of a motion: q, v and time, who rests and how it slips.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/shapes.hpp"

namespace impulsekit {

// Slip, rolling or spin of a contact and its direction: it sticks, or it moves.
struct SlipState {
    bool moves = false;
    double direction[2] = {};  // unit vector in the tangents; of a spin its sign

    // Direction of a velocity, which is none below `none`.
    static SlipState of(double a, double b, double none) {
        const double speed = std::hypot(a, b);
        return speed > none ? SlipState{true, {a / speed, b / speed}} : SlipState();
    }
    double along(double a, double b) const { return direction[0] * a + direction[1] * b; }
    // True if slip has just begun: it has no direction yet but that of its acceleration, to which
    // friction turns it within nanoseconds.
    bool begins() const { return moves && direction[0] == 0.0 && direction[1] == 0.0; }
    bool operator==(const SlipState& b) const {
        return moves == b.moves && direction[0] == b.direction[0] && direction[1] == b.direction[1];
    }
};

// A point that rests.
struct RestingContact {
    int gap = 0;
    Feature feature{};    // of bodies, how it is followed
    double since = 0.0;   // [s]
    bool pressed = true;  // at the last evaluation
    SlipState slip, roll, spin;

    bool is_same_point(const RestingContact& b) const {
        return gap == b.gap && feature == b.feature;
    }
};

// All that rests: points in the order of their gaps, and joints with dry friction (−1, 1: moving
// that way; 0: sticking); and the torques that are set from outside meanwhile.
struct RestingState {
    std::vector<RestingContact> points;
    std::vector<signed char> dry;
    std::vector<double> controls;  // (nv), or none

    bool acts() const {
        return !points.empty() || std::find(dry.begin(), dry.end(), 0) != dry.end();
    }
    bool rests_on(int gap) const {
        return std::any_of(points.begin(), points.end(),
                           [gap](const RestingContact& point) { return point.gap == gap; });
    }
    // True if the same rests in the same way, since whenever.
    bool is_same(const RestingState& b) const {
        const auto same = [](const RestingContact& x, const RestingContact& y) {
            return x.is_same_point(y) && x.slip == y.slip && x.roll == y.roll && x.spin == y.spin;
        };
        return dry == b.dry && controls == b.controls &&
               std::equal(points.begin(), points.end(), b.points.begin(), b.points.end(), same);
    }
};

struct MotionState {
    double t = 0.0;
    int nq = 0;
    std::vector<double> y, rate;  // (nq + nv) q and v; ẏ
    RestingState rest;

    double* q() { return y.data(); }
    double* v() { return y.data() + nq; }
    const double* q() const { return y.data(); }
    const double* v() const { return y.data() + nq; }
};

}  // namespace impulsekit
