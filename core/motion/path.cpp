#include "motion/path.hpp"

#include <algorithm>

#include "spatial/joints.hpp"

namespace impulsekit {
std::size_t piece_at(const Motion& motion, double at) {
    std::size_t low = 0, high = motion.path.size();
    while (high - low > 1) {
        const std::size_t middle = (low + high) / 2;
        (motion.path[middle].step.start <= at ? low : high) = middle;
    }
    return low;
}

void sample(const Motion& motion, double at, double* found) {
    const MotionState& now = motion.now;
    if (motion.path.empty() || !(at < now.t)) {
        std::copy(now.y.begin(), now.y.end(), found);
        return;
    }
    const Step& step = motion.path[piece_at(motion, at)].step;
    step.at(std::min(std::max(at, step.start), step.end), found);
}

void state_at(const Motion& motion, double at, double* q, double* v) {
    std::vector<double> found(motion.now.y.size());
    sample(motion, at, found.data());
    normalize_configuration(*motion.scene->scene.model, found.data());
    std::copy(found.begin(), found.begin() + motion.nq(), q);
    std::copy(found.begin() + motion.nq(), found.end(), v);
}

const RestingState& resting_state_at(const Motion& motion, double at) {
    return motion.path.empty() || !(at < motion.now.t)
               ? motion.now.rest
               : motion.resting_states[motion.path[piece_at(motion, at)].resting_state];
}

void forget_before(Motion& motion, double before) {
    const std::size_t first = motion.path.empty() ? 0 : piece_at(motion, before);
    if (first == 0) return;
    motion.path.erase(motion.path.begin(), motion.path.begin() + first);
    const int known = motion.path.front().resting_state;
    motion.resting_states.erase(motion.resting_states.begin(),
                                motion.resting_states.begin() + known);
    for (Piece& piece : motion.path) piece.resting_state -= known;
}

void keep_step(Motion& motion, const Step& step) {
    if (motion.resting_states.empty() || !motion.resting_states.back().is_same(motion.now.rest))
        motion.resting_states.push_back(motion.now.rest);
    motion.path.push_back({step, static_cast<int>(motion.resting_states.size()) - 1});
}

}  // namespace impulsekit
