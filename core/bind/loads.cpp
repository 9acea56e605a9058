// Links of a robot and their loads, as Python calls them.
#include "impact/loads.hpp"

#include <utility>

#include "bind/fields.hpp"
#include "bind/given_scene.hpp"
#include "scene/joint_axes.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// Links and rigid parts, given in the axes of joints; parts by numbers, −1 for none.
Links links_of(const Model& model, const std::vector<Link>& links, std::vector<RigidPart> parts,
               std::vector<int> part_of_frame, std::vector<int> part_of_joint) {
    const auto check = [](int part, std::size_t count) {
        if (part < -1 || part >= static_cast<int>(count))
            throw nb::value_error("parts: expected their numbers, or -1");
    };
    for (std::size_t i = 0; i < parts.size(); ++i) {
        check_body(model, parts[i].body);
        check(parts[i].holder, i);
        to_body(model, parts[i].body, parts[i].origin);
        to_body(model, parts[i].body, parts[i].middle);
    }
    Links found{{}, std::move(parts), std::move(part_of_frame), std::move(part_of_joint)};
    for (Link link : links) {
        check_body(model, link.body);
        check(link.part, found.parts.size());
        to_body(model, link.body, link.centre);
        static_cast<Load&>(link) = in_body_axes(model, link);
        found.links.push_back(link);
    }
    for (const std::vector<int>* list : {&found.part_of_frame, &found.part_of_joint})
        for (int part : *list) check(part, found.parts.size());
    return found;
}

Loads loads_of(const GivenScene& self, const Links& links, const Array& q, const Array& dv,
               const Array& numbers, const StateRows* rows, const Array& multipliers,
               const Array& impulses) {
    const Scene& scene = self.scene;
    const StateRows none;
    const StateRows& at = rows ? *rows : none;
    return impact_loads(
        scene, links, at,
        {data_of(q, self.model.nq, "q"), data_of(dv, self.model.nv, "dv"),
         data_of(numbers, 6 * scene.blows.size() + scene.kicks.size(), "numbers"),
         data_of(multipliers, scene.rows(), "multipliers"),
         data_of(impulses, 3 * (at.points.size() + at.turning_of.size()), "impulses")});
}

}  // namespace
}  // namespace impulsekit

void bind_loads(nb::module_& module) {
    using namespace impulsekit;
    Record<Link>(module, "Link", "A link: its mass about its centre, in the axes of its joint.")
        .fields("body", &Link::body, "part", &Link::part, "mass", &Link::mass, "centre",
                &Link::centre, "inertia", &Link::inertia);
    using P = RigidPart;
    Record<P>(module, "RigidPart", "What a fixed joint or a base carries, in a joint's axes.")
        .fields("body", &P::body, "holder", &P::holder, "origin", &P::origin, "middle", &P::middle);
    nb::class_<Links>(module, "Links", "Links of a robot, and what fixed joints carry.")
        .def(
            "__init__",
            [](Links* self, const Model& model, const std::vector<Link>& links,
               const std::vector<RigidPart>& parts, const std::vector<int>& part_of_frame,
               const std::vector<int>& part_of_joint) {
                new (self) Links(links_of(model, links, parts, part_of_frame, part_of_joint));
            },
            nb::arg("model"), nb::arg("links"), nb::arg("parts"), nb::arg("part_of_frame"),
            nb::arg("part_of_joint"));
    Result<Loads>(module, "Loads", "What joints, rigid parts, entries and links take.")
        .parts("joints", &Loads::joints, "parts", &Loads::parts, "entries", &Loads::entries,
               "links", &Loads::links, "base", &Loads::base);
    module.def("impact_loads", &loads_of, nb::arg("scene"), nb::arg("links"), nb::arg("q"),
               nb::arg("dv"), nb::arg("numbers"), nb::arg("rows").none(), nb::arg("multipliers"),
               nb::arg("impulses"), "Return the loads of an impact of a scene.");
}
