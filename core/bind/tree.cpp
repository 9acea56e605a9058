// Trees of bodies, as Python calls them.
#include "spatial/tree.hpp"

#include "bind/arrays.hpp"
#include "spatial/articulated.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

constexpr int kInts = 4, kFloats = 28;

Model given_model(const Integers& ints, const Array& floats, const Array& armature, int nq) {
    const std::size_t count = ints.size() / kInts, nv = armature.size();
    const int* i = data_of(ints, count * kInts, "bodies");
    const double* f = data_of(floats, count * kFloats, "numbers");
    std::vector<GivenBody> bodies(count);
    for (std::size_t k = 0; k < count; ++k, i += kInts, f += kFloats) {
        GivenBody& body = bodies[k];
        body.parent = i[0];
        body.joint = i[1];
        body.q = i[2];
        body.v = i[3];
        if (body.parent < 0 || body.parent > static_cast<int>(k))
            throw nb::value_error("bodies: a parent comes before its child");
        if (body.joint < 0 || body.joint > static_cast<int>(Joint::ellipsoid))
            throw nb::value_error("bodies: unknown kind of joint");
        const Joint joint = static_cast<Joint>(body.joint);
        if (body.q < 0 || body.q + coordinates_of(joint) > nq || body.v < 0 ||
            body.v + freedoms_of(joint) > static_cast<int>(nv))
            throw nb::value_error("bodies: q or v is too short");
        std::copy(f, f + 3, body.axis);
        std::copy(f + 3, f + 12, body.rotation);
        std::copy(f + 12, f + 15, body.shift);
        body.mass = f[15];
        std::copy(f + 16, f + 19, body.moment);
        std::copy(f + 19, f + 25, body.inertia);
        body.pitch = f[25];
        body.ratio = f[26];
        body.offset = f[27];
    }
    return model_of(bodies, nq, static_cast<int>(nv), armature.data());
}

Tree<double> placed(const Model& model, const Array& q) {
    Tree<double> tree(model);
    tree.place(data_of(q, model.nq, "q"));
    return tree;
}

std::vector<double> placements(const Model& model, const Array& q) {
    const Tree<double> tree = placed(model, q);
    std::vector<double> found;
    for (int k = 0; k < tree.count(); ++k) {
        const Mat3<double> turn = mat3<double>(model.bodies[k].turn);
        const Vec3<double> rows[3] = {{turn.x.x, turn.y.x, turn.z.x},
                                      {turn.x.y, turn.y.y, turn.z.y},
                                      {turn.x.z, turn.y.z, turn.z.z}};
        // R turnᵀ, by columns; then by rows.
        const Mat3<double> r{tree.rotation[k] * rows[0], tree.rotation[k] * rows[1],
                             tree.rotation[k] * rows[2]};
        const Vec3<double> p = tree.world_place(tree.origin[k]);
        found.insert(found.end(), {r.x.x, r.y.x, r.z.x, r.x.y, r.y.y, r.z.y, r.x.z, r.y.z, r.z.z,
                                   p.x, p.y, p.z});
    }
    return found;
}

