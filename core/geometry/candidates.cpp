#include "geometry/candidates.hpp"

#include <limits>

#include "linalg/tolerances.hpp"

namespace impulsekit::convex {
namespace {

// True if two numbers are on either side of zero, or one is zero but for rounding.
bool opposite(double x, double y) {
    return !(x > tolerance::parallel && y > tolerance::parallel) &&
           !(x < -tolerance::parallel && y < -tolerance::parallel);
}

// An edge of a polytope: a corner on it, its direction, and the normals of the faces to its left
// and right.
struct Ridge {
    V corner, along, left, right;
};
std::vector<Ridge> ridges_of(const Core& core) {
    std::vector<V> corners, normals;
    for (const V& p : core.shape.points) corners.push_back(core.at.act(p));
    for (const Face& face : core.shape.faces) normals.push_back(core.at.rotation * face.normal);
    std::vector<Ridge> found;
    found.reserve(core.shape.edges.size());
    for (const Shape::Edge& e : core.shape.edges) {
        const V along = core.shape.points[e.end] - core.shape.points[e.start];
        found.push_back({corners[e.start], core.at.rotation * (along * (1.0 / length(along))),
                         normals[e.left], e.right < 0 ? -normals[e.left] : normals[e.right]});
    }
    return found;
}

// The direction across two edges, of either sign; none where they are parallel.
bool cross_edges(const V& e, const V& f, V& across) {
    const V turn = cross(e, f);
    const double sine = length(turn);
    across = turn * (1.0 / sine);
    return sine > tolerance::parallel;
}

// Use every direction, of either sign, across two edges of polytopes that make a face of their
// difference: the arcs from the left to the right normal of one and, turned round, of the other
// cross (Gregorius 2013); and how far the edges are apart along it.
template <typename Use>
void for_crossing_edges(const Pair& pair, const Use& use) {
    V across;
    const std::vector<Ridge> others = ridges_of(pair.b);
    for (const Ridge& e : ridges_of(pair.a)) {
        for (const Ridge& f : others) {
            const double left = dot(f.left, e.along), right = dot(e.right, f.along);
            if (opposite(left, dot(f.right, e.along)) && opposite(dot(e.left, f.along), right) &&
                opposite(left, right) && cross_edges(e.along, f.along, across))
                use(across, dot(across, e.corner - f.corner));
        }
    }
}

}  // namespace

Guess best_candidate(const Pair& pair, bool polytopes, std::vector<Guess>& guesses) {
    Guess best{-std::numeric_limits<double>::infinity(), {0, 0, 1}};
    const auto use = [&](const V& normal, double better) {
        const Guess own{pair.separation(normal), normal};
        if (!polytopes) guesses.push_back(own);
        if (own.separation > best.separation + better) best = own;
    };
    const auto use_face = [&](const V& axis) { use(axis, 0.0), use(-axis, 0.0); };
    for (const V& axis : pair.b.shape.face_axes) use_face(axis);
    for (const V& axis : pair.a.shape.face_axes) use_face(pair.a.at.rotation * axis);
    // Shapes are no further apart along a direction than two of their points.
    const auto use_edges = [&](const V& axis, double apart) {
        if (apart > best.separation) use(axis, tolerance::at_rest);
        if (-apart > best.separation) use(-axis, tolerance::at_rest);
    };
    if (polytopes) {
        for_crossing_edges(pair, use_edges);
        return best;
    }
    V across;
    for (const V& e : pair.a.shape.edge_axes)
        for (const V& f : pair.b.shape.edge_axes)
            if (cross_edges(pair.a.at.rotation * e, f, across))
                use(across, tolerance::at_rest), use(-across, tolerance::at_rest);
    return best;
}

}  // namespace impulsekit::convex
