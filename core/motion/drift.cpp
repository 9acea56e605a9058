#include "motion/drift.hpp"

#include <algorithm>
#include <cmath>

#include "linalg/dense.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {
namespace {

constexpr int kMostSteps = 3;

// The same of places alone, by Newton's method; `J` are the rows of resting points there.
bool correct_places(Motion& motion, bool all_normals, std::vector<double>& J) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    std::vector<double> off;
    std::vector<int> of_rows;
    const BilateralConstraints& held = dynamics.constraints;
    for (int step = 0;; ++step) {
        J = rows_of(motion, now.rest.points);
        if (step == kMostSteps) return true;
        Correction back;
        if (held.rows() > 0) {
            dynamics.constraints.fill_rows(dynamics.tree, now.q());
            held.drift(dynamics.tree, now.q(), now.t, off, of_rows);
            for (std::size_t i = 0; i < off.size(); ++i)
                back.add(held.A() + of_rows[i] * motion.nv(), motion.nv(), -off[i]);
        }
        for (std::size_t i = 0; i < now.rest.points.size(); ++i) {
            const RestingContact& point = now.rest.points[i];
            if (point.pressed || all_normals)
                back.add(J.data() + (3 * i + 2) * motion.nv(), motion.nv(),
                         -dynamics.contact_gaps.gap_of(dynamics.tree, point, now.q(), nullptr));
        }
        std::vector<double> dq(motion.nv()), shift(motion.nq());
        if (!back.is_needed() || !dynamics.correct(back, dq.data())) return step > 0;
        configuration_rate(*motion.scene->scene.model, now.q(), dq.data(), shift.data());
        for (int i = 0; i < motion.nq(); ++i) now.y[i] += shift[i];
        normalize_configuration(*motion.scene->scene.model, now.q());
        set_state(motion);
    }
}

// The same of velocities alone.
bool correct_velocities(Motion& motion, bool all_normals, const std::vector<double>& J) {
    Dynamics& dynamics = motion.dynamics;
    MotionState& now = motion.now;
    const double* v = now.v();
    Correction back;
    const auto still = [&](const double* row) {
        back.add(row, motion.nv(), -dot(row, v, motion.nv()));
    };
    if (const int m = dynamics.constraints.rows(); m > 0) {
        std::vector<double> speed(m), rate(m);
        dynamics.constraints.fill_rows(dynamics.tree, now.q());
        dynamics.constraints.speeds(now.t, speed.data(), rate.data());
        for (int r = 0; r < m; ++r) {
            const double* row = dynamics.constraints.A() + r * motion.nv();
            back.add(row, motion.nv(), speed[r] - dot(row, v, motion.nv()));
        }
    }
    const double *row = J.data(), *turn = row + 3 * motion.nv() * now.rest.points.size();
    for (const RestingContact& point : now.rest.points) {
        const Gap& gap = motion.gap(point.gap);
        const ContactCoefficients& own = motion.scene->law.contacts[gap.entry];
        const double *second = row + motion.nv(), *normal = second + motion.nv();
        // A chattering contact does not slip either: friction of so little slip would tip it.
        const bool sticks = all_normals ? chatters(motion, point.gap) &&
                                              std::hypot(dot(row, v, motion.nv()),
                                                         dot(second, v, motion.nv())) < gap.capture
                                        : point.pressed && !point.slip.moves &&
                                              dynamics.static_friction(gap.entry) > 0.0;
        const bool turns = gap.turns && point.pressed && !all_normals;
        if (point.pressed || all_normals) still(normal);
        if (sticks) still(row), still(second);
        if (turns && !point.roll.moves && own.rolling > 0.0) still(turn), still(turn + motion.nv());
        if (turns && !point.spin.moves && own.torsion > 0.0) still(turn + 2 * motion.nv());
        row += 3 * motion.nv();
        if (gap.turns) turn += 3 * motion.nv();
    }
    for (std::size_t j = 0; j < now.rest.dry.size() && !all_normals; ++j)
        if (now.rest.dry[j] == 0) {
            std::vector<double> joint(motion.nv());
            joint[motion.scene->dry[j].v] = 1.0;
            still(joint.data());
        }
    return back.is_needed() && dynamics.correct(back, now.v());
}

}  // namespace

bool correct_drift(Motion& motion, bool all_normals) {
    std::vector<double> J;
    const bool in_places = correct_places(motion, all_normals, J);
    return correct_velocities(motion, all_normals, J) || in_places;
}

}  // namespace impulsekit
