#include "spatial/whole_tree.hpp"

#include "spatial/articulated.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {
namespace {

Tree<double> placed(const Model& model, const double* q) {
    Tree<double> tree(model);
    tree.place(q);
    return tree;
}

// Entries of spatial vectors of all bodies but the world.
std::vector<double> entries_of(const std::vector<Spatial<double>>& all) {
    std::vector<double> found;
    found.reserve(6 * all.size());
    for (std::size_t k = 1; k < all.size(); ++k) append(found, all[k]);
    return found;
}

}  // namespace

std::vector<double> placements(const Model& model, const double* q) {
    const Tree<double> tree = placed(model, q);
    std::vector<double> found;
    for (int k = 0; k < tree.count(); ++k) {
        const Mat3<double> r = tree.rotation[k] * transposed(mat3<double>(model.bodies[k].turn));
        const Vec3<double> p = tree.world_place(tree.origin[k]);
        found.insert(found.end(), {r.x.x, r.y.x, r.z.x, r.x.y, r.y.y, r.z.y, r.x.z, r.y.z, r.z.z,
                                   p.x, p.y, p.z});
    }
    return found;
}

std::vector<double> jacobian(const Model& model, const double* q) {
    const Tree<double> tree = placed(model, q);
    std::vector<double> found(6 * model.nv, 0.0);
    for (std::size_t a = 0; a < model.slots.size(); ++a) {
        const Slot& slot = model.slots[a];
        const Spatial<double> own =
            twist_at(tree.column[a], -tree.world_place(tree.origin[slot.body]));
        const double entries[6] = {own.linear.x,  own.linear.y,  own.linear.z,
                                   own.angular.x, own.angular.y, own.angular.z};
        for (int i = 0; i < 6; ++i) found[i * model.nv + slot.v] += entries[i];
    }
    return found;
}

std::vector<double> mass_matrix(const Model& model, const double* q) {
    Tree<double> tree = placed(model, q);
    std::vector<double> M(model.nv * model.nv);
    tree.weigh();
    tree.mass_matrix(M.data());
    return M;
}

std::vector<double> bias(const Model& model, const double* q, const double* v,
                         const double* gravity) {
    Tree<double> tree = placed(model, q);
    std::vector<double> c(model.nv);
    tree.move(v);
    tree.bias(v, gravity, c.data());
    return c;
}

std::vector<double> energies(const Model& model, const double* q, const double* v,
                             const double* gravity) {
    Tree<double> tree = placed(model, q);
    tree.move(v);
    double kinetic = 0.0, potential = 0.0;
    for (const Slot& slot : model.slots) kinetic += 0.5 * slot.armature * v[slot.v] * v[slot.v];
    Spatial<double> momentum;
    for (int k = 1; k < tree.count(); ++k) {
        const Inertia<double> own = tree.in_world(k, inertia_of<double>(model.bodies[k]));
        const Spatial<double> moved = own * tree.twist[k];
        const Vec3<double> place = tree.world_place(tree.origin[k]);
        kinetic += 0.5 * dot(tree.twist[k], moved);
        potential -= dot(vec3<double>(gravity), place * own.mass + own.moment);
        momentum += wrench_about(moved, place);
    }
    std::vector<double> found{kinetic, potential};
    append(found, momentum);
    return found;
}

AppliedImpulses apply_impulses(const Model& model, const double* q, const double* v,
                               const TreeImpulses& given) {
    const std::size_t nv = model.nv;
    std::vector<char> struck(model.bodies.size(), 1);
    std::vector<double> dv(nv), after(v, v + nv), along(nv);
    std::vector<Spatial<double>> outside(model.bodies.size());
    for (std::size_t i = 0; i < given.count; ++i) {
        const double* wrench = given.wrenches + 6 * i;
        const Mat3<double> turn = mat3<double>(model.bodies[given.bodies[i]].turn);
        outside[given.bodies[i]] +=
            {back(turn, vec3<double>(wrench)), back(turn, vec3<double>(wrench + 3))};
    }
    {
        ArticulatedTree<double> articulated(model);
        articulated.place(q);
        articulated.factor();
        articulated.wrench = outside;
        articulated.respond(struck.data(), given.impulse, dv.data());
    }
    Tree<double> tree = placed(model, q);
    for (int k = 1; k < tree.count(); ++k)
        tree.wrench[k] = {tree.rotation[k] * outside[k].linear,
                          tree.rotation[k] * outside[k].angular};
    tree.move(dv.data());
    tree.load(tree.twist, [&](int k) { return inertia_of<double>(model.bodies[k]); }, false);
    tree.gather(along.data());
    const std::vector<double> reactions = entries_of(tree.wrench);
    for (std::size_t i = 0; i < nv; ++i) after[i] += dv[i];
    tree.move(after.data());
    return {dv, entries_of(tree.twist), reactions};
}

}  // namespace impulsekit
