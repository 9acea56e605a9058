// Forces and torques between impacts, as Python gives them.
#pragma once

#include <memory>

#include "bind/given_scene.hpp"
#include "motion/dynamics.hpp"

namespace impulsekit {

struct GivenMotionScene {
    std::shared_ptr<MotionScene> scene = std::make_shared<MotionScene>();
    const GivenScene& given;

    GivenMotionScene(const GivenScene& own, const ContactLaw& law, const Array& gravity,
                     const std::vector<bool>& places, const std::vector<bool>& speeds);
};

// Refuse a state of other sizes than those of the scene.
void check_state(const MotionScene& scene, const Array& q, const Array& v);

}  // namespace impulsekit
