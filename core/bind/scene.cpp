// Scenes and their rows, as Python calls them.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>

#include <optional>

#include "bind/fields.hpp"
#include "bind/given_scene.hpp"
#include "bind/points.hpp"
#include "scene/joint_axes.hpp"
#include "scene/rows.hpp"

namespace nb = nanobind;

namespace impulsekit {

GivenState GivenInputs::state() const {
    GivenState given;
    given.function_rows = function_rows.data();
    given.function_contacts = function_contacts.data();
    given.only = only.empty() ? nullptr : only.data();
    given.features = features ? &*features : nullptr;
    return given;
}

void GivenInputs::check(const GivenScene& self) const {
    const Scene& scene = self.scene;
    const std::size_t nv = self.model.nv, contacts = scene.contacts.size();
    if (function_rows.size() != scene.function_rows * nv ||
        function_contacts.size() != scene.function_contacts * (1 + 3 * nv) ||
        (!only.empty() && only.size() != contacts))
        throw nb::value_error("given: must have the scene's rows and contacts by functions");
    if (!features) return;
    for (const auto& [entry, feature] : *features) {
        if (entry < 0 || entry >= static_cast<int>(contacts))
            throw nb::value_error("features: expected numbers of the scene's contacts");
        const Contact& contact = scene.contacts[entry];
        if (contact.kind == Contact::shapes && !is_named(feature, contact.first, contact.other))
            throw nb::value_error("features: unknown feature of bodies");
    }
}

void check_body(const Model& model, int body) {
    if (body < 0 || body >= static_cast<int>(model.bodies.size()))
        throw nb::value_error("body: expected the number of a body");
}

namespace {

Site site_of(const Model& model, const Site& given) {
    check_body(model, given.body);
    return in_body_axes(model, given);
}

Pair pair_of(const Model& model, const Pair& given) {
    Pair pair = given;
    pair.first = site_of(model, given.first);
    pair.other = site_of(model, given.other);
    return pair;
}

void add_held(GivenScene& self, Held held, const std::vector<int>& select) {
    self.check_unused();
    for (int row : select)
        if (row < 0 || row > 5) throw nb::value_error("select: must be 0 to 5");
    if (select.size() > 6) throw nb::value_error("select: six rows at most");
    std::copy(select.begin(), select.end(), held.select);
    if (held.kind == Held::pair) {
        held.count = static_cast<int>(select.size());
        held.frames = pair_of(self.model, held.frames);
    }
    for (const Held::Term& term : held.terms)
        if (term.row < 0 || term.row >= held.count || term.v < 0 || term.v >= self.model.nv)
            throw nb::value_error("terms: expected numbers of rows and degrees of freedom");
    if (held.kind == Held::functions) self.scene.function_rows += held.count;
    held.row = 0;
    for (const Held& other : self.scene.held) held.row = other.row + other.count;
    self.scene.held.push_back(std::move(held));
}

// Targets of the rows: velocities after, or that these stay; see ImpactProblem for the rest.
void set_rows(GivenScene& self, std::vector<double> velocity, const std::vector<bool>& kept,
              std::vector<int> vectors, const std::vector<bool>& passive, std::vector<int> locks) {
    self.check_unused();
    std::size_t rows = 0;
    for (const Held& held : self.scene.held) rows += held.count;
    if (velocity.size() != rows || kept.size() != rows || vectors.size() != rows ||
        passive.size() != rows || locks.size() != rows)
        throw nb::value_error("rows: must have one number for each row");
    for (int lock : locks)
        if (lock < -1 || lock >= self.model.nv)
            throw nb::value_error("locks: expected numbers of degrees of freedom, or -1");
    self.scene.velocity = std::move(velocity);
    self.scene.kept.assign(kept.begin(), kept.end());
    self.scene.vectors = std::move(vectors);
    self.scene.passive.assign(passive.begin(), passive.end());
    self.scene.locks = std::move(locks);
}

void add_contact(GivenScene& self, Contact contact) {
    self.check_unused();
    contact.frames = pair_of(self.model, contact.frames);
    if (contact.q < 0 || contact.v < 0 ||
        (contact.kind == Contact::stop &&
         (contact.q >= self.model.nq || contact.v >= self.model.nv)))
        throw nb::value_error("stop: expected numbers of a coordinate and its degree of freedom");
    if (contact.ellipse_body >= 0) {
        check_body(self.model, contact.ellipse_body);
        to_body(self.model, contact.ellipse_body, contact.along);
    }
    if (Contact::of_bodies(contact.kind) && (contact.first.empty() || contact.other.empty()))
        throw nb::value_error("a body without pieces");
    if (contact.kind == Contact::functions) ++self.scene.function_contacts;
    self.scene.contacts.push_back(std::move(contact));
}

void add_blow(GivenScene& self, Blow blow) {
    self.check_unused();
    blow.site = site_of(self.model, blow.site);
    self.scene.blows.push_back(blow);
}

void add_kick(GivenScene& self, int v) {
    self.check_unused();
    if (v < 0 || v >= self.model.nv)
        throw nb::value_error("v: expected the number of a degree of freedom, got another");
    self.scene.kicks.push_back(v);
}

void add_load(GivenScene& self, const Load& given) {
    self.check_unused();
    check_body(self.model, given.body);
    self.scene.loads.push_back(in_body_axes(self.model, given));
}

void vary_points(GivenScene& self, const std::vector<int>& contacts) {
    self.check_unused();
    for (int entry : contacts)
        if (entry < 0 || entry >= static_cast<int>(self.scene.contacts.size()))
            throw nb::value_error("points: expected numbers of the scene's contacts");
    self.scene.points = contacts;
}

StateRows rows_of(const GivenScene& self, const Array& q, const Array& v,
                  const std::optional<nb::ndarray<const double, nb::f_contig>>& jacobian,
                  const std::optional<GivenInputs>& inputs) {
    Tree<double> tree(self.model);
    const double *at = data_of(q, self.model.nq, "q"), *speeds = data_of(v, self.model.nv, "v");
    tree.place(at);
    if (jacobian) {
        const std::size_t slots = self.model.slots.size();
        if (jacobian->size() != 6 * slots) throw nb::value_error("jacobian: must be (6, nv)");
        for (std::size_t a = 0; a < slots; ++a) {
            const double* own = jacobian->data() + 6 * a;
            tree.column[a] = twist_at(Spatial<double>{vec3<double>(own), vec3<double>(own + 3)},
                                      tree.world_place(tree.origin[self.model.slots[a].body]));
        }
    }
    Rows<double> rows(self.scene);
    const GivenInputs given = inputs.value_or(GivenInputs());
    given.check(self);
    const GivenState state = given.state();
    rows.fill(tree, at, speeds, &state);
    StateRows found;
    rows.extract(tree, 0, found);
    return found;
}

void bind_state_rows(nb::module_& module) {
    Result<StateRows>(module, "StateRows", "The rows of a scene at a state.")
        .parts("A", &StateRows::A, "target", &StateRows::target, "J", &StateRows::J, "wider",
               &StateRows::wider, "yielded", &StateRows::yielded, "turning_of",
               &StateRows::turning_of)
        .part("entries", [](const StateRows& r) { return of_each(r.points, &Point::entry); })
        .part("of_bodies", [](const StateRows& r) { return of_each(r.points, &Point::of_bodies); })
        .part("features",
              [](const StateRows& r) {
                  std::vector<Feature> found;
                  for (const Point& p : r.points) found.push_back(p.feature[0]);
                  return found;
              })
        .part("axes", [](const StateRows& r) { return axes_of(r.points); })
        .part("places", [](const StateRows& r) { return places_of(r.points, r.origin); })
        .part("gaps", [](const StateRows& r) { return of_each(r.points, &Point::gap); })
        .part("ellipses",
              [](const StateRows& r) {
                  return numbers_of(r.points, 2, [](const Point& p, double* to) {
                      std::copy(p.ellipse, p.ellipse + 2, to);
                  });
              })
        .parts("without_line", &StateRows::without_line, "without_ellipse",
               &StateRows::without_ellipse);
}

// A point in the axes of a joint, and the axes of its frame there in Pinocchio's order.
Site made_site(int body, int frame, const Array& point,
               const nb::ndarray<const double, nb::f_contig>& axes) {
    Site site;
    site.body = body;
    site.frame = frame;
    const double* at = data_of(point, 3, "point");
    std::copy(at, at + 3, site.point);
    if (axes.ndim() != 2 || axes.shape(0) != 3 || axes.shape(1) != 3)
        throw nb::value_error("axes: must be (3, 3)");
    for (int i = 0; i < 9; ++i) site.axes[i] = axes.data()[i % 3 * 3 + i / 3];
    return site;
}

void bind_parts(nb::module_& module) {
    bind_enum<Carrier>(module, "Carrier", "world", Carrier::world, "first", Carrier::first, "other",
                       Carrier::other, "line", Carrier::line);
    bind_enum<Held::Kind>(module, "HeldKind", "pair", Held::pair, "speeds", Held::speeds,
                          "functions", Held::functions);
    bind_enum<Ball::Kind>(module, "BallAgainst", "ball", Ball::ball, "box", Ball::box, "cylinder",
                          Ball::cylinder, "capsule", Ball::capsule, "plane", Ball::plane);
    bind_enum<Contact::Kind>(module, "ContactKind", "point", Contact::point, "rope", Contact::rope,
                             "stop", Contact::stop, "functions", Contact::functions, "ball",
                             Contact::ball, "shapes", Contact::shapes);
    Record<Site>(module, "Site", "A point of a frame and the frame's axes, in those of a joint.")
        .fields("body", &Site::body, "frame", &Site::frame, "point", &Site::point, "axes",
                &Site::axes)
        .def_static("of", &made_site, nb::arg("body"), nb::arg("frame"), nb::arg("point"),
                    nb::arg("axes"));
    Record<Pair>(module, "Pair", "Two frames, and the axes of rows between them.")
        .fields("first", &Pair::first, "other", &Pair::other, "coincides", &Pair::coincides,
                "carrier", &Pair::carrier, "axes", &Pair::axes);
    Record<Held::Term>(module, "Term", "A degree of freedom in a row of speeds.")
        .fields("row", &Held::Term::row, "v", &Held::Term::v, "factor", &Held::Term::factor);
    Record<Held>(module, "Held", "Bilateral rows.")
        .fields("kind", &Held::kind, "count", &Held::count, "frames", &Held::frames, "terms",
                &Held::terms, "stop", &Held::stop);
    Record<Ball>(module, "Ball", "A ball, and what may touch it.")
        .fields("kind", &Ball::kind, "radius", &Ball::radius, "size", &Ball::size, "sign",
                &Ball::sign);
    Record<Contact>(module, "Contact", "A contact of a scene.")
        .fields("kind", &Contact::kind, "frames", &Contact::frames, "shape", &Contact::shape,
                "first", &Contact::first, "other", &Contact::other, "limit", &Contact::limit, "q",
                &Contact::q, "v", &Contact::v, "lower", &Contact::lower, "upper", &Contact::upper,
                "turns", &Contact::turns, "ellipse_body", &Contact::ellipse_body, "along",
                &Contact::along);
    Record<Blow>(module, "Blow", "A known impulse on a body.")
        .fields("site", &Blow::site, "is_local", &Blow::is_local);
    Record<Load>(module, "Load", "A link whose mass varies, in the axes of its joint.")
        .fields("body", &Load::body, "mass", &Load::mass, "moment", &Load::moment, "inertia",
                &Load::inertia);
    Record<GivenInputs>(module, "Inputs", "Inputs of a state beside q and v.")
        .array("function_rows", &GivenInputs::function_rows)
        .array("function_contacts", &GivenInputs::function_contacts)
        .field("features", &GivenInputs::features)
        .custom(
            "only", [](const GivenInputs& own) { return array_of(own.only); },
            [](GivenInputs& own, const std::vector<bool>& only) {
                own.only.assign(only.begin(), only.end());
            });
}

}  // namespace
}  // namespace impulsekit

void bind_scene(nb::module_& module) {
    using namespace impulsekit;
    bind_state_rows(module);
    bind_parts(module);
    nb::class_<GivenScene>(module, "Scene", "The constraints and contacts of a robot.")
        .def(nb::init<const Model&>(), nb::arg("model"))
        .def("add_held", &add_held, nb::arg("held"), nb::arg("select") = std::vector<int>())
        .def("set_rows", &set_rows, nb::arg("velocity"), nb::arg("kept"), nb::arg("vectors"),
             nb::arg("passive"), nb::arg("locks"))
        .def("add_contact", &add_contact, nb::arg("contact"))
        .def("add_blow", &add_blow, nb::arg("blow"))
        .def("add_kick", &add_kick, nb::arg("v"))
        .def("add_load", &add_load, nb::arg("load"))
        .def("vary_points", &vary_points, nb::arg("contacts"))
        .def("rows", &rows_of, nb::arg("q"), nb::arg("v"), nb::arg("jacobian") = nb::none(),
             nb::arg("inputs") = nb::none(),
             "The rows at a state. jacobian: of Pinocchio's joints, in place of the core's own.");
}
