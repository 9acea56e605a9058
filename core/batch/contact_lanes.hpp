// The impacts of eight states of a scene without bilateral rows: matrices, velocities and residuals
// side by side, the law of contact lane by lane.
#pragma once

#include <vector>

#include "impact/coefficients.hpp"
#include "impact/impact_steps.hpp"
#include "scene/rows.hpp"

namespace impulsekit {

class ContactLanes {
  public:
    // W of so many rows side by side fits into the cache; larger problems go one by one.
    static constexpr int kMostRows = 240;

    // The input and the answer of one lane.
    struct Lane {
        bool is_given = false;                                     // it takes part
        const double *restitution = nullptr, *friction = nullptr;  // see PointCoefficients
        StateRows rows;                                            // its points
        ContactSolution contact;
        Status status = Status::solved;
    };

    ContactLanes(const Scene& scene, const ContactLaw& law) : scene_(scene), law_(law) {}

    // The frames of `rows` that touch in some lane that is given. False where they are too many.
    // `stays`: M and all rows are those of the call before, whose factors then serve again.
    bool choose(const Tree<Pack>& tree, const Rows<Pack>& rows, Lane* lanes, bool stays) {
        std::swap(frames_, frames_before_);
        frames_.clear();
        turning_.clear();
        for (std::size_t i = 0; i < rows.contact_frames.size(); ++i) {
            const ContactFrame<Pack>& frame = rows.contact_frames[i];
            bool touches = false;
            for (int k = 0; k < kLanes; ++k)
                touches = touches || (lanes[k].is_given && frame.closed[k]);
            if (!touches) continue;
            if (scene_.contacts[frame.entry].turns)
                turning_.push_back(static_cast<int>(frames_.size()));
            frames_.push_back(static_cast<int>(i));
        }
        keeps_ = keeps_ && stays && frames_ == frames_before_;
        count_ = 3 * static_cast<int>(frames_.size() + turning_.size());
        if (count_ > kMostRows) return false;
        for (int k = 0; k < kLanes; ++k)
            if (lanes[k].is_given) rows.extract_points(tree, k, lanes[k].rows);
        if (keeps_) return true;
        const std::size_t block = 3 * scene_.model->nv;
        J_.resize(count_ / 3 * block);
        Pack* to = J_.data();
        for (int frame : frames_) to = std::copy_n(rows.J.data() + frame * block, block, to);
        for (int at : turning_)
            to = std::copy_n(rows.turning.data() + frames_[at] * block, block, to);
        return true;
    }

    // Solve what was chosen: Δv (nv) of all lanes, and of each its answer and status. `impulse`:
    // (nv) of the known impulses; null for none.
    void solve(const Pack* M, const Pack* v, const Pack* impulse, Lane* lanes, Pack* dv) {
        const int nv = scene_.model->nv;
        const Arena::Scope scope(scratch());
        ImpactSteps<Pack> steps(M, nv, v, impulse, J_.data(), count_);
        steps.exclude_untouched(scene_.model->parent_v.data(), nullptr, 0);
        if (!keeps_ || !std::equal(touched_.begin(), touched_.end(), steps.touched)) factor(steps);
        steps.begin(mass_);
        std::copy(half_.begin(), half_.end(), steps.half);
        std::copy(shared_W_.begin(), shared_W_.end(), steps.W);
        steps.set_free();
        bool has_answer[kLanes] = {};
        for (int k = 0; k < kLanes; ++k) {
            if (!lanes[k].is_given) continue;
            const StateRows& own = lanes[k].rows;
            const bool has_directions = own.without_line < 0 && own.without_ellipse < 0;
            lanes[k].status = !has_directions ? Status::refused
                              : weak_[k] >= 0 ? Status::singular_mass
                                              : Status::solved;
            if (lanes[k].status != Status::solved) continue;
            take_lane(steps, lanes[k], k);
            has_answer[k] = solve_law(steps, lanes[k], k);
        }
        Pack* change = scratch().allocate_of<Pack>(nv);
        const auto respond = [&] {
            steps.add_impulses(change);
            steps.finish(mass_, change);
        };
        respond();
        steps.refine(
            has_answer,
            [&](int k) {
                for (std::size_t i = 0; i < lane_[k].size(); ++i)
                    free_[k][i] = steps.free[lane_[k][i]][k];
                return solve_law(steps, lanes[k], k);
            },
            respond,
            [&] {
                std::fill(change, change + nv, Pack{});
                steps.sharpen(mass_, change);
            });
        std::copy(steps.dv, steps.dv + nv, dv);
        judge(steps, lanes);
    }

