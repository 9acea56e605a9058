#include "spatial/configuration.hpp"

#include <algorithm>

#include "linalg/numbers.hpp"

namespace impulsekit {

std::vector<std::pair<int, int>> units_of(const Model& model) {
    std::vector<std::pair<int, int>> units;
    for (std::size_t k = 1; k < model.bodies.size(); ++k) {
        const Body& body = model.bodies[k];
        if (body.joint == Joint::ball) units.emplace_back(body.q, 4);
        if (body.joint == Joint::free) units.emplace_back(body.q + 3, 4);
        if (body.joint == Joint::circle) units.emplace_back(body.q, 2);
        if (body.joint == Joint::planar) units.emplace_back(body.q + 2, 2);
    }
    return units;
}

void slopes_by_entries(const Model& model, const double* all, const double* slopes, double* to) {
    // For a quaternion E = q ⊗ (ω/2, 0), and Eᵀ E = 1/4.
    const auto roll = [&](int i, const double* g) {
        const double x = 2.0 * all[i], y = 2.0 * all[i + 1], z = 2.0 * all[i + 2],
                     w = 2.0 * all[i + 3];
        to[i] = w * g[0] - z * g[1] + y * g[2];
        to[i + 1] = z * g[0] + w * g[1] - x * g[2];
        to[i + 2] = -y * g[0] + x * g[1] + w * g[2];
        to[i + 3] = -x * g[0] - y * g[1] - z * g[2];
    };
    const auto turn = [&](int i, double g) {
        to[i] = -all[i + 1] * g;
        to[i + 1] = all[i] * g;
    };
    for (std::size_t k = 1; k < model.bodies.size(); ++k) {
        const Body& body = model.bodies[k];
        if (body.freedoms == 0) continue;
        const int i = body.q;
        const double* q = all + i;
        const double* g = slopes + model.slots[body.slot].v;
        switch (body.joint) {
            case Joint::circle:
                turn(i, g[0]);
                break;
            case Joint::ball:
                roll(i, g);
                break;
            case Joint::free: {
                const Vec3<double> place =
                    of_quaternion(q[3], q[4], q[5], q[6]) * Vec3<double>{g[0], g[1], g[2]};
                to[i] = place.x;
                to[i + 1] = place.y;
                to[i + 2] = place.z;
                roll(i + 3, g + 3);
                break;
            }
            case Joint::planar:
                to[i] = q[2] * g[0] - q[3] * g[1];
                to[i + 1] = q[3] * g[0] + q[2] * g[1];
                turn(i + 2, g[2]);
                break;
            default:
                std::copy(g, g + body.freedoms, to + i);
        }
    }
}

}  // namespace impulsekit