std::vector<double> jacobian(const Model& model, const Array& q) {
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

std::vector<double> mass_matrix(const Model& model, const Array& q) {
    Tree<double> tree = placed(model, q);
    std::vector<double> M(model.nv * model.nv);
    tree.weigh();
    tree.mass_matrix(M.data());
    return M;
}

std::vector<double> bias(const Model& model, const Array& q, const Array& v, const Array& gravity) {
    Tree<double> tree = placed(model, q);
    const double* speeds = data_of(v, model.nv, "v");
    std::vector<double> c(model.nv);
    tree.move(speeds);
    tree.bias(speeds, data_of(gravity, 3, "gravity"), c.data());
    return c;
}

// Entries of spatial vectors of all bodies but the world.
std::vector<double> entries_of(const std::vector<Spatial<double>>& all) {
    std::vector<double> found;
    found.reserve(6 * all.size());
    for (std::size_t k = 1; k < all.size(); ++k) {
        const Spatial<double>& x = all[k];
        found.insert(found.end(),
                     {x.linear.x, x.linear.y, x.linear.z, x.angular.x, x.angular.y, x.angular.z});
    }
    return found;
}

// Responses to impulses in joints (nv) and wrenches on some bodies, in the axes of their joints:
// Δv; of each body the twist after and the wrench that its parent gives it, in world axes.
nb::tuple apply_impulses(const Model& model, const Array& q, const Array& v, const Array& impulse,
                         const Integers& bodies, const Array& wrenches) {
    if (model.has_followers || model.has_ellipsoids)
        throw nb::value_error("joints that follow others, and ellipsoids, need the mass matrix");
    const std::size_t count = bodies.size(), nv = model.nv;
    const double* given = data_of(wrenches, 6 * count, "wrenches");
    const double *at = data_of(q, model.nq, "q"), *before = data_of(v, nv, "v");
    std::vector<char> struck(model.bodies.size(), 1);
    std::vector<double> dv(nv), after(before, before + nv), along(nv);
    std::vector<Spatial<double>> outside(model.bodies.size());
    for (std::size_t i = 0; i < count; ++i, given += 6) {
        const int k = bodies.data()[i];
        if (k < 1 || k >= static_cast<int>(model.bodies.size()))
            throw nb::value_error("bodies: expected numbers of bodies");
        const Mat3<double> turn = mat3<double>(model.bodies[k].turn);
        outside[k] += {back(turn, vec3<double>(given)), back(turn, vec3<double>(given + 3))};
    }
    {
        ArticulatedTree<double> articulated(model);
        articulated.place(at);
        articulated.factor();
        articulated.wrench = outside;
        articulated.respond(struck.data(), data_of(impulse, nv, "impulse"), dv.data());
    }
    Tree<double> tree = placed(model, q);
    tree.move(dv.data());
    for (int k = 1; k < tree.count(); ++k) {
        const Mat3<double>& r = tree.rotation[k];
        tree.wrench[k] = tree.in_world(k, inertia_of<double>(model.bodies[k])) * tree.twist[k] -
                         Spatial<double>{r * outside[k].linear, r * outside[k].angular};
    }
    tree.gather(along.data());
    const std::vector<double> reactions = entries_of(tree.wrench);
    for (std::size_t i = 0; i < nv; ++i) after[i] += dv[i];
    tree.move(after.data());
    return nb::make_tuple(array_of(dv), array_of(entries_of(tree.twist)), array_of(reactions));
}

}  // namespace
}  // namespace impulsekit

void bind_tree(nb::module_& module) {
    using namespace impulsekit;
    nb::class_<Model>(module, "Model", "A tree of rigid bodies with joints.")
        .def(
            "__init__",
            [](Model* self, const Integers& bodies, const Array& numbers, const Array& armature,
               int nq) { new (self) Model(given_model(bodies, numbers, armature, nq)); },
            nb::arg("bodies"), nb::arg("numbers"), nb::arg("armature"), nb::arg("nq"))
        .def_ro("nq", &Model::nq)
        .def_ro("nv", &Model::nv)
        .def_ro("has_followers", &Model::has_followers)
        .def_ro("has_ellipsoids", &Model::has_ellipsoids)
        .def_prop_ro("parents", [](const Model& m) { return m.parent_v; })
        .def(
            "placements", [](const Model& m, const Array& q) { return array_of(placements(m, q)); },
            nb::arg("q"), "(bodies + 1, 12) rotations, row by row, and origins in the world.")
        .def(
            "jacobian", [](const Model& m, const Array& q) { return array_of(jacobian(m, q)); },
            nb::arg("q"), "(6, nv) columns of the joints about the origin of the world.")
        .def(
            "mass_matrix",
            [](const Model& m, const Array& q) { return array_of(mass_matrix(m, q)); },
            nb::arg("q"), "(nv, nv) M.")
        .def(
            "bias",
            [](const Model& m, const Array& q, const Array& v, const Array& gravity) {
                return array_of(bias(m, q, v, gravity));
            },
            nb::arg("q"), nb::arg("v"), nb::arg("gravity"), "(nv) c(q, v).")
        .def("apply_impulses", &apply_impulses, nb::arg("q"), nb::arg("v"), nb::arg("impulse"),
             nb::arg("bodies"), nb::arg("wrenches"),
             "The jump of the velocities by impulses in joints and on bodies; twists after and "
             "reactions of all bodies, in world axes.");
}
