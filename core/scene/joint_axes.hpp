// Vectors given in the axes of joints, in those of their bodies, which may be others.
#pragma once

#include "scene/scene.hpp"

namespace impulsekit {

// A vector (3), in place.
void to_body(const Model& model, int body, double* vector);
Site in_body_axes(const Model& model, const Site& given);
Load in_body_axes(const Model& model, const Load& given);

}  // namespace impulsekit
