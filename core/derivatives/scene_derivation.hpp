// The derivatives of one impact of a scene.
#pragma once

#include "derivatives/derivatives.hpp"
#include "impact/scene_impact.hpp"
#include "scene/frame_pair_states.hpp"

namespace impulsekit {

// An impact that was solved, made linear in its modes; scene, law and impact outlive this. Its
// derivation is still to be checked (`check_rows`).
class SceneDerivation {
  public:
    // `inertia_of`: see Differentiated.
    SceneDerivation(const Scene& scene, const ContactLaw& law, const SceneImpact& impact,
                    int inertia_of);
    SceneDerivation(const SceneDerivation&) = delete;
    SceneDerivation& operator=(const SceneDerivation&) = delete;

    Derivation derivation;

  private:
    Tree<double> tree_;
    PointCoefficients coefficients_;
    ImpactProblem problem_;
    std::vector<int> entries_;
    std::vector<FramePairSlopes<double>> pairs_;
};

}  // namespace impulsekit
