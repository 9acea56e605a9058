// Shapes of each kind, and how far they reach.
#include "geometry/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "linalg/tolerances.hpp"

namespace impulsekit {
namespace {

using V = Vec3<double>;

double length(const V& a) { return std::sqrt(dot(a, a)); }
V unit(const V& a) { return a * (1.0 / length(a)); }

void add_axis(std::vector<V>& axes, const V& a) {
    for (const V& b : axes) {
        const V less = a - b, more = a + b;
        if (std::min(dot(less, less), dot(more, more)) < tolerance::alike * tolerance::alike)
            return;
    }
    axes.push_back(a);
}

void bound(Shape& shape, const V& centre) {
    shape.centre = centre;
    shape.reach = 0.0;
    for (const V& p : shape.points) shape.reach = std::max(shape.reach, length(p - centre));
    for (const Shape::Circle& c : shape.circles) {
        const V away = c.centre - centre;
        shape.reach = std::max(shape.reach, std::hypot(length(away), c.radius));
    }
    shape.reach += shape.radius;
}

Shape round_shape(Shape::Kind kind, double around, const Placement& at) {
    Shape shape;
    shape.kind = kind;
    shape.radius = around;
    shape.axis = at.rotation.z;
    shape.across = at.rotation.x;
    return shape;
}

void add_end(Shape& shape, const V& normal, const V& point) {
    shape.faces.push_back({normal, dot(normal, point), {}});
    add_axis(shape.face_axes, normal);
}

}  // namespace

int parts_of(const Shape& shape) {
    return static_cast<int>(shape.kind == Shape::polytope
                                ? shape.edges.size()
                                : shape.points.size() + shape.circles.size());
}

Shape part_of(const Shape& shape, int part) {
    Shape found;
    found.radius = shape.radius;
    found.axis = shape.axis;
    found.across = shape.across;
    const int count = static_cast<int>(shape.points.size());
    if (shape.kind == Shape::polytope) {
        found.kind = Shape::capsule;
        found.points = {shape.points[shape.edges[part].start], shape.points[shape.edges[part].end]};
        bound(found, (found.points[0] + found.points[1]) * 0.5);
    } else if (part < count) {
        found.points = {shape.points[part]};
        bound(found, found.points[0]);
    } else {
        found.kind = Shape::cylinder;
        found.circles = {shape.circles[part - count]};
        bound(found, found.circles[0].centre);
    }
    return found;
}

Shape ball_shape(double radius, const Placement& at) {
    Shape shape = round_shape(Shape::ball, radius, at);
    shape.points = {at.origin};
    bound(shape, at.origin);
    return shape;
}

Shape capsule_shape(double radius, double half_length, const Placement& at) {
    Shape shape = round_shape(Shape::capsule, radius, at);
    shape.points = {at.act({0, 0, -half_length}), at.act({0, 0, half_length})};
    shape.edges = {{0, 1}};
    shape.edge_axes = {shape.axis};
    bound(shape, at.origin);
    return shape;
}

Shape cylinder_shape(double radius, double half_length, double around, const Placement& at) {
    Shape shape = round_shape(Shape::cylinder, around, at);
    for (double sign : {-1.0, 1.0}) {
        const V middle = at.act({0, 0, sign * half_length});
        shape.circles.push_back({middle, radius});
        add_end(shape, shape.axis * sign, middle);
    }
    shape.edge_axes = {shape.axis};
    bound(shape, at.origin);
    return shape;
}

Shape cone_shape(double radius, double half_length, double around, const Placement& at) {
    Shape shape = round_shape(Shape::cone, around, at);
    shape.points = {at.act({0, 0, half_length})};
    shape.circles = {{at.act({0, 0, -half_length}), radius}};
    add_end(shape, -shape.axis, shape.circles[0].centre);
    bound(shape, at.origin);
    return shape;
}

Shape ellipsoid_shape(const V& semi_axes, double around, const Placement& at) {
    Shape shape = round_shape(Shape::ellipsoid, around, at);
    shape.axes = {at.rotation.x * semi_axes.x, at.rotation.y * semi_axes.y,
                  at.rotation.z * semi_axes.z};
    shape.centre = at.origin;
    shape.reach = std::max({semi_axes.x, semi_axes.y, semi_axes.z}) + around;
    return shape;
}

Shape half_space_shape(const V& normal, double offset, const Placement& at) {
    Shape shape;
    shape.kind = Shape::half_space;
    const V n = at.rotation * normal;
    shape.faces = {{n, offset + dot(n, at.origin), {}}};
    return shape;
}

Shape box_shape(const V& half, double around, const Placement& at) {
    std::vector<V> corners;
    for (double x : {-1.0, 1.0})
        for (double y : {-1.0, 1.0})
            for (double z : {-1.0, 1.0}) corners.push_back({x * half.x, y * half.y, z * half.z});
    return polytope_shape(
        corners,
        {{0, 1, 3, 2}, {4, 6, 7, 5}, {0, 4, 5, 1}, {2, 3, 7, 6}, {0, 2, 6, 4}, {1, 5, 7, 3}},
        around, at);
}

Shape polytope_shape(const std::vector<V>& corners, const std::vector<std::vector<int>>& loops,
                     double around, const Placement& at) {
    Shape shape = round_shape(Shape::polytope, around, at);
    V sum;
    for (const V& corner : corners) {
        shape.points.push_back(at.act(corner));
        sum += shape.points.back();
    }
    std::map<std::pair<int, int>, int> face_at;
    for (std::size_t k = 0; k < loops.size(); ++k)
        for (std::size_t i = 0; i < loops[k].size(); ++i)
            face_at[{loops[k][i], loops[k][(i + 1) % loops[k].size()]}] = static_cast<int>(k);
    for (const std::vector<int>& loop : loops) {
        // Newell's normal, and the mean height.
        const int n = static_cast<int>(loop.size());
        V normal, middle;
        for (int k = 0; k < n; ++k) middle += shape.points[loop[k]] * (1.0 / n);
        for (int k = 0; k < n; ++k)
            normal +=
                cross(shape.points[loop[k]] - middle, shape.points[loop[(k + 1) % n]] - middle);
        normal = unit(normal);
        shape.faces.push_back({normal, dot(normal, middle), loop});
        add_axis(shape.face_axes, normal);
        for (int k = 0; k < n; ++k) {
            const int i = loop[k], j = loop[(k + 1) % n];
            if (i > j) continue;
            const auto right = face_at.find({j, i});
            shape.edges.push_back({i, j, static_cast<int>(shape.faces.size()) - 1,
                                   right == face_at.end() ? -1 : right->second});
            add_axis(shape.edge_axes, unit(shape.points[j] - shape.points[i]));
        }
    }
    bound(shape, sum * (1.0 / static_cast<double>(corners.size())));
    return shape;
}

double support(const Shape& shape, const V& d, V* point) {
    V at;
    double best = -std::numeric_limits<double>::infinity();
    if (shape.kind == Shape::ellipsoid) {
        const V across = back(shape.axes, d);
        const double size = length(across);
        at = size > 0.0 ? shape.centre + shape.axes * (across * (1.0 / size)) : shape.centre;
        best = dot(d, shape.centre) + size;
    }
    for (const V& p : shape.points) {
        const double height = dot(p, d);
        if (height > best) best = height, at = p;
    }
    if (!shape.circles.empty()) {
        const V out = d - shape.axis * dot(d, shape.axis);
        const double sine = length(out);
        const V along = sine > 0.0 ? out * (1.0 / sine) : shape.across;
        for (const Shape::Circle& c : shape.circles) {
            const double height = dot(c.centre, d) + c.radius * sine;
            if (height > best) best = height, at = c.centre + along * c.radius;
        }
    }
    if (point) *point = at + d * shape.radius;
    return best + shape.radius;
}

}  // namespace impulsekit
