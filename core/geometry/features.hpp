// Features: parts of two bodies by which a point at which they touch is followed.
#pragma once

#include <cmath>

#include "geometry/shapes.hpp"

namespace impulsekit {

inline double length(const Vec3<double>& a) { return std::sqrt(dot(a, a)); }

// Distance of a point of a face's plane from its border, inwards [m]; infinite without border.
double inside_of(const Shape& shape, const Face& face, const Vec3<double>& point);

// Two lines where they are nearest: s and u along them, and e × f.
struct Crossing {
    Vec3<double> turn, here, there;
    double square, s, u, size, reach;
};
Crossing crossing_of(const Vec3<double>& start, const Vec3<double>& end, const Vec3<double>& from,
                     const Vec3<double>& to);

// How far both points are from the ends of their edges, inwards [m].
double inside_of(const Crossing& crossing);

// A tip, corner or fixed spot of a body on a face of the other: the point of its surface, how far
// over the face it is and from where that ends.
struct OverFace {
    Vec3<double> x, n;
    double gap, inside;
};
// `at`: of the body's joint in that of the ground.
OverFace over_face(const Shape& own, const Placement& at, const Shape& ground,
                   const Feature& feature, const Vec3<double>& spot);

}  // namespace impulsekit
