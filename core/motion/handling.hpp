// What follows of an event: impacts, contacts that let go, slip that stops.
#pragma once

#include "motion/events.hpp"

namespace impulsekit {

// Deal with the event that ends a step at y; false where the motion cannot go on.
bool handle_event(Motion& motion, const Event& event);

}  // namespace impulsekit
