#include "motion/contact_gaps.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/arena.hpp"
#include "linalg/dense.hpp"
#include "motion/free_times.hpp"
#include "motion/tolerances.hpp"
#include "scene/contact_geometry.hpp"

namespace impulsekit {
namespace {

// Bodies turn by this, or move by this many radii, for the rates of what is followed on them.
constexpr double kMove = 1e-3;
// Overlaps deeper than these are no motion that is right: of points and stops, whose drift is taken
// out after every step, and of bodies, in radii of the smaller one and at most [m]; what has not
// left its face is not too deep.
constexpr double kDeepest = 1e-4, kDeepestOfRadius = 1e-3, kDeepestOfBodies = 1e-5;
// Corners, ends and rims that come down more slowly stay [m/s]: they would hop some 1e-9 m high.
constexpr double kSlowCorner = 2e-4;

// R turned by a rotation vector.
Mat turned_by(const Vec& w, const Mat& r) {
    const double angle = std::sqrt(dot(w, w));
    if (!(angle > 0.0)) return r;
    const double s = std::sin(angle) / angle, half = std::sin(0.5 * angle) / (0.5 * angle),
                 c = 0.5 * half * half;
    const auto turn = [&](const Vec& a) {
        const Vec first = cross(w, a);
        return a + first * s + cross(w, first) * c;
    };
    return {turn(r.x), turn(r.y), turn(r.z)};
}

Placement placement_after(const Tree<double>& tree, int body, double time) {
    Placement place = placement_of(tree, body);
    const Spatial<double>& twist = tree.twist[body];
    place.origin += twist.linear * time;
    place.rotation = turned_by(twist.angular * time, place.rotation);
    return place;
}

double length_of(const Vec& a) { return std::sqrt(dot(a, a)); }

double smaller_of(const Contact& contact) {
    double least = INFINITY;
    for (const auto* own : {&contact.first, &contact.other}) {
        double reach = 0.0;
        for (const Shape& shape : *own) reach = std::max(reach, shape.reach);
        least = std::min(least, reach);
    }
    return least;
}

// True if corners, ends of capsules or rims may touch, which lift each other in turn.
bool has_ends(const Contact& contact) {
    const auto is_smooth = [](const Shape& s) {
        return s.kind == Shape::ball || s.kind == Shape::ellipsoid || s.kind == Shape::half_space;
    };
    return !(std::all_of(contact.first.begin(), contact.first.end(), is_smooth) &&
             std::all_of(contact.other.begin(), contact.other.end(), is_smooth));
}

// An upper bound of the speed of a shape's points.
double fastest(const Spatial<double>& twist, const Placement& at, const Shape& shape,
               const Vec& other_place) {
    if (std::isinf(shape.reach)) {
        // The part of a half-space near the other body counts.
        return length_of(twist_at(twist, other_place - at.origin).linear);
    }
    const Vec centre = at.rotation * shape.centre;
    return length_of(twist_at(twist, centre).linear) + length_of(twist.angular) * shape.reach;
}

}  // namespace

ContactGaps::ContactGaps(const Scene& scene, const ContactLaw& law, GapFunctions functions,
                         const std::vector<char>& conditional)
    : scene_(&scene), law_(&law), functions_(std::move(functions)) {
    int function = 0;
    for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
        const Contact& contact = scene.contacts[i];
        Gap gap;
        gap.entry = static_cast<int>(i);
        gap.kind = contact.kind;
        gap.turns = contact.turns;
        gap.has_condition = conditional[i];
        gap.deepest = kDeepest;
        if (contact.kind == Contact::stop) {
            for (double sign : {1.0, -1.0}) {
                gap.sign = sign;
                gap.limit = sign > 0.0 ? contact.lower : contact.upper;
                if (std::isfinite(gap.limit)) gaps_.push_back(gap);
            }
            continue;
        }
        if (contact.kind == Contact::functions) gap.function = function++;
        if (gap.of_bodies()) {
            gap.smaller = smaller_of(contact);
            for (int side : {1, 0})
                if (is_pointed(side == 0 ? contact.first : contact.other, gap.reach))
                    gap.pointed = side;
            gap.capture = has_ends(contact) ? kSlowCorner : kCreeps;
            gap.rests = kCreeps;
            gap.deepest =
                std::max(std::min(kDeepestOfBodies, kDeepestOfRadius * gap.smaller), kLeft);
        }
        gaps_.push_back(gap);
    }
}

