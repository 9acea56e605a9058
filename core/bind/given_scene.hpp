// A scene as Python holds it: filled entry by entry, then asked for its rows.
#pragma once

#include <nanobind/stl/pair.h>

#include <optional>
#include <tuple>
#include <utility>

#include "bind/arrays.hpp"
#include "impact/scene_impact.hpp"
#include "linalg/numbers.hpp"
#include "scene/scene.hpp"

namespace impulsekit {

// A body of the model, and rotation and point of a frame in the axes of its joint.
using GivenSite = std::pair<int, Array>;

struct GivenScene {
    Model model;
    Scene scene;
    mutable int batches = 0;  // that run now, without Python's lock; counted with it

    // Refuse to change what a batch reads.
    void check_unused() const {
        if (batches > 0) throw nb::value_error("scene: a batch that runs now reads it");
    }

    explicit GivenScene(const Model& own) : model(own) { scene.model = &model; }
    GivenScene(const GivenScene&) = delete;
    GivenScene& operator=(const GivenScene&) = delete;
};

// Values of functions and geometry for a state, beside q and v.
struct GivenArrays {
    std::vector<double> function_rows, function_contacts;
    std::vector<char> only;
    std::optional<std::vector<std::pair<int, Feature>>> features;

    GivenState state() const;
};

GivenArrays given_of(const std::optional<Array>& function_rows,
                     const std::optional<Array>& function_contacts,
                     const std::optional<std::vector<bool>>& only);
// Refuse arrays that are not of the scene's size.
void check_given(const GivenScene& self, const GivenArrays& given);
// Refuse a law or an impact of another scene.
void check_impact(const GivenScene& self, const ContactLaw& law, const SceneImpact& impact);

void check_body(const Model& model, int body);
// A direction in the axes of a joint, in those of its body.
void to_body(const Model& model, int body, const double* in, double* out);
Site site_of(const Model& model, const GivenSite& given);

}  // namespace impulsekit
