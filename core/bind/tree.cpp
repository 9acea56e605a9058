// Trees of bodies, as Python calls them.
#include "spatial/tree.hpp"

#include <tuple>

#include "bind/fields.hpp"
#include "spatial/articulated.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// Bodies by columns, a row for each, in the axes of their joints; see GivenBody.
struct Bodies {
    Integers parent, joint, q, v;
    Array axis, rotation, shift, mass, moment, inertia, pitch, ratio, offset;

    std::size_t count() const { return parent.size(); }
    // Check the columns' sizes.
    void check() const {
        for (const auto& [column, name] : {std::pair{&joint, "joint"}, {&q, "q"}, {&v, "v"}})
            data_of(*column, count(), name);
        const std::tuple<const Array*, std::size_t, const char*> columns[] = {
            {&axis, 3, "axis"},   {&rotation, 9, "rotation"}, {&shift, 3, "shift"},
            {&mass, 1, "mass"},   {&moment, 3, "moment"},     {&inertia, 6, "inertia"},
            {&pitch, 1, "pitch"}, {&ratio, 1, "ratio"},       {&offset, 1, "offset"}};
        for (const auto& [column, width, name] : columns) data_of(*column, width * count(), name);
    }
    GivenBody body(std::size_t k) const {
        GivenBody body;
        body.parent = parent.data()[k];
        body.joint = joint.data()[k];
        body.q = q.data()[k];
        body.v = v.data()[k];
        std::copy_n(axis.data() + 3 * k, 3, body.axis);
        std::copy_n(rotation.data() + 9 * k, 9, body.rotation);
        std::copy_n(shift.data() + 3 * k, 3, body.shift);
        body.mass = mass.data()[k];
        std::copy_n(moment.data() + 3 * k, 3, body.moment);
        std::copy_n(inertia.data() + 6 * k, 6, body.inertia);
        body.pitch = pitch.data()[k];
        body.ratio = ratio.data()[k];
        body.offset = offset.data()[k];
        return body;
    }
};

Model given_model(const Bodies& given, const Array& armature, int nq) {
    given.check();
    const int nv = static_cast<int>(armature.size());
    std::vector<GivenBody> bodies(given.count());
    for (std::size_t k = 0; k < bodies.size(); ++k) {
        const GivenBody body = bodies[k] = given.body(k);
        if (body.parent < 0 || body.parent > static_cast<int>(k))
            throw nb::value_error("bodies: a parent comes before its child");
        if (body.joint < 0 || body.joint > static_cast<int>(Joint::ellipsoid))
            throw nb::value_error("bodies: unknown kind of joint");
        const Joint joint = static_cast<Joint>(body.joint);
        if (body.q < 0 || body.q + coordinates_of(joint) > nq || body.v < 0 ||
            body.v + freedoms_of(joint) > nv)
            throw nb::value_error("bodies: q or v is too short");
    }
    return model_of(bodies, nq, nv, armature.data());
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

// Of impulses in joints and on bodies: Δv; of each body but the world the twist after and the
// wrench that its parent gives it, in world axes.
struct AppliedImpulses {
    std::vector<double> dv, twists, reactions;
};

// `impulse`: in joints (nv); wrenches on some bodies in the axes of their joints.
AppliedImpulses apply_impulses(const Model& model, const Array& q, const Array& v,
                               const Array& impulse, const Integers& bodies,
                               const Array& wrenches) {
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
    return {dv, entries_of(tree.twist), reactions};
}

}  // namespace
}  // namespace impulsekit

void bind_tree(nb::module_& module) {
    using namespace impulsekit;
    bind_enum<Joint>(module, "Joint", "angle", Joint::angle, "circle", Joint::circle, "slide",
                     Joint::slide, "helix", Joint::helix, "ball", Joint::ball, "free", Joint::free,
                     "planar", Joint::planar, "translation", Joint::translation, "ellipsoid",
                     Joint::ellipsoid);
    Record<Bodies>(module, "Bodies", "Bodies by columns, in the axes of their joints.")
        .fields("parent", &Bodies::parent, "joint", &Bodies::joint, "q", &Bodies::q, "v",
                &Bodies::v, "axis", &Bodies::axis, "rotation", &Bodies::rotation, "shift",
                &Bodies::shift, "mass", &Bodies::mass, "moment", &Bodies::moment, "inertia",
                &Bodies::inertia, "pitch", &Bodies::pitch, "ratio", &Bodies::ratio, "offset",
                &Bodies::offset);
    using A = AppliedImpulses;
    Result<A>(module, "AppliedImpulses", "What impulses in joints and on bodies do.")
        .parts("dv", &A::dv, "twists", &A::twists, "reactions", &A::reactions);
    nb::class_<Model>(module, "Model", "A tree of rigid bodies with joints.")
        .def(
            "__init__",
            [](Model* self, const Bodies& bodies, const Array& armature, int nq) {
                new (self) Model(given_model(bodies, armature, nq));
            },
            nb::arg("bodies"), nb::arg("armature"), nb::arg("nq"))
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
             nb::arg("bodies"), nb::arg("wrenches"), "Apply impulses in joints and on bodies.");
}