bool ContactGaps::counts(const Gap& gap, const double* q, const double* v) const {
    return !gap.has_condition || functions_.counts(gap.entry, q, v);
}

GapState ContactGaps::measure(const Tree<double>& tree, const Gap& gap, const double* q,
                              const double* v, const Ahead* ahead) const {
    const Contact& contact = contact_of(gap);
    GapState found;
    if (gap.kind == Contact::stop) {
        found.gap = gap.sign * (q[contact.q] - gap.limit);
        found.rate = gap.sign * v[contact.v];
        found.bound = std::abs(found.rate);
        return found;
    }
    if (gap.kind == Contact::functions) {
        const int nv = scene_->model->nv;
        Arena::Scope scope(scratch());
        double* own = scratch().allocate(1 + 3 * nv);
        functions_.rows(gap.function, q, own);
        found.gap = own[0];
        for (int i = 0; i < nv; ++i) found.rate += own[1 + 2 * nv + i] * v[i];
        found.bound = std::abs(found.rate);
        return found;
    }
    if (gap.of_frames()) {
        const FramePairMotion b = frame_pair_motion(tree, contact.frames);
        const Vec u = b.wanders - velocity_at(tree, b.other, b.other_place);
        found.rate = dot(b.axes.z, u);
        found.bound = length_of(u);
        found.turning = std::max(length_of(tree.twist[b.first].angular),
                                 length_of(tree.twist[b.other].angular));
        found.rounding =
            tolerance::last_bits *
            std::max(length_of(b.place), length_of(place_of(tree, contact.frames.other)));
        found.gap = impulsekit::gap_of<double>(tree, contact, b);
        return found;
    }
    measure_bodies(tree, gap, ahead, found);
    return found;
}

void ContactGaps::measure_bodies(const Tree<double>& tree, const Gap& gap, const Ahead* ahead,
                                 GapState& found) const {
    const Contact& contact = contact_of(gap);
    const int a = contact.first_body(), b = contact.other_body();
    const Placement pa = placement_of(tree, a), pb = placement_of(tree, b);
    found.gap = INFINITY;
    found.rounding =
        tolerance::last_bits * (length_of(pa.origin) + length_of(pb.origin) + gap.smaller);
    found.turning = std::max(length_of(tree.twist[a].angular), length_of(tree.twist[b].angular));
    const bool is_first = gap.pointed == 0;
    if (gap.pointed >= 0) found.motion = relative_motion(tree, is_first ? a : b, is_first ? b : a);
    double free = ahead && gap.pointed >= 0 ? INFINITY : 0.0;
    for (const Shape& one : contact.first)
        for (const Shape& two : contact.other) {
            const Vec centre = std::isinf(one.reach) ? pb.origin + pb.rotation * two.centre
                                                     : pa.origin + pa.rotation * one.centre;
            const double bound =
                fastest(tree.twist[a], pa, one, centre) + fastest(tree.twist[b], pb, two, centre);
            found.bound = std::max(found.bound, bound);
            if (std::isfinite(one.reach) && std::isfinite(two.reach)) {
                const double far = 0.1 * std::min(one.reach, two.reach);
                const double apart = least_distance(one, pa, two, pb, far);
                if (apart > far) {
                    if (apart < found.gap)
                        found.gap = apart, found.rate = 0.0, found.is_rough = true;
                    if (free > 0.0)
                        free = std::min(free, time_to(apart, -bound, ahead->acceleration));
                    continue;
                }
            }
            const Nearest near = nearest(one, pa, two, pb, true);
            double slowest = INFINITY;
            if (free > 0.0) {
                const Mat& frame = is_first ? pb.rotation : pa.rotation;
                const Mat& own = is_first ? pa.rotation : pb.rotation;
                const Mat turn{back(frame, own.x), back(frame, own.y), back(frame, own.z)};
                const Vec normal = back(frame, near.normal) * (is_first ? 1.0 : -1.0);
                free = std::min(free, free_time(is_first ? one : two, turn, normal,
                                                near.gap - ahead->base, 4.0 * found.rounding,
                                                found.motion, ahead->acceleration, slowest));
            }
            if (!(near.gap < found.gap)) continue;
            found.gap = near.gap;
            found.is_rough = false;
            found.rate =
                std::min(slowest, dot(near.normal, velocity_at(tree, a, near.on_first) -
                                                       velocity_at(tree, b, near.on_other)));
        }
    found.free = free;
}

