// One contact followed along its normal impulse: friction opposes the slip at every instant.
#pragma once

#include "contact/problem.hpp"

namespace impulsekit {

// The impact of one contact.
struct PathImpact {
    double impulse[3] = {0.0, 0.0, 0.0};            // tangents, normal [N s]
    double after[3] = {0.0, 0.0, 0.0};              // u⁺ [m/s]
    double normal_work = 0.0, friction_work = 0.0;  // [J]
    double residual = 0.0;
    Status status = Status::solved;
};

// W (3, 3) of the contact [1/kg], u_n⁻ for Newton's target, u_free where the impact starts [m/s].
// With s the direction of slip, du/dp = W (−µ s, 1) (Routh 1860; Keller 1986). Slip ends where
// u_t = 0: there the contact sticks if friction can hold it, |k| <= µ with W_tt k = −W_tn; else
// slip starts again in the one direction that keeps. The impact ends at u_n = −e u_n⁻ (Newton), at
// p = (1 + e) p_c (Poisson), or when e² of the work of compression is regained (Stronge 1990).
PathImpact follow_path(const double* W, double before, const double* free, double e, double mu,
                       Restitution restitution);

// Impulse (3) of a contact that receives the normal impulse `normal` whatever its u_n becomes, from
// the velocity (3) `start`.
void push_along_path(const double* W, const double* start, double normal, double mu,
                     double* impulse);

// W_t1t1, W_t1t2, W_t2t2, W_t1n, W_t2n, W_nn; the velocity at the start; u_n⁻, e and µ.
inline constexpr int kPathParameters = 12;

struct PathDerivative {
    double impulse[3] = {0.0, 0.0, 0.0};
    double by[3 * kPathParameters] = {};  // (3, parameters)
    // 1: what has stuck is at the edge of its cone; 2: slip ends just as the compression or the
    // impact does; 4: it hardly slips when it meets.
    int edges = 0;
    // True if friction draws the contact in again, or holds all that moves: no derivative then.
    bool is_drawn_in = false;
};

// The impulse of `follow_path`, of a contact that approaches, and its derivatives.
PathDerivative derive_path(const double* W, double before, const double* free, double e, double mu,
                           Restitution restitution);

}  // namespace impulsekit
