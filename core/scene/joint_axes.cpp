#include "scene/joint_axes.hpp"

#include <algorithm>

#include "spatial/tree.hpp"

namespace impulsekit {

void to_body(const Model& model, int body, double* vector) {
    const Vec3<double> own = back(mat3<double>(model.bodies[body].turn), vec3<double>(vector));
    vector[0] = own.x;
    vector[1] = own.y;
    vector[2] = own.z;
}

Site in_body_axes(const Model& model, const Site& given) {
    Site site;
    site.body = given.body;
    const Mat3<double> turn = mat3<double>(model.bodies[site.body].turn);
    const Mat3<double> axes = mat3<double>(given.axes);
    const Vec3<double> x = back(turn, axes.x), y = back(turn, axes.y), z = back(turn, axes.z);
    const double rows[9] = {x.x, y.x, z.x, x.y, y.y, z.y, x.z, y.z, z.z};
    std::copy(rows, rows + 9, site.axes);
    std::copy(given.point, given.point + 3, site.point);
    to_body(model, site.body, site.point);
    return site;
}

Load in_body_axes(const Model& model, const Load& given) {
    const Mat3<double> turn = mat3<double>(model.bodies[given.body].turn);
    Load load = given;
    to_body(model, load.body, load.moment);
    const Mat3<double> to_own{{turn.x.x, turn.y.x, turn.z.x},
                              {turn.x.y, turn.y.y, turn.z.y},
                              {turn.x.z, turn.y.z, turn.z.z}};
    const double* from = given.inertia;
    const Sym3<double> i =
        turned(to_own, Sym3<double>{from[0], from[1], from[2], from[3], from[4], from[5]});
    const double entries[6] = {i.xx, i.xy, i.xz, i.yy, i.yz, i.zz};
    std::copy(entries, entries + 6, load.inertia);
    return load;
}

std::vector<Shape> in_body_axes(const Model& model, int body, std::vector<Shape> shapes) {
    const Mat3<double> turn = mat3<double>(model.bodies[body].turn);
    for (Shape& s : shapes) {
        for (auto* own : {&s.points, &s.face_axes, &s.edge_axes})
            for (Vec3<double>& x : *own) x = back(turn, x);
        for (Shape::Circle& circle : s.circles) circle.centre = back(turn, circle.centre);
        for (Face& face : s.faces) face.normal = back(turn, face.normal);
        for (Vec3<double>* x : {&s.axis, &s.across, &s.centre, &s.axes.x, &s.axes.y, &s.axes.z})
            *x = back(turn, *x);
    }
    return shapes;
}

}  // namespace impulsekit