double ContactGaps::gap_of(const Tree<double>& tree, const RestingContact& point, const double* q,
                           double* inside) const {
    const Gap& gap = gaps_[point.gap];
    if (inside) *inside = INFINITY;
    if (!gap.of_bodies()) {
        Arena::Scope scope(scratch());
        const double* still = scratch().allocate(scene_->model->nv);
        return measure(tree, gap, q, still).gap;
    }
    const Contact& contact = contact_of(gap);
    return follow(point.feature, contact.first, placement_of(tree, contact.first_body()),
                  contact.other, placement_of(tree, contact.other_body()), inside)
        .gap;
}

void ContactGaps::find_points(const Tree<double>& tree, int gap, double margin,
                              std::vector<RestingContact>& found) const {
    RestingContact point;
    point.gap = gap;
    if (!gaps_[gap].of_bodies()) {
        found.push_back(point);
        return;
    }
    const Contact& contact = contact_of(gaps_[gap]);
    std::vector<ContactPoint> points;
    contact_points(contact.first, placement_of(tree, contact.first_body()), contact.other,
                   placement_of(tree, contact.other_body()), margin, points);
    for (const ContactPoint& own : points) {
        point.feature = own.feature;
        found.push_back(point);
    }
}

bool ContactGaps::is_elliptic(int entry) const {
    return law_->contacts[entry].model.kind == Friction::Kind::elliptic;
}

void ContactGaps::scale_to_ellipse(const Tree<double>& tree, int entry, Mat& axes) const {
    if (!is_elliptic(entry)) return;
    const Contact& contact = scene_->contacts[entry];
    const Friction& friction = law_->contacts[entry].model;
    double axis[2];
    if (!ellipse_axis(contact, tree.rotation[contact.ellipse_body], axes, axis)) return;
    const Vec first = (axes.x * axis[0] + axes.y * axis[1]) * friction.first,
              second = (axes.y * axis[0] - axes.x * axis[1]) * friction.second;
    axes.x = first;
    axes.y = second;
}

// True if a point is at a fixed distance from one that is fixed in a body, along the normal of a
// face of the other: a corner, a ball, an end of a capsule, a spot.
bool is_fixed_on_face(const Feature& feature, const Shape& own) {
    if (feature.kind == Feature::corner_on_face || feature.kind == Feature::spot_on_face)
        return true;
    return feature.kind == Feature::tip_on_face && own.kind != Shape::ellipsoid &&
           feature.index[1] < static_cast<int>(own.points.size());
}

// The rates of such a point and its normal: p = c − (r + g/2) m, where m is the normal
// of the face and g = m·(c − o) − r.
void follow_on_face(const Tree<double>& tree, const ContactPoint& here, double radius, int own,
                    int ground, const Vec& m, Vec& wanders, Vec& change) {
    const Vec centre = here.point + m * (radius + 0.5 * here.gap);
    const Vec v = velocity_at(tree, own, centre);
    const double rate = dot(m, v - velocity_at(tree, ground, centre));
    change = cross(tree.twist[ground].angular, m);
    wanders = v - change * (radius + 0.5 * here.gap) - m * (0.5 * rate);
}

