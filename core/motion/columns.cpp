#include "motion/columns.hpp"

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
    const std::size_t contacts = motion.scene().scene.contacts.size();
    for (const MotionImpact& impact : motion.impacts) {
        times.push_back(impact.t);
        status.push_back(static_cast<int>(impact.status));
        before.insert(before.end(), impact.v.begin(), impact.v.end());
        after.insert(after.end(), impact.after.begin(), impact.after.end());
        impulses.insert(impulses.end(), impact.impulses.begin(), impact.impulses.end());
        touching.resize(touching.size() + contacts);
        for (int entry : impact.entries) touching[touching.size() - contacts + entry] = 1;
    }
}

std::vector<double> samples(const Motion& motion, const double* times, std::size_t count) {
    const std::size_t size = motion.nq() + motion.nv();
    std::vector<double> found(count * size);
    for (std::size_t i = 0; i < count; ++i) motion.sample(times[i], found.data() + i * size);
    return found;
}

std::vector<RestInterval> rests_of(const Motion& motion) {
    std::vector<RestInterval> found = motion.rests;
    const std::vector<RestInterval> now = motion.resting();
    found.insert(found.end(), now.begin(), now.end());
    return found;
}

}  // namespace impulsekit
