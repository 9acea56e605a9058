// One impact of a scene at one state: rows, law and velocities in one call.
#pragma once

#include <vector>

#include "impact/coefficients.hpp"
#include "impact/impact.hpp"
#include "scene/scene.hpp"

namespace impulsekit {

struct SceneImpact {
    StateRows rows;
    std::vector<double> M, impulse;  // (nv, nv); (nv) of the known impulses
    ImpactSolution solution;
};

// The impact of a scene under a law at q (nq), v (nv); `impulses`: six numbers of each blow, then
// one of each kick. Without directions of lines or ellipses nothing is solved: see `rows`.
void solve_scene(const Scene& scene, const ContactLaw& law, const double* q, const double* v,
                 const double* impulses, const GivenState& given, SceneImpact& impact);

// The problem of a scene's rows but for M, v, impulses and coefficients.
ImpactProblem problem_of(const Scene& scene, const StateRows& rows, const Law& law);

}  // namespace impulsekit
