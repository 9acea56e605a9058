// Shapes of bodies, how far they are apart, and where they touch, for Python.
#include <nanobind/stl/optional.h>
#include <nanobind/stl/pair.h>
#include <nanobind/stl/tuple.h>

#include <optional>
#include <tuple>

#include "bind/arrays.hpp"
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

void put(std::vector<double>& out, const Vec3<double>& a) {
    out.insert(out.end(), {a.x, a.y, a.z});
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

// Gap, normal and the points of both: 10 numbers.
Numbers nearest_of(const Shape& a, const Array& pa, const Shape& b, const Array& pb) {
    const Nearest found = nearest(a, placement_of(pa), b, placement_of(pb));
    std::vector<double> out{found.gap};
    put(out, found.normal);
    put(out, found.on_first);
    put(out, found.on_other);
    return array_of(out);
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

// Of kind, pieces and index, and the fixed point.
Feature feature_of(const std::vector<int>& whole, const std::vector<double>& fixed) {
    if (whole.size() != 7 || fixed.size() != 3 || whole[0] < 0 || whole[0] > Feature::nearest_part)
        throw nb::value_error("feature: expected seven whole numbers and three others");
    Feature f;
    f.kind = static_cast<Feature::Kind>(whole[0]);
    std::copy_n(whole.begin() + 1, 2, f.piece);
    std::copy_n(whole.begin() + 3, 4, f.index);
    std::copy_n(fixed.begin(), 3, f.fixed);
    return f;
}

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
    module.def("nearest_points", &nearest_of);
    nb::class_<Feature>(module, "Feature", "The name of a point at which two bodies touch.")
        .def_prop_ro("kind", [](const Feature& f) { return static_cast<int>(f.kind); })
        .def_prop_ro("pieces", [](const Feature& f) { return std::pair(f.piece[0], f.piece[1]); })
        .def_prop_ro("index",
                     [](const Feature& f) {
                         return std::tuple(f.index[0], f.index[1], f.index[2], f.index[3]);
                     })
        .def(
            "__init__",
            [](Feature* f, const std::vector<int>& whole, const std::vector<double>& fixed) {
                new (f) Feature(feature_of(whole, fixed));
            },
            nb::arg("whole"), nb::arg("fixed"))
        .def_prop_ro("whole",
                     [](const Feature& f) {
                         return std::vector<int>{f.kind,     f.piece[0], f.piece[1], f.index[0],
                                                 f.index[1], f.index[2], f.index[3]};
                     })
        .def_prop_ro("fixed",
                     [](const Feature& f) { return std::vector<double>(f.fixed, f.fixed + 3); })
        .def("__reduce__", [](const nb::object& f) {
            return nb::make_tuple(f.type(), nb::make_tuple(f.attr("whole"), f.attr("fixed")));
        });
    nb::class_<ContactPoint>(module, "ContactPoint", "A point at which two bodies touch.")
        .def_ro("feature", &ContactPoint::feature)
        .def_ro("gap", &ContactPoint::gap)
        .def_prop_ro(
            "point", [](const ContactPoint& p) { return numbers(p.point); }, nb::rv_policy::move)
        .def_prop_ro(
            "normal", [](const ContactPoint& p) { return numbers(p.normal); }, nb::rv_policy::move);
    // (9) columns t₁, t₂, n, row by row.
    module.def("contact_axes", [](const Array& normal) {
        const Mat3<double> a = contact_axes(three(normal, "normal"));
        return array_of(
            std::vector<double>{a.x.x, a.y.x, a.z.x, a.x.y, a.y.y, a.z.y, a.x.z, a.y.z, a.z.z});
    });
    module.def("contact_points", &contact_points_of);
    module.def("follow", &follow_of);
}
