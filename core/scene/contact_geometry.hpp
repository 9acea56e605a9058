// Axes on a normal, and where a ball meets a shape.
#pragma once

#include <algorithm>
#include <cmath>

#include "linalg/numbers.hpp"
#include "scene/scene.hpp"

namespace impulsekit {

// A right-handed triad on a unit normal: t₁ is the world axis that is most across the normal, made
// perpendicular to it. S of one lane.
template <typename S>
Mat3<S> contact_axes(const Vec3<S>& n) {
    const auto size = [](const S& a) { return std::abs(Number<S>::get(a, 0)); };
    const double x = size(n.x), y = size(n.y), z = size(n.z);
    Vec3<S> t = x <= y + kAlongNormal && x <= z + kAlongNormal
                    ? Vec3<S>{1.0 - n.x * n.x, -n.y * n.x, -n.z * n.x}
                : y <= z + kAlongNormal ? Vec3<S>{-n.x * n.y, 1.0 - n.y * n.y, -n.z * n.y}
                                        : Vec3<S>{-n.x * n.z, -n.y * n.z, 1.0 - n.z * n.z};
    const S length = root(dot(t, t));
    t = {t.x / length, t.y / length, t.z / length};
    return {t, cross(n, t), n};
}

// A number kept between two bounds.
template <typename S>
S within(const S& x, double low, double high) {
    const double value = Number<S>::get(x, 0);
    return value < low ? number<S>(low) : value > high ? number<S>(high) : x;
}

// The shortest way out of a core from a point within: its direction, and how long it is.
template <typename S>
Vec3<S> shortest_way_out(const Ball& ball, const Vec3<S>& c, S& length) {
    const auto get = [](const S& x) { return Number<S>::get(x, 0); };
    const auto sign = [&](const S& x) { return number<S>(get(x) < 0.0 ? -1.0 : 1.0); };
    // The depth of a coordinate within a half size.
    const auto depth = [&](double size, const S& x) { return size - sign(x) * x; };
    const double* size = ball.size;
    length = S{};
    const S one = number<S>(1.0), zero{};
    if (ball.kind == Ball::capsule) return {one, zero, zero};
    if (ball.kind == Ball::ball) return {zero, zero, one};
    const S z = depth(size[ball.kind == Ball::box ? 2 : 1], c.z);
    if (ball.kind == Ball::cylinder) {
        const S square = c.x * c.x + c.y * c.y;
        const bool on_axis = !(get(square) > 0.0);
        const S out = on_axis ? zero : root(square);
        length = z;
        if (get(z) <= size[0] - get(out)) return {zero, zero, sign(c.z)};
        length = size[0] - out;
        if (on_axis) return {one, zero, zero};
        return {c.x / out, c.y / out, zero};
    }
    const S x = depth(size[0], c.x), y = depth(size[1], c.y);
    const double least = std::min({get(x), get(y), get(z)});
    length = get(x) == least ? x : get(y) == least ? y : z;
    if (get(x) == least) return {sign(c.x), zero, zero};
    if (get(y) == least) return {zero, sign(c.y), zero};
    return {zero, zero, sign(c.z)};
}

// The contact of a ball and a shape, in the shape's axes: the point halfway between the surfaces,
// the normal towards the ball's centre c, and the gap. A shape is a core and a radius around it: of
// a ball a point, of a capsule a segment, of a box or a cylinder the whole. From within a core the
// shortest way out counts.
template <typename S>
S ball_contact(const Ball& ball, const Vec3<S>& c, Vec3<S>& point, Vec3<S>& normal) {
    const auto get = [](const S& x) { return Number<S>::get(x, 0); };
    const double a = ball.size[0], b = ball.size[1], d = ball.size[2];
    double around = 0.0;
    Vec3<S> core;
    if (ball.kind == Ball::plane) {
        const S gap = c.z - ball.radius;
        normal = {S{}, S{}, number<S>(1.0)};
        point = {c.x, c.y, 0.5 * gap};
        return gap;
    }
    if (ball.kind == Ball::box) {
        core = {within(c.x, -a, a), within(c.y, -b, b), within(c.z, -d, d)};
    } else if (ball.kind == Ball::cylinder) {
        const S square = c.x * c.x + c.y * c.y;
        S share = number<S>(1.0);
        if (std::sqrt(get(square)) > a) share = a / root(square);
        core = {c.x * share, c.y * share, within(c.z, -b, b)};
    } else {
        around = a;
        if (ball.kind == Ball::capsule) core.z = within(c.z, -b, b);
    }
    const Vec3<S> offset = c - core;
    const S square = dot(offset, offset);
    if (!(get(square) > 0.0)) {
        S out{};
        normal = shortest_way_out(ball, c, out);
        const S gap = -out - around - ball.radius;
        point = core + normal * (out + around + 0.5 * gap);
        return gap;
    }
    const S length = root(square);
    normal = {offset.x / length, offset.y / length, offset.z / length};
    const S gap = length - around - ball.radius;
    point = core + normal * (around + 0.5 * gap);
    return gap;
}

}  // namespace impulsekit
