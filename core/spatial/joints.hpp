// Joints: places and columns by their types, and configurations beside their tangents.
#pragma once

#include <utility>
#include <vector>

#include "spatial/model.hpp"
#include "spatial/spatial_vectors.hpp"

namespace impulsekit {

// R Rz(c, s) and R Rx(c, s).
template <typename S, typename T>
Mat3<S> about_z(const Mat3<S>& r, const T& c, const T& s) {
    return {{r.x.x * c + r.y.x * s, r.x.y * c + r.y.y * s, r.x.z * c + r.y.z * s},
            {r.y.x * c - r.x.x * s, r.y.y * c - r.x.y * s, r.y.z * c - r.x.z * s},
            r.z};
}

template <typename S>
Mat3<S> about_x(const Mat3<S>& r, double c, double s) {
    return {r.x,
            {r.y.x * c + r.z.x * s, r.y.y * c + r.z.y * s, r.y.z * c + r.z.z * s},
            {r.z.x * c - r.y.x * s, r.z.y * c - r.y.y * s, r.z.z * c - r.y.z * s}};
}

// An ellipsoid's joint: its origin at p = (a sin q₁, −b sin q₀ cos q₁, c cos q₀ cos q₁), with
// derivatives, and the axes Rx(q₀) Ry(q₁).
template <typename S>
struct Ellipsoid {
    Vec3<S> place, by_first, by_second, twice_first, both, twice_second;
    Vec3<S> second_axis;  // about which q₁ turns
    Mat3<S> axes;

