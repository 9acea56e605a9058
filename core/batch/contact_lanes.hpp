// The impacts of eight states of a scene without bilateral rows, side by side; where their contacts
// do not act alike, the law of contact lane by lane.
#pragma once

#include <vector>

#include "batch/alike_contacts.hpp"
#include "derivatives/derivatives.hpp"
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
        Status status = Status::solved, of_law = Status::solved;
        double residual = 0.0;  // of the law
    };

    ContactLanes(const Scene& scene, const ContactLaw& law)
        : scene_(scene), law_(law), alike_(scene, law) {}

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
        tree_ = &tree;
        points_ = &rows;
        if (keeps_) return true;
        const std::size_t block = 3 * scene_.model->nv;
        J_ = rows.J.data();
        if (turning_.empty() && frames_.size() == rows.contact_frames.size()) return true;
        some_J_.resize(count_ / 3 * block);
        J_ = some_J_.data();
        Pack* to = some_J_.data();
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
        half_.resize(count_ * nv);
        W_.resize(count_ * count_);
        ImpactSteps<Pack> steps(M, nv, v, impulse, J_, count_, half_.data(), W_.data());
        steps.exclude_untouched(scene_.model->parent_v.data(), nullptr, 0);
        if (!keeps_ || !std::equal(touched_.begin(), touched_.end(), steps.touched)) factor(steps);
        steps.begin(mass_);
        steps.set_free();
        P_.assign(count_, Pack{});
        after_ = P_;
        shares_.assign(count_ / 3, Pack{});
        const PackBits solved = solve_alike(steps, lanes);
        bool has_answer[kLanes] = {};
        for (int k = 0; k < kLanes; ++k) {
            if (!lanes[k].is_given) continue;
            has_answer[k] = solved[k] != 0 || solve_lane(steps, lanes[k], k);
        }
        std::copy(P_.begin(), P_.end(), steps.P);
        std::copy(after_.begin(), after_.end(), steps.after);
        Pack* change = scratch().allocate_of<Pack>(nv);
        const auto respond = [&] {
            steps.add_impulses(change);
            steps.finish(mass_, change);
        };
        respond();
        steps.refine(
            has_answer,
            [&](int k) {
                const bool has = solve_lane(steps, lanes[k], k);
                for (int r = 0; r < count_; ++r) {
                    steps.P[r][k] = P_[r][k];
                    steps.after[r][k] = after_[r][k];
                }
                return has;
            },
            respond,
            [&] {
                std::fill(change, change + nv, Pack{});
                steps.sharpen(mass_, change);
            });
        std::copy(steps.dv, steps.dv + nv, dv);
        before_.assign(steps.before, steps.before + count_);
        judge(steps, lanes);
    }

    // The contact frames of `choose`, and which of them turn.
    const std::vector<int>& frames() const { return frames_; }
    const std::vector<int>& turning() const { return turning_; }
    // (rows) u⁻, P and u⁺ of the frames, then of those that turn.
    const std::vector<Pack>& before() const { return before_; }
    const std::vector<Pack>& P() const { return P_; }
    const std::vector<Pack>& after() const { return after_; }

    // What derivatives at the points of one lane need not find again; nothing where M was changed
    // for trees that nothing touches.
    const FactoredLane* factored(const StateRows& points, int k) {
        const int nv = scene_.model->nv;
        for (int i = 0; i < nv; ++i)
            if (scene_.model->parent_v[i] < 0 && !touched_[i]) return nullptr;
        if (response_.empty()) {
            response_ = half_;
            for (int r = 0; r < count_; ++r) mass_.rest(response_.data() + r * nv);
        }
        find_rows(points);
        factored_ = {&mass_, response_.data(), own_.data(), k};
        return &factored_;
    }

    // The law's answer at the points of one lane.
    ContactSolution solution(const StateRows& points, const Lane& lane, int k) {
        find_rows(points);
        ContactSolution found;
        found.impulse.reserve(own_.size());
        found.after.reserve(own_.size());
        found.unique.reserve(own_.size() / 3);
        for (int r : own_) {
            found.impulse.push_back(P_[r][k]);
            found.after.push_back(after_[r][k]);
            if (r % 3 == 0) found.unique.push_back(shares_[r / 3][k] <= tolerance::shared);
        }
        found.status = lane.of_law;
        found.residual = lane.residual;
        return found;
    }

  private:
    // Factor M, and half-solve the rows that touch.
    void factor(ImpactSteps<Pack>& steps) {
        std::fill(weak_, weak_ + kLanes, -1);
        mass_.factor(steps.M, scene_.model->parent_v.data(), steps.nv, weak_);
        steps.add_contacts(mass_);
        steps.set_delassus(steps.half);
        touched_.assign(steps.touched, steps.touched + steps.nv);
        keeps_ = true;
        response_.clear();
    }

    // The lanes solved side by side.
    PackBits solve_alike(const ImpactSteps<Pack>& steps, Lane* lanes) {
        entries_.clear();
        PackBits todo{}, gains{};
        for (int k = 0; k < kLanes; ++k)
            todo[k] = -(lanes[k].is_given && points_->has_line[k] && weak_[k] < 0);
        for (int frame : frames_) {
            const ContactFrame<Pack>& own = points_->contact_frames[frame];
            entries_.push_back(own.entry);
            for (int k = 0; k < kLanes; ++k) todo[k] &= -own.closed[k];
        }
        const double *e[kLanes], *mu[kLanes];
        for (int k = 0; k < kLanes; ++k) {
            e[k] = lanes[k].restitution;
            mu[k] = lanes[k].friction;
        }
        if (!alike_.set(entries_, e, mu)) return gains;
        Pack residual{};
        const PackBits solved = alike_.solve(steps.W, steps.before, steps.free, todo, P_.data(),
                                             after_.data(), shares_.data(), residual, gains);
        for (int k = 0; k < kLanes; ++k) {
            if (!solved[k]) continue;
            lanes[k].status = lanes[k].of_law = gains[k] ? Status::energy_gain : Status::solved;
            lanes[k].residual = residual[k];
        }
        return solved;
    }

    // True if the law has an answer in one lane.
    bool solve_lane(ImpactSteps<Pack>& steps, Lane& lane, int k) {
        points_->extract_points(*tree_, k, lane_);
        const bool has_directions = lane_.without_line < 0 && lane_.without_ellipse < 0;
        lane.status = !has_directions ? Status::refused
                      : weak_[k] >= 0 ? Status::singular_mass
                                      : Status::solved;
        if (lane.status != Status::solved) return false;
        find_rows(lane_);
        const std::size_t n = own_.size();
        numbers_.resize(n * n + 2 * n);
        double *W = numbers_.data(), *before = W + n * n, *free = before + n;
        for (int r = 0; r < steps.rows; ++r) steps.in_use[r][k] = 0.0;
        for (int r : own_) steps.in_use[r][k] = 1.0;
        for (std::size_t i = 0; i < n; ++i) {
            before[i] = steps.before[own_[i]][k];
            free[i] = steps.free[own_[i]][k];
            for (std::size_t j = 0; j < n; ++j)
                W[i * n + j] = steps.W[own_[i] * steps.rows + own_[j]][k];
        }
        ContactProblem p;
        p.W = W;
        p.before = before;
        p.free = free;
        coefficients_.set(law_, lane_, lane.restitution, lane.friction, nullptr, p);
        return solve_law(p, lane, k);
    }

    // The rows of a lane's points among those of all lanes.
    void find_rows(const StateRows& points) {
        own_.clear();
        const auto add = [&](std::size_t block) {
            for (int j = 0; j < 3; ++j) own_.push_back(static_cast<int>(3 * block) + j);
        };
        std::size_t at = 0;
        for (int frame : points.contact_frame_of) {
            while (frames_[at] != frame) ++at;
            add(at);
        }
        at = 0;
        for (int point : points.turning_of) {
            while (frames_[turning_[at]] != points.contact_frame_of[point]) ++at;
            add(frames_.size() + at);
        }
    }

    // True if the law has an answer, which is then in its lane.
    bool solve_law(const ContactProblem& problem, Lane& lane, int k) {
        const ContactSolution found =
            own_.empty() ? ContactSolution() : solve_contacts(problem, law_.law);
        if (!found.refused.empty()) {
            lane.status = Status::refused;
            return false;
        }
        for (std::size_t i = 0; i < own_.size(); ++i) {
            P_[own_[i]][k] = found.impulse[i];
            after_[own_[i]][k] = found.after[i];
            shares_[own_[i] / 3][k] = found.unique[i / 3] ? 0.0 : 1.0;
        }
        lane.status = lane.of_law = found.status;
        lane.residual = found.residual;
        return found.status < Status::no_solution;
    }

    // The status of each lane by its residuals.
    void judge(const ImpactSteps<Pack>& steps, Lane* lanes) const {
        const Pack momentum = steps.momentum_residual([](Pack*, Pack*) {});
        const Pack* speeds = steps.add_up_speeds();
        const Pack contact = steps.contact_residual(speeds, 3 * static_cast<int>(frames_.size()));
        for (int k = 0; k < kLanes; ++k) {
            if (!lanes[k].is_given || lanes[k].status != Status::solved) continue;
            const double worst = std::max({momentum[k], lanes[k].residual, contact[k]});
            if (!(worst <= tolerance::residual)) lanes[k].status = Status::inaccurate;
        }
    }

    const Scene& scene_;
    const ContactLaw& law_;
    AlikeContacts alike_;
    const Tree<Pack>* tree_ = nullptr;
    const Rows<Pack>* points_ = nullptr;
    MassFactorOf<Pack> mass_;
    std::vector<int> frames_, turning_, entries_;  // that touch; which of them turn; contacts
    std::vector<int> frames_before_, touched_;
    int weak_[kLanes];    // degrees of freedom without mass
    bool keeps_ = false;  // what was factored serves again
    int count_ = 0;       // rows of all
    const Pack* J_ = nullptr;
    std::vector<Pack> some_J_, half_, W_, response_;
    std::vector<Pack> before_, P_, after_, shares_;
    // One lane: its points, their rows among all, and its problem.
    StateRows lane_;
    FactoredLane factored_;
    std::vector<int> own_;
    std::vector<double> numbers_;
    PointCoefficients coefficients_;
};

}  // namespace impulsekit
