// The equations of one stage: who carries, sticks or slips, and which demands are left out.
#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "derivatives/derivation.hpp"
#include "linalg/dense.hpp"
#include "linalg/pivoted.hpp"
#include "scene/tree_gradient.hpp"

namespace impulsekit {
namespace {

// A contact that slips has its impulse on the cone, to this share of its bound.
constexpr double kOnCone = 1e-6;
// An impulse that could move this much faster than anything moves is held up by nothing.
constexpr double kProportion = 1e7;

}  // namespace

// The mode of a point in a stage; tells edges.
Derivation::Mode Derivation::mode_of(int i, const Stage& stage) const {
    auto& self = const_cast<Derivation&>(*this);
    const Coefficients& own = own_[i];
    const bool newton = law_.law.restitution == Restitution::newton;
    const double small = tolerance::edge * scale_;
    const double *start = velocities_[stage.start].data(), *end = velocities_[stage.end].data();
    const double* P = stage.impulses.data() + m_ + 3 * i;
    double xi[3], mobility[3] = {};
    for (int k = 0; k < 3; ++k) {
        const double* J = row(m_ + 3 * i + k);
        const double before = dot(J, start, nv_);
        xi[k] = dot(J, end, nv_);
        if (newton && k < 2 && own.mu > 0.0) xi[k] += own.tangential * before;
        if (newton && k == 2) xi[k] += own.e * std::min(before, 0.0);
        // Without the coupling of joints: of the size of W, from below.
        for (int j = 0; j < nv_; ++j)
            if (J[j] != 0.0) mobility[k] += J[j] * J[j] / given_.problem->M[j * (nv_ + 1)];
    }
    Mode mode;
    const double tangential = std::hypot(P[0], P[1]), speed = std::hypot(xi[0], xi[1]);
    const double compressed = stage.compressed.empty() ? 0.0 : stage.compressed[i];
    const double e = stage.compressed.empty() ? 0.0 : own.e;
    if (mobility[2] * (P[2] - e * compressed) <= small) {
        mode.held = compressed > 0.0;
        // Without restitution nothing expands, and the velocity stays at zero.
        const bool clear = xi[2] > small || (mode.held && e == 0.0);
        if (!clear) self.add_edge(Edge::hardly_presses, i);
        if (!mode.held && (clear || P[2] <= 0.0)) return mode;
    }
    mode.parted = false;
    mode.normal = P[2];
    mode.compressed = compressed;
    mode.sticking = own.mu > 0.0 && speed <= small;
    // Without restitution an expansion has neither impulse nor cone.
    if (mode.sticking && !(mode.held && e == 0.0) &&
        std::max(mobility[0], mobility[1]) * (own.mu * P[2] - tangential) <= small)
        self.add_edge(Edge::edge_of_cone, i);
    if (own.mu > 0.0 && !mode.sticking && own.mu * P[2] - tangential > kOnCone * own.mu * P[2])
        self.add_edge(Edge::hardly_slips, i);
    if (mobility[2] * P[2] > kProportion * scale_) self.add_edge(Edge::out_of_proportion, i);
    if (speed <= small) return mode;
    mode.slip[0] = xi[0] / speed;
    mode.slip[1] = xi[1] / speed;
    mode.resistance = own.mu * P[2] / speed;
    return mode;
}

// Keep a stage in which one point takes part; `acting`: n for all of them, −1 for none.
void Derivation::add_stage(Stage stage, int acting) {
    const double* start = velocities_[stage.start].data();
    for (int r = 0; r < m_; ++r) {
        stage.rows.push_back(r);
        stage.kappa.push_back(!stage.first || scene_.kept[r] ? 1.0 : 0.0);
    }
    for (int i = 0; i < n_; ++i) {
        if (acting != n_ && acting != i) continue;
        const Mode mode = mode_of(i, stage);
        if (mode.parted) continue;
        stage.carrying.push_back(i);
        stage.modes.push_back(mode);
        const bool newton = law_.law.restitution == Restitution::newton;
        const double shift = newton && own_[i].mu > 0.0 ? own_[i].tangential : 0.0;
        const bool approaches = dot(row(m_ + 3 * i + 2), start, nv_) < 0.0;
        for (int k = 0; k < 3; ++k) {
            stage.rows.push_back(m_ + 3 * i + k);
            stage.kappa.push_back(k < 2 ? -shift : newton && approaches ? -own_[i].e : 0.0);
        }
    }
    std::vector<double> change = velocities_[stage.end];
    for (int i = 0; i < nv_; ++i) change[i] -= start[i];
    stage.change = keep(std::move(change));
    solve_system(stage);
    stages_.push_back(std::move(stage));
}

void Derivation::solve_system(Stage& stage) {
    const int count = static_cast<int>(stage.rows.size()), all = m_ + 3 * n_;
    std::vector<double> W(count * count);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) W[i * count + j] = W_[stage.rows[i] * all + stage.rows[j]];
    if (is_shared_ && !mass_.is_filled()) share_evenly(stage, W);
    double most = tolerance::tiny;
    for (int i = 0; i < count; ++i) most = std::max(most, W[i * (count + 1)]);
    stage.null.assign(count, 0);
    stage.scale.assign(count, 1.0);
    for (int i = 0; i < count; ++i) {
        stage.null[i] = W[i * (count + 1)] <= tolerance::immovable * most;
        if (!stage.null[i]) stage.scale[i] = 1.0 / std::sqrt(W[i * (count + 1)]);
    }
    const int m = stage.bilateral();
    stage.mix.assign(m, 1.0);
    stage.own.assign(m, 0.0);
    for (std::size_t c = 0; c < stage.carrying.size(); ++c) {
        const Mode& mode = stage.modes[c];
        const double normal = mode.held ? 0.0 : 1.0, k = mode.resistance, a = mode.slip[0],
                     b = mode.slip[1], mu = own_[stage.carrying[c]].mu;
        double mix[9] = {k * b * b, -k * a * b, 0, -k * a * b, k * a * a, 0, 0, 0, normal};
        double own[9] = {1, 0, mu * a, 0, 1, mu * b, 0, 0, 1.0 - normal};
        if (mode.sticking) {
            mix[0] = mix[4] = 1.0;
            mix[1] = mix[3] = own[0] = own[2] = own[4] = own[5] = 0.0;
        }
        stage.mix.insert(stage.mix.end(), mix, mix + 9);
        stage.own.insert(stage.own.end(), own, own + 9);
    }
    stage.kept.assign(count, 0);
    drop_rows(stage);
    // (Φ W + E)ᵀ, its rows and columns of one size.
    stage.factors.assign(count * count, 0.0);
    const auto put = [&](int r, int k, double mix, double own) {
        if (own != 0.0) stage.factors[k * count + r] += own * stage.scale[r] * stage.scale[k];
        for (int j = 0; j < count && mix != 0.0; ++j)
            stage.factors[j * count + r] +=
                mix * W[k * count + j] * stage.scale[r] * stage.scale[j];
    };
    for (int r = 0; r < m; ++r) put(r, r, stage.mix[r], stage.own[r]);
    for (int r = m; r < count; ++r)
        for (int k = 0; k < 3; ++k) {
            const int at = m + 3 * (r - m) + k;
            put(r, m + (r - m) / 3 * 3 + k, stage.mix[at], stage.own[at]);
        }
    stage.pivots.resize(count);
    stage.is_open = !factor_lu(stage.factors.data(), count, stage.pivots.data());
}