    Ellipsoid(const Body& body, const S* q) {
        const double a = body.radius[0], b = body.radius[1], c = body.radius[2];
        S s0, c0, s1, c1;
        sine_cosine(q[0], s0, c0);
        sine_cosine(q[1], s1, c1);
        place = {a * s1, -(b * (s0 * c1)), c * (c0 * c1)};
        by_first = {S{}, -(b * (c0 * c1)), -(c * (s0 * c1))};
        by_second = {a * c1, b * (s0 * s1), -(c * (c0 * s1))};
        twice_first = {S{}, b * (s0 * c1), -(c * (c0 * c1))};
        both = {S{}, b * (c0 * s1), c * (s0 * s1)};
        twice_second = {-(a * s1), b * (s0 * c1), -(c * (c0 * c1))};
        second_axis = {S{}, c0, s0};
        axes = {{c1, s0 * s1, -(c0 * s1)}, second_axis, {s1, -(s0 * c1), c0 * c1}};
    }
};

// The placement of a body in its parent: cosine and sine of γ + θ where it turns about z alone;
// else a rotation and its origin.
template <typename S>
struct Stance {
    S cosine{}, sine{};
    Mat3<S> rotation;
    Vec3<S> shift;
};

template <typename S>
void set_stance(const Body& body, const S* all, Stance<S>& to) {
    const JointType& type = body.type;
    const S* q = all + body.q;
    S follows;
    if (type.coordinates() == 1) {
        follows = body.ratio * q[0] + body.offset;
        q = &follows;
    }
    const S* turn = q + type.places;
    S c{}, s{};
    if (type.turn == Turn::angle) sine_cosine(turn[0], s, c);
    if (type.turn == Turn::circle) c = turn[0], s = turn[1];
    if (body.turns_about_z) {
        to.cosine = body.gamma[0] * c - body.gamma[1] * s;
        to.sine = body.gamma[1] * c + body.gamma[0] * s;
        return;
    }
    Mat3<S> axes = mat3<S>(body.rotation);
    to.shift = vec3<S>(body.shift);
    Vec3<S> place;
    for (int i = 0; i < type.places; ++i) entry(place, type.along[i]) = q[i];
    if (body.pitch != 0.0) place.z = turn[0] * body.pitch;
    if (type.turn == Turn::ellipsoid) {
        const Ellipsoid<S> e(body, turn);
        place = e.place;
        to.shift += axes * place;
        axes = {axes * e.axes.x, axes * e.axes.y, axes * e.axes.z};
        sine_cosine(turn[2], s, c);
    } else if (type.places > 0 || body.pitch != 0.0) {
        to.shift += axes * place;
    }
    if (type.turn == Turn::none)
        to.rotation = axes;
    else if (type.turn == Turn::quaternion)
        to.rotation = axes * of_quaternion(turn[0], turn[1], turn[2], turn[3]);
    else
        to.rotation = about_z(axes, c, s);
}

template <typename S>
Vec3<S> shift_of(const Body& body, const Stance<S>& to) {
    return body.turns_about_z ? vec3<S>(body.shift) : to.shift;
}

template <typename S>
Mat3<S> turned_on(const Mat3<S>& parent, const Body& body, const Stance<S>& to) {
    if (!body.turns_about_z) return parent * to.rotation;
    Mat3<S> r = parent;
    if (body.about_z) r = about_z(r, body.beta[0], body.beta[1]);
    if (body.about_x) r = about_x(r, body.alpha[0], body.alpha[1]);
    return about_z(r, to.cosine, to.sine);
}

// The twists of a body's slots at unit speed, in the world; of an ellipsoid also the second
// derivatives of its origin: 00, 01, 11. `parent`, `own`: rotations of both.
template <typename S>
void write_columns(const Body& body, const Slot* slots, const S* q, const Mat3<S>& parent,
                   const Mat3<S>& own, Spatial<S>* column, Vec3<S>* bend) {
    for (int a = 0; a < body.freedoms; ++a) {
        const int d = slots[a].direction;
        Vec3<S> axis = entry(own, d % 3);
        if (slots[a].ratio != 1.0) axis = axis * number<S>(slots[a].ratio);
        column[a] = {};
        (d < 3 ? column[a].linear : column[a].angular) = axis;
        if (body.pitch != 0.0) column[a].linear = axis * number<S>(body.pitch);
    }
    if (body.type.turn != Turn::ellipsoid) return;
    const Ellipsoid<S> e(body, q + body.q);
    const Mat3<S> f = parent * mat3<S>(body.rotation);
    column[0] = {f * e.by_first, f.x};
    column[1] = {f * e.by_second, f * e.second_axis};
    bend[0] = f * e.twice_first;
    bend[1] = f * e.both;
    bend[2] = f * e.twice_second;
}

// ∂s_i/∂q_j − s_j × s_i: the columns of an ellipsoid do not turn with it alone.
template <typename S>
Spatial<S> slope_of_column(const Spatial<S>* s, const Vec3<S>* bend, int i, int j) {
    const Vec3<S> twice = i < 2 && j < 2 ? bend[i + j] : Vec3<S>{};
    return {twice - cross(s[j].angular, s[i].linear),
            i < j ? -cross(s[j].angular, s[i].angular) : Vec3<S>{}};
}

// q̇ (nq) of v (nv), as Pinocchio counts both.
void configuration_rate(const Model& model, const double* q, const double* v, double* rate);

// Slopes (nq) by the entries of q, of slopes (nv) on its tangent: Eᵀ⁺ with q ⊕ δ = q + E δ.
void slopes_by_entries(const Model& model, const double* q, const double* slopes, double* to);

// First entry and number of each unit vector in q.
std::vector<std::pair<int, int>> units_of(const Model& model);

// Entries of q that are a point on a circle or sphere, brought back onto it.
void normalize_configuration(const Model& model, double* q);

// Quaternions of q with the sign that brings them near those of another configuration: a quaternion
// and its opposite are one rotation.
void choose_signs(const Model& model, const double* near, double* q);

// Distance of q from another along an entry of v; 0 of one that follows another.
double coordinate_difference(const Model& model, int v, const double* from, const double* to);

// The entries of q behind an entry of v that is an angle or a length.
void set_coordinate(const Model& model, int v, double value, double* q);

}  // namespace impulsekit
