#include "impact/scene_impact.hpp"

#include "scene/blows.hpp"
#include "scene/rows.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

namespace {

// Without the rows of controls that yielded, an impact is one of the scene without these.
void drop_yielded(int nv, SceneImpact& impact) {
    StateRows& rows = impact.rows;
    for (auto row = rows.yielded.rbegin(); row != rows.yielded.rend(); ++row) {
        const auto from = rows.A.begin() + static_cast<std::ptrdiff_t>(*row) * nv;
        rows.A.erase(from, from + nv);
        rows.target.erase(rows.target.begin() + *row);
        rows.wider.erase(rows.wider.begin() + *row);
        impact.solution.multipliers.erase(impact.solution.multipliers.begin() + *row);
        impact.solution.unique.erase(impact.solution.unique.begin() + *row);
    }
}

}  // namespace

ImpactProblem problem_of(const Scene& scene, const StateRows& rows, const Law& law) {
    ImpactProblem p;
    p.nv = scene.model->nv;
    p.parent = scene.model->parent_v.data();
    p.bilateral = scene.rows();
    p.A = rows.A.data();
    p.target = rows.target.data();
    p.vectors = scene.vectors.data();
    p.wider = rows.wider.data();
    p.passive = scene.passive.data();
    p.locks = scene.locks.data();
    p.J = rows.J.data();
    p.law = law;
    return p;
}

ImpactProblem problem_of(const Scene& scene, const ContactLaw& law, const double* restitution,
                         const SceneImpact& impact, PointCoefficients& coefficients) {
    ImpactProblem p = problem_of(scene, impact.rows, law.law);
    p.M = impact.M.data();
    p.v = impact.v.data();
    if (!impact.numbers.empty()) p.impulse = impact.impulse.data();
    coefficients.set(law, impact.rows, restitution, nullptr, p.v, p.contact);
    return p;
}

void fill_scene(const Scene& scene, const GivenState& given, SceneImpact& impact) {
    const int nv = scene.model->nv;
    Tree<double> tree(*scene.model);
    tree.place(impact.q.data());
    tree.weigh();
    impact.M.resize(static_cast<std::size_t>(nv) * static_cast<std::size_t>(nv));
    tree.mass_matrix(impact.M.data());
    Rows<double> rows(scene);
    rows.fill(tree, impact.q.data(), impact.v.data(), &given);
    rows.extract(tree, 0, impact.rows);
    if (impact.numbers.empty()) return;
    impact.impulse.resize(nv);
    add_blow_wrenches(scene, impact.numbers.data(), tree);
    tree.gather(impact.impulse.data());
    const double* kicks = impact.numbers.data() + 6 * scene.blows.size();
    for (std::size_t i = 0; i < scene.kicks.size(); ++i) impact.impulse[scene.kicks[i]] += kicks[i];
}

void solve_scene(const Scene& scene, const ContactLaw& law, const double* restitution,
                 SceneImpact& impact) {
    if (!impact.has_directions()) {
        impact.solution.failure = ImpactSolution::Failure::refused;
        impact.solution.dv.assign(impact.v.size(), 0.0);
        return;
    }
    PointCoefficients coefficients;
    solve_impact(problem_of(scene, law, restitution, impact, coefficients), impact.solution);
    if (impact.is_solved()) drop_yielded(scene.model->nv, impact);
}

std::vector<double> contact_impulses(const Scene& scene, const SceneImpact& impact) {
    std::vector<double> found(3 * scene.contacts.size());
    if (!impact.is_solved()) return found;
    const std::vector<ContactFrame<double>>& points = impact.rows.points;
    for (std::size_t i = 0; i < points.size(); ++i) {
        const double* P = impact.solution.contact.impulse.data() + 3 * i;
        const Vec3<double> world = world_impulse(scene, points[i], {P[0], P[1], P[2]});
        double* to = found.data() + 3 * points[i].entry;
        to[0] += world.x;
        to[1] += world.y;
        to[2] += world.z;
    }
    return found;
}

}  // namespace impulsekit
