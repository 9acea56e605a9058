// Points at which two bodies touch, and such points followed as the bodies move.
//
// Whatever two convex polytopes share where they touch has as its ends corners of one on a face of
// the other, and crossings of an edge of each: n·(x − o) of a corner x over a face, n·(p − p') of
// the points at which two edges e, f are nearest, n = ± e × f / |e × f|. Of a round body what
// touches a face is a tip, where it reaches furthest against the normal of the face,
//     x = p − ρ n,   x = c − r d − ρ n,  d = (n − (n·a) a) / |n − (n·a) a|,
//     x = c − E Eᵀ n / |Eᵀ n| − ρ n
// of a point p, a rim about c with the axis a, an ellipsoid with the semi-axes E; of a rim that
// lies flat, spots fixed on it.
#include <algorithm>
#include <cmath>

#include "geometry/features.hpp"
#include "geometry/patch.hpp"

namespace impulsekit {

Placement relative_to(const Placement& pb, const Placement& pa) {
    const Mat3<double>& r = pb.rotation;
    return {{back(r, pa.rotation.x), back(r, pa.rotation.y), back(r, pa.rotation.z)},
            pb.back(pa.origin)};
}

Shape placed(const Shape& shape, const Placement& at) {
    Shape found = shape;
    for (auto& p : found.points) p = at.act(p);
    for (auto& c : found.circles) c.centre = at.act(c.centre);
    for (auto& f : found.faces) {
        f.normal = at.rotation * f.normal;
        f.offset += dot(f.normal, at.origin);
    }
    found.axis = at.rotation * shape.axis;
    found.across = at.rotation * shape.across;
    found.centre = at.act(shape.centre);
    found.axes = at.rotation * shape.axes;
    for (auto& a : found.face_axes) a = at.rotation * a;
    for (auto& a : found.edge_axes) a = at.rotation * a;
    return found;
}

namespace {

using V = Vec3<double>;

// Faces and crossings that look further away from the normal of all have no part in it (cosine).
constexpr double kFacesNormal = 0.5;
// The same to say that a face looks along the normal.
constexpr double kLooksAlong = 1.0 - 1e-3;

// Two pieces, the first in the frame of the other's joint.
struct Pieces {
    Shape a;
    const Shape& b;
    Placement at;  // of the first's joint there
    int number[2];

    const Shape& of(int side) const { return side == 0 ? a : b; }
};

struct Finder {
    const Pieces& pieces;
    V n;
    double least, most;
    std::vector<ContactPoint> found;

