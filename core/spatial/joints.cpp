#include "spatial/joints.hpp"

#include <algorithm>
#include <cmath>

namespace impulsekit {

const std::vector<JointType>& joint_types() {
    static const std::vector<JointType> types = {
        {"angle", 0, {}, Turn::angle},
        {"circle", 0, {}, Turn::circle},
        {"slide", 1, {2}, Turn::none},
        {"ball", 0, {}, Turn::quaternion},
        {"free", 3, {0, 1, 2}, Turn::quaternion},
        {"planar", 2, {0, 1}, Turn::circle},
        {"translation", 3, {0, 1, 2}, Turn::none},
        {"ellipsoid", 0, {}, Turn::ellipsoid},
    };
    return types;
}

namespace {

// By Turn: entries of q, of v, and those of q that are a unit vector.
constexpr int kCoordinates[] = {0, 1, 2, 4, 3}, kFreedoms[] = {0, 1, 1, 3, 3},
              kUnits[] = {0, 0, 2, 4, 0};

int unit_of(const JointType& type) { return kUnits[static_cast<int>(type.turn)]; }

// Lengths along axes of a body in those of its joint's frame with `way` 1, back with −1.
void turn_places(const JointType& type, const double* turn, double way, const double* from,
                 double* to) {
    if (type.places == 0) return;
    Vec3<double> u;
    for (int i = 0; i < type.places; ++i) entry(u, type.along[i]) = from[i];
    if (type.turn == Turn::quaternion) {
        // u + 2 w (r × u) + 2 r × (r × u).
        const Vec3<double> r = vec3<double>(turn) * way, c = cross(r, u);
        const double w = turn[3];
        u += Vec3<double>{w * c.x + r.y * c.z - r.z * c.y, w * c.y + r.z * c.x - r.x * c.z,
                          w * c.z + r.x * c.y - r.y * c.x} *
             2.0;
    } else if (type.turn != Turn::none) {
        double c = turn[0], s = turn[1];
        if (type.turn == Turn::angle) sine_cosine(turn[0], s, c);
        u = {c * u.x - way * s * u.y, way * s * u.x + c * u.y, u.z};
    }
    for (int i = 0; i < type.places; ++i) to[i] = entry(u, type.along[i]);
}

// E u with q ⊕ δ = q + E δ, a quaternion's E times `share`.
void along_tangent(const Model& model, const double* q, const double* v, double share, double* to) {
    for (std::size_t k = 1; k < model.bodies.size(); ++k) {
        const Body& body = model.bodies[k];
        if (body.freedoms == 0) continue;
        const JointType& type = body.type;
        const double *p = q + body.q + type.places, *u = v + model.slots[body.slot].v,
                     *w = u + type.places;
        double *places = to + body.q, *own = places + type.places;
        turn_places(type, p, 1.0, u, places);
        if (type.turn == Turn::circle) {
            own[0] = -p[1] * w[0];
            own[1] = p[0] * w[0];
        } else if (type.turn == Turn::quaternion) {
            // ṗ = p (ω, 0)/2.
            const double half = 0.5 * share;
            own[0] = half * (p[3] * w[0] + p[1] * w[2] - p[2] * w[1]);
            own[1] = half * (p[3] * w[1] + p[2] * w[0] - p[0] * w[2]);
            own[2] = half * (p[3] * w[2] + p[0] * w[1] - p[1] * w[0]);
            own[3] = -half * (p[0] * w[0] + p[1] * w[1] + p[2] * w[2]);
        } else {
            std::copy(w, u + body.freedoms, own);
        }
    }
}

// The i-th coordinate of the way from one configuration of a joint to another.
double difference(const JointType& type, int i, const double* from, const double* to) {
    const int n = type.places;
    if (i < n) {
        double apart[3];
        for (int k = 0; k < n; ++k) apart[k] = to[k] - from[k];
        turn_places(type, from + n, -1.0, apart, apart);
        return apart[i];
    }
    const double *a = from + n, *b = to + n;
    if (type.turn == Turn::circle)
        return std::atan2(a[0] * b[1] - a[1] * b[0], a[0] * b[0] + a[1] * b[1]);
    if (type.turn != Turn::quaternion) return to[i] - from[i];
    // 2 of the vector part of p₀⁻¹ p₁.
    const Vec3<double> part{a[3] * b[0] - a[0] * b[3] - a[1] * b[2] + a[2] * b[1],
                            a[3] * b[1] - a[1] * b[3] - a[2] * b[0] + a[0] * b[2],
                            a[3] * b[2] - a[2] * b[3] - a[0] * b[1] + a[1] * b[0]};
    const double w = a[0] * b[0] + a[1] * b[1] + a[2] * b[2] + a[3] * b[3];
    return 2.0 * entry(part, i - n) * (w < 0.0 ? -1.0 : 1.0);
}

}  // namespace

int JointType::coordinates() const { return places + kCoordinates[static_cast<int>(turn)]; }

int JointType::freedoms() const { return places + kFreedoms[static_cast<int>(turn)]; }

int JointType::direction(int i) const {
    if (i < places) return along[i];
    return turn == Turn::angle || turn == Turn::circle ? 5 : 3 + i - places;
}

bool JointType::has_axis() const {
    for (int i = 0; i < freedoms(); ++i)
        if (direction(i) % 3 != 2) return false;
    return true;
}

void configuration_rate(const Model& model, const double* q, const double* v, double* rate) {
    along_tangent(model, q, v, 1.0, rate);
}

void slopes_by_entries(const Model& model, const double* q, const double* slopes, double* to) {
    // A quaternion has Eᵀ E = 1/4.
    along_tangent(model, q, slopes, 4.0, to);
}

std::vector<std::pair<int, int>> units_of(const Model& model) {
    std::vector<std::pair<int, int>> units;
    for (std::size_t k = 1; k < model.bodies.size(); ++k) {
        const JointType& type = model.bodies[k].type;
        if (unit_of(type) > 0) units.emplace_back(model.bodies[k].q + type.places, unit_of(type));
    }
    return units;
}

void normalize_configuration(const Model& model, double* q) {
    for (std::size_t k = 1; k < model.bodies.size(); ++k) {
        const JointType& type = model.bodies[k].type;
        const int count = unit_of(type);
        double square = 0.0;
        double* own = q + model.bodies[k].q + type.places;
        for (int i = 0; i < count; ++i) square += own[i] * own[i];
        for (int i = 0; i < count; ++i) own[i] /= std::sqrt(square);
    }
}

void choose_signs(const Model& model, const double* near, double* q) {
    for (const auto& [first, count] : units_of(model)) {
        double *own = q + first, product = 0.0;
        for (int i = 0; i < count; ++i) product += own[i] * near[first + i];
        for (int i = 0; i < count && count == 4 && product < 0.0; ++i) own[i] = -own[i];
    }
}

double coordinate_difference(const Model& model, int v, const double* from, const double* to) {
    for (std::size_t a = 0; a < model.slots.size(); ++a) {
        const Body& body = model.bodies[model.slots[a].body];
        if (model.slots[a].v == v && body.ratio == 1.0 && body.offset == 0.0)
            return difference(body.type, static_cast<int>(a) - body.slot, from + body.q,
                              to + body.q);
    }
    return 0.0;
}

void set_coordinate(const Model& model, int v, double value, double* q) {
    for (const Slot& slot : model.slots) {
        const Body& body = model.bodies[slot.body];
        if (slot.v != v) continue;
        q[body.q] = body.type.turn == Turn::circle ? std::cos(value) : value;
        if (body.type.turn == Turn::circle) q[body.q + 1] = std::sin(value);
    }
}

}  // namespace impulsekit
