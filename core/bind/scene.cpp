// Scenes and their rows, as Python calls them.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <optional>

#include "bind/given_scene.hpp"
#include "scene/rows.hpp"

namespace nb = nanobind;

namespace impulsekit {

namespace {

void copy_numbers(const Array& from, std::size_t size, const char* name, double* to) {
    const double* data = data_of(from, size, name);
    std::copy(data, data + size, to);
}

}  // namespace

GivenState GivenArrays::state() const {
    GivenState given;
    given.function_rows = function_rows.data();
    given.function_contacts = function_contacts.data();
    given.only = only.empty() ? nullptr : only.data();
    given.features = features ? &*features : nullptr;
    return given;
}

void to_body(const Model& model, int body, const double* in, double* out) {
    const Vec3<double> own = back(mat3<double>(model.bodies[body].turn), vec3<double>(in));
    out[0] = own.x;
    out[1] = own.y;
    out[2] = own.z;
}

void check_body(const Model& model, int body) {
    if (body < 0 || body >= static_cast<int>(model.bodies.size()))
        throw nb::value_error("body: expected the number of a body");
}

Site site_of(const Model& model, const GivenSite& given) {
    Site site;
    site.body = given.first;
    check_body(model, site.body);
    const double* numbers = data_of(given.second, 12, "site");
    const Mat3<double> turn = mat3<double>(model.bodies[site.body].turn);
    const Mat3<double> axes = mat3<double>(numbers);
    const Vec3<double> x = back(turn, axes.x), y = back(turn, axes.y), z = back(turn, axes.z);
    const double rows[9] = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
    std::copy(rows, rows + 9, site.axes);
    to_body(model, site.body, numbers + 9, site.point);
    return site;
}

GivenArrays given_of(const std::optional<Array>& function_rows,
                     const std::optional<Array>& function_contacts,
                     const std::optional<std::vector<bool>>& only) {
    GivenArrays given;
    if (function_rows)
        given.function_rows.assign(function_rows->data(),
                                   function_rows->data() + function_rows->size());
    if (function_contacts)
        given.function_contacts.assign(function_contacts->data(),
                                       function_contacts->data() + function_contacts->size());
    if (only) given.only.assign(only->begin(), only->end());
    return given;
}

void check_given(const GivenScene& self, const GivenArrays& given) {
    if (given.function_rows.size() !=
            static_cast<std::size_t>(self.scene.function_rows) * self.model.nv ||
        given.function_contacts.size() !=
            static_cast<std::size_t>(self.scene.function_contacts) * (1 + 3 * self.model.nv) ||
        (!given.only.empty() && given.only.size() != self.scene.contacts.size()))
        throw nb::value_error("given: must have the scene's rows and contacts by functions");
    if (!given.features) return;
    for (const auto& [entry, feature] : *given.features) {
        if (entry < 0 || entry >= static_cast<int>(self.scene.contacts.size()))
            throw nb::value_error("features: expected numbers of the scene's contacts");
        const Contact& contact = self.scene.contacts[entry];
        if (contact.kind == Contact::shapes)
            if (!is_named(feature, contact.first, contact.other))
                throw nb::value_error("features: unknown feature of bodies");
    }
}

namespace {

using Terms = std::vector<std::tuple<int, int, double>>;

Pair pair_of(const Model& model, const GivenSite& first, const GivenSite& other, bool coincides,
             int carrier, const Array& axes) {
    if (carrier < 0 || carrier > 3) throw nb::value_error("carrier: must be 0 to 3");
    Pair pair;
    pair.first = site_of(model, first);
    pair.other = site_of(model, other);
    pair.coincides = coincides;
    pair.carrier = static_cast<Carrier>(carrier);
    copy_numbers(axes, 9, "axes", pair.axes);
    return pair;
}

Held& new_held(GivenScene& self, Held::Kind kind, int count) {
    self.check_unused();
    Held held;
    held.kind = kind;
    held.count = count;
    for (const Held& other : self.scene.held) held.row = other.row + other.count;
    self.scene.held.push_back(held);
    if (kind == Held::functions) self.scene.function_rows += count;
    return self.scene.held.back();
}

void add_pair(GivenScene& self, const GivenSite& first, const GivenSite& other, bool coincides,
              int carrier, const Array& axes, const std::vector<int>& select) {
    if (select.size() > 6) throw nb::value_error("select: six rows at most");
    for (int row : select)
        if (row < 0 || row > 5) throw nb::value_error("select: must be 0 to 5");
    const Pair pair = pair_of(self.model, first, other, coincides, carrier, axes);
    Held& held = new_held(self, Held::pair, static_cast<int>(select.size()));
    held.frames = pair;
    std::copy(select.begin(), select.end(), held.select);
}

void add_speed_rows(GivenScene& self, int count, const Terms& terms, int stop) {
    Held& held = new_held(self, Held::speeds, count);
    held.stop = stop;
    for (const auto& [row, v, factor] : terms) {
        if (row < 0 || row >= count || v < 0 || v >= self.model.nv)
            throw nb::value_error("terms: expected numbers of rows and degrees of freedom");
        held.terms.push_back({row, v, factor});
    }
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

Contact& new_contact(GivenScene& self, Contact::Kind kind) {
    self.check_unused();
    self.scene.contacts.emplace_back();
    self.scene.contacts.back().kind = kind;
    return self.scene.contacts.back();
}

void add_point_contact(GivenScene& self, const GivenSite& first, const GivenSite& plane,
                       int carrier, const Array& axes, bool turns) {
    const Pair pair = pair_of(self.model, first, plane, true, carrier, axes);
    Contact& contact = new_contact(self, Contact::point);
    contact.frames = pair;
    contact.turns = turns;
}

void add_rope(GivenScene& self, const GivenSite& first, const GivenSite& other, const Array& axes,
              double length) {
    const Pair pair =
        pair_of(self.model, first, other, false, static_cast<int>(Carrier::line), axes);
    Contact& contact = new_contact(self, Contact::rope);
    contact.frames = pair;
    contact.limit = length;
}

void add_stop(GivenScene& self, int q, int v, double lower, double upper) {
    if (q < 0 || q >= self.model.nq || v < 0 || v >= self.model.nv)
        throw nb::value_error("stop: expected numbers of a coordinate and its degree of freedom");
    Contact& contact = new_contact(self, Contact::stop);
    contact.q = q;
    contact.v = v;
    contact.lower = lower;
    contact.upper = upper;
}

void add_body_contact(GivenScene& self, const GivenSite& first, const GivenSite& other,
                      double margin, bool turns,
                      const std::optional<std::tuple<int, double, Array, double>>& ball,
                      std::vector<Shape> one, std::vector<Shape> two) {
    Pair pair;
    pair.first = site_of(self.model, first);
    pair.other = site_of(self.model, other);
    Contact& contact = new_contact(self, ball ? Contact::ball : Contact::shapes);
    contact.frames = pair;
    contact.limit = margin;
    contact.turns = turns;
    contact.first = std::move(one);
    contact.other = std::move(two);
    if (!ball) return;
    const auto& [kind, radius, size, sign] = *ball;
    if (kind < 0 || kind > 4) throw nb::value_error("ball: unknown kind of shape");
    contact.shape.kind = static_cast<Ball::Kind>(kind);
    contact.shape.radius = radius;
    copy_numbers(size, 3, "size", contact.shape.size);
    contact.shape.sign = sign;
}

void set_ellipse(GivenScene& self, int body, const Array& along) {
    self.check_unused();
    check_body(self.model, body);
    if (self.scene.contacts.empty()) throw nb::value_error("ellipse: there is no contact");
    Contact& contact = self.scene.contacts.back();
    contact.ellipse_body = body;
    to_body(self.model, body, data_of(along, 3, "along"), contact.along);
}

StateRows rows_of(const GivenScene& self, const Array& q, const Array& v,
                  const std::optional<nb::ndarray<const double, nb::f_contig>>& jacobian,
                  const GivenArrays& given) {
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
    check_given(self, given);
    const GivenState state = given.state();
    rows.fill(tree, at, speeds, &state);
    StateRows found;
    rows.extract(tree, 0, found);
    return found;
}

std::vector<double> of_points(const StateRows& rows, const double* (*part)(const StateRows::Point&),
                              int size) {
    std::vector<double> found;
    for (const StateRows::Point& p : rows.points)
        found.insert(found.end(), part(p), part(p) + size);
    return found;
}

void bind_state_rows(nb::module_& module) {
    using Point = StateRows::Point;
    nb::class_<StateRows>(module, "StateRows", "The rows of a scene at a state.")
        .def_prop_ro(
            "A", [](const StateRows& r) { return array_of(r.A); }, nb::rv_policy::move)
        .def_prop_ro(
            "target", [](const StateRows& r) { return array_of(r.target); }, nb::rv_policy::move)
        .def_prop_ro(
            "J", [](const StateRows& r) { return array_of(r.J); }, nb::rv_policy::move)
        .def_prop_ro(
            "wider", [](const StateRows& r) { return array_of(r.wider); }, nb::rv_policy::move)
        .def_ro("yielded", &StateRows::yielded)
        .def_prop_ro("turning_of", [](const StateRows& r) { return r.turning_of; })
        .def_prop_ro("entries",
                     [](const StateRows& r) {
                         std::vector<int> found;
                         for (const Point& p : r.points) found.push_back(p.entry);
                         return found;
                     })
        .def_prop_ro("of_bodies",
                     [](const StateRows& r) {
                         std::vector<bool> found;
                         for (const Point& p : r.points) found.push_back(p.of_bodies);
                         return found;
                     })
        .def_prop_ro(
            "axes",
            [](const StateRows& r) {
                return array_of(of_points(r, [](const Point& p) { return p.axes; }, 9));
            },
            nb::rv_policy::move)
        .def_prop_ro(
            "places",
            [](const StateRows& r) {
                return array_of(of_points(r, [](const Point& p) { return p.place; }, 3));
            },
            nb::rv_policy::move)
        .def_prop_ro(
            "gaps",
            [](const StateRows& r) {
                return array_of(of_points(r, [](const Point& p) { return &p.gap; }, 1));
            },
            nb::rv_policy::move)
        .def_prop_ro(
            "ellipses",
            [](const StateRows& r) {
                return array_of(of_points(r, [](const Point& p) { return p.ellipse; }, 2));
            },
            nb::rv_policy::move)
        .def_prop_ro(
            "features",
            [](const StateRows& r) {
                std::vector<Feature> found;
                for (const Point& p : r.points) found.push_back(p.feature);
                return found;
            },
            "The names of the points, of bodies of any shapes alone.")
        .def_ro("without_line", &StateRows::without_line)
        .def_ro("without_ellipse", &StateRows::without_ellipse);
}

}  // namespace
}  // namespace impulsekit

void bind_scene(nb::module_& module) {
    using namespace impulsekit;
    bind_state_rows(module);
    nb::class_<GivenScene>(module, "Scene", "The constraints and contacts of a robot.")
        .def(nb::init<const Model&>(), nb::arg("model"))
        .def("add_pair", &add_pair, nb::arg("first"), nb::arg("other"), nb::arg("coincides"),
             nb::arg("carrier"), nb::arg("axes"), nb::arg("select"))
        .def("add_speed_rows", &add_speed_rows, nb::arg("count"), nb::arg("terms"), nb::arg("stop"))
        .def(
            "add_function_rows",
            [](GivenScene& self, int count) { new_held(self, Held::functions, count); },
            nb::arg("count"))
        .def("set_rows", &set_rows, nb::arg("velocity"), nb::arg("kept"), nb::arg("vectors"),
             nb::arg("passive"), nb::arg("locks"))
        .def("add_point_contact", &add_point_contact, nb::arg("first"), nb::arg("plane"),
             nb::arg("carrier"), nb::arg("axes"), nb::arg("turns"))
        .def("add_rope", &add_rope, nb::arg("first"), nb::arg("other"), nb::arg("axes"),
             nb::arg("length"))
        .def("add_stop", &add_stop, nb::arg("q"), nb::arg("v"), nb::arg("lower"), nb::arg("upper"))
        .def("add_function_contact",
             [](GivenScene& self) {
                 new_contact(self, Contact::functions);
                 ++self.scene.function_contacts;
             })
        .def("add_body_contact", &add_body_contact, nb::arg("first"), nb::arg("other"),
             nb::arg("margin"), nb::arg("turns"), nb::arg("ball").none(), nb::arg("first_shapes"),
             nb::arg("other_shapes"))
        .def("set_ellipse", &set_ellipse, nb::arg("body"), nb::arg("along"))
        .def(
            "rows",
            [](const GivenScene& self, const Array& q, const Array& v,
               const std::optional<nb::ndarray<const double, nb::f_contig>>& jacobian,
               const std::optional<Array>& function_rows,
               const std::optional<Array>& function_contacts,
               const std::optional<std::vector<bool>>& only) {
                return rows_of(self, q, v, jacobian,
                               given_of(function_rows, function_contacts, only));
            },
            nb::arg("q"), nb::arg("v"), nb::arg("jacobian") = nb::none(),
            nb::arg("function_rows") = nb::none(), nb::arg("function_contacts") = nb::none(),
            nb::arg("only") = nb::none(),
            "The rows at a state. jacobian: of Pinocchio's joints, in place of the core's own.");
}
