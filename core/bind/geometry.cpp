// Shapes of bodies, how far they are apart, and where they touch, for Python.
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include "bind/fields.hpp"
#include "geometry/shapes.hpp"
#include "scene/contact_geometry.hpp"

namespace impulsekit {
namespace {

using Numbers = nb::ndarray<nb::numpy, double, nb::ndim<1>>;

// A frame's rotation, row by row, and its origin.
struct Place {
    double rotation[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1}, origin[3] = {};
};

Placement placement_of(const Place& given) {
    return {mat3<double>(given.rotation), vec3<double>(given.origin)};
}

Vec3<double> three(const Array& given, const char* name) {
    return vec3<double>(data_of(given, 3, name));
}

Shape polytope_of(const Array& corners, const std::vector<std::vector<int>>& loops, double around,
                  const Place& at) {
    const double* a = data_of(corners, corners.size() / 3 * 3, "corners");
    std::vector<Vec3<double>> points;
    for (std::size_t i = 0; i < corners.size() / 3; ++i) points.push_back(vec3<double>(a + 3 * i));
    if (points.empty()) throw nb::value_error("corners: must be one or more");
    for (const auto& loop : loops) {
        if (loop.size() < 3) throw nb::value_error("a face has fewer than three corners");
        for (int i : loop)
            if (i < 0 || i >= static_cast<int>(points.size()))
                throw nb::value_error("a face has a corner that is not there");
    }
    return polytope_shape(points, loops, around, placement_of(at));
}

Nearest nearest_of(const Shape& first, const Place& pa, const Shape& other, const Place& pb) {
    return nearest(first, placement_of(pa), other, placement_of(pb));
}

using Bodies = std::vector<Shape>;

std::vector<ContactPoint> contact_points_of(const Bodies& first, const Place& pa,
                                            const Bodies& other, const Place& pb, double margin) {
    std::vector<ContactPoint> found;
    contact_points(first, placement_of(pa), other, placement_of(pb), margin, found);
    return found;
}

std::pair<ContactPoint, double> follow_of(const Feature& feature, const Bodies& first,
                                          const Place& pa, const Bodies& other, const Place& pb) {
    const int count[] = {static_cast<int>(first.size()), static_cast<int>(other.size())};
    for (int k = 0; k < 2; ++k)
        if (feature.piece[k] >= count[k]) throw nb::value_error("a piece that is not there");
    double inside = 0.0;
    const ContactPoint point =
        follow(feature, first, placement_of(pa), other, placement_of(pb), &inside);
    return {point, inside};
}

Numbers numbers(const Vec3<double>& a) { return array_of(std::vector<double>{a.x, a.y, a.z}); }

void bind_shapes(nb::module_& module) {
    Record<Place>(module, "Place", "A frame in another one.")
        .fields("rotation", &Place::rotation, "origin", &Place::origin);
    nb::class_<Shape>(module, "Shape", "A convex piece of a body, in the axes of its joint.")
        .def_ro("reach", &Shape::reach)
        .def_prop_ro(
            "centre", [](const Shape& shape) { return numbers(shape.centre); },
            nb::rv_policy::move);
    module.def(
        "ball_shape",
        [](double radius, const Place& at) { return ball_shape(radius, placement_of(at)); },
        nb::arg("radius"), nb::arg("at"));
    module.def(
        "capsule_shape",
        [](double radius, double half, const Place& at) {
            return capsule_shape(radius, half, placement_of(at));
        },
        nb::arg("radius"), nb::arg("half_length"), nb::arg("at"));
    const auto round = [&](const char* name,
                           Shape (*made)(double, double, double, const Placement&)) {
        module.def(
            name,
            [made](double radius, double half, double around, const Place& at) {
                return made(radius, half, around, placement_of(at));
            },
            nb::arg("radius"), nb::arg("half_length"), nb::arg("around"), nb::arg("at"));
    };
    round("cylinder_shape", &cylinder_shape);
    round("cone_shape", &cone_shape);
    module.def(
        "box_shape",
        [](const Array& half, double around, const Place& at) {
            return box_shape(three(half, "half_sides"), around, placement_of(at));
        },
        nb::arg("half_sides"), nb::arg("around"), nb::arg("at"));
    module.def(
        "ellipsoid_shape",
        [](const Array& axes, double around, const Place& at) {
            return ellipsoid_shape(three(axes, "semi_axes"), around, placement_of(at));
        },
        nb::arg("semi_axes"), nb::arg("around"), nb::arg("at"));
    module.def(
        "half_space_shape",
        [](const Array& normal, double offset, const Place& at) {
            return half_space_shape(three(normal, "normal"), offset, placement_of(at));
        },
        nb::arg("normal"), nb::arg("offset"), nb::arg("at"));
    module.def("polytope_shape", &polytope_of, nb::arg("corners"), nb::arg("loops"),
               nb::arg("around"), nb::arg("at"));
}

}  // namespace
}  // namespace impulsekit

void bind_geometry(nanobind::module_& module) {
    using namespace impulsekit;
    bind_shapes(module);
    const auto vector = [](auto member) {
        return [member](const auto& own) {
            const Vec3<double>& a = own.*member;
            return std::vector<double>{a.x, a.y, a.z};
        };
    };
    Result<Nearest>(module, "Nearest", "The nearest points of two bodies.")
        .part("gap", &Nearest::gap)
        .part("normal", vector(&Nearest::normal))
        .part("on_first", vector(&Nearest::on_first))
        .part("on_other", vector(&Nearest::on_other));
    module.def("nearest_points", &nearest_of, nb::arg("first"), nb::arg("first_place"),
               nb::arg("other"), nb::arg("other_place"));
    bind_enum<Feature::Kind>(module, "FeatureKind", "corner_on_face", Feature::corner_on_face,
                             "edges_cross", Feature::edges_cross, "tip_on_face",
                             Feature::tip_on_face, "spot_on_face", Feature::spot_on_face,
                             "nearest_points", Feature::nearest_points, "nearest_part",
                             Feature::nearest_part);
    Record<Feature>(module, "Feature", "The name of a point at which two bodies touch.")
        .fields("kind", &Feature::kind, "piece", &Feature::piece, "index", &Feature::index, "fixed",
                &Feature::fixed);
    Result<ContactPoint>(module, "ContactPoint", "A point at which two bodies touch.")
        .parts("feature", &ContactPoint::feature, "gap", &ContactPoint::gap)
        .part("point", vector(&ContactPoint::point))
        .part("normal", vector(&ContactPoint::normal));
    // (9) columns t₁, t₂, n, row by row.
    module.def(
        "contact_axes",
        [](const Array& normal) {
            const Mat3<double> a = contact_axes(three(normal, "normal"));
            return array_of(
                std::vector<double>{a.x.x, a.y.x, a.z.x, a.x.y, a.y.y, a.z.y, a.x.z, a.y.z, a.z.z});
        },
        nb::arg("normal"));
    module.def("contact_points", &contact_points_of, nb::arg("first"), nb::arg("first_place"),
               nb::arg("other"), nb::arg("other_place"), nb::arg("margin"));
    module.def("follow", &follow_of, nb::arg("feature"), nb::arg("first"), nb::arg("first_place"),
               nb::arg("other"), nb::arg("other_place"));
}
