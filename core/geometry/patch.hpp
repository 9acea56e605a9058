// Inner parts of the geometry: shapes somewhere, and what two of them share where they touch.
#pragma once

#include <vector>

#include "geometry/shapes.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit {

// A point beside a face, or beyond the end of an edge, by less than this is on it [m].
inline constexpr double kBeside = 1e-6;
// Points nearer to each other than this are one [m]: each of them may be beside a third.
inline constexpr double kOnePoint = 3.0 * kBeside;
// Cosines, and shares of an arc, that differ by less are alike: digits of meshes.
inline constexpr double kAlike = 1e-6;
// Edges that cross at a smaller angle (sine) end no patch; alone they are a point all the same.
inline constexpr double kEndsPatch = 1e-3;
// A rim whose far side is this near to a face [m] comes to lie flat, and lies flat.
inline constexpr double kComesFlat = 2e-8, kLiesFlat = 1.5 * kComesFlat;
// Edges that cross at a smaller angle than when they were named, by this part, are parallel.
inline constexpr double kStillCross = 1e-3;

// The gap of two shapes and its normal from b to a, in the frame of b's joint; of polytopes along
// the normals of faces and pairs of edges alone.
void separate(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb, double& gap,
              Vec3<double>& normal);

// The placement of one joint in the frame of another.
Placement relative_to(const Placement& pb, const Placement& pa);

// A shape in the axes of another joint, which is placed there.
Shape placed(const Shape& shape, const Placement& at);

// A point of a patch, halfway between the surfaces, and its gap [m].
struct PatchPoint {
    Vec3<double> point;
    double gap = 0.0;
};

// The points where two shapes, not both polytopes, are no further apart than `margin`, at least
// one, given their gap and its normal from b to a; all in one plane. b may be a half-space.
std::vector<PatchPoint> patch_of(const Shape& a, const Shape& b, double gap,
                                 const Vec3<double>& normal, double margin);

}  // namespace impulsekit
