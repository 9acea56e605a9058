// The points at which two convex shapes touch, of which one is round.
//
// The part of each surface touches that is within the margin of the other's: a
// point, a segment (an edge, the side of a cylinder or a capsule), a polygon or the disc of a rim.
// Seen along the normal two such parts overlap, and the points of contact are the ends of the
// overlap:
//     point and anything        the point
//     segments that cross       the point where they do
//     segments side by side     both ends of the stretch
//     segment and face, disc    both ends of what is left of the segment
//     faces, discs              the corners of the overlap, and along what is left of a rim points
//                               no further than an eighth of the circle from each other, evenly
//     a whole rim               eight points evenly
#include "geometry/patch.hpp"

#include <algorithm>
#include <cmath>

namespace impulsekit {
namespace {

using V = Vec3<double>;

constexpr int kRimPoints = 8;
constexpr double kTurn = 6.283185307179586;

struct V2 {
    double x = 0.0, y = 0.0;
    V2 operator+(const V2& b) const { return {x + b.x, y + b.y}; }
    V2 operator-(const V2& b) const { return {x - b.x, y - b.y}; }
    V2 operator*(double a) const { return {x * a, y * a}; }
};
double dot(const V2& a, const V2& b) { return a.x * b.x + a.y * b.y; }
double length(const V2& a) { return std::hypot(a.x, a.y); }

// Two axes across a normal.
struct Frame {
    V t, s, n;

    explicit Frame(const V& normal) : n(normal) {
        const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
        t = cross(n, x <= y && x <= z ? V{1, 0, 0} : y <= z ? V{0, 1, 0} : V{0, 0, 1});
        t = t * (1.0 / std::sqrt(impulsekit::dot(t, t)));
        s = cross(n, t);
    }
    V2 flat(const V& a) const { return {impulsekit::dot(t, a), impulsekit::dot(s, a)}; }
};

// The part of a shape that reaches furthest, along the normal: a point, a segment or a polygon
// against the clock; or the disc of a radius about one corner.
struct Area {
    std::vector<V2> corners;
    std::vector<double> levels;  // heights of the corners along the normal [m]
    double radius = 0.0;
    double level = 0.0;  // height elsewhere: level + slope·x
    V2 slope, across;    // where the first point of a rim is, not of unit length
    double round = 0.0;  // how far a segment is from the line it is parallel to all around [m]

