// Cores of convex shapes, and first guesses of where two are nearest: simplices of their
// difference.
#pragma once

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "geometry/shapes.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit::convex {

using V = Vec3<double>;

// First guesses need no more digits than Newton's method takes to converge.
inline constexpr double kGuess = 1e-7;
inline constexpr int kMostSupports = 60;

inline double length(const V& a) { return std::sqrt(dot(a, a)); }

// A part of a core that reaches furthest: a corner, a rim or the whole ellipsoid.
struct Part {
    int number = 0;  // among points, then circles; the ellipsoid is 0
    V point;
};

// A core somewhere: directions and points go through its placement.
struct Core {
    const Shape& shape;
    Placement at;

    double reach(const V& direction, Part& part) const {
        const V d = back(at.rotation, direction);
        const int count = static_cast<int>(shape.points.size());
        double best = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < count; ++i) {
            const double height = dot(shape.points[i], d);
            if (height > best) best = height, part.number = i;
        }
        if (!shape.circles.empty()) {
            const V out = d - shape.axis * dot(d, shape.axis);
            const double sine = length(out);
            for (int i = 0; i < static_cast<int>(shape.circles.size()); ++i) {
                const auto& c = shape.circles[i];
                const double height = dot(c.centre, d) + c.radius * sine;
                if (height > best) best = height, part.number = count + i;
            }
        }
        if (shape.kind == Shape::ellipsoid) part.number = 0;
        part.point = point_of(part.number, direction);
        return dot(part.point, direction);
    }

    // Count the points that reach furthest along a direction, within `level`; the first and the
    // last.
    int count_furthest(const V& direction, double level, V* ends) const {
        if (shape.kind == Shape::ellipsoid) return 1;
        const V d = back(at.rotation, direction);
        const V out = d - shape.axis * dot(d, shape.axis);
        const double sine = length(out);
        const V along = sine > 0.0 ? out * (1.0 / sine) : shape.across;
        double best = -std::numeric_limits<double>::infinity();
        int count = 0;
        const auto each = [&](const auto& use_point) {
            for (const V& p : shape.points) use_point(p);
            for (const auto& c : shape.circles)
                for (double sign : {1.0, -1.0}) use_point(c.centre + along * (sign * c.radius));
        };
        each([&](const V& p) { best = std::max(best, dot(p, d)); });
        each([&](const V& p) {
            if (dot(p, d) >= best - level) ends[count++ > 0] = at.act(p);
        });
        return count;
    }

    // The point of one part that reaches furthest.
    V point_of(int number, const V& direction) const {
        const int count = static_cast<int>(shape.points.size());
        if (shape.kind != Shape::ellipsoid && number < count) return at.act(shape.points[number]);
        const V d = back(at.rotation, direction);
        if (shape.kind == Shape::ellipsoid) {
            const V across = back(shape.axes, d);
            return at.act(shape.centre + shape.axes * (across * (1.0 / length(across))));
        }
        const auto& c = shape.circles[number - count];
        const V out = d - shape.axis * dot(d, shape.axis);
        const double sine = length(out);
        return at.act(c.centre + (sine > 0.0 ? out * (c.radius / sine) : shape.across * c.radius));
    }

    // H t, how fast that point moves as the direction turns by t.
    V rate_of(int number, const V& direction, const V& t) const {
        const int count = static_cast<int>(shape.points.size());
        if (shape.kind != Shape::ellipsoid && number < count) return {};
        const V d = back(at.rotation, direction), turn = back(at.rotation, t);
        if (shape.kind == Shape::ellipsoid) {
            const V across = back(shape.axes, d), rate = back(shape.axes, turn);
            const double size = length(across);
            const V along = across * (dot(across, rate) / (size * size));
            return at.rotation * (shape.axes * ((rate - along) * (1.0 / size)));
        }
        const V out = d - shape.axis * dot(d, shape.axis);
        const double sine = length(out);
        if (!(sine > 0.0)) return {};
        const V side = cross(shape.axis, out * (1.0 / sine));
        const double share = shape.circles[number - count].radius * dot(side, turn) / sine;
        return at.rotation * (side * share);
    }
};

struct Pair {
    Core a, b;
    double around, size;

    double separation(const V& n) const {
        Part one, two;
        return -a.reach(-n, one) - b.reach(n, two);
    }
};

