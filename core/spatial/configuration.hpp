// Configurations: how fast q changes, unit entries kept at unit length, and q beside its tangent.
#pragma once

#include <cmath>
#include <utility>
#include <vector>

#include "spatial/model.hpp"

namespace impulsekit {

// q̇ (nq) of v (nv), as Pinocchio counts both.
inline void configuration_rate(const Model& model, const double* q, const double* v, double* rate) {
    for (std::size_t k = 1; k < model.bodies.size(); ++k) {
        const Body& body = model.bodies[k];
        const double *own = q + body.q, *u = v + model.slots[body.slot].v;
        double* to = rate + body.q;
        // For a unit quaternion p: ṗ = p (ω, 0)/2.
        const auto turn = [](const double* p, const double* w, double* dp) {
            dp[0] = 0.5 * (p[3] * w[0] + p[1] * w[2] - p[2] * w[1]);
            dp[1] = 0.5 * (p[3] * w[1] + p[2] * w[0] - p[0] * w[2]);
            dp[2] = 0.5 * (p[3] * w[2] + p[0] * w[1] - p[1] * w[0]);
            dp[3] = -0.5 * (p[0] * w[0] + p[1] * w[1] + p[2] * w[2]);
        };
        switch (body.joint) {
            case Joint::circle:
                to[0] = -own[1] * u[0];
                to[1] = own[0] * u[0];
                break;
            case Joint::ball:
                turn(own, u, to);
                break;
            case Joint::free: {
                // Velocities of the body are in its own axes: u + 2 w (r × u) + 2 r × (r × u).
                const double *r = own + 3, w = own[6];
                const double c[3] = {r[1] * u[2] - r[2] * u[1], r[2] * u[0] - r[0] * u[2],
                                     r[0] * u[1] - r[1] * u[0]};
                to[0] = u[0] + 2.0 * (w * c[0] + r[1] * c[2] - r[2] * c[1]);
                to[1] = u[1] + 2.0 * (w * c[1] + r[2] * c[0] - r[0] * c[2]);
                to[2] = u[2] + 2.0 * (w * c[2] + r[0] * c[1] - r[1] * c[0]);
                turn(r, u + 3, to + 3);
                break;
            }
            case Joint::planar:
                to[0] = own[2] * u[0] - own[3] * u[1];
                to[1] = own[3] * u[0] + own[2] * u[1];
                to[2] = -own[3] * u[2];
                to[3] = own[2] * u[2];
                break;
            default:
                for (int i = 0; i < coordinates_of(body.joint); ++i) to[i] = u[i];
        }
    }
}

// Entries of q that are a point on a circle or sphere, brought back onto it.
inline void normalize_configuration(const Model& model, double* q) {
    for (std::size_t k = 1; k < model.bodies.size(); ++k) {
        const Body& body = model.bodies[k];
        int first = 0, count = 0;
        if (body.joint == Joint::ball) count = 4;
        if (body.joint == Joint::circle) count = 2;
        if (body.joint == Joint::free) first = 3, count = 4;
        if (body.joint == Joint::planar) first = 2, count = 2;
        double square = 0.0;
        double* own = q + body.q + first;
        for (int i = 0; i < count; ++i) square += own[i] * own[i];
        if (count > 0)
            for (int i = 0; i < count; ++i) own[i] /= std::sqrt(square);
    }
}

// First entry and number of each unit vector in q.
std::vector<std::pair<int, int>> units_of(const Model& model);

// Slopes (nq) by the entries of q, of slopes (nv) on its tangent: Eᵀ⁺ with q ⊕ δ = q + E δ.
void slopes_by_entries(const Model& model, const double* q, const double* slopes, double* to);

}  // namespace impulsekit
