#include "spatial/loads.hpp"

#include <algorithm>

namespace impulsekit {
namespace {

// An entry of a list, or −1 where it has none.
int number_in(const std::vector<int>& list, int i) {
    return i >= 0 && i < static_cast<int>(list.size()) ? list[i] : -1;
}

Vec3<double> middle_of(const Tree<double>& tree, const RigidPart& part) {
    return tree.rotation[part.body] * vec3<double>(part.middle);
}

// Of each part what its links ask for, less what acts on it.
void load_parts(OuterWrenches& outside, const std::vector<Spatial<double>>& motion, bool moves) {
    const Tree<double>& tree = outside.tree;
    for (Spatial<double>& own : outside.parts) own = -own;
    for (const Link& link : outside.links.links) {
        if (link.part < 0) continue;
        const Inertia<double> own =
            shifted_to(tree.in_world(link.body, inertia_of<double>(link)),
                       tree.rotation[link.body] * vec3<double>(link.centre));
        Spatial<double> asked = own * motion[link.body];
        if (moves) asked += gyroscopic(own, tree.twist[link.body]);
        outside.parts[link.part] +=
            wrench_about(asked, -middle_of(tree, outside.links.parts[link.part]));
    }
}

}  // namespace

OuterWrenches::OuterWrenches(Tree<double>& on, const Links& of, std::size_t count)
    : tree(on), links(of), parts(of.parts.size()), entries(count) {
    std::fill(tree.wrench.begin(), tree.wrench.end(), Spatial<double>{});
}

void OuterWrenches::add(int entry, int body, int frame, const Spatial<double>& wrench) {
    tree.wrench[body] += wrench;
    if (body > 0) entries[entry] += wrench_about(wrench, tree.world_place(tree.origin[body]));
    const int part = number_in(links.part_of_frame, frame);
    if (part >= 0) parts[part] += wrench_about(wrench, -middle_of(tree, links.parts[part]));
}

Loads find_loads(OuterWrenches& outside, const std::vector<Spatial<double>>& motion, bool moves) {
    Tree<double>& tree = outside.tree;
    const Links& links = outside.links;
    std::vector<Spatial<double>>& parts = outside.parts;
    load_parts(outside, motion, moves);
    tree.load(motion, [&](int k) { return inertia_of<double>(tree.model.bodies[k]); }, moves);
    std::vector<double> along(tree.model.nv);
    tree.gather(along.data());
    Loads found;
    Spatial<double> base;
    for (int k = 1; k < tree.count(); ++k) {
        const Spatial<double>& own = tree.wrench[k];
        append(found.joints, own);
        if (tree.model.bodies[k].parent == 0)
            base += wrench_about(own, tree.world_place(tree.origin[k]));
        const int part = number_in(links.part_of_joint, k);
        if (part >= 0)
            parts[part] += wrench_about(own, tree.arm[k] - middle_of(tree, links.parts[part]));
    }
    append(found.base, base);
    for (std::size_t p = parts.size(); p-- > 0;)
        if (links.parts[p].holder >= 0) parts[links.parts[p].holder] += parts[p];
    for (std::size_t p = 0; p < parts.size(); ++p) {
        const RigidPart& part = links.parts[p];
        const Vec3<double> arm = vec3<double>(part.middle) - vec3<double>(part.origin);
        append(found.parts, wrench_about(parts[p], tree.rotation[part.body] * arm));
    }
    for (const Spatial<double>& own : outside.entries) append(found.entries, own);
    for (const Link& link : links.links)
        append(found.links, at_centre(tree, link, motion[link.body]));
    return found;
}

}  // namespace impulsekit
