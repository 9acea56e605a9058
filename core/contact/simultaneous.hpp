// All contacts at once, friction by the slip at the end: Newton's and Poisson's restitution.
#pragma once

#include "contact/cone_solution.hpp"
#include "contact/problem.hpp"

namespace impulsekit {

// ξ = u⁺ + e min(u⁻, 0) along normals and u_t⁺ + e_t u_t⁻ along tangents obey the cones (Moreau
// 1988; Glocker 2001); or compression to ξ = u⁺, then expansion with P_n >= e P_n of the
// compression (Glocker & Pfeiffer 1995).
ContactSolution solve_simultaneous(const ContactProblem& problem, const Law& law);

// The cones of a problem, in scratch memory, with floors of zero.
template <typename S>
ConesOf<S> cones_of(const ContactProblemOf<S>& problem, Alike<S>& alike) {
    const int n = problem.contacts;
    ConesOf<S> cones(n, n + 2 * problem.turning, scratch());
    for (int i = 0; i < n; ++i) {
        const S pull = problem.adhesion ? problem.adhesion[i] : S{};
        cones.add_contact(3 * i + 2, pull > 0.0 ? S(-pull) : S{}, pull);
    }
    auto add = [&](int first, int size, int contact, const S& friction) {
        if (alike(friction > tolerance::negligible))
            cones.add_group(first, size, contact, friction);
    };
    for (int i = 0; i < n; ++i) add(3 * i, 2, i, problem.friction[i]);
    for (int k = 0; k < problem.turning; ++k) {
        add(3 * (n + k), 2, problem.turning_of[k], problem.rolling[k]);
        add(3 * (n + k) + 2, 1, problem.turning_of[k], problem.torsion[k]);
    }
    return cones;
}

// e min(u_n⁻, 0) and e_t u_t⁻: what Newton's law adds to u⁺ (r) [m/s].
template <typename S>
void add_newtons_shift(const ContactProblemOf<S>& problem, S* xi) {
    for (int i = 0; i < problem.contacts; ++i) {
        const S* u = problem.before + 3 * i;
        xi[3 * i + 2] += problem.restitution[i] * smaller(u[2], S{});
        for (int k = 0; k < 2; ++k) xi[3 * i + k] += problem.tangential[i] * u[k];
    }
}

// The size of u⁻ and u_free in the rows that the law uses [m/s].
template <typename S>
S velocity_scale(const ContactProblemOf<S>& problem, Alike<S>& alike) {
    S scale{};
    for (int i = 0; i < problem.contacts; ++i)
        for (int k = alike(problem.friction[i] > tolerance::negligible) ? 0 : 2; k < 3; ++k)
            scale = larger(larger(scale, magnitude(problem.before[3 * i + k])),
                           magnitude(problem.free[3 * i + k]));
    return scale;
}

inline Cones cones_of(const ContactProblem& problem) {
    Alike<double> alike;
    return cones_of(problem, alike);
}
inline double velocity_scale(const ContactProblem& problem) {
    Alike<double> alike;
    return velocity_scale(problem, alike);
}

// True if impulses raised the energy by more than rounding. Blows act in the same instant: a gain
// is one from the velocities before them and from those that they alone would leave.
template <typename S>
auto gains_energy(const S* impulse, const S* start, const S* free, int rows, const S& work,
                  const S& work_size) {
    S by_blows{}, size = work_size;
    for (int r = 0; r < rows; ++r) {
        by_blows += 0.5 * impulse[r] * (free[r] - start[r]);
        size += magnitude(impulse[r]) * (magnitude(start[r]) + magnitude(free[r]));
    }
    return smaller(work, S(work + by_blows)) > tolerance::gain * size;
}

// Add the work P·(u + u⁺)/2 of each contact.
template <typename S>
void add_works(const ContactProblemOf<S>& problem, const S* impulse, const S* start, const S* after,
               S* normal_work, S* friction_work) {
    const int n = problem.contacts;
    for (int i = 0; i < n + problem.turning; ++i) {
        S own[3];
        for (int k = 0; k < 3; ++k) {
            int r = 3 * i + k;
            own[k] = 0.5 * impulse[r] * (start[r] + after[r]);
        }
        // About the normal a moment acts, not the normal impulse.
        normal_work[i] += i < n ? own[2] : S{};
        friction_work[i] += own[0] + own[1] + (i < n ? S{} : own[2]);
    }
}

// The answer of all contacts at once, in arrays that were zero.
template <typename S>
struct SimultaneousOf {
    S *impulse, *after;              // (r)
    S *normal_work, *friction_work;  // (contacts + turning)
    S* shares;                       // (contacts) see solve_cones
    S residual{};
    int iterations = 0;
    bool has_none = false;  // no impulses obey
};

// The answer of all modes of few contacts that slips least, where Newton's method found none; true
// if it is proven that there is none.
bool try_all_modes(const ContactProblem& problem, const Law& law, double* xi, double scale,
                   const Cones& cones, double* P, ConeSolution& found);

// What restitution adds after a compression with P: where nothing is regained, nothing.
template <typename S>
void release(const ContactProblemOf<S>& problem, ConesOf<S>& cones, const S& scale,
             SimultaneousOf<S>& to, ConeSolutionOf<S>& found, Alike<S>& alike) {
    const int rows = problem.rows(), n = problem.contacts;
    S most{};
    for (int i = 0; i < n; ++i) {
        cones.floor[i] = problem.restitution[i] * to.impulse[3 * i + 2];
        most = larger(most, cones.floor[i]);
    }
    if (!alike(most > 0.0) || !alike(found.residual <= tolerance::residual)) return;
    S *middle = scratch().allocate_of<S>(rows), *release = scratch().allocate_of<S>(rows),
      *shares = scratch().allocate_of<S>(n);
    // Velocities that are rounding of what they are sums of are zero.
    for (int r = 0; r < rows; ++r)
        middle[r] = magnitude(to.after[r]) <= tolerance::sums * scale ? S{} : to.after[r];
    found = solve_cones(problem.W, rows, middle, scale, cones, release, shares, alike);
    multiply(problem.W, rows, release, middle, to.after);
    add_works(problem, release, middle, to.after, to.normal_work, to.friction_work);
    for (int r = 0; r < rows; ++r) to.impulse[r] += release[r];
    multiply(problem.W, rows, to.impulse, problem.free, to.after);
    for (int i = 0; i < n; ++i) to.shares[i] = larger(to.shares[i], shares[i]);
    to.residual = larger(to.residual, found.residual);
    to.iterations += found.steps;
}

template <typename S>
void solve_simultaneous(const ContactProblemOf<S>& problem, const Law& law, SimultaneousOf<S>& to,
                        Alike<S>& alike) {
    const int rows = problem.rows();
    const bool newton = law.restitution == Restitution::newton;
    ConesOf<S> cones = cones_of(problem, alike);
    const S scale = velocity_scale(problem, alike);
    S* xi = scratch().allocate_of<S>(rows);
    std::copy(problem.free, problem.free + rows, xi);
    if (newton) add_newtons_shift(problem, xi);
    ConeSolutionOf<S> found =
        solve_cones(problem.W, rows, xi, scale, cones, to.impulse, to.shares, alike);
    if constexpr (Number<S>::lanes == 1)
        to.has_none = newton && !found.infeasible && !(found.residual <= tolerance::residual) &&
                      try_all_modes(problem, law, xi, scale, cones, to.impulse, found);
    multiply(problem.W, rows, to.impulse, problem.free, to.after);
    add_works(problem, to.impulse, newton ? problem.before : problem.free, to.after, to.normal_work,
              to.friction_work);
    to.residual = found.residual;
    to.iterations = found.steps;
    if (!newton) release(problem, cones, scale, to, found, alike);
    to.has_none = to.has_none || found.immovable || found.infeasible;
}

// Where works P·(u + u⁺)/2 raised the energy.
template <typename S>
auto gains_energy(const ContactProblemOf<S>& problem, const Law& law, const SimultaneousOf<S>& of) {
    S work{}, size{};
    for (int i = 0; i < problem.contacts + problem.turning; ++i) {
        work += of.normal_work[i] + of.friction_work[i];
        size += magnitude(of.normal_work[i]) + magnitude(of.friction_work[i]);
    }
    const S* start = law.restitution == Restitution::newton ? problem.before : problem.free;
    return gains_energy(of.impulse, start, problem.free, problem.rows(), work, size);
}

}  // namespace impulsekit
