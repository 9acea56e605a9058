// One impact of a scene at one state: rows, law and velocities in one call.
#pragma once

#include <vector>

#include "impact/coefficients.hpp"
#include "impact/impact.hpp"

namespace impulsekit {

// An impact, with all that it was solved from.
struct SceneImpact {
    std::vector<double> q, v;     // (nq), (nv) before it
    std::vector<double> numbers;  // of the known impulses: six of each blow, then of each kick
    StateRows rows;
    std::vector<double> M, impulse;  // (nv, nv); (nv) of the known impulses
    ImpactSolution solution;

    bool has_directions() const { return rows.without_line < 0 && rows.without_ellipse < 0; }
    bool is_solved() const { return solution.failure == ImpactSolution::Failure::none; }
};

// Find M, the rows and the generalized impulse of an impact at its q, v and numbers.
void fill_scene(const Scene& scene, const GivenState& given, SceneImpact& impact);
// Solve an impact with its rows under a law. `restitution`: of each contact in place of the law's;
// null where that holds. Refused without directions of lines or ellipses. Controls that yielded to
// their stops have no rows any more.
void solve_scene(const Scene& scene, const ContactLaw& law, const double* restitution,
                 SceneImpact& impact);

// The problem that an impact is the solution of; `coefficients` are those that it refers to.
ImpactProblem problem_of(const Scene& scene, const ContactLaw& law, const double* restitution,
                         const SceneImpact& impact, PointCoefficients& coefficients);

// The problem of a scene's rows but for M, v, impulses and coefficients.
ImpactProblem problem_of(const Scene& scene, const StateRows& rows, const Law& law);

// The impulse P of a point in world axes; of a stop along its coordinate, then two zeros.
template <typename S>
Vec3<S> world_impulse(const Scene& scene, const ContactFrame<S>& point, const Vec3<S>& P) {
    if (scene.contacts[point.entry].kind == Contact::stop) return {point.sign * P.z, S{}, S{}};
    return point.axes * P;
}
// (contacts, 3) the impulses of a scene's contacts in world axes; zero where it was refused.
std::vector<double> contact_impulses(const Scene& scene, const SceneImpact& impact);

}  // namespace impulsekit
