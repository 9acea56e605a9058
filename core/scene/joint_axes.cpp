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
    Site site = given;
    const Mat3<double> turn = mat3<double>(model.bodies[site.body].turn);
    const Mat3<double> axes = mat3<double>(given.axes);
    to_rows({back(turn, axes.x), back(turn, axes.y), back(turn, axes.z)}, site.axes);
    to_body(model, site.body, site.point);
    return site;
}

Load in_body_axes(const Model& model, const Load& given) {
    Load load = given;
    to_body(model, load.body, load.moment);
    turn_entries(transposed(mat3<double>(model.bodies[given.body].turn)), given.inertia,
                 load.inertia);
    return load;
}

}  // namespace impulsekit
