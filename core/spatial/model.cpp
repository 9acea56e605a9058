#include "spatial/model.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/numbers.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit {
namespace {

using Vector = Vec3<double>;
using Matrix = Mat3<double>;

bool has_axis(const GivenBody& body) { return joint_types()[body.joint].has_axis(); }

Vector normalized(const Vector& a) { return a * (1.0 / std::sqrt(dot(a, a))); }

// Axes in which a unit vector is z, by the least turn of names where it is x, y or z itself.
Matrix axes_along(const Vector& axis) {
    if (axis.x == 1.0) return {{0, 1, 0}, {0, 0, 1}, {1, 0, 0}};
    if (axis.y == 1.0) return {{0, 0, 1}, {1, 0, 0}, {0, 1, 0}};
    if (axis.z == 1.0) return identity<double>();
    const double x = std::abs(axis.x), y = std::abs(axis.y), z = std::abs(axis.z);
    Vector across = x <= y && x <= z ? Vector{1, 0, 0} : y <= z ? Vector{0, 1, 0} : Vector{0, 0, 1};
    const Vector first = normalized(cross(across, axis));
    return {first, cross(axis, first), axis};
}

// x is across the axis of a joint that hangs on the body: α about x alone then leads to it.
Matrix axes_between(const Vector& axis, const Vector& next) {
    Vector across = cross(axis, next);
    if (!(std::sqrt(dot(across, across)) > tolerance::parallel)) return axes_along(axis);
    across = normalized(across - axis * dot(axis, across));
    return {across, cross(axis, across), axis};
}

void write(const Vector& a, double* to) {
    to[0] = a.x;
    to[1] = a.y;
    to[2] = a.z;
}

// Take a rotation apart: F = Rz(β) Rx(α) Rz(γ).
void write_angles(const Matrix& f, Body& body) {
    const double x = f.z.x, y = -f.z.y;
    double sine = std::hypot(x, y), cosine = f.z.z;
    const bool aligned = sine < tolerance::last_bits,
               straight = aligned || std::abs(x) < tolerance::last_bits;
    body.beta[0] = straight ? 1.0 : y / sine;
    body.beta[1] = straight ? 0.0 : x / sine;
    body.alpha[0] = aligned ? std::copysign(1.0, cosine) : cosine;
    body.alpha[1] = aligned ? 0.0 : straight ? y : sine;
    body.gamma[0] = body.beta[0] * f.x.x + body.beta[1] * f.x.y;
    body.gamma[1] = -(body.beta[0] * f.y.x + body.beta[1] * f.y.y);
    body.about_x = body.alpha[0] != 1.0 || body.alpha[1] != 0.0;
    body.about_z = body.beta[0] != 1.0 || body.beta[1] != 0.0;
}

}  // namespace

// The axes of all bodies in those of their joints, chosen such that most β are nothing.
static std::vector<Matrix> axes_of_bodies(const std::vector<GivenBody>& given) {
    const int count = static_cast<int>(given.size());
    std::vector<Matrix> turns(count + 1, identity<double>());
    std::vector<char> chosen(count + 1, 0);
    for (int k = 1; k <= count; ++k)
        if (has_axis(given[k - 1])) turns[k] = axes_along(vec3<double>(given[k - 1].axis));
    for (int k = 1; k <= count; ++k) {
        const GivenBody& child = given[k - 1];
        const int parent = child.parent;
        if (parent == 0 || chosen[parent] || !has_axis(child)) continue;
        const GivenBody& above = given[parent - 1];
        if (!has_axis(above)) continue;
        const Vector next = mat3<double>(child.rotation) * vec3<double>(child.axis);
        const Vector across = cross(vec3<double>(above.axis), next);
        if (!(std::sqrt(dot(across, across)) > tolerance::parallel)) continue;
        chosen[parent] = 1;
        turns[parent] = axes_between(vec3<double>(above.axis), next);
    }
    return turns;
}

Model model_of(const std::vector<GivenBody>& given, int nq, int nv, const double* armature) {
    const int count = static_cast<int>(given.size());
    Model model;
    model.nq = nq;
    model.nv = nv;
    model.bodies.resize(given.size() + 1);
    const std::vector<Matrix> turns = axes_of_bodies(given);
    for (Body& body : model.bodies) to_rows(identity<double>(), body.turn);
    std::vector<int> last_v(count + 1, -1);
    std::vector<char> seen(nv, 0);
    model.parent_v.assign(nv, -1);
    for (int k = 1; k <= count; ++k) {
        const GivenBody& from = given[k - 1];
        Body& body = model.bodies[k];
        body.parent = from.parent;
        body.type = joint_types()[from.joint];
        body.q = from.q;
        body.slot = static_cast<int>(model.slots.size());
        body.freedoms = body.type.freedoms();
        body.pitch = from.pitch;
        std::copy(from.axis, from.axis + 3, body.radius);
        model.has_ellipsoids = model.has_ellipsoids || body.type.turn == Turn::ellipsoid;
        body.ratio = from.ratio;
        body.offset = from.offset;
        const Matrix &turn = turns[k], to_own = transposed(turn);
        to_rows(turn, body.turn);
        const Matrix above = transposed(turns[from.parent]);
        const Matrix rotation = above * mat3<double>(from.rotation) * turn;
        to_rows(rotation, body.rotation);
        write(above * vec3<double>(from.shift), body.shift);
        const bool about_axis = body.type.turn == Turn::angle || body.type.turn == Turn::circle;
        body.turns_about_z = about_axis && body.freedoms == 1 && body.pitch == 0.0;
        if (body.turns_about_z) write_angles(rotation, body);
        body.mass = from.mass;
        write(to_own * vec3<double>(from.moment), body.moment);
        turn_entries(to_own, from.inertia, body.inertia);
        last_v[k] = last_v[from.parent];
        for (int d = 0; d < body.freedoms; ++d) {
            const int v = from.v + d;
            const bool follows = seen[v];
            seen[v] = 1;
            model.has_followers = model.has_followers || follows;
            model.slots.push_back(
                {k, body.type.direction(d), v, from.ratio, follows ? 0.0 : armature[v]});
            if (follows) continue;
            model.parent_v[v] = last_v[k];
            last_v[k] = v;
        }
    }
    // A body that follows another ties branches together: M is then dense.
    if (model.has_followers)
        for (int v = 0; v < nv; ++v) model.parent_v[v] = v - 1;
    return model;
}

}  // namespace impulsekit
