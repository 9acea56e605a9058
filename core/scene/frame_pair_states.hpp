// The frame pairs of a state, as slopes by the configuration take them.
#pragma once

#include <vector>

#include "scene/contact_frame.hpp"
#include "scene/tree_gradient.hpp"

namespace impulsekit {

// A blow as rows against the world.
inline Pair pair_of(const Blow& blow) {
    Pair pair;
    pair.first = blow.site;
    pair.carrier = blow.is_local ? Carrier::first : Carrier::world;
    return pair;
}

// The frame pairs of the points of a state; false, and which contact it is, where one does not move
// in closed form.
bool find_frame_pair_states(const Scene& scene, const Tree<double>& tree, const StateRows& rows,
                            std::vector<FramePairSlopes<double>>& found, int& entry);

// The bodies of one lane.
template <typename S>
void extract_lane(const Tree<S>& from, int lane, Tree<double>& to) {
    for (int k = 0; k < from.count(); ++k) {
        to.rotation[k] = lane_of(from.rotation[k], lane);
        to.origin[k] = lane_of(from.origin[k], lane);
        to.arm[k] = lane_of(from.arm[k], lane);
    }
    for (std::size_t a = 0; a < from.column.size(); ++a)
        to.column[a] = {lane_of(from.column[a].linear, lane),
                        lane_of(from.column[a].angular, lane)};
    for (std::size_t i = 0; i < from.bend.size(); ++i) to.bend[i] = lane_of(from.bend[i], lane);
}

}  // namespace impulsekit
