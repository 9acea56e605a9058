// Known impulses as wrenches on the bodies of a tree.
#pragma once

#include <algorithm>

#include "scene/scene.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

// The wrench of a blow with numbers p (6) about its body's origin; `world`: R of the body, to the
// axes of the wrench unless it is expressed in the body's own.
template <typename S>
Spatial<S> wrench_of(const Blow& blow, const S* p, const Mat3<S>& world, bool in_body) {
    Vec3<S> f{p[0], p[1], p[2]}, m{p[3], p[4], p[5]};
    const Vec3<S> point = vec3<S>(blow.site.point);
    if (blow.is_local) {
        const Mat3<S> axes = mat3<S>(blow.site.axes);
        f = axes * f;
        m = axes * m;
        if (!in_body) f = world * f, m = world * m;
    } else if (in_body) {
        f = back(world, f);
        m = back(world, m);
    }
    return {f, m + cross(in_body ? point : world * point, f)};
}

// The blows of a scene as the wrenches of a tree that has been placed; `numbers`: six of each.
template <typename S>
void add_blow_wrenches(const Scene& scene, const S* numbers, Tree<S>& tree) {
    std::fill(tree.wrench.begin(), tree.wrench.end(), Spatial<S>{});
    for (std::size_t i = 0; i < scene.blows.size(); ++i) {
        const int body = scene.blows[i].site.body;
        tree.wrench[body] += wrench_of(scene.blows[i], numbers + 6 * i, tree.rotation[body], false);
    }
}

}  // namespace impulsekit
