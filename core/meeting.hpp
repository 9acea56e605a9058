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

// The shortest way out of a core from a point within: its direction, and how long it is.
inline Vec3<double> way_out(const Ball& ball, const Vec3<double>& c, double& length) {
    const auto sign = [](double x) { return x < 0.0 ? -1.0 : 1.0; };
    const double* size = ball.size;
    length = 0.0;
    if (ball.kind == Ball::capsule) return {1.0, 0.0, 0.0};
    if (ball.kind == Ball::cylinder) {
        const double out = std::hypot(c.x, c.y), to_end = size[1] - std::abs(c.z);
        length = std::min(size[0] - out, to_end);
        if (length == to_end) return {0.0, 0.0, sign(c.z)};
        if (!(out > 0.0)) return {1.0, 0.0, 0.0};
        return {c.x / out, c.y / out, 0.0};
    }
    if (ball.kind == Ball::ball) return {0.0, 0.0, 1.0};
    const double x = size[0] - std::abs(c.x), y = size[1] - std::abs(c.y),
                 z = size[2] - std::abs(c.z);
    length = std::min({x, y, z});
    if (length == x) return {sign(c.x), 0.0, 0.0};
    if (length == y) return {0.0, sign(c.y), 0.0};
    return {0.0, 0.0, sign(c.z)};
}

// Where a ball meets a shape, in the shape's axes: the point halfway between the surfaces, the
// normal towards the ball's centre c, and the gap. A shape is a core and a radius around it: of a
// ball a point, of a capsule a segment, of a box or a cylinder the whole. From within a core the
// shortest way out counts.
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
        double out = 0.0;
        normal = way_out(ball, c, out);
        const double gap = -out - around - ball.radius;
        point = core + normal * (out + around + 0.5 * gap);
        return gap;
    }
    normal = {way.x / length, way.y / length, way.z / length};
    const double gap = length - around - ball.radius;
    point = core + normal * (around + 0.5 * gap);
    return gap;
}

}  // namespace impulsekit
