// A scene as Python holds it: filled entry by entry, then asked for its rows.
#pragma once

#include <nanobind/stl/pair.h>

#include <optional>
#include <utility>

#include "bind/arrays.hpp"
#include "impact/scene_impact.hpp"
#include "linalg/numbers.hpp"
#include "scene/scene.hpp"

namespace impulsekit {

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

// Inputs of a state beside q and v, see GivenState; those of a scene that needs none stay empty.
struct GivenInputs {
    std::vector<double> function_rows, function_contacts;
    std::vector<char> only;
    std::optional<std::vector<std::pair<int, Feature>>> features;

    GivenState state() const;
    // Refuse what is not of the scene's size.
    void check(const GivenScene& self) const;
};

// Refuse a law or an impact of another scene.
void check_impact(const GivenScene& self, const ContactLaw& law, const SceneImpact& impact);

void check_body(const Model& model, int body);

}  // namespace impulsekit