    int size() const {
        return radius > 0.0 ? 2 : std::min(static_cast<int>(corners.size()) - 1, 2);
    }
    double height(const V2& place) const {
        int best = 0;
        double away = std::numeric_limits<double>::infinity();
        for (int k = 0; k < static_cast<int>(corners.size()); ++k) {
            const V2 along = corners[k] - place;
            const double own = std::max(std::abs(along.x), std::abs(along.y));
            if (own < away) away = own, best = k;
        }
        return away <= kOnePoint ? levels[best] : level + dot(slope, place);
    }
};

struct Spot {
    V2 place;
    double more = 0.0;  // how much further apart surfaces are there [m]
};

// Order the corners of a polygon, and set its slope.
void close_polygon(Area& area, const Shape& shape, const V& along, const Frame& frame) {
    V2 middle;
    const double share = 1.0 / static_cast<double>(area.corners.size());
    double mean = 0.0;
    for (std::size_t k = 0; k < area.corners.size(); ++k) {
        middle = middle + area.corners[k] * share;
        mean += area.levels[k] * share;
    }
    std::vector<std::pair<double, std::size_t>> order;
    for (std::size_t k = 0; k < area.corners.size(); ++k) {
        const V2 arm = area.corners[k] - middle;
        order.push_back({std::atan2(arm.y, arm.x), k});
    }
    std::sort(order.begin(), order.end());
    const Area before = area;
    for (std::size_t k = 0; k < order.size(); ++k) {
        area.corners[k] = before.corners[order[k].second];
        area.levels[k] = before.levels[order[k].second];
    }
    const Face* face = &shape.faces[0];
    for (const Face& own : shape.faces)
        if (impulsekit::dot(own.normal, along) > impulsekit::dot(face->normal, along)) face = &own;
    area.slope = frame.flat(face->normal) * (-1.0 / impulsekit::dot(face->normal, frame.n));
    area.level = mean - dot(area.slope, middle);
    for (const Shape::Edge& edge : shape.edges) {
        const V e = shape.points[edge.end] - shape.points[edge.start];
        const double up = impulsekit::dot(e, along), square = impulsekit::dot(e, e);
        if (square - up * up > (1.0 - 2.0 * kAlike) * square) {
            area.across = frame.flat(e);
            break;
        }
    }
}

// The part of a shape within `near` of its furthest point along ±n, in the half that faces there.
Area area_of(const Shape& shape, const V& along, const Frame& frame, double near) {
    near = std::min(near, 0.5 * (support(shape, along) + support(shape, -along)));
    const V out = along - shape.axis * impulsekit::dot(along, shape.axis);
    const double sine = std::sqrt(impulsekit::dot(out, out));
    const double top = support(shape, along) - shape.radius;
    Area area;
    area.across = frame.flat(shape.across);
    const auto add = [&](const V& core) {
        const V tip = core + along * shape.radius;
        area.corners.push_back(frame.flat(tip));
        area.levels.push_back(impulsekit::dot(tip, frame.n));
    };
    for (const V& p : shape.points)
        if (impulsekit::dot(p, along) >= top - near) add(p);
    for (const Shape::Circle& c : shape.circles) {
        if (impulsekit::dot(c.centre, along) + c.radius * sine < top - near) continue;
        if (2.0 * c.radius * sine <= near) {
            const double up = impulsekit::dot(shape.axis, frame.n);
            Area disc;
            disc.across = area.across;
            disc.radius = c.radius;
            disc.slope = frame.flat(shape.axis) * (-1.0 / up);
            const V middle = c.centre + along * shape.radius;
            disc.corners = {frame.flat(middle)};
            disc.levels = {impulsekit::dot(middle, frame.n)};
            disc.level = disc.levels[0] - dot(disc.slope, disc.corners[0]);
            return disc;
        }
        add(c.centre + (sine > 0.0 ? out * (c.radius / sine) : shape.across * c.radius));
    }
    if (shape.kind == Shape::ellipsoid) {
        V tip;
        support(shape, along, &tip);
        add(tip - along * shape.radius);
    }
    area.round = shape.radius + (shape.circles.size() > 1 ? shape.circles[0].radius : 0.0);
    if (area.corners.size() > 2) {
        close_polygon(area, shape, along, frame);
        return area;
    }
    if (area.corners.size() == 2) {
        const V2 along = area.corners[1] - area.corners[0];
        const double square = dot(along, along);
        if (square > 0.0) area.slope = along * ((area.levels[1] - area.levels[0]) / square);
    }
    area.level = area.levels[0] - dot(area.slope, area.corners[0]);
    return area;
}

// The part of a plane below a shape, and more.
Area below(const Shape& shape, const Frame& frame, double height) {
    const V2 c = frame.flat(shape.centre);
    const double r = 2.0 * shape.reach + 1.0;
    Area area;
    area.corners = {{c.x - r, c.y - r}, {c.x + r, c.y - r}, {c.x + r, c.y + r}, {c.x - r, c.y + r}};
    area.levels.assign(4, height);
    area.level = height;
    area.across = frame.flat(shape.across);
    return area;
}

// A side of a polygon: a corner of it, and the unit vector inwards.
struct Side {
    V2 corner, inwards;
};
std::vector<Side> sides_of(const Area& area) {
    std::vector<Side> found;
    const std::size_t n = area.corners.size();
    for (std::size_t k = 0; k < n; ++k) {
        const V2 along = area.corners[(k + 1) % n] - area.corners[k];
        const double size = length(along);
        if (size > 0.0) found.push_back({area.corners[k], V2{-along.y, along.x} * (1.0 / size)});
    }
    return found;
}

bool lies_in(const V2& place, const Area& area) {
    if (area.radius > 0.0) return length(place - area.corners[0]) <= area.radius + kBeside;
    for (const Side& side : sides_of(area))
        if (dot(side.inwards, place - side.corner) < -kBeside) return false;
    return true;
}

// The ends of what of a segment lies over an area, or beside it by so much.
bool clip(const V2& start, const V2& end, const Area& area, double beside, std::vector<Spot>& out) {
    const V2 along = end - start;
    double low = 0.0, high = 1.0;
    if (area.radius > 0.0) {
        const V2 from = start - area.corners[0];
        const double square = dot(along, along), r = area.radius + beside;
        const double middle = square > 0.0 ? -dot(from, along) / square : 0.0;
        const V2 foot = from + along * middle;
        const double rest = r * r - dot(foot, foot);
        if (rest < 0.0) return false;
        if (square > 0.0) {
            const double half = std::sqrt(rest / square);
            low = std::max(low, middle - half), high = std::min(high, middle + half);
        }
    } else {
        for (const Side& side : sides_of(area)) {
            const double over = dot(side.inwards, start - side.corner) + beside;
            const double rate = dot(side.inwards, along);
            if (rate == 0.0 && over < 0.0) return false;
            if (rate > 0.0) low = std::max(low, -over / rate);
            if (rate < 0.0) high = std::min(high, -over / rate);
        }
    }
    if (low > high) return false;
    out.push_back({start + along * low});
    out.push_back({start + along * high});
    return true;
}

void two_segments(const Area& first, const Area& second, double rise, std::vector<Spot>& out) {
    const bool longer = length(first.corners[1] - first.corners[0]) >=
                        length(second.corners[1] - second.corners[0]);
    const Area &a = longer ? first : second, &b = longer ? second : first;
    // The shorter one seen along the longer.
    const V2 e = a.corners[1] - a.corners[0];
    const double size = length(e), around = a.round + b.round;
    const V2 along = e * (1.0 / size), side{-along.y, along.x};
    double share[2], off[2];
    for (int k = 0; k < 2; ++k) {
        share[k] = dot(b.corners[k] - a.corners[0], along);
        off[k] = dot(b.corners[k] - a.corners[0], side);
    }
    const double low = std::max(0.0, std::min(share[0], share[1]));
    const double high = std::min(size, std::max(share[0], share[1]));
    const double reach = share[1] - share[0];
    if (high > low && std::abs(reach) > 0.0) {
        for (double at : {low, high}) {
            const double here = off[0] + (at - share[0]) / reach * (off[1] - off[0]);
            double more = std::abs(here) / kEndsPatch;
            if (around > 0.0)
                more = here == 0.0 ? 0.0 : here * here / (std::hypot(around, here) + around);
            if (more <= rise)
                out.push_back({a.corners[0] + along * at + side * (0.5 * here), more});
        }
    }
    if (out.size() == 2) return;
    const double turn = off[0] - off[1];
    if (turn == 0.0) return;
    const double part = std::clamp(off[0] / turn, 0.0, 1.0);
    out = {{b.corners[0] + (b.corners[1] - b.corners[0]) * part}};
}

struct Arc {
    double start, size;
};

// The arcs of a circle that remain after cuts about angles, by so much to both sides.
std::vector<Arc> arcs_left(const std::vector<Arc>& cuts) {
    const double begin = cuts[0].start + cuts[0].size, end = kTurn - 2.0 * cuts[0].size;
    std::vector<Arc> spans, kept;
    double at = 0.0;
    for (std::size_t k = 1; k < cuts.size(); ++k) {
        double start = std::fmod(cuts[k].start - cuts[k].size - begin, kTurn);
        if (start < 0.0) start += kTurn;
        spans.push_back({start, 2.0 * cuts[k].size});
        at = std::max(at, start + 2.0 * cuts[k].size - kTurn);
    }
    std::sort(spans.begin(), spans.end(),
              [](const Arc& a, const Arc& b) { return a.start < b.start; });
    for (const Arc& span : spans) {
        if (span.start > at) kept.push_back({begin + at, std::min(span.start, end) - at});
        at = std::max(at, span.start + span.size);
    }
    if (end > at) kept.push_back({begin + at, end - at});
    kept.erase(
        std::remove_if(kept.begin(), kept.end(), [](const Arc& a) { return !(a.size > 0.0); }),
        kept.end());
    return kept;
}

// The angle of the first point of a whole rim [rad], up to an eighth of a turn.
double first_angle(const Area& disc, const Area& area) {
    const double own = std::atan2(disc.across.y, disc.across.x);
    const double other = std::atan2(area.across.y, area.across.x);
    if (area.radius == 0.0) return other;
    if (disc.radius < area.radius) return own;
    // Halfway between the points that either would have.
    const double x = std::cos(kRimPoints * own) + std::cos(kRimPoints * other);
    const double y = std::sin(kRimPoints * own) + std::sin(kRimPoints * other);
    return std::atan2(y, x) / kRimPoints;
}

// Points along what of a disc's rim lies over an area.
void add_arcs(const Area& disc, const Area& area, std::vector<Spot>& out) {
    const V2 middle = disc.corners[0];
    const double r = disc.radius;
    std::vector<Arc> cuts;
    if (area.radius > 0.0) {
        const V2 along = middle - area.corners[0];
        const double apart = length(along);
        if (apart + r > area.radius + tolerance::alike && apart > 0.0) {
            const double cosine =
                (area.radius * area.radius - r * r - apart * apart) / (2.0 * r * apart);
            if (cosine <= -1.0) return;
            if (cosine < 1.0) cuts.push_back({std::atan2(along.y, along.x), std::acos(cosine)});
        }
    } else {
        for (const Side& side : sides_of(area)) {
            const double over = dot(side.inwards, middle - side.corner);
            if (over <= -r) return;
            if (over < r)
                cuts.push_back({std::atan2(-side.inwards.y, -side.inwards.x), std::acos(over / r)});
        }
    }
    const auto add = [&](double angle) {
        out.push_back({middle + V2{std::cos(angle), std::sin(angle)} * r});
    };
    if (cuts.empty()) {
        const double first = first_angle(disc, area);
        for (int k = 0; k < kRimPoints; ++k) add(first + k * kTurn / kRimPoints);
        return;
    }
    for (const Arc& arc : arcs_left(cuts)) {
        const double pieces = std::max(1.0, std::ceil(arc.size / (kTurn / kRimPoints) - kAlike));
        for (int k = 0; k <= pieces; ++k) add(arc.start + k * arc.size / pieces);
    }
}

void two_areas(const Area& a, const Area& b, std::vector<Spot>& out) {
    if (a.radius > 0.0 && b.radius > 0.0) {
        const Area &small = a.radius <= b.radius ? a : b, &large = a.radius <= b.radius ? b : a;
        add_arcs(small, large, out);
        if (length(small.corners[0] - large.corners[0]) > kOnePoint) add_arcs(large, small, out);
        return;
    }
    for (const Area* own : {&a, &b}) {
        const Area& other = own == &a ? b : a;
        if (own->radius > 0.0) continue;
        for (const V2& corner : own->corners)
            if (lies_in(corner, other)) out.push_back({corner});
    }
    if (a.radius > 0.0 || b.radius > 0.0) {
        add_arcs(a.radius > 0.0 ? a : b, a.radius > 0.0 ? b : a, out);
        return;
    }
    const std::size_t n = a.corners.size();
    for (std::size_t k = 0; k < n; ++k) clip(a.corners[k], a.corners[(k + 1) % n], b, 0.0, out);
}

// Ends of what two areas share.
std::vector<Spot> overlap(const Area& first, const Area& second, double rise) {
    const bool turn = first.size() > second.size();
    const Area &a = turn ? second : first, &b = turn ? first : second;
    std::vector<Spot> found;
    if (a.size() == 0) {
        found = {{b.size() == 0 ? (a.corners[0] + b.corners[0]) * 0.5 : a.corners[0]}};
    } else if (a.size() == 1 && b.size() == 1) {
        two_segments(a, b, rise, found);
    } else if (a.size() == 1) {
        if (!clip(a.corners[0], a.corners[1], b, 0.0, found))
            clip(a.corners[0], a.corners[1], b, kBeside, found);
    } else {
        two_areas(a, b, found);
    }
    return found;
}

}  // namespace

std::vector<PatchPoint> patch_of(const Shape& a, const Shape& b, double gap, const V& normal,
                                 double margin) {
    const Frame frame(normal);
    const bool endless = b.kind == Shape::half_space;
    const double size = endless ? 2.0 * a.reach : 2.0 * (a.reach + b.reach);
    const double near = margin - gap + tolerance::solved * size;
    const Area one = area_of(a, -normal, frame, near);
    const Area two = endless ? below(a, frame, b.faces[0].offset) : area_of(b, normal, frame, near);
    const double level = -support(a, -normal) - 0.5 * gap;
    std::vector<PatchPoint> found;
    std::vector<V2> places;
    const auto add = [&](const V2& place, double here) {
        for (const V2& known : places) {
            const V2 along = place - known;
            if (std::max(std::abs(along.x), std::abs(along.y)) <= kOnePoint) return;
        }
        places.push_back(place);
        found.push_back({frame.t * place.x + frame.s * place.y + normal * level, here});
    };
    for (const Spot& spot : overlap(one, two, std::max(margin - gap, 0.0))) {
        const double here = one.height(spot.place) - two.height(spot.place) + spot.more;
        if (here <= gap + near) add(spot.place, here);
    }
    if (found.empty()) {
        V low, high;
        support(a, -normal, &low);
        if (endless)
            high = low;
        else
            support(b, normal, &high);
        add(frame.flat((low + high) * 0.5), gap);
    }
    return found;
}

}  // namespace impulsekit
