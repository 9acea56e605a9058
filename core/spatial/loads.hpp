// Loads of a tree: what every joint carries, fixed ones too, and how links move.
#pragma once

#include <vector>

#include "spatial/tree.hpp"

namespace impulsekit {

// A link: its mass about its centre, in the axes of its body.
struct Link : Load {
    int part = -1;  // that it belongs to; −1: to its body alone
    double centre[3] = {};
};

// What a fixed joint carries of its body, or of the world what stands on one base.
struct RigidPart {
    int body = 0;
    int holder = -1;        // the part of the same body that it hangs on, which comes before it
    double origin[3] = {};  // of its joint [m]
    double middle[3] = {};  // about which its loads are summed up: of a base its origin [m]
};

struct Links {
    std::vector<Link> links;
    std::vector<RigidPart> parts;
    std::vector<int> part_of_frame;  // as of links
    std::vector<int> part_of_joint;  // (bodies) that a body's joint hangs on
};

// How a link moves where its body moves so.
template <typename S>
Spatial<S> at_centre(const Tree<S>& tree, const Link& link, const Spatial<S>& motion) {
    return twist_at(motion, tree.rotation[link.body] * vec3<S>(link.centre));
}

// Impulses or forces on a tree from outside it, about the origins of bodies in world axes.
struct OuterWrenches {
    Tree<double>& tree;
    const Links& links;
    std::vector<Spatial<double>> parts;    // on rigid parts, about their middles
    std::vector<Spatial<double>> entries;  // on all that moves, about the world's origin

    OuterWrenches(Tree<double>& on, const Links& of, std::size_t count);
    // Add that of an entry on a body, at a frame; −1: of none that is known.
    void add(int entry, int body, int frame, const Spatial<double>& wrench);
};

// Impulses or forces: of bodies but the world and of rigid parts what their parents give them about
// the origins of their joints, of entries and of all that the world carries what acts on the bodies
// that move about the world's origin; and of links the motion of their mass centres. Six numbers
// each, world axes.
struct Loads {
    std::vector<double> joints, parts, entries, links, base;
};

// The loads where bodies move so: jumps of twists, or accelerations less gravity; `moves`: with the
// tree's twists. The tree with places; its wrenches are overwritten.
Loads find_loads(OuterWrenches& outside, const std::vector<Spatial<double>>& motion, bool moves);

}  // namespace impulsekit
