// Spatial vectors, linear before angular, and inertias: for one state or eight side by side.
#pragma once

#include <vector>

#include "linalg/numbers.hpp"

namespace impulsekit {

// A velocity, an acceleration, or a force with its moment: linear before angular.
template <typename S>
struct Spatial {
    Vec3<S> linear, angular;

    Spatial operator+(const Spatial& b) const { return {linear + b.linear, angular + b.angular}; }
    Spatial operator-(const Spatial& b) const { return {linear - b.linear, angular - b.angular}; }
    Spatial operator-() const { return {-linear, -angular}; }
    Spatial& operator+=(const Spatial& b) { return *this = *this + b; }
    Spatial operator*(const S& a) const { return {linear * a, angular * a}; }
};

template <typename S>
S dot(const Spatial<S>& a, const Spatial<S>& b) {
    return dot(a.linear, b.linear) + dot(a.angular, b.angular);
}

// A twist at the point that stands at an arm from its own.
template <typename S>
Spatial<S> twist_at(const Spatial<S>& a, const Vec3<S>& arm) {
    return {a.linear + cross(a.angular, arm), a.angular};
}

// A force about the point from which its own stands at an arm.
template <typename S>
Spatial<S> wrench_about(const Spatial<S>& f, const Vec3<S>& arm) {
    return {f.linear, f.angular + cross(arm, f.linear)};
}

// Mass, first moment and inertia of a body, or of several, about a point.
template <typename S>
struct Inertia {
    S mass{};
    Vec3<S> moment;
    Sym3<S> about;

    Inertia& operator+=(const Inertia& b) {
        mass += b.mass;
        moment += b.moment;
        about = about + b.about;
        return *this;
    }
    Spatial<S> operator*(const Spatial<S>& v) const {
        return {v.linear * mass + cross(v.angular, moment),
                about * v.angular + cross(moment, v.linear)};
    }
};

// v × I v, of forces: what a twist asks for at no acceleration.
template <typename S>
Spatial<S> gyroscopic(const Inertia<S>& inertia, const Spatial<S>& v) {
    const Spatial<S> momentum = inertia * v;
    return {cross(v.angular, momentum.linear),
            cross(v.angular, momentum.angular) + cross(v.linear, momentum.linear)};
}

// Write six numbers behind others.
inline void append(std::vector<double>& to, const Spatial<double>& x) {
    to.insert(to.end(),
              {x.linear.x, x.linear.y, x.linear.z, x.angular.x, x.angular.y, x.angular.z});
}

// A share of an inertia.
template <typename S>
Inertia<S> share_of(const Inertia<S>& a, const S& x) {
    const Sym3<S>& i = a.about;
    return {a.mass * x, a.moment * x, {i.xx * x, i.xy * x, i.xz * x, i.yy * x, i.yz * x, i.zz * x}};
}

// About the point from which its own stands at an arm r: I + 2 g·r 1 − g rᵀ − r gᵀ, g = h + m r/2.
template <typename S>
Inertia<S> shifted_to(const Inertia<S>& a, const Vec3<S>& r) {
    const Vec3<S> half = r * (0.5 * a.mass), g = a.moment + half;
    const S x = g.x * r.x, y = g.y * r.y, z = g.z * r.z;
    const Sym3<S> more{2.0 * (y + z), -(g.x * r.y + g.y * r.x), -(g.x * r.z + g.z * r.x),
                       2.0 * (x + z), -(g.y * r.z + g.z * r.y), 2.0 * (x + y)};
    return {a.mass, g + half, a.about + more};
}

// The inertia of a body, or of a link whose mass varies, in the axes of its body.
template <typename S, typename Part>
Inertia<S> inertia_of(const Part& body) {
    const double* i = body.inertia;
    return {number<S>(body.mass),
            vec3<S>(body.moment),
            {number<S>(i[0]), number<S>(i[1]), number<S>(i[2]), number<S>(i[3]), number<S>(i[4]),
             number<S>(i[5])}};
}

}  // namespace impulsekit
