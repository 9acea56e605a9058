// Points of contacts, as Python reads them.
#pragma once

#include <vector>

#include "scene/contact_frame.hpp"

namespace impulsekit {

using Point = ContactFrame<double>;

// A part of all points.
template <typename T, typename Class>
std::vector<T> of_each(const std::vector<Point>& points, T Class::* part) {
    std::vector<T> found;
    for (const Point& p : points) found.push_back(p.*part);
    return found;
}

// So many numbers of each point.
template <typename Write>
std::vector<double> numbers_of(const std::vector<Point>& points, std::size_t count, Write write) {
    std::vector<double> found(count * points.size());
    for (std::size_t i = 0; i < points.size(); ++i) write(points[i], found.data() + count * i);
    return found;
}

inline std::vector<double> axes_of(const std::vector<Point>& points) {
    return numbers_of(points, 9, [](const Point& p, double* to) { to_rows(p.axes, to); });
}

// `origin`: of the world, as places are seen.
inline std::vector<double> places_of(const std::vector<Point>& points, const Vec3<double>& origin) {
    return numbers_of(points, 3, [&](const Point& p, double* to) {
        const Vec3<double> place = p.place - origin;
        to[0] = place.x, to[1] = place.y, to[2] = place.z;
    });
}

}  // namespace impulsekit
