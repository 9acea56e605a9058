#include "contact/lzb_changes.hpp"

#include <algorithm>

#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Deflection that a tangential spring lacks to all its friction: it sticks up to there.
double friction_left(const LzbContact& c, const double* y, double depth) {
    return c.mu * depth - std::hypot(y[c.spring], y[c.spring + 1]);
}

double margin_of_tangents(const LzbState& state, const LzbContact& c, const double* y,
                          double depth) {
    if (!c.is_elastic()) {
        double least = c.slips() ? state.ahead(c) - c.from : 1.0;
        if (c.slip != Slipping::turning && state.slip(c) > tolerance::gain)
            least = std::min(least, tolerance::gain - state.slip(c));
        return least;
    }
    if (!c.slips()) {
        const double turn = c.kept < 1.0 ? (c.releases ? -1.0 : 1.0) * state.along(c) : 1.0;
        return std::min(friction_left(c, y, depth), turn);
    }
    const double deeper =
        c.slip == Slipping::turning ? depth - tolerance::shallow : tolerance::shallow - depth;
    const bool changes = (c.slip == Slipping::turning) == (state.un(c) > 0.0);
    return std::min(state.slip_of_spring(c), changes ? deeper : 1.0);
}

// The tangential spring of a contact that loads from zero on slips at once where it is deflected
// faster than friction grows.
void begin_spring(const LzbState& state, LzbContact& c, double* y) {
    if (c.spring < 0) return;
    y[c.spring] = y[c.spring + 1] = 0.0;
    c.releases = false;
    const bool slips = c.ratio * state.slip(c) > c.mu * std::abs(state.un(c));
    c.slip = slips ? Slipping::straight : Slipping::none;
    for (int k = 0; k < 2 && slips; ++k) c.last[k] = state.u[c.tangents + k] / state.slip(c);
}

// The spring of a contact that was held carries on from its friction.
void load_spring(const LzbState& state, LzbContact& c, double* y, double depth) {
    if (c.spring < 0) return;
    for (int k = 0; k < 2; ++k)
        y[c.spring + k] =
            c.slips() ? c.mu * depth * c.way[k] : -state.force[c.tangents + k] / c.stiffness;
    c.releases = false;
    if (c.slips()) c.slip = Slipping::turning;
}

void let_spring_go(LzbContact& c, double* y) {
    if (c.spring >= 0) y[c.spring] = y[c.spring + 1] = 0.0;
}

// The slip of tangential springs at the end of a step.
void change_spring(const LzbState& state, LzbContact& c, double* y, double depth) {
    if (c.slips() ? state.slip_of_spring(c) < -tolerance::solved
                  : friction_left(c, y, depth) < -tolerance::solved)
        c.slip = c.slips() ? Slipping::none : Slipping::turning;
    c.releases = c.kept < 1.0 && !c.slips() && state.along(c) < 0.0;
    std::copy(c.way, c.way + 2, c.last);
    if (!c.slips()) return;
    c.slip = depth <= tolerance::shallow ? Slipping::straight : Slipping::turning;
    // Rounding would part the spring from its friction.
    for (int k = 0; k < 2; ++k) y[c.spring + k] = c.mu * std::max(depth, 0.0) * c.way[k];
}

// The ways of slip at the end of a step; slip that has passed zero has ended.
void end_slips(LzbState& state, double* y) {
    state.rates(y, nullptr);
    for (std::size_t i = 0; i < state.contacts.size(); ++i) {
        LzbContact& c = state.contacts[i];
        if (!c.rubs()) continue;
        if (c.is_elastic()) {
            change_spring(state, c, y, state.depth(y, static_cast<int>(i)));
            continue;
        }
        const double speed = state.slip(c);
        const bool slipped = c.slips(),
                   remains = slipped && speed > tolerance::solved && state.ahead(c) > 0.0;
        c.slip = speed > tolerance::gain ? Slipping::turning
                 : remains               ? Slipping::straight
                                         : Slipping::none;
        for (int k = 0; k < 2 && c.slips(); ++k) c.last[k] = state.u[c.tangents + k] / speed;
        c.from = 0.0;
        c.slip_ended = slipped && !c.slips();
    }
}

