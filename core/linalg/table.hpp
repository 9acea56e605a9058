// Values by a number.
#pragma once

#include <algorithm>
#include <vector>

namespace impulsekit {

// Linear between rising points, constant beyond them.
struct Table {
    std::vector<double> points, values;

    bool empty() const { return points.empty(); }
    double at(double x) const {
        const std::size_t i = std::upper_bound(points.begin(), points.end(), x) - points.begin();
        if (i == 0) return values.front();
        if (i == points.size()) return values.back();
        return slope_before(i) * (x - points[i - 1]) + values[i - 1];
    }
    // Between the (i − 1)-th point and the i-th.
    double slope_before(std::size_t i) const {
        return (values[i] - values[i - 1]) / (points[i] - points[i - 1]);
    }
};

}  // namespace impulsekit
