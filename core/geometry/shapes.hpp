// Convex pieces of bodies: how far two of them are apart, where they touch, and points that are
// followed as both move.
//
// Every shape is a core with a radius around it. Cores are hulls of points and circles,
//     h(d) = max(maxᵢ d·pᵢ, maxⱼ d·cⱼ + rⱼ |d − (d·a) a|) + radius |d|,
// ellipsoids, h(d) = d·c + |E d| + radius |d|, or half-spaces n·x ≤ offset + radius.
#pragma once

#include <limits>
#include <vector>

#include "linalg/numbers.hpp"

namespace impulsekit {

// A placement in the world: axes by columns, and origin [m].
struct Placement {
    Mat3<double> rotation{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    Vec3<double> origin{};

    Vec3<double> act(const Vec3<double>& a) const { return rotation * a + origin; }
    Vec3<double> back(const Vec3<double>& a) const {
        return impulsekit::back(rotation, a - origin);
    }
};

// A flat face: its normal outwards, n·x on it [m], and its corners against the clock.
struct Face {
    Vec3<double> normal;
    double offset = 0.0;
    std::vector<int> loop;
};

// A convex piece of a body, in the axes of the joint that carries it.
struct Shape {
    enum Kind { ball, capsule, polytope, cylinder, cone, ellipsoid, half_space };
    struct Circle {
        Vec3<double> centre;
        double radius = 0.0;
    };
    struct Edge {
        int start = 0, end = 0;     // corners; of a capsule its ends
        int left = -1, right = -1;  // faces
    };

    Kind kind = ball;
    double radius = 0.0;               // around the core [m]
    std::vector<Vec3<double>> points;  // corners; a ball's centre, a capsule's ends, a cone's tip
    std::vector<Circle> circles;       // rims of a cylinder (two) or cone (one)
    std::vector<Face> faces;           // also of cylinders and cones (ends) and half-spaces
    std::vector<Edge> edges;
    Vec3<double> axis{0, 0, 1}, across{1, 0, 0};  // of circles, and where rims begin
    Vec3<double> centre;                          // of a ball that contains it, whose radius
    double reach = std::numeric_limits<double>::infinity();  // this is [m]
    Mat3<double> axes;                                       // semi-axes of an ellipsoid [m]
    std::vector<Vec3<double>> face_axes, edge_axes;          // up to their sign each once

    bool is_round() const { return kind != polytope && kind != half_space; }
};

// A tip or rim of a round body, or an edge of a polytope, by itself.
Shape part_of(const Shape& shape, int part);
int parts_of(const Shape& shape);

// Shapes of each kind; rotation and origin place them in the joint.
Shape ball_shape(double radius, const Placement& at);
Shape capsule_shape(double radius, double half_length, const Placement& at);
Shape cylinder_shape(double radius, double half_length, double around, const Placement& at);
Shape cone_shape(double radius, double half_length, double around, const Placement& at);
Shape box_shape(const Vec3<double>& half_sides, double around, const Placement& at);
Shape ellipsoid_shape(const Vec3<double>& semi_axes, double around, const Placement& at);
Shape half_space_shape(const Vec3<double>& normal, double offset, const Placement& at);
// Corners, and faces of which only the loops are read.
Shape polytope_shape(const std::vector<Vec3<double>>& corners,
                     const std::vector<std::vector<int>>& loops, double around,
                     const Placement& at);

// Signed distance (negative by the least way out where they overlap), unit normal from b to a, and
// the points of both surfaces; world.
struct Nearest {
    double gap = 0.0;
    Vec3<double> normal, on_first, on_other;
};
// `by_faces_and_edges`: of two polytopes along the normals of faces and pairs of edges alone, which
// is their distance where they overlap or touch at one of these, and less apart.
Nearest nearest(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb,
                bool by_faces_and_edges = false);
// A lower bound of the gap, above `enough` wherever the gap is clearly so: by the balls around
// both, or along the way between their nearest points.
double least_distance(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb,
                      double enough);
// The same distance alone. Larger than `enough` it may be any smaller bound that is, too.
double distance(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb,
                double enough = std::numeric_limits<double>::infinity());
// The support function of a shape in its own axes, and the point that reaches furthest.
double support(const Shape& shape, const Vec3<double>& direction, Vec3<double>* point = nullptr);

// One point at which two pieces touch, by name. `side` is whose corner or tip it is: 0 the first's.
struct Feature {
    enum Kind {
        corner_on_face,  // index: side, corner, face
        edges_cross,     // index: ends of the first's edge, of the other's; fixed[0]: sign of e × f
        tip_on_face,     // index: side, tip (points, then circles), face: where it reaches furthest
        spot_on_face,    // index: side, −, face; fixed: a point of the round body, in its joint
        nearest_points,  // of both
        nearest_part,    // of a rim, tip or edge of one and the other: index: side, part
    };
    Kind kind = nearest_points;
    int piece[2] = {0, 0};  // of the first and of the other
    int index[4] = {0, 0, 0, 0};
    double fixed[3] = {0.0, 0.0, 0.0};

    bool operator==(const Feature& other) const;
};
struct ContactPoint {
    Feature feature;
    Vec3<double> point, normal;  // world; halfway between the surfaces, from the other to the first
    double gap = 0.0;
};
// True if a feature names pieces, corners, edges and faces that are there.
bool is_named(const Feature& feature, const std::vector<Shape>& first,
              const std::vector<Shape>& other);
// Adds the points at which two bodies are no further apart than `margin` [m]: the ends of what
// their surfaces share, piece by piece.
void contact_points(const std::vector<Shape>& first, const Placement& pa,
                    const std::vector<Shape>& other, const Placement& pb, double margin,
                    std::vector<ContactPoint>& found);
// A named point at other placements, smooth in them. `inside` is how far it is from where its face
// or edges end [m], negative beyond, infinite where nothing ends.
ContactPoint follow(const Feature& feature, const std::vector<Shape>& first, const Placement& pa,
                    const std::vector<Shape>& other, const Placement& pb, double* inside = nullptr);

}  // namespace impulsekit
