// Shapes of bodies, how far they are apart, and where they touch, for Python.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <optional>
#include <tuple>

#include "bind/fields.hpp"
#include "geometry/shapes.hpp"
#include "scene/contact_geometry.hpp"

namespace impulsekit {
namespace {

using Numbers = nb::ndarray<nb::numpy, double, nb::ndim<1>>;

// Twelve numbers: the rotation row by row, and the origin.
Placement placement_of(const Array& given) {
    const double* a = data_of(given, 12, "placement");
    return {mat3<double>(a), vec3<double>(a + 9)};
}

Vec3<double> three(const Array& given, const char* name) {
    return vec3<double>(data_of(given, 3, name));
}

Shape polytope_of(const Array& corners, const std::vector<std::vector<int>>& loops, double around,
                  const Array& at) {
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

Nearest nearest_of(const Shape& first, const Array& pa, const Shape& other, const Array& pb) {
    return nearest(first, placement_of(pa), other, placement_of(pb));
}

using Bodies = std::vector<Shape>;

std::vector<ContactPoint> contact_points_of(const Bodies& first, const Array& pa,
                                            const Bodies& other, const Array& pb, double margin) {
    std::vector<ContactPoint> found;
    contact_points(first, placement_of(pa), other, placement_of(pb), margin, found);
    return found;
}

std::pair<ContactPoint, double> follow_of(const Feature& feature, const Bodies& first,
                                          const Array& pa, const Bodies& other, const Array& pb) {
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
    nb::class_<Shape>(module, "Shape", "A convex piece of a body, in the axes of its joint.")
        .def_ro("reach", &Shape::reach)
        .def_ro("radius", &Shape::radius)
        .def_prop_ro("kind",
                     [](const Shape& shape) {
                         static const char* const kNames[] = {"ball",      "capsule", "polytope",
                                                              "cylinder",  "cone",    "ellipsoid",
                                                              "half-space"};
                         return kNames[shape.kind];
                     })
        .def("tip",
             [](const Shape& shape, int i) -> std::optional<Numbers> {
                 if (i < 0 || i >= static_cast<int>(shape.points.size())) return std::nullopt;
                 return numbers(shape.points[i]);
             })
        .def("face",
             [](const Shape& shape, int i) {
                 if (i < 0 || i >= static_cast<int>(shape.faces.size()))
                     throw nb::value_error("a face that is not there");
                 const Face& face = shape.faces[i];
                 return std::pair(numbers(face.normal), face.offset + shape.radius);
             })
        .def_prop_ro(
            "centre", [](const Shape& shape) { return numbers(shape.centre); },
            nb::rv_policy::move);
    module.def("ball_shape",
               [](double r, const Array& at) { return ball_shape(r, placement_of(at)); });
    module.def("capsule_shape", [](double r, double half, const Array& at) {
        return capsule_shape(r, half, placement_of(at));
    });
    module.def("cylinder_shape", [](double r, double half, double around, const Array& at) {
        return cylinder_shape(r, half, around, placement_of(at));
    });
    module.def("cone_shape", [](double r, double half, double around, const Array& at) {
        return cone_shape(r, half, around, placement_of(at));
    });
    module.def("box_shape", [](const Array& half, double around, const Array& at) {
        return box_shape(three(half, "half_sides"), around, placement_of(at));
    });
    module.def("ellipsoid_shape", [](const Array& axes, double around, const Array& at) {
        return ellipsoid_shape(three(axes, "semi_axes"), around, placement_of(at));
    });
    module.def("half_space_shape", [](const Array& normal, double offset, const Array& at) {
        return half_space_shape(three(normal, "normal"), offset, placement_of(at));
    });
    module.def("polytope_shape", &polytope_of);
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
    module.def("contact_axes", [](const Array& normal) {
        const Mat3<double> a = contact_axes(three(normal, "normal"));
        return array_of(
            std::vector<double>{a.x.x, a.y.x, a.z.x, a.x.y, a.y.y, a.z.y, a.x.z, a.y.z, a.z.z});
    });
    module.def("contact_points", &contact_points_of);
    module.def("follow", &follow_of);
}
