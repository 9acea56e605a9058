// A motion by columns.
#pragma once

#include <vector>

#include "motion/motion.hpp"

namespace impulsekit {

// The steps of a motion: start, end, begin, length (pieces, 4), y at the beginning, coefficients
// (pieces, 7, nq + nv), and which resting state each has.
struct Path {
    std::vector<double> times, before, shape;
    std::vector<int> resting_state;
    std::vector<RestingState> resting_states;

    explicit Path(const Motion& motion);
};

// Impacts: v before and after, impulses (contacts, 3), and the contacts that take part.
struct ImpactColumns {
    std::vector<double> times, before, after, impulses;
    std::vector<int> status;
    std::vector<char> touching;

    explicit ImpactColumns(const Motion& motion);
};

// From when to when contacts rested; those that rest now last.
std::vector<RestInterval> rests_of(const Motion& motion);

// All that a batch keeps of a motion that has ended.
struct MotionColumns {
    double t;
    int evaluations;
    std::vector<double> end;      // (nq + nv) the state at t
    std::vector<double> samples;  // (reached, nq + nv) y at times up to t, as the steps have it
    ImpactColumns impacts;
    std::vector<RestInterval> rests;

    // `times`: (count) increasing.
    MotionColumns(const Motion& motion, const double* times, std::size_t count);
};

}  // namespace impulsekit