// A point of the difference of two cores, and its weight.
struct Corner {
    Part one, two;
    V at;
    double weight = 0.0;
};

struct Simplex {
    std::array<Corner, 4> corners;
    int count = 0;

    V sum() const {
        V found;
        for (int k = 0; k < count; ++k) found += corners[k].at * corners[k].weight;
        return found;
    }
};

// Solve a small system with row exchanges; false where it is singular.
template <int N>
bool solve(double (&m)[N][N], double (&x)[N], int n) {
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int i = k + 1; i < n; ++i)
            if (std::abs(m[i][k]) > std::abs(m[best][k])) best = i;
        if (!(std::abs(m[best][k]) > tolerance::rounding)) return false;
        for (int j = 0; j < n; ++j) std::swap(m[k][j], m[best][j]);
        std::swap(x[k], x[best]);
        for (int i = k + 1; i < n; ++i) {
            const double f = m[i][k] / m[k][k];
            for (int j = k; j < n; ++j) m[i][j] -= f * m[k][j];
            x[i] -= f * x[k];
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int j = k + 1; j < n; ++j) x[k] -= m[k][j] * x[j];
        x[k] /= m[k][k];
    }
    return true;
}

// Weights of the point nearest to −shift among the hull of some corners; corners without go.
inline void reduce(Simplex& simplex, const V& shift) {
    double best = std::numeric_limits<double>::infinity();
    Simplex found = simplex;
    for (int set = 1; set < 1 << simplex.count; ++set) {
        Simplex own;
        for (int k = 0; k < simplex.count; ++k)
            if (set >> k & 1) own.corners[own.count++] = simplex.corners[k];
        double m[3][3], x[3];
        const V base = own.corners[0].at + shift;
        double scale = 0.0;
        for (int i = 1; i < own.count; ++i) {
            const V e = own.corners[i].at - own.corners[0].at;
            scale = std::max(scale, dot(e, e));
        }
        for (int i = 1; i < own.count; ++i) {
            const V e = own.corners[i].at - own.corners[0].at;
            for (int j = 1; j < own.count; ++j)
                m[i - 1][j - 1] = dot(e, own.corners[j].at - own.corners[0].at) / scale;
            x[i - 1] = -dot(e, base) / scale;
        }
        if (!solve(m, x, own.count - 1)) continue;
        double rest = 1.0;
        bool inside = true;
        for (int i = 1; i < own.count; ++i) {
            own.corners[i].weight = x[i - 1];
            rest -= x[i - 1];
            inside = inside && x[i - 1] >= 0.0;
        }
        own.corners[0].weight = rest;
        if (!inside || rest < 0.0) continue;
        const V point = own.sum() + shift;
        // Among equally near ones that with fewer corners.
        if (dot(point, point) < best * (1.0 - tolerance::sums))
            best = dot(point, point), found = own;
    }
    simplex = found;
}

inline Corner corner_along(const Pair& pair, const V& n) {
    Corner found;
    pair.a.reach(-n, found.one);
    pair.b.reach(n, found.two);
    found.at = found.one.point - found.two.point;
    return found;
}

// The point of the difference of the cores nearest to −shift, up to a guess's digits
// (Gilbert, Johnson & Keerthi 1988); sooner where the distance is known to be above or below one
// that is given.
inline Simplex nearest_simplex(const Pair& pair, const V& n, const V& shift,
                               double enough = std::numeric_limits<double>::quiet_NaN()) {
    Simplex simplex;
    simplex.corners[0] = corner_along(pair, n);
    simplex.corners[0].weight = 1.0;
    simplex.count = 1;
    for (int k = 0; k < kMostSupports; ++k) {
        const V point = simplex.sum() + shift;
        const double away = length(point);
        if (!(away > tolerance::sums * pair.size) || away <= enough) break;
        const V along = point * (1.0 / away);
        const Corner next = corner_along(pair, along);
        const double least = dot(next.at + shift, along);
        if (away - least <= kGuess * away || least > enough) break;
        bool known = false;
        for (int i = 0; i < simplex.count; ++i) {
            const V same = simplex.corners[i].at - next.at;
            known = known || dot(same, same) == 0.0;
        }
        if (known || simplex.count == 4) break;
        simplex.corners[simplex.count++] = next;
        const Simplex before = simplex;
        reduce(simplex, shift);
        if (simplex.count == 0) return before;
    }
    return simplex;
}

}  // namespace impulsekit::convex
