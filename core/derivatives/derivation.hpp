// The stages of a `Derivation`: what its files share.
#pragma once

#include "derivatives/derivatives.hpp"

namespace impulsekit {

// Coefficients of a point at its approach speed, and how e changes with that.
struct Derivation::Coefficients {
    double e = 0.0, slope = 0.0, mu = 0.0, tangential = 0.0;
};

// One point in one stage. parted: P = 0. sliding: ξ_n = 0, P_t = −µ P_n s with s = ξ_t/|ξ_t|.
// sticking: ξ = 0. Under Poisson's law the expansion may hold P_n at e P_n^c instead of ξ_n at 0
// (held). ξ is the velocity after, shifted by restitution.
struct Derivation::Mode {
    bool parted = true, sticking = false, held = false;
    double slip[2] = {}, resistance = 0.0, normal = 0.0, compressed = 0.0;
};

// M d = r + Gᵀ y under the rows that the modes keep, Φ G d + E y = given:
//     bilateral, sticking, normal    G d = given
//     held normal                    y = given directly
//     sliding tangents               y_t + µ s y_n + µ P_n/|ξ_t| (1 − s sᵀ) G_t d = given
// so that (Φ W + E) y = given − Φ G M⁻¹ r with W = G M⁻¹ Gᵀ. Its rows keep G end = κ G start.
struct Derivation::Stage {
    int start = 0, end = 0, change = 0;  // of the velocities that were kept
    // For that change, and for those by unit impulses of a hit along a path: −M Δv and what the
    // impulses give, as wrenches on all that hangs on each joint.
    std::vector<std::vector<Spatial<double>>> wrenches;
    bool first = false;              // whether known impulses and imposed velocities act
    std::vector<double> impulses;    // (m + 3n) λ and P
    std::vector<double> compressed;  // (n) P_n^c that an expansion starts from, or empty
    std::vector<int> carrying;       // the points that have rows
    std::vector<Mode> modes;         // of these
    std::vector<int> rows;           // which of all
    std::vector<double> kappa;       // by row
    std::vector<double> mix, own;  // Φ and E: bilateral rows one number, then (3, 3) of each point
    std::vector<char> null, kept;  // rows that move nothing; whose demands are left out or shared
    std::vector<double> factors, scale;  // of (Φ W + E)ᵀ
    std::vector<int> pivots;
    bool is_open = false;  // whether the modes leave the impulses open
    // Springs under normals between which load is shared: their rows here, √D Π √D and Π √D.
    std::vector<int> even;
    std::vector<double> stiffness, springs;
    // Points that are followed along the impact: ∂P (3 k, parameters) as `law_parameters` orders
    // them, and the velocities by unit impulses (3 k of those that were kept).
    std::vector<int> along;
    std::vector<double> law;
    int units = 0;
    bool from_start = false;  // whether Newton's law looks at the start of the hit

    int bilateral() const { return static_cast<int>(rows.size() - 3 * carrying.size()); }
};

}  // namespace impulsekit
