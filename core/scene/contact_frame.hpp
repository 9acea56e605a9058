// Points that may touch, and the rows of one state as a law of contact takes them.
#pragma once

#include <vector>

#include "scene/frame_pair.hpp"

namespace impulsekit {

// A frame pair that may touch. Lanes that do not are left out of the law.
template <typename S>
struct ContactFrame : FramePairState<S> {
    int entry = 0;
    bool of_bodies = false;  // it has a place, and axes in the world
    S gap{};
    bool closed[Number<S>::lanes] = {};
    Feature feature[Number<S>::lanes];  // of bodies of any shapes
    double sign = 1.0;                  // of a stop: −1 at its upper limit
    double ellipse[2] = {1.0, 0.0};  // of one lane: elliptic friction's first axis in the tangents
};

// The rows of one state, of those points alone that touch.
struct StateRows {
    std::vector<double> A, target;  // (rows, nv), (rows)
    // (rows) length of the whole vector over that of its longest axis among the rows.
    std::vector<double> wider;
    std::vector<int> yielded;  // rows of controls that give way to their stops
    std::vector<double> J;     // (3 (points + turning), nv)
    std::vector<ContactFrame<double>> points;
    Vec3<double> origin;                          // of the world, as places are seen
    std::vector<int> turning_of;                  // the points that resist turning
    std::vector<int> contact_frame_of;            // (points) the contact frame that each is
    int without_line = -1, without_ellipse = -1;  // an entry that has no direction here, or −1
};

// The first axis of an ellipse of friction in a contact's tangents; false where it has none there.
// `rotation`: of the body that is touched.
inline bool ellipse_axis(const Contact& contact, const Mat3<double>& rotation,
                         const Mat3<double>& axes, double* axis) {
    const Vec3<double> along = rotation * vec3<double>(contact.along);
    const double a = dot(axes.x, along), b = dot(axes.y, along), length = std::hypot(a, b);
    axis[0] = a / length;
    axis[1] = b / length;
    return length > kAlongNormal;
}

}  // namespace impulsekit