    // (rows) u⁻ of a lane's points and of those that turn.
    const std::vector<double>& before(int k) const { return before_[k]; }

  private:
    // Factor M, and half-solve the rows that touch.
    void factor(ImpactSteps<Pack>& steps) {
        std::fill(weak_, weak_ + kLanes, -1);
        mass_.factor(steps.M, scene_.model->parent_v.data(), steps.nv, weak_);
        steps.add_contacts(mass_);
        steps.set_delassus(steps.half);
        touched_.assign(steps.touched, steps.touched + steps.nv);
        half_.assign(steps.half, steps.half + steps.rows * steps.nv);
        shared_W_.assign(steps.W, steps.W + steps.rows * steps.rows);
        keeps_ = true;
    }

    // The problem of one lane: the rows of its points, among those of all lanes.
    void take_lane(ImpactSteps<Pack>& steps, Lane& lane, int k) {
        std::vector<int>& own = lane_[k];
        own.clear();
        const auto add = [&](std::size_t block) {
            for (int j = 0; j < 3; ++j) own.push_back(static_cast<int>(3 * block) + j);
        };
        std::size_t at = 0;
        for (int frame : lane.rows.contact_frame_of) {
            while (frames_[at] != frame) ++at;
            add(at);
        }
        at = 0;
        for (int point : lane.rows.turning_of) {
            while (frames_[turning_[at]] != lane.rows.contact_frame_of[point]) ++at;
            add(frames_.size() + at);
        }
        const std::size_t n = own.size();
        for (int r = 0; r < steps.rows; ++r) steps.in_use[r][k] = 0.0;
        for (int r : own) steps.in_use[r][k] = 1.0;
        W_[k].resize(n * n);
        before_[k].resize(n);
        free_[k].resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            before_[k][i] = steps.before[own[i]][k];
            free_[k][i] = steps.free[own[i]][k];
            for (std::size_t j = 0; j < n; ++j)
                W_[k][i * n + j] = steps.W[own[i] * steps.rows + own[j]][k];
        }
        ContactProblem& p = problems_[k];
        p = ContactProblem();
        p.W = W_[k].data();
        p.before = before_[k].data();
        p.free = free_[k].data();
        coefficients_[k].set(law_, lane.rows, lane.restitution, lane.friction, nullptr, p);
    }

    // True if the law has an answer, which is then in its lane.
    bool solve_law(ImpactSteps<Pack>& steps, Lane& lane, int k) {
        lane.contact =
            lane_[k].empty() ? ContactSolution() : solve_contacts(problems_[k], law_.law);
        if (!lane.contact.refused.empty()) {
            lane.status = Status::refused;
            return false;
        }
        for (std::size_t i = 0; i < lane_[k].size(); ++i) {
            steps.P[lane_[k][i]][k] = lane.contact.impulse[i];
            steps.after[lane_[k][i]][k] = lane.contact.after[i];
        }
        lane.status = lane.contact.status;
        return lane.contact.status < Status::no_solution;
    }

    // The status of each lane by its residuals.
    void judge(const ImpactSteps<Pack>& steps, Lane* lanes) const {
        const Pack momentum = steps.momentum_residual([](Pack*, Pack*) {});
        const Pack* speeds = steps.add_up_speeds();
        const Pack contact = steps.contact_residual(speeds, 3 * static_cast<int>(frames_.size()));
        for (int k = 0; k < kLanes; ++k) {
            if (!lanes[k].is_given || lanes[k].status != Status::solved) continue;
            const double worst = std::max({momentum[k], lanes[k].contact.residual, contact[k]});
            if (!(worst <= tolerance::residual)) lanes[k].status = Status::inaccurate;
        }
    }

    const Scene& scene_;
    const ContactLaw& law_;
    MassFactorOf<Pack> mass_;
    std::vector<int> frames_, turning_;  // that touch; which of them turn
    std::vector<int> frames_before_, touched_;
    int weak_[kLanes];    // degrees of freedom without mass
    bool keeps_ = false;  // what was factored serves again
    std::vector<Pack> half_, shared_W_;
    int count_ = 0;  // rows of all
    std::vector<Pack> J_;
    std::vector<int> lane_[kLanes];  // the rows of each lane
    std::vector<double> W_[kLanes], before_[kLanes], free_[kLanes];
    ContactProblem problems_[kLanes];
    PointCoefficients coefficients_[kLanes];
};

}  // namespace impulsekit
