// The names of points at which two bodies touch, and such points followed as the bodies move.
#include "geometry/features.hpp"

#include <algorithm>
#include <limits>

#include "geometry/patch.hpp"

namespace impulsekit {

using V = Vec3<double>;

double inside_of(const Shape& shape, const Face& face, const V& point) {
    double least = std::numeric_limits<double>::infinity();
    const std::size_t n = face.loop.size();
    for (std::size_t k = 0; k < n; ++k) {
        const V& corner = shape.points[face.loop[k]];
        const V along = shape.points[face.loop[(k + 1) % n]] - corner;
        least = std::min(least, dot(cross(face.normal, along), point - corner) / length(along));
    }
    for (const Shape::Circle& c : shape.circles) {
        if (n > 0 || std::abs(dot(face.normal, c.centre) - face.offset) > kBeside) continue;
        const V along = point - c.centre;
        least = std::min(least, c.radius - length(along - face.normal * dot(along, face.normal)));
    }
    return least;
}

double inside_of(const Crossing& c) { return std::min({c.s, c.size - c.s, c.u, c.reach - c.u}); }

Crossing crossing_of(const V& start, const V& end, const V& from, const V& to) {
    Crossing c;
    V e = end - start, f = to - from;
    c.size = length(e), c.reach = length(f);
    e = e * (1.0 / c.size), f = f * (1.0 / c.reach);
    c.turn = cross(e, f);
    c.square = dot(c.turn, c.turn);
    const V apart = from - start;
    c.s = dot(cross(apart, f), c.turn) / c.square;
    c.u = dot(cross(apart, e), c.turn) / c.square;
    c.here = start + e * c.s, c.there = from + f * c.u;
    return c;
}

OverFace over_face(const Shape& own, const Placement& at, const Shape& ground,
                   const Feature& feature, const V& spot) {
    const Face& face = ground.faces[feature.index[2]];
    OverFace found;
    found.n = face.normal;
    const V n = back(at.rotation, face.normal);
    const int tip = feature.index[1], count = static_cast<int>(own.points.size());
    double flat = std::numeric_limits<double>::infinity(), around = own.radius;
    if (feature.kind == Feature::spot_on_face) {
        found.x = spot, around = 0.0;
    } else if (own.kind == Shape::ellipsoid) {
        const V across = back(own.axes, n);
        found.x = own.centre - own.axes * (across * (1.0 / length(across)));
    } else if (tip < count) {
        found.x = own.points[tip];
    } else {
        const Shape::Circle& c = own.circles[tip - count];
        const V out = n - own.axis * dot(own.axis, n);
        const double sine = length(out);
        found.x = c.centre - (sine > 0.0 ? out * (c.radius / sine) : own.across * c.radius);
        flat = 2.0 * c.radius * sine - kComesFlat;
    }
    found.x = at.act(found.x) - face.normal * around;
    found.gap = dot(face.normal, found.x) - face.offset - ground.radius;
    found.inside = std::min(flat, inside_of(ground, face, found.x));
    return found;
}

bool is_named(const Feature& feature, const std::vector<Shape>& first,
              const std::vector<Shape>& other) {
    const int* piece = feature.piece;
    const auto has = [](int i, std::size_t size) { return i >= 0 && i < static_cast<int>(size); };
    if (!has(piece[0], first.size()) || !has(piece[1], other.size())) return false;
    const Shape &a = first[piece[0]], &b = other[piece[1]];
    const int* index = feature.index;
    if (feature.kind == Feature::nearest_points) return true;
    if (feature.kind == Feature::nearest_part)
        return has(index[0], 2) && index[1] >= 0 && index[1] < parts_of(index[0] == 0 ? a : b);
    if (feature.kind == Feature::edges_cross)
        return has(index[0], a.points.size()) && has(index[1], a.points.size()) &&
               has(index[2], b.points.size()) && has(index[3], b.points.size());
    const Shape &own = index[0] == 0 ? a : b, &ground = index[0] == 0 ? b : a;
    if ((index[0] != 0 && index[0] != 1) || !has(index[2], ground.faces.size())) return false;
    return feature.kind == Feature::spot_on_face || own.kind == Shape::ellipsoid ||
           has(index[1], own.points.size() + own.circles.size());
}

bool Feature::operator==(const Feature& other) const {
    // For crossing edges the sign alone is part of the name.
    const int said = kind == edges_cross ? 1 : 3;
    return kind == other.kind && std::equal(piece, piece + 2, other.piece) &&
           std::equal(index, index + 4, other.index) &&
           std::equal(fixed, fixed + said, other.fixed);
}

ContactPoint follow(const Feature& feature, const std::vector<Shape>& first, const Placement& pa,
                    const std::vector<Shape>& other, const Placement& pb, double* inside) {
    const Shape &a = first[feature.piece[0]], &b = other[feature.piece[1]];
    ContactPoint found;
    found.feature = feature;
    double ends = std::numeric_limits<double>::infinity();
    if (inside) *inside = ends;
    const V fixed = vec3<double>(feature.fixed);
    if (feature.kind == Feature::edges_cross) {
        // In the frame of the other's joint: digits of places in the world are not in the gap.
        const Placement at = relative_to(pb, pa);
        const int* k = feature.index;
        const Crossing c = crossing_of(at.act(a.points[k[0]]), at.act(a.points[k[1]]),
                                       b.points[k[2]], b.points[k[3]]);
        const double sine = std::sqrt(c.square);
        const V n = c.turn * (feature.fixed[0] / sine);
        found.gap = dot(n, c.here - c.there) - a.radius - b.radius;
        found.point = pb.act((c.here + c.there - n * (a.radius - b.radius)) * 0.5);
        found.normal = pb.rotation * n;
        ends = sine < feature.fixed[1] ? -ends : inside_of(c);
    } else if (feature.kind == Feature::nearest_part) {
        const bool of_first = feature.index[0] == 0;
        const Shape part = part_of(of_first ? a : b, feature.index[1]);
        const Nearest near = of_first ? nearest(part, pa, b, pb) : nearest(a, pa, part, pb);
        found.gap = near.gap, found.normal = near.normal;
        found.point = (near.on_first + near.on_other) * 0.5;
    } else if (feature.kind == Feature::nearest_points) {
        const Nearest near = nearest(a, pa, b, pb);
        found.gap = near.gap, found.normal = near.normal;
        found.point = (near.on_first + near.on_other) * 0.5;
    } else {
        const int side = feature.index[0];
        const Placement &own = side == 0 ? pa : pb, &ground = side == 0 ? pb : pa;
        const Placement at = relative_to(ground, own);
        const Shape &body = side == 0 ? a : b, &under = side == 0 ? b : a;
        const OverFace over = over_face(body, at, under, feature, fixed);
        const V n = ground.rotation * over.n;
        found.gap = over.gap;
        found.point = ground.act(over.x - over.n * (0.5 * over.gap));
        found.normal = side == 0 ? n : -n;
        ends = over.inside;
    }
    if (inside) *inside = ends;
    return found;
}

}  // namespace impulsekit