    void add_point(const V& at, double gap, const Feature& feature) {
        if (!(gap >= least && gap <= most)) return;
        for (const ContactPoint& known : found) {
            const V away = at - known.point;
            if (std::max({std::abs(away.x), std::abs(away.y), std::abs(away.z)}) <= kOnePoint)
                return;
        }
        found.push_back({feature, at, n, gap});
    }
};

Feature named(const Pieces& pieces, Feature::Kind kind, int i, int j, int k, int m = 0) {
    Feature feature;
    feature.kind = kind;
    std::copy(pieces.number, pieces.number + 2, feature.piece);
    const int index[] = {i, j, k, m};
    std::copy(index, index + 4, feature.index);
    return feature;
}

// The corners of a body that are near, on faces of the other that look towards it.
void add_corners(Finder& finder, int side, const std::vector<char>& near) {
    const Shape &own = finder.pieces.of(side), &ground = finder.pieces.of(1 - side);
    const V towards = side == 0 ? finder.n : -finder.n;
    double best = -1.0;
    for (const Face& face : ground.faces) best = std::max(best, dot(face.normal, towards));
    const double least = std::max(kFacesNormal, best - kAlike);
    for (std::size_t i = 0; i < own.points.size(); ++i) {
        if (!near[i]) continue;
        double over = -std::numeric_limits<double>::infinity();
        int face = -1;
        for (std::size_t k = 0; k < ground.faces.size(); ++k) {
            if (!(dot(ground.faces[k].normal, towards) > least)) continue;
            const double above =
                dot(ground.faces[k].normal, own.points[i]) - ground.faces[k].offset;
            if (above > over) over = above, face = static_cast<int>(k);
        }
        if (face < 0 || inside_of(ground, ground.faces[face], own.points[i]) < -kBeside) continue;
        over -= own.radius;
        const double gap = over - ground.radius;
        const V at = own.points[i] - ground.faces[face].normal * (own.radius + 0.5 * gap);
        finder.add_point(
            at, gap,
            named(finder.pieces, Feature::corner_on_face, side, static_cast<int>(i), face));
    }
}

// Points where edges cross at more than an angle (sine).
void add_crossings(Finder& finder, const std::vector<char>* near, double least) {
    const Shape &a = finder.pieces.a, &b = finder.pieces.b;
    for (const Shape::Edge& one : a.edges) {
        if (!near[0][one.start] || !near[0][one.end]) continue;
        for (const Shape::Edge& two : b.edges) {
            if (!near[1][two.start] || !near[1][two.end]) continue;
            const Crossing c = crossing_of(a.points[one.start], a.points[one.end],
                                           b.points[two.start], b.points[two.end]);
            const double sine = std::sqrt(c.square);
            if (sine < tolerance::parallel || sine <= least) continue;
            const double facing = dot(c.turn, finder.n) / sine;
            if (std::abs(facing) < kFacesNormal || inside_of(c) < -kBeside) continue;
            const double sign = facing >= 0.0 ? 1.0 : -1.0;
            const double gap = sign * dot(c.turn, c.here - c.there) / sine - a.radius - b.radius;
            Feature feature =
                named(finder.pieces, Feature::edges_cross, one.start, one.end, two.start, two.end);
            feature.fixed[0] = sign, feature.fixed[1] = kStillCross * sine;
            finder.add_point((c.here + c.there - finder.n * (a.radius - b.radius)) * 0.5, gap,
                             feature);
        }
    }
}

// The ends of what two polytopes share, or one and a half-space, along their normal.
std::vector<ContactPoint> of_polytopes(const Pieces& pieces, double gap, const V& n,
                                       double margin) {
    std::vector<char> near[2];
    double level[2], thick[2], size = 0.0;
    for (int side : {0, 1}) {
        const Shape& own = pieces.of(side);
        const V along = side == 0 ? -n : n;
        level[side] = own.kind == Shape::half_space ? 0.0 : support(own, along);
        thick[side] = own.kind == Shape::half_space ? 1e300 : level[side] + support(own, -along);
        for (const V& p : own.points) {
            const V away = p - own.points[0];
            size = std::max({size, std::abs(away.x), std::abs(away.y), std::abs(away.z)});
        }
    }
    const double rounding = tolerance::solved * size;
    for (int side : {0, 1}) {
        const Shape& own = pieces.of(side);
        const double reach = std::min(margin - gap, 0.5 * thick[side]) + rounding;
        for (const V& p : own.points) {
            const double height = dot(p, side == 0 ? -n : n) + own.radius;
            near[side].push_back(level[side] - height <= reach);
        }
    }
    Finder finder{pieces, n, gap - margin - rounding, margin, {}};
    add_corners(finder, 0, near[0]);
    add_corners(finder, 1, near[1]);
    add_crossings(finder, near, kEndsPatch);
    if (finder.found.empty()) add_crossings(finder, near, 0.0);
    const bool on_first = pieces.a.kind != Shape::half_space;
    const double middle = on_first ? -level[0] - 0.5 * gap : level[1] + 0.5 * gap;
    for (ContactPoint& p : finder.found) p.point += n * (middle - dot(p.point, n));
    return finder.found;
}

// The face of a shape that looks along a direction, −1 if none does.
int face_along(const Shape& shape, const V& direction) {
    int face = -1;
    double best = kLooksAlong;
    for (std::size_t k = 0; k < shape.faces.size(); ++k) {
        const double facing = dot(shape.faces[k].normal, direction);
        if (facing > best) best = facing, face = static_cast<int>(k);
    }
    return face;
}

bool is_hull_of_points(const Shape& s) {
    return s.circles.empty() && s.kind != Shape::ellipsoid && s.kind != Shape::half_space;
}

// The name of the one point at which two hulls of points touch, by which parts of them do: their
// nearest points have kinks where one part follows another. False where a corner does.
bool name_parts(const Pieces& pieces, const PatchPoint& point, const V& n, Feature& found) {
    const Shape &a = pieces.a, &b = pieces.b;
    if (!is_hull_of_points(a) || !is_hull_of_points(b)) return false;
    const auto is_here = [&](const V& at) { return length(at - point.point) <= kOnePoint; };
    const std::vector<char> all[2] = {std::vector<char>(a.points.size(), 1),
                                      std::vector<char>(b.points.size(), 1)};
    Finder finder{pieces, n, point.gap - kOnePoint, point.gap + kOnePoint, {}};
    add_crossings(finder, all, kEndsPatch);
    for (const ContactPoint& crossing : finder.found)
        if (is_here(crossing.point)) {
            found = crossing.feature;
            return true;
        }
    for (int side : {0, 1}) {
        const Shape &own = pieces.of(side), &other = pieces.of(1 - side);
        if (!own.is_round()) continue;
        for (int part = 0; part < parts_of(own); ++part) {
            const Shape tip = part_of(own, part);
            const Nearest near =
                side == 0 ? nearest(tip, {}, other, {}) : nearest(other, {}, tip, {});
            if (!is_here((near.on_first + near.on_other) * 0.5)) continue;
            found = named(pieces, Feature::nearest_part, side, part, 0);
            return true;
        }
    }
    return false;
}

// The name of a point of a patch: a tip or corner on a face that looks along the normal, if one is
// there; a part of one body and the other's point next to it; a spot on a face; else the nearest
// points.
Feature name_of(const Pieces& pieces, const PatchPoint& point, const V& n, bool alone) {
    for (int side : {0, 1}) {
        const Shape &own = pieces.of(side), &ground = pieces.of(1 - side);
        if (own.kind == Shape::half_space) continue;
        const int face = face_along(ground, side == 0 ? n : -n);
        if (face < 0) continue;
        const int count = static_cast<int>(own.points.size());
        const int tips =
            own.kind == Shape::ellipsoid ? 1 : count + static_cast<int>(own.circles.size());
        for (int tip = 0; tip < tips; ++tip) {
            const bool corner = own.kind == Shape::polytope;
            Feature feature = named(pieces, corner ? Feature::corner_on_face : Feature::tip_on_face,
                                    side, tip, face);
            if (own.kind != Shape::ellipsoid && tip >= count) {
                // A rim that lies flat has no lowest point.
                const V up = ground.faces[face].normal;
                const V out = up - own.axis * dot(up, own.axis);
                if (2.0 * own.circles[tip - count].radius * length(out) <= kLiesFlat) continue;
            }
            const OverFace over = over_face(own, {}, ground, feature, {});
            const V away = over.x - over.n * (0.5 * over.gap) - point.point;
            if (length(away) <= kOnePoint + std::abs(point.gap) && over.inside >= -kBeside)
                return feature;
        }
    }
    // An end of a line along which round bodies touch.
    for (int side : {0, 1}) {
        if (alone) break;
        const Shape &own = pieces.of(side), &other = pieces.of(1 - side);
        if (own.kind == Shape::half_space || other.kind == Shape::half_space) continue;
        // All of a rim that lies flat is as near.
        const bool flat = own.is_round() && face_along(own, side == 0 ? -n : n) >= 0;
        const int parts = flat ? static_cast<int>(own.points.size()) : parts_of(own);
        for (int part = 0; part < parts; ++part) {
            const Shape alone = part_of(own, part);
            const Nearest near =
                side == 0 ? nearest(alone, {}, other, {}) : nearest(other, {}, alone, {});
            const V away = (near.on_first + near.on_other) * 0.5 - point.point;
            if (length(away) <= kOnePoint && std::abs(near.gap - point.gap) <= kOnePoint)
                return named(pieces, Feature::nearest_part, side, part, 0);
        }
    }
    // Elsewhere on a face: where it begins or ends, or on the rim of what lies flat on it.
    for (int side : {0, 1}) {
        const int face = face_along(pieces.of(1 - side), side == 0 ? n : -n);
        if (alone || face < 0 || !pieces.of(side).is_round()) continue;
        Feature feature = named(pieces, Feature::spot_on_face, side, 0, face);
        const V half = n * (0.5 * point.gap);
        const V spot = side == 0 ? pieces.at.back(point.point + half) : point.point - half;
        feature.fixed[0] = spot.x, feature.fixed[1] = spot.y, feature.fixed[2] = spot.z;
        return feature;
    }
    Feature parts;
    if (alone && name_parts(pieces, point, n, parts)) return parts;
    return named(pieces, Feature::nearest_points, 0, 0, 0);
}

std::vector<ContactPoint> contact_points_of_pieces(const Pieces& pieces, double gap, const V& n,
                                                   double margin) {
    const auto flat = [](const Shape& s) {
        return s.kind == Shape::polytope || s.kind == Shape::half_space;
    };
    if (flat(pieces.a) && flat(pieces.b)) return of_polytopes(pieces, gap, n, margin);
    std::vector<ContactPoint> found;
    const bool turn = pieces.a.kind == Shape::half_space;
    const std::vector<PatchPoint> points = turn ? patch_of(pieces.b, pieces.a, gap, -n, margin)
                                                : patch_of(pieces.a, pieces.b, gap, n, margin);
    for (const PatchPoint& p : points)
        found.push_back({name_of(pieces, p, n, points.size() == 1), p.point, n, p.gap});
    return found;
}

// Gap and normal in the frame of b's joint; along faces and edges of polytopes.
void gap_of(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb, double& gap,
            V& n) {
    const bool endless = a.kind == Shape::half_space || b.kind == Shape::half_space;
    if (!endless) return separate(a, pa, b, pb, gap, n);
    const Nearest found = nearest(a, pa, b, pb);
    gap = found.gap, n = back(pb.rotation, found.normal);
}

}  // namespace

void contact_points(const std::vector<Shape>& first, const Placement& pa,
                    const std::vector<Shape>& other, const Placement& pb, double margin,
                    std::vector<ContactPoint>& found) {
    for (std::size_t i = 0; i < first.size(); ++i) {
        for (std::size_t j = 0; j < other.size(); ++j) {
            const Shape &a = first[i], &b = other[j];
            if (a.kind == Shape::half_space && b.kind == Shape::half_space) continue;
            if (least_distance(a, pa, b, pb, margin) > margin) continue;
            double gap;
            V n;
            gap_of(a, pa, b, pb, gap, n);
            if (!(gap <= margin)) continue;
            const Placement at = relative_to(pb, pa);
            const Pieces pieces{placed(a, at), b, at, {static_cast<int>(i), static_cast<int>(j)}};
            for (ContactPoint& p : contact_points_of_pieces(pieces, gap, n, margin)) {
                p.point = pb.act(p.point);
                p.normal = pb.rotation * p.normal;
                found.push_back(p);
            }
        }
    }
}

}  // namespace impulsekit
