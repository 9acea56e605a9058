// A scene as Python holds it: filled entry by entry, then asked for its rows.
#pragma once

#include "bind/arrays.hpp"
#include "scene.hpp"

namespace impulsekit {

struct GivenScene {
    Model model;
    Scene scene;

    explicit GivenScene(const Model& own) : model(own) { scene.model = &model; }
    GivenScene(const GivenScene&) = delete;
    GivenScene& operator=(const GivenScene&) = delete;
};

// What functions and geometry give for a state beside q and v.
struct GivenArrays {
    std::vector<Meeting> meetings;
    std::vector<double> function_rows, function_contacts;
    std::vector<char> only;

    GivenState state() const;
};

}  // namespace impulsekit