// Springs that keep shares of load even where contacts slip: of redundant loads the rule is theirs.
void Derivation::share_evenly(Stage& stage, std::vector<double>& W) {
    const int count = static_cast<int>(stage.rows.size()), m = stage.bilateral();
    bool slips = false;
    std::vector<double> points;
    for (std::size_t c = 0; c < stage.carrying.size(); ++c) {
        if (stage.modes[c].held) continue;
        slips = slips || !stage.modes[c].sticking;
        stage.even.push_back(m + 3 * static_cast<int>(c) + 2);
        const double* normal = row(stage.rows[stage.even.back()]);
        points.insert(points.end(), normal, normal + nv_);
    }
    const int k = static_cast<int>(stage.even.size());
    std::vector<double> velocity_changes, unit_multipliers, own, projector(k * k);
    std::vector<int> order(k);
    int rank = k;
    if (k > 1 && slips) {
        // Row by row: a normal by itself is a vector.
        own.resize(k * k);
        std::vector<double> half = points;
        for (int i = 0; i < k; ++i) {
            mass_.mass().half(half.data() + i * nv_);
            if (m_ > 0) mass_.rows().project_out(half.data() + i * nv_);
        }
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < k; ++j)
                own[i * k + j] = dot(half.data() + i * nv_, half.data() + j * nv_, nv_);
        bool moves = true;
        for (int i = 0; i < k; ++i) moves = moves && own[i * (k + 1)] > 0.0;
        std::vector<double> roots(k);
        for (int i = 0; i < k && moves; ++i) roots[i] = std::sqrt(own[i * (k + 1)]);
        for (int i = 0; i < k * k && moves; ++i) own[i] /= roots[i / k] * roots[i % k];
        if (moves) rank = factor_pivoted(own.data(), k, order.data(), tolerance::dependent);
        if (rank < k) {
            null_projector(own.data(), order.data(), k, rank, projector.data(), scratch());
            stage.springs.assign(count * k, 0.0);
            for (int i = 0; i < k; ++i)
                for (int j = 0; j < k; ++j) {
                    const double spring = projector[i * k + j] * roots[j];
                    stage.springs[stage.even[j] * k + i] = spring;
                    W[stage.even[i] * count + stage.even[j]] += roots[i] * spring;
                }
        }
    }
    if (rank == k) stage.even.clear();
}

