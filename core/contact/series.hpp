// Taylor series of slip that turns, and numbers with their slopes by what a path starts from.
#pragma once

#include <algorithm>
#include <cmath>

#include "contact/path.hpp"
#include "contact/tolerances.hpp"
#include "linalg/numbers.hpp"

namespace impulsekit {

// Terms of a series: a step of this order is exact to rounding.
inline constexpr int kOrder = 20;

using Derived = Dual<16>;
static_assert(kPathParameters <= 16, "each parameter has a slope");

inline double value_of(double x) { return x; }
inline double value_of(const Derived& x) { return x.value; }

inline double size_of(double x) { return std::abs(x); }
inline Derived size_of(const Derived& x) { return x.value < 0.0 ? -x : x; }

inline double length_of(double x, double y) { return std::hypot(x, y); }
// At zero without derivatives, which it has none of there.
inline Derived length_of(const Derived& x, const Derived& y) {
    if (x.value == 0.0 && y.value == 0.0) return {};
    return root(x * x + y * y);
}

// x with p(x) = goal moves by (∂goal − ∂p)/p'.
inline double moved(double x, double, double, double) { return x; }
inline Derived moved(double x, const Derived& goal, const Derived& here, double slope) {
    Derived found{x, {}};
    for (int i = 0; i < kPathParameters && slope != 0.0; ++i)
        found.slope[i] = (goal.slope[i] - here.slope[i]) / slope;
    return found;
}

template <typename S>
struct Series {
    S c[kOrder + 1];

    S at(const S& x) const {
        S total{};
        for (int k = kOrder; k >= 0; --k) total = total * x + c[k];
        return total;
    }
    S gain(const S& x) const {
        S total{};
        for (int k = kOrder; k >= 1; --k) total = total * x + c[k];
        return x * total;
    }
    S integral(const S& x) const {
        S total{};
        for (int k = kOrder - 1; k >= 0; --k) total = total * x + c[k] / (k + 1);
        return x * total;
    }
    // The root between 0 and `high` of the series, monotone there, minus a value: Newton, bisected.
    S root(const S& goal, const S& high) const {
        const double value = value_of(goal);
        double low = 0.0, top = value_of(high), x = top, slope = 0.0;
        bool rising = at(high) >= c[0];
        for (int count = 0; count < 100; ++count) {
            double here = 0.0;
            slope = 0.0;
            for (int k = kOrder; k >= 0; --k) {
                slope = slope * x + here;
                here = here * x + value_of(c[k]);
            }
            double missing = value - here;
            if (missing == 0.0) break;
            ((missing > 0.0) == rising ? low : top) = x;
            double next = slope != 0.0 ? x + missing / slope : 0.5 * (low + top);
            if (!(low <= next && next <= top)) next = 0.5 * (low + top);
            if (std::abs(next - x) <= 0.25 * tolerance::last_bits * x) break;
            x = next;
        }
        return moved(x, goal, at(number<S>(x)), slope);
    }
};

template <typename S>
Series<S> integral_of(const Series<S>& f) {
    Series<S> result{};
    for (int k = 0; k < kOrder; ++k) result.c[k + 1] = f.c[k] / (k + 1);
    return result;
}

template <typename S>
Series<S> product(const Series<S>& f, const Series<S>& g) {
    Series<S> result{};
    for (int k = 0; k <= kOrder; ++k)
        for (int j = 0; j <= k; ++j) result.c[k] += f.c[j] * g.c[k - j];
    return result;
}

}  // namespace impulsekit
