// From the cones' problem in given units to its solution there: one state, or eight side by side
// in which all that acts sticks.
#pragma once

#include "contact/even_shares.hpp"

namespace impulsekit {

// P as it is on its cones: what parts, and what nothing presses, carries nothing.
template <typename S>
void clear_open(const ConeSystemOf<S>& s, S* P, Arena& arena) {
    Arena::Scope scope(arena);
    S* xi = arena.allocate_of<S>(s.rows);
    multiply(s.A, s.rows, P, s.b, xi);
    for (int c = 0; c < s.contacts; ++c) {
        S& own = P[s.normal[c]];
        own = own - xi[s.normal[c]] <= s.floor[c] ? s.floor[c] : own;
    }
    for (int k = 0; k < s.groups; ++k) {
        const auto is_pressed = radius_of(s, k, P, xi) > 0.0;
        for (int j = 0; j < s.size[k]; ++j) {
            S& own = P[s.first[k] + j];
            own = is_pressed ? own : S{};
        }
    }
}

// P in the units that were given; what is at its floor to the last digit.
template <typename S>
void write_back(const ConeSystemOf<S>& s, const ConesOf<S>& cones, const S* own, int rows, S* P) {
    std::fill(P, P + rows, S{});
    // An impulse of nothing has no sign.
    for (int i = 0; i < s.rows; ++i) P[s.source[i]] = own[i] * s.unit[i] * s.velocity + 0.0;
    for (int c = 0; c < s.contacts; ++c) {
        const int n = s.normal[c];
        S& to = P[s.source[n]];
        to = own[n] == s.floor[c] ? cones.floor[s.owner[c]] : to;
    }
}

// The same of one state where not all that acts sticks, and whether nothing obeys.
void solve_beyond_sticking(const ConeSystem& s, HeldRows& held, double* P, double* shares,
                           int& steps, Arena& arena);
bool is_infeasible(const double* W, int rows, const double* b, double scale, const Cones& cones,
                   Arena& arena);

// `solve_cones` of states that are `alike`, in which those stay for which P was found.
template <typename S>
ConeSolutionOf<S> solve_cones(const S* W, int rows, const S* b, const S& scale,
                              const ConesOf<S>& cones, S* P, S* shares, Alike<S>& alike) {
    Arena& arena = scratch();
    Arena::Scope scope(arena);
    const ConeSystemOf<S> s = build_system(W, rows, b, scale, cones, alike, arena);
    ConeSolutionOf<S> solution;
    S *own = arena.allocate_of<S>(s.rows), *shared = arena.allocate_of<S>(s.rows);
    HeldRowsOf<S> held(s, arena);
    const bool sticks = solve_from_sticking(s, held, own, solution.steps, alike, arena);
    if (sticks && held.is_redundant()) find_shares(s, own, held, shared, alike, arena);
    if constexpr (Number<S>::lanes == 1)
        if (!sticks) solve_beyond_sticking(s, held, own, shared, solution.steps, arena);
    clear_open(s, own, arena);
    solution.residual = residual_of(s, own, arena);
    solution.immovable = s.blocked;
    const bool is_found = alike.keep(solution.residual <= tolerance::residual);
    if constexpr (Number<S>::lanes == 1)
        solution.infeasible = !is_found && is_infeasible(W, rows, b, scale, cones, arena);
    else if (!sticks)
        alike.keep(typename Number<S>::Bits{});
    for (int c = 0; c < s.contacts && shares; ++c) {
        S& share = shares[s.owner[c]] = shared[s.normal[c]];
        for (int k = 0; k < s.groups; ++k)
            if (s.contact[k] == c)
                for (int j = 0; j < s.size[k]; ++j) share += shared[s.first[k] + j];
    }
    write_back(s, cones, own, rows, P);
    return solution;
}

}  // namespace impulsekit
