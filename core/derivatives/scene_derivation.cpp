#include "derivatives/scene_derivation.hpp"

namespace impulsekit {

SceneDerivation::SceneDerivation(const Scene& scene, const ContactLaw& law,
                                 const SceneImpact& impact, int inertia_of)
    : derivation(scene, law),
      tree_(*scene.model),
      problem_(problem_of(scene, law, nullptr, impact, coefficients_)) {
    tree_.place(impact.q.data());
    for (const ContactFrame<double>& point : impact.rows.points) entries_.push_back(point.entry);
    Differentiated d;
    d.is_closed = find_frame_pair_states(scene, tree_, impact.rows, pairs_, derivation.contact);
    d.tree = &tree_;
    d.problem = &problem_;
    d.solution = &impact.solution;
    d.entries = entries_.data();
    d.pairs = pairs_.data();
    d.impulses = impact.numbers.data();
    d.inertia_of = inertia_of;
    derivation.set(d);
}

}  // namespace impulsekit
