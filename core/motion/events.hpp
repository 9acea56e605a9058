// Events that end a step of a motion.
#pragma once

#include "motion/motion.hpp"

namespace impulsekit {

// Something that may happen within a step: a function of the state that is positive until then, and
// falls below zero. `index`: of the gap, force with a kink, joint with dry friction or resting
// point.
struct EventFunction {
    enum Kind {
        none,
        unsure,             // nothing is known of what follows: the step ends here
        gap_closes,         // of what does not rest: an impact, or it begins to count
        force_enters,       // or leaves, its zone
        force_bends,        // its limit, or its damper's
        touches_elsewhere,  // of bodies that rest: an impact where they do not
        joint_stops,        // dry friction
        joint_starts,
        slip_stops,
        roll_stops,
        spin_stops,
        point_lifts,
        point_leaves,  // its face or edges
        point_tears,   // off what holds it: static friction, or a pull
    };
    Kind kind = none;
    int index = -1;

    // True if no zero of it may be missed: it is followed by bounds of how fast it falls.
    bool is_followed() const { return kind == gap_closes || kind == force_enters; }
    bool is_of_point() const { return kind >= slip_stops; }
    // True if it needs accelerations at the state.
    bool needs_rates() const { return kind == joint_starts || kind == point_tears; }
};

// The first of them in a step.
struct Event {
    EventFunction what;
    double t = 0.0;
};

// A gap at the tree's state, from what counts as closed; of passing contacts how deep they are.
GapState gap_here(Motion& motion, int i, Ahead* ahead = nullptr);

// The first event in a step; none where nothing happens.
Event first_event(Motion& motion, const Step& step);

}  // namespace impulsekit
