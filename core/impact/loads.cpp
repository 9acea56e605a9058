#include "impact/loads.hpp"

#include <algorithm>

#include "scene/wrenches.hpp"

namespace impulsekit {

std::vector<double> moments_by_point(std::size_t points, const std::vector<int>& turning_of,
                                     const double* moments) {
    std::vector<double> found(3 * points);
    for (std::size_t i = 0; i < turning_of.size(); ++i)
        std::copy_n(moments + 3 * i, 3, found.data() + 3 * turning_of[i]);
    return found;
}

Loads impact_loads(const Scene& scene, const Links& links, const StateRows& rows,
                   const ImpactImpulses& given) {
    Tree<double> tree(*scene.model);
    tree.place(given.q);
    const std::vector<double> moments =
        moments_by_point(rows.points.size(), rows.turning_of, given.P + 3 * rows.points.size());
    OuterWrenches outside(tree, links,
                          scene.blows.size() + scene.held.size() + scene.contacts.size());
    for_wrenches<double>(scene, tree, rows.points,
                         {given.numbers, given.lambda, given.P, moments.data()},
                         [&](int entry, const Site& site, const Spatial<double>& wrench) {
                             outside.add(entry, site.body, site.frame, wrench);
                         });
    tree.move(given.dv);
    return find_loads(outside, tree.twist, false);
}

}  // namespace impulsekit
