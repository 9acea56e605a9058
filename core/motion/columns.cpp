#include "motion/columns.hpp"

#include <algorithm>

#include "motion/path.hpp"

namespace impulsekit {

Path::Path(const Motion& motion) : resting_states(motion.resting_states) {
    for (const Piece& piece : motion.path) {
        const Step& s = piece.step;
        times.insert(times.end(), {s.start, s.end, s.begin, s.length});
        before.insert(before.end(), s.before.begin(), s.before.end());
        shape.insert(shape.end(), s.shape.begin(), s.shape.end());
        resting_state.push_back(piece.resting_state);
    }
}

ImpactColumns::ImpactColumns(const Motion& motion) {
    const Scene& scene = motion.scene->scene;
    const std::size_t contacts = scene.contacts.size(), nv = motion.nv();
    for (const auto& impact : motion.impacts) {
        const SceneImpact& solved = impact->solved;
        times.push_back(impact->t);
        status.push_back(static_cast<int>(status_of(solved.solution)));
        for (std::size_t i = 0; i < nv; ++i) {
            before.push_back(solved.v[i]);
            after.push_back(solved.v[i] + solved.solution.dv[i]);
        }
        const std::vector<double> own = contact_impulses(scene, solved);
        impulses.insert(impulses.end(), own.begin(), own.end());
        touching.resize(touching.size() + contacts);
        for (const ContactFrame<double>& point : solved.rows.points)
            touching[touching.size() - contacts + point.entry] = 1;
    }
}

std::vector<RestInterval> rests_of(const Motion& motion) {
    std::vector<RestInterval> found = motion.rests;
    const std::vector<RestInterval> now = rests_now(motion);
    found.insert(found.end(), now.begin(), now.end());
    return found;
}

MotionColumns::MotionColumns(const Motion& motion, const double* times, std::size_t count)
    : t(motion.now.t),
      evaluations(motion.dynamics.evaluations),
      end(motion.nq() + motion.nv()),
      impacts(motion),
      rests(rests_of(motion)) {
    state_at(motion, t, end.data(), end.data() + motion.nq());
    const std::size_t reached = std::upper_bound(times, times + count, t) - times;
    samples.resize(reached * end.size());
    for (std::size_t i = 0; i < reached; ++i)
        sample(motion, times[i], samples.data() + i * end.size());
}

}  // namespace impulsekit
