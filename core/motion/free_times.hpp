// For how long bodies surely do not touch: by where the corners of one are, how they move in the
// frame of the other, and a bound of their accelerations there.
#pragma once

#include <vector>

#include "motion/state.hpp"
#include "scene/frame_pair.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

// The axes of a body's joint, in which its shapes are given, and its origin.
Placement placement_of(const Tree<double>& tree, int body);

// The motion of one body in the frame of another: velocity of its origin, and angular velocity.
struct RelativeMotion {
    Vec velocity, spin;
};
RelativeMotion relative_motion(const Tree<double>& tree, int body, int other);

// A bound of the acceleration of points within `reach` of the origin [m/s²], from motions so much
// time apart [s].
double bound_of_acceleration(const RelativeMotion& one, const RelativeMotion& two, double reach,
                             double apart);

// True if pieces are hulls of points with a radius around; then their reach from the origin.
bool is_pointed(const std::vector<Shape>& pieces, double& reach);

// When g + ġ t − A t²/2 is zero, without cancellation.
double time_to(double gap, double rate, double acceleration);

// The time in which a hull of points stays on its side of a plane of the other body, at a gap
// along the normal: every point by g + ġ t − A t²/2. In the other's frame; `turn` brings the
// hull's axes there. `slowest`: the rate of those within `rounding` of the nearest.
double free_time(const Shape& hull, const Mat& turn, const Vec& normal, double gap, double rounding,
                 const RelativeMotion& motion, double acceleration, double& slowest);

// Bodies that rest with corners of one on one face of the other.
struct CornersOnFace {
    int side = -1;  // whose corners: 0 the first's; −1 where it is not so
    int face = 0;
    std::vector<char> rests;  // by corner
    double reach = 0.0;       // of its corners from the origin [m]

    CornersOnFace(const Contact& contact, int gap, const std::vector<RestingContact>& points);
    int body(const Contact& contact) const {
        return side == 0 ? contact.first_body() : contact.other_body();
    }
    int ground(const Contact& contact) const {
        return side == 0 ? contact.other_body() : contact.first_body();
    }
    // The time in which its other corners stay above the face's plane; the tree with places.
    double free_time(const Contact& contact, const Tree<double>& tree, const RelativeMotion& motion,
                     double acceleration) const;
};

}  // namespace impulsekit
