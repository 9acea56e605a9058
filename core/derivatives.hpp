// How the rows of a scene and the mass matrix change with the configuration.
#pragma once

#include <vector>

#include "scene.hpp"

namespace impulsekit {

// At q, and along each direction δ of its tangent (q ⊕ δ as Pinocchio's `integrate` has it, along
// the directions of v): all derivatives begin with the direction.
struct DerivedRows {
    int rows = 0;           // six of each blow, one of each kick, bilateral ones, then contacts'
    std::vector<double> M;  // (nv, nv)
    std::vector<double> G, dG;  // (rows, nv), (nv, rows, nv)
    std::vector<int> entries;   // (points) of those that touch
    std::vector<double> axes,
        daxes;  // (points, 3, 3) by rows: columns t₁, t₂, n; (nv, points, 3, 3)
};

DerivedRows derive_rows(const Scene& scene, const double* q, const GivenState& given);

// (nv, nv) ∂(M x)/∂q: begins with the direction, as above.
std::vector<double> momentum_by_q(const Model& model, const double* q, const double* x);

// (nv, 10) ∂(M x)/∂(m, m c, I_xx, I_xy, I_yy, I_xz, I_yz, I_zz) of a body, in the frame of its
// joint.
std::vector<double> inertia_regressor(const Model& model, const double* q, const double* x,
                                      int body);

}  // namespace impulsekit
