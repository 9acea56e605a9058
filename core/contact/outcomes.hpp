// Outcomes of contacts that compress in any order and in any shares: Routh's process.
#pragma once

#include <cstdint>
#include <vector>

#include "contact/problem.hpp"

namespace impulsekit {

enum class OutcomeState : std::int8_t {
    ended = 0,         // no contact approaches
    gains_energy = 1,  // Poisson's restitution brought more than was lost
    not_ended = 2,     // friction jams a contact, or too many pieces
};

// Outcomes one after the other: samples, then the extreme of each direction.
struct Outcomes {
    std::vector<double> impulses;     // (count, r) P [N s]
    std::vector<double> works;        // (count) the energy that contacts add [J]
    std::vector<std::int8_t> states;  // (count) of OutcomeState
};

// While contacts approach, u_n < 0, their normal impulses grow in any shares, friction opposing the
// slip at every instant (Routh 1860; Halm & Posa 2019):
//     dP_n = λ ds, λ >= 0, Σ λ = 1, λ_i = 0 where u_n,i > 0;   du = W dP.
// The extreme shares are one contact at a time, and any others are limits of them that alternate.
// So an outcome is made of pieces, in each of which one contact is followed along its path until
// its approach has fallen by a fraction: an exact solution whatever the fractions are. Small
// fractions in turn are shares of a mixture, whole ones a sequence of impacts. Contacts that stick,
// or whose slip keeps its direction, are also pressed together, in constant shares.
// After the compression each contact receives e P_n of it more, in any shares (Poisson), and what
// then approaches is compressed without restitution (Glocker & Pfeiffer 1995).
//
// `directions` (K, r): outcomes with large d·P are looked for from the best sample on, by `tries`
// changes of its pieces. Sample k depends on `seed` and k alone.
Outcomes find_outcomes(const ContactProblem& problem, int samples, const double* directions, int K,
                       int tries, std::uint64_t seed, int threads);

}  // namespace impulsekit
