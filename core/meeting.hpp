// Axes on a normal, and where a ball meets a shape.
#pragma once

#include <algorithm>
#include <cmath>

#include "numbers.hpp"
#include "scene.hpp"

namespace impulsekit {

// A right-handed triad on a unit normal: t₁ is the world axis that is most across the normal, made
// perpendicular to it.
inline Mat3<double> contact_axes(const Vec3<double>& n) {
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    Vec3<double> t = x <= y && x <= z ? Vec3<double>{1.0 - n.x * n.x, -n.y * n.x, -n.z * n.x}
                     : y <= z         ? Vec3<double>{-n.x * n.y, 1.0 - n.y * n.y, -n.z * n.y}
                                      : Vec3<double>{-n.x * n.z, -n.y * n.z, 1.0 - n.z * n.z};
    const double length = std::sqrt(dot(t, t));
    t = {t.x / length, t.y / length, t.z / length};
    return {t, cross(n, t), n};
}

// Where a ball meets a shape, in the shape's axes: the point halfway between the surfaces, the
// normal towards the ball's centre c, and the gap; NaN where the centre lies within the core. A
// shape is a core and a radius around it: of a ball a point, of a capsule a segment, of a box or a
// cylinder the whole.
inline double meet_ball(const Ball& ball, const Vec3<double>& c, Vec3<double>& point,
                        Vec3<double>& normal) {
    const double a = ball.size[0], b = ball.size[1], d = ball.size[2];
    double around = 0.0;
    Vec3<double> core;
    if (ball.kind == Ball::box) {
        core = {std::clamp(c.x, -a, a), std::clamp(c.y, -b, b), std::clamp(c.z, -d, d)};
    } else if (ball.kind == Ball::cylinder) {
        const double out = std::sqrt(c.x * c.x + c.y * c.y), share = out > a ? a / out : 1.0;
        core = {c.x * share, c.y * share, std::clamp(c.z, -b, b)};
    } else {
        around = a;
        if (ball.kind == Ball::capsule) core.z = std::clamp(c.z, -b, b);
    }
    const Vec3<double> way = c - core;
    const double length = std::sqrt(dot(way, way));
    if (!(length > 0.0)) {
        normal = {0.0, 0.0, 1.0};
        point = core + normal * around;
        return NAN;
    }
    normal = {way.x / length, way.y / length, way.z / length};
    const double gap = length - around - ball.radius;
    point = core + normal * (around + 0.5 * gap);
    return gap;
}

}  // namespace impulsekit