// Leave out demands of rows that move nothing, or that others already make.
void Derivation::drop_rows(Stage& stage) {
    const int count = static_cast<int>(stage.rows.size()), m = stage.bilateral();
    const int springs = static_cast<int>(stage.even.size()), width = nv_ + springs;
    std::vector<int> chosen, vectors;
    std::vector<char> dropped(count, 0);
    std::vector<double> half;
    for (int r = 0; r < count; ++r) {
        if (r >= m) {
            const Mode& mode = stage.modes[(r - m) / 3];
            if ((r - m) % 3 == 2 ? mode.held : !mode.sticking) continue;
        }
        if (stage.null[r]) {
            dropped[r] = 1;
        } else if (is_shared_) {
            chosen.push_back(r);
            vectors.push_back(r < m ? given_.problem->vectors[r] : -1 - r);
            const double* own = row(stage.rows[r]);
            half.insert(half.end(), own, own + nv_);
            mass_.mass().half(half.data() + half.size() - nv_);
            half.insert(half.end(), stage.springs.data() + r * springs,
                        stage.springs.data() + (r + 1) * springs);
        }
    }
    if (!chosen.empty()) {
        const BilateralRows ranked(half.data(), static_cast<int>(chosen.size()), width,
                                   vectors.data());
        for (std::size_t k = ranked.rank(); k < chosen.size(); ++k)
            dropped[chosen[ranked.order()[k]]] = 1;
    }
    for (int r = 0; r < count; ++r) {
        if (!dropped[r]) continue;
        stage.kept[r] = 1;
        const int size = r < m ? 1 : 3, at = r < m ? r : m + 3 * (r - m);
        for (int k = 0; k < size; ++k)
            stage.mix[at + k] = 0.0, stage.own[at + k] = k == (r < m ? 0 : (r - m) % 3) ? 1.0 : 0.0;
    }
    // Springs would take up what redundant rows contradict each other by.
    for (int r : stage.even) stage.kept[r] = 1;
}

// True if v⁺ may depend on how redundant contacts share their load: under Poisson's law e times
// each share comes back, which is e times the resultant without friction and with one e for all.
bool Derivation::is_split_open() const {
    if (law_.law.restitution != Restitution::poisson) return false;
    bool any = false, rubs = false, differ = false;
    double first = -1.0;
    for (int i = 0; i < n_; ++i) {
        if (given_.solution->contact.unique[i]) continue;
        any = any || own_[i].e != 0.0;
        rubs = rubs || own_[i].mu != 0.0;
        if (first < 0.0) first = own_[i].e;
        differ = differ || own_[i].e != first;
    }
    return any && (rubs || differ);
}

// λ and P of a unit impulse along one row of a point that is hit.
std::vector<double> Derivation::unit_impulses(int i, int row) const {
    std::vector<double> found(m_ + 3 * n_, 0.0);
    for (int r = 0; r < m_; ++r) found[r] = free_multipliers_[(3 * i + row) * m_ + r];
    found[m_ + 3 * i + row] = 1.0;
    return found;
}

// Find the wrenches of a stage's impulses and of −M Δv.
void Derivation::find_wrenches(Stage& stage) const {
    const TreeGradient<double, double> tree(*given_.tree);
    const auto add = [&](int change, const double* p, bool first) {
        stage.wrenches.emplace_back(inertias_.size());
        std::vector<Spatial<double>>& to = stage.wrenches.back();
        for (std::size_t k = 1; k < to.size(); ++k) to[k] = -(inertias_[k] * twists_[change][k]);
        const auto add_pair = [&](const FramePairSlopes<double>& m, const double* six) {
            const Spatial<double> f{m.axes * Vec3<double>{six[0], six[1], six[2]},
                                    m.axes * Vec3<double>{six[3], six[4], six[5]}};
            tree.wrench_at(m.first, m.place, f, to);
            tree.wrench_at(m.other, m.other_place, -f, to);
        };
        int pair = 0;
        for (const Held& held : scene_.held) {
            if (held.kind != Held::pair) continue;
            double six[6] = {};
            for (int r = 0; r < held.count; ++r) six[held.select[r]] = p[held.row + r];
            add_pair(held_pairs_[pair++], six);
        }
        for (int i = 0; i < n_; ++i) {
            const double* P = p + m_ + 3 * i;
            const double six[6] = {P[0], P[1], P[2], 0.0, 0.0, 0.0};
            if (!is_stop(i)) add_pair(given_.pairs[i], six);
        }
        for (std::size_t i = 0; i < blow_pairs_.size() && first; ++i)
            add_pair(blow_pairs_[i], given_.impulses + 6 * i);
        tree.sum(to);
    };
    add(stage.change, stage.impulses.data(), stage.first);
    for (int j = 0; j < 3 * static_cast<int>(stage.along.size()); ++j)
        add(stage.units + j, unit_impulses(stage.along[j / 3], j % 3).data(), false);
}

}  // namespace impulsekit
