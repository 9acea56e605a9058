#include "motion/columns.hpp"

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

std::vector<double> samples(const Motion& motion, const double* times, std::size_t count) {
    const std::size_t size = motion.nq() + motion.nv();
    std::vector<double> found(count * size);
    for (std::size_t i = 0; i < count; ++i) sample(motion, times[i], found.data() + i * size);
    return found;
}

std::vector<RestInterval> rests_of(const Motion& motion) {
    std::vector<RestInterval> found = motion.rests;
    const std::vector<RestInterval> now = rests_now(motion);
    found.insert(found.end(), now.begin(), now.end());
    return found;
}

}  // namespace impulsekit