// A followed point, and the rates of it and its normal over both bodies: where nothing
// is fixed, differences of fourth order along their motion.
FramePairMotion ContactGaps::spot_of_bodies(const Tree<double>& tree, const RestingContact& point,
                                            bool moves) const {
    const Gap& gap = gaps_[point.gap];
    const Contact& contact = contact_of(gap);
    FramePairMotion b;
    b.first = contact.first_body();
    b.other = contact.other_body();
    const auto at = [&](double time) {
        return follow(point.feature, contact.first, placement_after(tree, b.first, time),
                      contact.other, placement_after(tree, b.other, time), nullptr);
    };
    const ContactPoint here = at(0.0);
    set_coincident<double>(tree, here.point, here.point - tree.origin[b.first], b);
    b.axes = contact_axes(here.normal);
    if (!moves) return b;
    const Vec spin = tree.twist[b.other].angular;
    const Feature& feature = point.feature;
    const bool is_first = feature.index[0] == 0;
    const Shape& own = is_first ? contact.first[feature.piece[0]] : contact.other[feature.piece[1]];
    if (is_fixed_on_face(feature, own)) {
        const double radius = feature.kind == Feature::spot_on_face ? 0.0 : own.radius;
        Vec change;
        follow_on_face(tree, here, radius, is_first ? b.first : b.other,
                       is_first ? b.other : b.first, is_first ? b.axes.z : -b.axes.z, b.wanders,
                       change);
        b.turns = b.axes.z * dot(b.axes.z, spin) + cross(b.axes.z, is_first ? change : -change);
        return b;
    }
    const double speed =
        std::max({length_of(tree.twist[b.first].angular), length_of(tree.twist[b.other].angular),
                  length_of(velocity_at(tree, b.first, here.point) -
                            velocity_at(tree, b.other, here.point)) /
                      gap.smaller});
    b.wanders = velocity_at(tree, b.other, here.point);
    b.turns = b.axes.z * dot(b.axes.z, spin);
    if (!(speed > 0.0)) return b;
    const double time = kMove / speed;
    const ContactPoint one = at(time), minus = at(-time), two = at(2.0 * time),
                       minus_two = at(-2.0 * time);
    const double near = 8.0 / (12.0 * time), far = 1.0 / (12.0 * time);
    b.wanders = (one.point - minus.point) * near - (two.point - minus_two.point) * far;
    const Vec change = (one.normal - minus.normal) * near - (two.normal - minus_two.normal) * far;
    b.turns += cross(b.axes.z, change);
    return b;
}

FramePairMotion ContactGaps::spot(const Tree<double>& tree, const RestingContact& point,
                                  bool moves) const {
    const Gap& gap = gaps_[point.gap];
    FramePairMotion b;
    if (gap.of_bodies())
        b = spot_of_bodies(tree, point, moves);
    else if (moves)
        b = frame_pair_motion(tree, contact_of(gap).frames);
    else
        static_cast<FramePairState<double>&>(b) = frame_pair_state(tree, contact_of(gap).frames);
    scale_to_ellipse(tree, gap.entry, b.axes);
    return b;
}

Spatial<double> ContactGaps::velocity(const Tree<double>& tree, const RestingContact& point,
                                      const double* q, const double* v) const {
    const Gap& gap = gaps_[point.gap];
    if (!gap.of_bodies() && !gap.of_frames()) {
        const int nv = scene_->model->nv;
        const Arena::Scope scope(scratch());
        double* J = scratch().allocate(3 * nv);
        rows(tree, point, q, v, {J});
        return {{dot<double>(J, v, nv), dot<double>(J + nv, v, nv), dot<double>(J + 2 * nv, v, nv)},
                {}};
    }
    const FramePairState<double> pair = spot(tree, point, false);
    Spatial<double> u = relative_velocity(tree, pair);
    if (pair.carrier == Carrier::line) u.linear.x = u.linear.y = 0.0;
    return u;
}

void ContactGaps::rows(const Tree<double>& tree, const RestingContact& point, const double* q,
                       const double* v, const RestRows& to) const {
    const auto [J, turning, bias, turning_bias] = to;
    const int nv = scene_->model->nv;
    const Gap& gap = gaps_[point.gap];
    const Contact& contact = scene_->contacts[gap.entry];
    std::fill(J, J + 3 * nv, 0.0);
    if (bias) std::fill(bias, bias + 3, 0.0);
    if (gap.kind == Contact::stop) {
        J[2 * nv + contact.v] = gap.sign;
        return;
    }
    if (gap.kind == Contact::functions) {
        Arena::Scope scope(scratch());
        double* own = scratch().allocate(1 + 3 * nv);
        functions_.rows(gap.function, q, own);
        std::copy(own + 1, own + 1 + 3 * nv, J);
        if (bias) functions_.bias(gap.function, q, v, bias);
        return;
    }
    if (turning) std::fill(turning, turning + 3 * nv, 0.0);
    const FramePairMotion b = spot(tree, point, bias != nullptr);
    add_rows<double>(tree, b, J, turning);
    if (bias) {
        const Spatial<double> rate = relative_rate(tree, b);
        bias[0] = rate.linear.x, bias[1] = rate.linear.y, bias[2] = rate.linear.z;
        if (turning_bias) {
            turning_bias[0] = rate.angular.x;
            turning_bias[1] = rate.angular.y;
            turning_bias[2] = rate.angular.z;
        }
    }
    if (b.carrier == Carrier::line) std::fill(J, J + 2 * nv, 0.0);
}

}  // namespace impulsekit