// Bring what is left of velocities of all that sticks and is held to zero, by impulses of its own.
void remove_drift(LzbState& state, double* y) {
    state.rates(y, nullptr);
    const LzbState::Resting& rest = state.resting;
    const int m = rest.rows();
    double drift = 0.0;
    for (int i : rest.contact) {
        const LzbContact& c = state.contacts[i];
        if (c.holds()) drift = std::max(drift, std::abs(state.un(c)));
        if (!c.slips()) drift = std::max(drift, state.slip(c));
    }
    if (drift <= tolerance::solved) return;
    Arena::Scope scope(scratch());
    double *answer = scratch().allocate(m * m), *u = scratch().allocate(m);
    rest_slopes(rest.problem, state.resting.pressed.data(), answer);
    for (int r = 0; r < m; ++r) u[r] = state.row_of(r) < 0 ? 0.0 : state.u[state.row_of(r)];
    for (int r = 0; r < m; ++r)
        if (state.row_of(r) >= 0) y[state.row_of(r)] += dot(answer + r * m, u, m);
    state.rates(y, nullptr);
}

// A contact that is held by all its friction begins to slip, or may: against its friction.
void begin_slips(LzbState& state, const double* y) {
    state.rates(y, nullptr);
    const LzbState::Resting& rest = state.resting;
    const double most = largest(rest.b.data(), rest.rows());
    for (std::size_t a = 0; a < rest.contact.size(); ++a) {
        LzbContact& c = state.contacts[rest.contact[a]];
        const double *rate = rest.rate.data() + 3 * a, torn = std::hypot(rate[0], rate[1]);
        if (c.slips() || !c.rubs() || !(torn > tolerance::torn * most)) continue;
        c.slip = Slipping::straight;
        for (int k = 0; k < 2; ++k) c.last[k] = rate[k] / torn;
        c.from = std::min(0.0, state.ahead(c));
    }
}

// A held contact whose force rises is loaded again, from the force that it carries. The residue of
// u_n = 0 after the steps would end the loading at once.
void load_again(LzbState& state, double* y, int i) {
    LzbContact& c = state.contacts[i];
    const double F = state.force[c.normal_row];
    const int row = c.normal_row, rows = static_cast<int>(state.u.size());
    const double held[2] = {c.rubs() ? state.force[c.tangents] : 0.0,
                            c.rubs() ? state.force[c.tangents + 1] : 0.0};
    c.normal = Normal::open;
    state.depth(y, i) = c.stored = 0.0;
    state.rates(y, nullptr);
    // Friction that draws it in holds what would part by itself.
    if (state.rises(c) >= 0.0) return;
    c.normal = Normal::loads;
    const double depth = state.depth(y, i) = state.depth_of(c, F);
    c.stored = state.energy(c, depth);
    for (int k = 0; k < 2 && c.rubs(); ++k) state.force[c.tangents + k] = held[k];
    load_spring(state, c, y, depth);
    y[row] -= state.un(c) / state.W[row * (rows + 1)];
}

// Decide what contact i does along its normal at the end of a step.
void change_normal(LzbState& state, double* y, int i) {
    state.rates(y, nullptr);
    LzbContact& c = state.contacts[i];
    const double un = state.un(c);
    double& depth = state.depth(y, i);
    if (c.normal == Normal::open) {
        if (!(depth >= -tolerance::solved && un < -tolerance::at_rest)) return;
        c.normal = std::isinf(c.stiffness) ? Normal::held : Normal::loads;
        depth = c.stored = 0.0;
        begin_spring(state, c, y);
    } else if (c.holds()) {
        if (state.force[c.normal_row] <= tolerance::solved) {
            c.normal = Normal::open;
            depth = 0.0;
        } else if (state.rises_of_held(y)[i] > tolerance::solved) {
            load_again(state, y, i);
        }
    } else if (depth <= tolerance::solved && un > tolerance::solved) {
        c.normal = Normal::open;
        depth = -tolerance::tiny;
        let_spring_go(c, y);
    } else if (c.normal == Normal::loads && c.e2 < 1.0 &&
               (un > tolerance::solved ||
                (c.slip_ended && un > -tolerance::gain && state.rises(c) >= 0.0))) {
        // It has stopped, or friction that has ended its slip wedges it.
        c.slip_ended = false;
        c.normal = c.e2 > 0.0 ? Normal::unloads : Normal::held;
        if (c.holds()) let_spring_go(c, y);
    } else if (c.normal == Normal::unloads && un < -tolerance::solved) {
        c.normal = Normal::loads;
    }
}

}  // namespace

