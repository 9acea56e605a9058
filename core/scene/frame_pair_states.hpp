// The frame pairs of a state, as slopes by the configuration take them.
#pragma once

#include <vector>

#include "scene/rows.hpp"
#include "scene/tree_gradient.hpp"

namespace impulsekit {

// A blow as rows against the world.
inline Pair pair_of(const Blow& blow) {
    Pair pair;
    pair.first = blow.site;
    pair.carrier = blow.is_local ? Carrier::first : Carrier::world;
    return pair;
}

template <typename S>
FramePairState<S> frame_pair_state(const Tree<S>& tree, const Pair& pair) {
    const typename Rows<S>::Ends ends = Rows<S>::ends_of(tree, pair);
    FramePairState<S> m;
    m.first = pair.first.body;
    m.other = pair.other.body;
    m.place = ends.place;
    m.other_place = ends.other_place;
    m.axes = ends.axes;
    m.coincides = pair.coincides;
    m.carrier = pair.carrier;
    return m;
}

// The frame pairs of the points of a state; false, and which contact it is, where one does not move
// in closed form.
bool find_frame_pair_states(const Scene& scene, const Tree<double>& tree, const StateRows& rows,
                            std::vector<FramePairState<double>>& found, int& entry);

// The bodies of one lane.
template <typename S>
void extract_lane(const Tree<S>& from, int lane, Tree<double>& to) {
    const auto get = [lane](const Vec3<S>& a) {
        return Vec3<double>{Number<S>::get(a.x, lane), Number<S>::get(a.y, lane),
                            Number<S>::get(a.z, lane)};
    };
    for (int k = 0; k < from.count(); ++k) {
        to.rotation[k] = {get(from.rotation[k].x), get(from.rotation[k].y),
                          get(from.rotation[k].z)};
        to.origin[k] = get(from.origin[k]);
        to.arm[k] = get(from.arm[k]);
    }
    for (std::size_t a = 0; a < from.column.size(); ++a)
        to.column[a] = {get(from.column[a].linear), get(from.column[a].angular)};
    for (std::size_t i = 0; i < from.bend.size(); ++i) to.bend[i] = get(from.bend[i]);
}

}  // namespace impulsekit
