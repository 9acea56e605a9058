// What the entries of a scene do on its bodies, for one state or eight side by side.
#pragma once

#include "scene/blows.hpp"
#include "scene/contact_frame.hpp"

namespace impulsekit {

// Impulses or forces of a scene; null where it has none of a kind.
template <typename S>
struct SceneImpulses {
    const S* numbers = nullptr;                // six of each blow
    const S* lambda = nullptr;                 // (rows)
    const S *P = nullptr, *moments = nullptr;  // (3 points) each, in the axes of points
};

// Call add(entry, site, wrench) for all that blows, then bilateral constraints, then contacts at
// points do on bodies, each about its body's origin in world axes; entries are counted in this
// order. The tree with places.
template <typename S, typename Add>
void for_wrenches(const Scene& scene, const Tree<S>& tree,
                  const std::vector<ContactFrame<S>>& points, const SceneImpulses<S>& given,
                  Add add) {
    const auto add_pair = [&](int entry, const Site& first, const Site& other,
                              const FramePairState<S>& pair, const S* p, const S* couple) {
        const Vec3<S> f = pair.axes * Vec3<S>{p[0], p[1], p[2]},
                      m = pair.axes * Vec3<S>{couple[0], couple[1], couple[2]};
        add(entry, first, Spatial<S>{f, cross(pair.place - tree.origin[pair.first], f) + m});
        add(entry, other,
            Spatial<S>{-f, cross(pair.other_place - tree.origin[pair.other], -f) - m});
    };
    const int blows = static_cast<int>(scene.blows.size()),
              held = static_cast<int>(scene.held.size());
    for (int i = 0; i < blows && given.numbers; ++i) {
        const Blow& blow = scene.blows[i];
        add(i, blow.site,
            wrench_of(blow, given.numbers + 6 * i, tree.rotation[blow.site.body], false));
    }
    for (int i = 0; i < held && given.lambda; ++i) {
        const Held& own = scene.held[i];
        if (own.kind != Held::pair) continue;
        S p[6] = {};
        for (int r = 0; r < own.count; ++r) p[own.select[r]] = given.lambda[own.row + r];
        add_pair(blows + i, own.frames.first, own.frames.other, frame_pair_state(tree, own.frames),
                 p, p + 3);
    }
    for (std::size_t i = 0; i < points.size() && given.P; ++i) {
        const Contact& contact = scene.contacts[points[i].entry];
        if (points[i].of_bodies)
            add_pair(blows + held + points[i].entry, contact.first_site(), contact.other_site(),
                     points[i], given.P + 3 * i, given.moments + 3 * i);
    }
}

}  // namespace impulsekit
