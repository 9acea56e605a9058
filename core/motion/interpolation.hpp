// The polynomial through values at Chebyshev's points (Berrut & Trefethen 2004, eq. (5.4)).
#pragma once

#include <cmath>

#include "linalg/tolerances.hpp"

namespace impulsekit {

struct Interpolation {
    static constexpr int count = 8;
    double nodes[count];  // times of the values, the first and the last at the ends
    double span;

    Interpolation(double begin, double end) : span(end - begin) {
        constexpr double kPi = 3.14159265358979323846;
        for (int i = 0; i < count; ++i)
            nodes[i] = begin + 0.5 * (1.0 - std::cos(kPi * i / (count - 1))) * span;
    }
    // (count) shares of the values in that at a time.
    void shares(double at, double* to) const {
        double sum = 0.0;
        for (int i = 0; i < count; ++i) {
            const double apart = at - nodes[i];
            if (std::abs(apart) < tolerance::sums * span) {
                for (int j = 0; j < count; ++j) to[j] = i == j;
                return;
            }
            to[i] = (i % 2 == 0 ? 1.0 : -1.0) * (i == 0 || i == count - 1 ? 0.5 : 1.0) / apart;
            sum += to[i];
        }
        for (int i = 0; i < count; ++i) to[i] /= sum;
    }
};

}  // namespace impulsekit
