// What ends a step of a motion.
#pragma once

namespace impulsekit {

// Something that may happen within a step: a function of the state that is positive until then, and
// falls below zero. `index`: of the gap, force with a kink, joint with dry friction or resting
// point.
struct EventFunction {
    enum Kind {
        gap_closes,         // of what does not rest: an impact, or it begins to count
        touches_elsewhere,  // of bodies that rest: where they do not
        force_enters,       // or leaves, its zone
        force_bends,        // its limit, or its damper's
        joint_stops,        // dry friction
        joint_starts,
        slip_stops,
        roll_stops,
        spin_stops,
        point_lifts,
        point_leaves,  // its face or edges
        point_tears,   // off what holds it: static friction, or a pull
    };
    Kind kind = gap_closes;
    int index = 0;

    bool is_of_gap() const { return kind == gap_closes || kind == touches_elsewhere; }
    bool is_of_point() const { return kind >= slip_stops; }
    // True if it needs accelerations at the state.
    bool needs_rates() const { return kind == joint_starts || kind == point_tears; }
};

// The first of them in a step, by what follows from it.
struct Event {
    enum Kind {
        none,
        closes,     // gaps close: an impact
        elsewhere,  // bodies that rest touch at other points: an impact
        changes,    // forces, slips and what rests change
        is_unsure,  // nothing is known of what follows: the step ends here
    };
    Kind kind = none;
    double t = 0.0;
    int gap = -1;
};

}  // namespace impulsekit
