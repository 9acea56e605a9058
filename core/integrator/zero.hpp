// Zeros of functions of time.
#pragma once

#include <algorithm>
#include <cmath>

#include "linalg/tolerances.hpp"

namespace impulsekit {

inline constexpr int kMostHalvings = 80;

// The zero of a function between a positive and a negative value (Illinois's variant of regula
// falsi): the end at which it is not positive.
template <typename Function>
double zero_between(double a, double fa, double b, double fb, Function f) {
    int side = 0;
    for (int i = 0;
         i < kMostHalvings && b - a > tolerance::last_bits * std::max(std::abs(a), std::abs(b));
         ++i) {
        double middle = fb == fa ? 0.5 * (a + b) : b - fb * (b - a) / (fb - fa);
        if (!(middle > a && middle < b) || i % 8 == 7) middle = 0.5 * (a + b);
        if (!(middle > a && middle < b)) break;
        const double value = f(middle);
        if (value == 0.0) return middle;
        if (value < 0.0) {
            b = middle;
            fb = value;
            if (side == -1) fa *= 0.5;
            side = -1;
        } else {
            a = middle;
            fa = value;
            if (side == 1) fb *= 0.5;
            side = 1;
        }
    }
    return b;
}

}  // namespace impulsekit
