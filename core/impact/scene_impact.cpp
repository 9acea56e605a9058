#include "impact/scene_impact.hpp"

#include "scene/blows.hpp"
#include "scene/rows.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

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

void solve_scene(const Scene& scene, const ContactLaw& law, const double* q, const double* v,
                 const double* impulses, const GivenState& given, SceneImpact& impact) {
    const int nv = scene.model->nv;
    Tree<double> tree(*scene.model);
    tree.place(q);
    tree.weigh();
    impact.M.resize(static_cast<std::size_t>(nv) * static_cast<std::size_t>(nv));
    tree.mass_matrix(impact.M.data());
    Rows<double> rows(scene);
    rows.fill(tree, q, v, &given);
    rows.extract(tree, 0, impact.rows);
    if (impact.rows.without_line >= 0 || impact.rows.without_ellipse >= 0) return;
    ImpactProblem p = problem_of(scene, impact.rows, law.law);
    p.M = impact.M.data();
    p.v = v;
    if (scene.blows.size() + scene.kicks.size() > 0) {
        impact.impulse.resize(nv);
        add_blow_wrenches(scene, impulses, tree);
        tree.gather(impact.impulse.data());
        const double* kicks = impulses + 6 * scene.blows.size();
        for (std::size_t i = 0; i < scene.kicks.size(); ++i)
            impact.impulse[scene.kicks[i]] += kicks[i];
        p.impulse = impact.impulse.data();
    }
    PointCoefficients coefficients;
    coefficients.set(law, impact.rows, nullptr, nullptr, p);
    solve_impact(p, impact.solution);
}

}  // namespace impulsekit
