#include "motion/free_times.hpp"

#include <algorithm>
#include <cmath>

#include "geometry/patch.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit {
namespace {

double length_of(const Vec& a) { return std::sqrt(dot(a, a)); }

}  // namespace

Placement placement_of(const Tree<double>& tree, int body) {
    return {tree.rotation[body] * transposed(mat3<double>(tree.model.bodies[body].turn)),
            tree.origin[body]};
}

RelativeMotion relative_motion(const Tree<double>& tree, int body, int other) {
    const Mat frame = placement_of(tree, other).rotation;
    const Spatial<double>& twist = tree.twist[body];
    const Vec across = tree.origin[body] - tree.origin[other];
    return {back(frame, twist.linear - twist_at(tree.twist[other], across).linear),
            back(frame, twist.angular - tree.twist[other].angular)};
}

double bound_of_acceleration(const RelativeMotion& one, const RelativeMotion& two, double reach,
                             double apart) {
    const double spin = std::max(length_of(one.spin), length_of(two.spin));
    return 2.0 *
           ((length_of(two.velocity - one.velocity) + length_of(two.spin - one.spin) * reach) /
                apart +
            spin * spin * reach);
}

bool is_pointed(const std::vector<Shape>& pieces, double& reach) {
    const auto is_hull = [](const Shape& s) {
        return s.circles.empty() && s.kind != Shape::ellipsoid && s.kind != Shape::half_space;
    };
    if (!std::all_of(pieces.begin(), pieces.end(), is_hull)) return false;
    reach = 0.0;
    for (const Shape& s : pieces) reach = std::max(reach, length_of(s.centre) + s.reach);
    return true;
}

double time_to(double gap, double rate, double acceleration) {
    const double root = std::sqrt(rate * rate + 2.0 * acceleration * gap);
    return rate < 0.0 ? 2.0 * gap / (root - rate)
                      : (rate + root) / (acceleration + tolerance::tiny);
}

double free_time(const Shape& hull, const Mat& turn, const Vec& normal, double gap, double rounding,
                 const RelativeMotion& motion, double acceleration, double& slowest) {
    gap = std::max(gap, 0.0);
    const Vec own = back(turn, normal);
    double lowest = INFINITY, free = INFINITY;
    for (const Vec& p : hull.points) lowest = std::min(lowest, dot(own, p));
    for (const Vec& p : hull.points) {
        const double rate = dot(normal, motion.velocity + cross(motion.spin, turn * p)),
                     over = gap + dot(own, p) - lowest;
        free = std::min(free, time_to(over, rate, acceleration));
        if (over <= rounding) slowest = std::min(slowest, rate);
    }
    return free;
}

CornersOnFace::CornersOnFace(const Contact& contact, int gap,
                             const std::vector<RestingContact>& points) {
    // Of bodies of several pieces a plane of one says nothing of the others.
    if (contact.first.size() != 1 || contact.other.size() != 1) return;
    for (const RestingContact& point : points) {
        if (point.gap != gap) continue;
        const Feature& feature = point.feature;
        const bool is_known =
            feature.kind == Feature::corner_on_face &&
            (rests.empty() || (feature.index[0] == side && feature.index[2] == face));
        const auto& pieces = feature.index[0] == 0 ? contact.first : contact.other;
        if (!is_known || !is_pointed(pieces, reach)) {
            side = -1;
            return;
        }
        side = feature.index[0];
        face = feature.index[2];
        rests.resize(pieces[0].points.size(), 0);
        rests[feature.index[1]] = 1;
    }
}

double CornersOnFace::free_time(const Contact& contact, const Tree<double>& tree,
                                const RelativeMotion& motion, double acceleration) const {
    const Shape &own = side == 0 ? contact.first[0] : contact.other[0],
                &under = side == 0 ? contact.other[0] : contact.first[0];
    const Placement at =
        relative_to(placement_of(tree, ground(contact)), placement_of(tree, body(contact)));
    const Face& plane = under.faces[face];
    double free = INFINITY;
    for (std::size_t i = 0; i < own.points.size(); ++i) {
        if (rests[i]) continue;
        const Vec p = at.rotation * own.points[i];
        const double over = dot(plane.normal, p + at.origin) - plane.offset - under.radius -
                            own.radius,
                     rate = dot(plane.normal, motion.velocity + cross(motion.spin, p));
        free = std::min(free, over > 0.0 ? time_to(over, rate, acceleration) : 0.0);
    }
    return free;
}

}  // namespace impulsekit
