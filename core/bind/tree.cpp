// Trees of bodies, as Python calls them.
#include <nanobind/stl/pair.h>

#include <tuple>

#include "bind/fields.hpp"
#include "spatial/whole_tree.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// Number of a type of joint.
enum class Joint : int {};

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
        if (body.joint < 0 || body.joint >= static_cast<int>(joint_types().size()))
            throw nb::value_error("bodies: unknown kind of joint");
        const JointType& joint = joint_types()[body.joint];
        if (body.q < 0 || body.q + joint.coordinates() > nq || body.v < 0 ||
            body.v + joint.freedoms() > nv)
            throw nb::value_error("bodies: q or v is too short");
    }
    return model_of(bodies, nq, nv, armature.data());
}

AppliedImpulses apply(const Model& model, const Array& q, const Array& v, const Array& impulse,
                      const Integers& bodies, const Array& wrenches) {
    if (model.has_followers || model.has_ellipsoids)
        throw nb::value_error("joints that follow others, and ellipsoids, need the mass matrix");
    for (std::size_t i = 0; i < bodies.size(); ++i)
        if (bodies.data()[i] < 1 || bodies.data()[i] >= static_cast<int>(model.bodies.size()))
            throw nb::value_error("bodies: expected numbers of bodies");
    return apply_impulses(model, data_of(q, model.nq, "q"), data_of(v, model.nv, "v"),
                          {data_of(impulse, model.nv, "impulse"), bodies.data(),
                           data_of(wrenches, 6 * bodies.size(), "wrenches"), bodies.size()});
}

void bind_bodies(nb::module_& module) {
    nb::enum_<Joint> joint(module, "Joint", nb::is_arithmetic());
    for (std::size_t i = 0; i < joint_types().size(); ++i)
        joint.value(joint_types()[i].name, static_cast<Joint>(i));
    module.def(
        "joint_sizes",
        [] {
            std::vector<std::pair<int, int>> sizes;
            for (const JointType& type : joint_types())
                sizes.emplace_back(type.coordinates(), type.freedoms());
            return sizes;
        },
        "Return entries of q and of v of each type of joint.");
    Record<Bodies>(module, "Bodies", "Bodies by columns, in the axes of their joints.")
        .fields("parent", &Bodies::parent, "joint", &Bodies::joint, "q", &Bodies::q, "v",
                &Bodies::v, "axis", &Bodies::axis, "rotation", &Bodies::rotation, "shift",
                &Bodies::shift, "mass", &Bodies::mass, "moment", &Bodies::moment, "inertia",
                &Bodies::inertia, "pitch", &Bodies::pitch, "ratio", &Bodies::ratio, "offset",
                &Bodies::offset);
}

}  // namespace
}  // namespace impulsekit

void bind_tree(nb::module_& module) {
    using namespace impulsekit;
    bind_bodies(module);
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
            "placements",
            [](const Model& m, const Array& q) {
                return array_of(placements(m, data_of(q, m.nq, "q")));
            },
            nb::arg("q"), "(bodies + 1, 12) rotations, row by row, and origins in the world.")
        .def(
            "jacobian",
            [](const Model& m, const Array& q) {
                return array_of(jacobian(m, data_of(q, m.nq, "q")));
            },
            nb::arg("q"), "(6, nv) columns of the joints about the origin of the world.")
        .def(
            "mass_matrix",
            [](const Model& m, const Array& q) {
                return array_of(mass_matrix(m, data_of(q, m.nq, "q")));
            },
            nb::arg("q"), "(nv, nv) M.")
        .def(
            "bias",
            [](const Model& m, const Array& q, const Array& v, const Array& gravity) {
                return array_of(bias(m, data_of(q, m.nq, "q"), data_of(v, m.nv, "v"),
                                     data_of(gravity, 3, "gravity")));
            },
            nb::arg("q"), nb::arg("v"), nb::arg("gravity"), "(nv) c(q, v).")
        .def(
            "energies",
            [](const Model& m, const Array& q, const Array& v, const Array& gravity) {
                return array_of(energies(m, data_of(q, m.nq, "q"), data_of(v, m.nv, "v"),
                                         data_of(gravity, 3, "gravity")));
            },
            nb::arg("q"), nb::arg("v"), nb::arg("gravity"),
            "(8) kinetic energy, that of weight, and momenta about the world's origin.")
        .def("apply_impulses", &apply, nb::arg("q"), nb::arg("v"), nb::arg("impulse"),
             nb::arg("bodies"), nb::arg("wrenches"), "Apply impulses in joints and on bodies.");
}