double margin_of_change(LzbState& state, const double* y) {
    const std::vector<double>& rise = state.rises_of_held(y);
    const int n = static_cast<int>(state.contacts.size());
    const int rows = static_cast<int>(state.u.size());
    double least = 1.0;
    for (int i = 0; i < n; ++i) {
        const LzbContact& c = state.contacts[i];
        const double un = state.un(c), depth = y[rows + i];
        if (c.normal == Normal::open) {
            if (un < -tolerance::at_rest) least = std::min(least, -depth);
            continue;
        }
        if (c.rubs()) least = std::min(least, margin_of_tangents(state, c, y, depth));
        if (c.holds()) {
            least = std::min({least, -rise[i], -un});
            continue;
        }
        if (un > 0.0) least = std::min(least, depth);
        if (c.normal == Normal::unloads)
            least = std::min(least, un);
        else if (c.e2 < 1.0 && depth > tolerance::solved)
            least = std::min(least, -un);
    }
    return least;
}

void begin_contacts(LzbState& state, double* y) {
    state.rates(y, nullptr);
    for (LzbContact& c : state.contacts) {
        c.normal = state.un(c) > tolerance::at_rest ? Normal::open
                   : std::isinf(c.stiffness)        ? Normal::held
                                                    : Normal::loads;
        if (c.springs()) begin_spring(state, c, y);
    }
    settle_contacts(state, y);
}

void settle_contacts(LzbState& state, double* y) {
    const int n = static_cast<int>(state.contacts.size());
    for (int i = 0; i < n; ++i) {
        LzbContact& c = state.contacts[i];
        if (!c.springs()) continue;
        const double stored = state.energy(c, state.depth(y, i));
        c.normal_work -= (stored - c.stored) / c.gives();
        c.stored = stored;
    }
    end_slips(state, y);
    remove_drift(state, y);
    // A contact that has come to be held may have to be let go at once.
    for (int k = 0; k < 2 * n; ++k) change_normal(state, y, k % n);
    begin_slips(state, y);
}

bool is_impact_over(const LzbState& state, bool& wedged) {
    bool presses = false, moves = false;
    const int rows = static_cast<int>(state.u.size());
    const double strongest = largest(state.force.data(), rows);
    for (const LzbContact& c : state.contacts) {
        const double un = state.un(c), f = state.force[c.normal_row];
        if (c.normal == Normal::open) {
            moves = moves || un < -tolerance::at_rest;
            continue;
        }
        const bool carries = f > tolerance::at_rest;
        presses = presses || carries;
        if (c.holds()) continue;
        moves = moves || un < -tolerance::at_rest || (carries && un > tolerance::at_rest) ||
                (carries && std::abs(state.rises(c)) > tolerance::at_rest * strongest);
    }
    if (!presses || moves) return !moves;
    for (int r = 0; r < rows; ++r)
        if (std::abs(dot(state.W.data() + r * rows, state.force.data(), rows)) >
            tolerance::at_rest * strongest)
            return false;
    for (const LzbContact& c : state.contacts)
        wedged =
            wedged || (c.springs() && c.e2 > 0.0 && state.force[c.normal_row] > tolerance::at_rest);
    return true;
}

}  // namespace impulsekit
