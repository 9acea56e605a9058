// The stages of an impact passed backwards: weights of its results in, slopes by parameters out.
#include <algorithm>
#include <cmath>
#include <limits>

#include "contact/tolerances.hpp"
#include "derivatives/pass.hpp"

namespace impulsekit {

template <typename S>
void Derivation::pull_set_back(Pass<S>& pass, const S* weights, S* slopes) const {
    Seed<S> seed;
    seed.after = weights;
    seed.multipliers = weights + nv_;
    seed.impulses = weights + nv_ + m_;
    pass.run(seed, slopes);
    for (int k = 0; k < this->slopes(); ++k)
        if (!consistent_[k]) slopes[k] = S{} + std::numeric_limits<double>::quiet_NaN();
}

void Derivation::pull_back(const double* weights, int count, double* slopes) const {
    const int results = this->results(), width = this->slopes();
    if (count == 1) {
        Pass<double> pass(*this);
        pull_set_back(pass, weights, slopes);
    } else {
        Pass<Pack> pass(*this);
        std::vector<Pack> in(results), out(width);
        for (int first = 0; first < count; first += kLanes) {
            const int own = std::min(kLanes, count - first);
            for (int k = 0; k < kLanes; ++k)
                for (int i = 0; i < results; ++i)
                    in[i][k] = k < own ? weights[(first + k) * results + i] : 0.0;
            pull_set_back(pass, in.data(), out.data());
            for (int k = 0; k < own; ++k)
                for (int i = 0; i < width; ++i) slopes[(first + k) * width + i] = out[i][k];
        }
    }
    for (int i = 0; i < count; ++i)
        if (!is_determined(weights + i * results))
            std::fill_n(slopes + i * width, width, std::numeric_limits<double>::quiet_NaN());
}

template <typename S>
void pull_back_blows(const Scene& scene, const Tree<S>& tree, const Inertia<S>* inertias,
                     const S* impulses, const S* weights, const S* x, const S* change, S* slopes) {
    const Parameters at(scene);
    const int nv = scene.model->nv;
    std::fill(slopes, slopes + at.count, S{});
    std::copy(weights, weights + nv, slopes + at.v);
    TreeGradient<S, S> gradient(tree);
    std::vector<Spatial<S>> by_x, by_change, of_x, of_change;
    gradient.begin();
    gradient.move(x, by_x);
    gradient.move(change, by_change);
    of_x.resize(by_x.size());
    of_change.resize(by_x.size());
    for (std::size_t k = 1; k < by_x.size(); ++k) {
        of_x[k] = -(inertias[k] * by_change[k]);
        of_change[k] = -(inertias[k] * by_x[k]);
    }
    for (std::size_t i = 0; i < scene.loads.size(); ++i) {
        const int k = scene.loads[i].body;
        const Inertia<S> own = tree.in_world(k, inertia_of<S>(scene.loads[i]));
        slopes[at.masses + i] -= dot(by_x[k], own * by_change[k]);
    }
    for (std::size_t i = 0; i < scene.blows.size(); ++i) {
        const Site& site = scene.blows[i].site;
        const FramePairSlopes<S> m(frame_pair_state(tree, pair_of(scene.blows[i])));
        const S* p = impulses + 6 * i;
        const Spatial<S> f{m.axes * Vec3<S>{p[0], p[1], p[2]}, m.axes * Vec3<S>{p[3], p[4], p[5]}};
        typename TreeGradient<S, S>::PairGradient pair_gradient;
        gradient.add_form(m, f, by_x, pair_gradient);
        gradient.distribute(m, pair_gradient);
        gradient.wrench_at(m.first, m.place, f, of_x);
        const Spatial<S> u = gradient.relative_twist(m, by_x);
        put(back(m.axes, u.linear), slopes + at.impulses + 6 * i);
        put(back(m.axes, u.angular), slopes + at.impulses + 6 * i + 3);
        put(back(tree.rotation[site.body] * mat3<S>(site.axes), pair_gradient.pull),
            slopes + at.blow_points + 3 * i);
    }
    for (std::size_t i = 0; i < scene.kicks.size(); ++i)
        slopes[at.impulses + 6 * scene.blows.size() + i] += x[scene.kicks[i]];
    gradient.sum(of_x);
    gradient.add_parents(x, by_x, of_x);
    gradient.sum(of_change);
    gradient.add_parents(change, by_change, of_change);
    gradient.finish(slopes + at.q);
}

template void pull_back_blows(const Scene&, const Tree<Pack>&, const Inertia<Pack>*, const Pack*,
                              const Pack*, const Pack*, const Pack*, Pack*);

// True if demands that were left out or are shared are met, whatever changes, eight side by side.
void Derivation::check_stage(int number) {
    const Stage& stage = stages_[number];
    const int count = slopes();
    // The part given by the configuration is a difference of terms of this size.
    double rows = 0.0, speed = 0.0;
    for (int r : stage.rows) rows = std::max(rows, largest(row(r), nv_));
    for (int v : {stage.start, stage.end})
        speed = std::max(speed, largest(velocities_[v].data(), nv_));
    std::vector<int> kept;
    for (std::size_t r = 0; r < stage.rows.size(); ++r)
        if (stage.kept[r]) kept.push_back(static_cast<int>(r));
    Pass<Pack> pass(*this);
    std::vector<Pack> made(count), given(count);
    for (std::size_t first = 0; first < kept.size(); first += kLanes) {
        Seed<Pack> seed;
        seed.stage = number;
        for (int k = 0; k < kLanes; ++k) seed.rows[k] = kept[std::min(first + k, kept.size() - 1)];
        pass.run(seed, made.data());
        seed.is_given = true;
        pass.run(seed, given.data());
        for (int i = 0; i < count; ++i)
            for (int k = 0; k < kLanes; ++k) {
                const double a = made[i][k], b = given[i][k],
                             terms = rows * speed + std::abs(a) + std::abs(b);
                if (!(std::abs(a - b) <= tolerance::contradiction * terms)) consistent_[i] = 0;
            }
    }
    // v⁺ hangs on shares of load that change with the configuration.
    if (!stage.even.empty()) std::fill_n(consistent_.begin() + parameters.q, nv_, 0);
}

void Derivation::check_rows() {
    if (unavailable != Unavailable::none) return;
    bool open = is_split_open();
    for (const Stage& stage : stages_) open = open || stage.is_open;
    for (std::size_t k = 0; k < stages_.size() && !open; ++k) {
        const std::vector<char>& kept = stages_[k].kept;
        if (std::find(kept.begin(), kept.end(), 1) != kept.end()) check_stage(static_cast<int>(k));
    }
    if (open) std::fill(consistent_.begin(), consistent_.end(), 0);
    determined.assign(m_, 1);
    for (int r = 0; r < m_; ++r)
        determined[r] = given_.solution->unique[r] || stages_.front().null[r];
    const auto states = consistent_.begin() + parameters.states();
    if (std::find(consistent_.begin(), states, 0) != states) existence = Existence::rank_changes;
}

}  // namespace impulsekit
