// Uniqueness of the velocities that obey the law, where that can be known.
#pragma once

#include <vector>

#include "contact/problem.hpp"

namespace impulsekit {

enum class Verdict {
    smooth,        // proven: nothing rubs, the problem is convex
    weak,          // proven: friction feeds back weakly on normal impulses
    all_tried,     // proven but for others found: every mode of one contact, or in a plane
    searched,      // not proven: Newton's method was started from every mode
    not_searched,  // not proven: too many contacts
};

struct Uniqueness {
    Verdict verdict = Verdict::not_searched;
    std::vector<std::vector<double>> impulses;  // P of others, each with other velocities
    std::vector<double> works;                  // the energy that each of them adds [J]
    bool gains = false;                         // others were found that gain energy
};

// Beside the answer `impulse`, of contacts at once with slip at the end, each one µ. Poisson's
// law: beside the compression that it contains.
//
// Proof by weak friction. Let P and P' obey, Δ their difference. Normals are monotone,
// Δ_nᵀ Δξ_n <= 0, and friction gives Δ_tᵀ Δξ_t <= µ |Δ_n|·|Δξ_t| (two points of maximal dissipation
// on discs whose radii differ by µ |Δ_n|). With Δξ = W Δ: ΔᵀWΔ <= Σ µ |Δ_n||Δξ_t| <= µ
// |Δ_n||W^½||y|, y = W^½ Δ. As |Δ_n|² <= |(W⁻¹)_nn| |y|², |y|² <= µ (|W| |(W⁻¹)_nn|)^½ |y|²: where
// µ² |W| |(W⁻¹)_nn| < 1 only y = 0 is left, and velocities are unique.
Uniqueness find_others(const ContactProblem& problem, const Law& law, const double* impulse);

}  // namespace impulsekit
