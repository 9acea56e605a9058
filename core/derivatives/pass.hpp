// One pass backwards through the stages of an impact, for one set of weights or eight side by side.
#pragma once

#include <algorithm>
#include <cmath>

#include "contact/law_slopes.hpp"
#include "derivatives/derivation.hpp"
#include "linalg/dense.hpp"
#include "scene/frame_pair_states.hpp"

namespace impulsekit {

template <typename S>
S inner(const double* a, const S* b, int n) {
    S sum{};
    for (int i = 0; i < n; ++i) sum += a[i] * b[i];
    return sum;
}

template <typename S>
Inertia<S> lifted(const Inertia<double>& a) {
    return {lift<S>(a.mass),
            lift<S>(a.moment),
            {lift<S>(a.about.xx), lift<S>(a.about.xy), lift<S>(a.about.xz), lift<S>(a.about.yy),
             lift<S>(a.about.yz), lift<S>(a.about.zz)}};
}

template <typename S>
void put(const Vec3<S>& a, S* to) {
    to[0] += a.x;
    to[1] += a.y;
    to[2] += a.z;
}

// Weights of v⁺, λ and P in the axes of the points; or of rows' velocities in one stage.
template <typename S>
struct Derivation::Seed {
    const S* after = nullptr;
    const S* multipliers = nullptr;
    const S* impulses = nullptr;  // (contacts, 3) in the world
    int stage = -1;               // the one stage, and its row in each lane
    int rows[Number<S>::lanes] = {};
    bool is_given = false;  // what the rows are given, in place of their velocities
};

template <typename S>
class Derivation::Pass {
  public:
    explicit Pass(const Derivation& of)
        : d_(of),
          p_(*of.given_.problem),
          at_(of.parameters),
          nv_(of.nv_),
          m_(of.m_),
          n_(of.n_),
          rows_(m_ + 3 * n_),
          gradient_(*of.given_.tree),
          met_(of.velocities_.size()) {}

    void run(const Seed<S>& seed, S* slopes) {
        begin(slopes);
        int last = static_cast<int>(d_.stages_.size()) - 1;
        if (seed.stage >= 0)
            last = seed.stage;
        else
            add_seed(seed);
        for (int k = last; k >= 0; --k) pass(d_.stages_[k], k == seed.stage ? &seed : nullptr);
        finish();
    }

  private:
    void begin(S* slopes) {
        slopes_ = slopes;
        std::fill(slopes, slopes + d_.slopes(), S{});
        gradient_.begin();
        end_.assign(nv_, S{});
        before_.assign(nv_, S{});
        e_.assign(n_, S{});
        share_.assign(n_, S{});
        P_.assign(3 * n_, S{});
        lambda_.assign(m_, S{});
        rho_.assign(met_.size() * rows_, S{});
        contacts_.assign(n_, {});
        held_.assign(d_.held_pairs_.size(), {});
        blows_.assign(d_.blow_pairs_.size(), {});
        for (Met& met : met_) {
            met.is_used = false;
            met.wrench.clear();
        }
    }

    static void add(S& x, int lane, double more) {
        Number<S>::set(x, lane, Number<S>::get(x, lane) + more);
    }

    void add_seed(const Seed<S>& seed) {
        if (seed.after) std::copy(seed.after, seed.after + nv_, end_.begin());
        if (seed.multipliers) std::copy(seed.multipliers, seed.multipliers + m_, lambda_.begin());
        for (int i = 0; i < n_ && seed.impulses; ++i) {
            const int entry = d_.given_.entries[i];
            const S* w = seed.impulses + 3 * entry;
            if (d_.is_stop(i)) {
                P_[3 * i + 2] = w[0] * d_.row(m_ + 3 * i + 2)[d_.scene_.contacts[entry].v];
                continue;
            }
            const FramePairSlopes<double>& m = d_.given_.pairs[i];
            const Vec3<S> weight{w[0], w[1], w[2]}, own = back(lift<S>(m.axes), weight);
            put(own, P_.data() + 3 * i);
            // The axes turn, and the impulse in them.
            const double* P = d_.given_.solution->contact.impulse.data() + 3 * i;
            const Vec3<double> all = m.axes * Vec3<double>{P[0], P[1], P[2]};
            contacts_[i].alone += cross(lift<S>(all), weight);
        }
    }

    // Weights of what a stage leaves become those of what it begins with.
    void pass(const Stage& stage, const Seed<S>* seed) {
        const int count = static_cast<int>(stage.rows.size()), m = stage.bilateral();
        y_.assign(count, S{});
        x_ = end_;
        for (int k = 0; seed && !seed->is_given && k < Number<S>::lanes; ++k) {
            const double* own = d_.row(stage.rows[seed->rows[k]]);
            for (int i = 0; i < nv_; ++i) add(x_[i], k, own[i]);
        }
        for (int r = 0; r < count; ++r)
            y_[r] = inner(d_.response_.data() + stage.rows[r] * nv_, x_.data(), nv_);
        for (int r = 0; r < m; ++r) y_[r] += lambda_[r];
        for (std::size_t c = 0; c < stage.carrying.size(); ++c)
            for (int k = 0; k < 3; ++k) {
                const int i = stage.carrying[c];
                y_[m + 3 * c + k] += P_[3 * i + k];
                if (k == 2) y_[m + 3 * c + k] += share_[i];
            }
        std::fill(share_.begin(), share_.end(), S{});
        for (int r = 0; r < count; ++r) y_[r] *= stage.scale[r];
        solve_lu(stage.factors.data(), stage.pivots.data(), count, y_.data());
        for (int r = 0; r < count; ++r) y_[r] *= stage.scale[r];
        directly(stage, m);
        mix(stage, m);
        for (int k = 0; seed && seed->is_given && k < Number<S>::lanes; ++k)
            add(g_[seed->rows[k]], k, 1.0);
        for (int r = 0; r < count; ++r) {
            const double* own = d_.row(stage.rows[r]);
            for (int i = 0; i < nv_; ++i)
                if (own[i] != 0.0) x_[i] -= own[i] * g_[r];
        }
        if (seed && seed->is_given) {
            // Only the velocity that is given, not its effects.
            std::fill(x_.begin(), x_.end(), S{});
        } else {
            d_.mass_.mass().solve(x_.data());
        }
        if (d_.mass_.is_filled())
            for (int r = 0; r < m; ++r)
                g_[r] += inner(d_.filling_.data() + r * nv_, x_.data(), nv_);
        for (int r = 0; r < count; ++r) add_row(stage, r);
        if (!stage.along.empty()) follow_law(stage);
        couple(stage.change, x_, stage.impulses.data(), stage.wrenches[0], stage.first);
    }

    // Add the slopes of the impulses themselves by µ and e.
    void directly(const Stage& stage, int m) {
        for (std::size_t c = 0; c < stage.carrying.size(); ++c) {
            const int i = stage.carrying[c], entry = d_.given_.entries[i];
            const Mode& mode = stage.modes[c];
            const S* s = y_.data() + m + 3 * c;
            if (!mode.sticking)
                slopes_[at_.friction + entry] -=
                    (mode.slip[0] * s[0] + mode.slip[1] * s[1]) * mode.normal;
            if (!mode.held) continue;
            e_[i] += mode.compressed * s[2];
            share_[i] += d_.own_[i].e * s[2];
        }
    }

    // g = Φᵀ s.
    void mix(const Stage& stage, int m) {
        g_.assign(y_.size(), S{});
        for (int r = 0; r < m; ++r) g_[r] = stage.mix[r] * y_[r];
        for (std::size_t c = 0; c < stage.carrying.size(); ++c)
            for (int r = 0; r < 3; ++r)
                for (int k = 0; k < 3; ++k)
                    g_[m + 3 * c + k] += stage.mix[m + 9 * c + 3 * r + k] * y_[m + 3 * c + r];
    }

    // Add the demand of a row on the velocities: G end = κ G start.
    void add_row(const Stage& stage, int r) {
        const int of = stage.rows[r], m = stage.bilateral();
        const double kappa = stage.kappa[r];
        const double* own = d_.row(of);
        add_demand(stage.end, of, -g_[r]);
        if (kappa != 0.0) add_demand(stage.start, of, kappa * g_[r]);
        if (kappa != 1.0)
            for (int i = 0; i < nv_; ++i)
                if (own[i] != 0.0) end_[i] += (kappa - 1.0) * own[i] * g_[r];
        if (r < m || (r - m) % 3 != 2) return;
        const double start = dot(own, d_.velocities_[stage.start].data(), nv_);
        const bool newton = d_.law_.law.restitution == Restitution::newton;
        if (newton && start < 0.0) e_[stage.carrying[(r - m) / 3]] -= start * g_[r];
    }

    // Add ρ G v of one row to the form that is differentiated.
    void add_demand(int velocity, int row, const S& rho) {
        rho_[velocity * rows_ + row] += rho;
        met_[velocity].is_used = true;
    }

    // P of contacts by their W, their velocities and their coefficients.
    void follow_law(const Stage& stage) {
        const int points = static_cast<int>(stage.along.size()), rows = 3 * points,
                  count = law_parameters(points), block = rows * (rows + 1) / 2;
        const auto row_of = [&](int r) { return 3 * stage.along[r / 3] + r % 3; };
        std::vector<S> g(count, S{});
        for (int r = 0; r < rows; ++r) {
            const S P = P_[row_of(r)] + inner(d_.row(m_ + row_of(r)), x_.data(), nv_);
            for (int k = 0; k < count; ++k) g[k] += stage.law[r * count + k] * P;
        }
        const S *by_free = g.data() + block, *by_start = by_free + rows, *by_e = by_start + points,
                *by_mu = by_e + points;
        for (int a = 0; a < points; ++a) {
            const int i = stage.along[a];
            if (!stage.from_start) {
                add_demand(0, m_ + 3 * i + 2, by_start[a]);
                add_scaled(before_, d_.row(m_ + 3 * i + 2), by_start[a]);
            }
            e_[i] += by_e[a];
            slopes_[at_.friction + d_.given_.entries[i]] += by_mu[a];
        }
        for (int r = 0; r < rows; ++r) {
            S own = by_free[r];
            if (stage.from_start && r % 3 == 2) own += by_start[r / 3];
            add_demand(stage.start, m_ + row_of(r), own);
            add_scaled(end_, d_.row(m_ + row_of(r)), own);
        }
        follow_mobility(stage, g.data());
    }

    // ∂W_ij = x_iᵀ ∂(J_jᵀ + Aᵀλ_j − M x_j) + ∂(J_i x_j) + λ_iᵀ ∂(A x_j), x_j and λ_j what a unit
    // impulse along row j does; g by the entries of W.
    void follow_mobility(const Stage& stage, const S* g) {
        const int rows = 3 * static_cast<int>(stage.along.size());
        for (int j = 0; j < rows; ++j) {
            std::vector<S> x(nv_, S{});
            for (int i = 0; i <= j; ++i, ++g) {
                const int row = 3 * stage.along[i / 3] + i % 3;
                add_scaled(x, d_.velocities_[stage.units + i].data(), *g);
                add_demand(stage.units + j, m_ + row, *g);
                for (int r = 0; r < m_; ++r)
                    add_demand(stage.units + j, r, d_.free_multipliers_[row * m_ + r] * *g);
            }
            const std::vector<double> impulses = d_.unit_impulses(stage.along[j / 3], j % 3);
            couple(stage.units + j, x, impulses.data(), stage.wrenches[1 + j], false);
        }
    }

    void add_scaled(std::vector<S>& to, const double* row, const S& by) const {
        for (int j = 0; j < nv_; ++j) to[j] += row[j] * by;
    }

    struct Met {
        bool is_used = false;            // by weights of rows
        std::vector<Spatial<S>> wrench;  // that meets its twists
    };

    std::vector<Spatial<S>>& wrench_of(int velocity) {
        std::vector<Spatial<S>>& own = met_[velocity].wrench;
        if (own.empty()) own.resize(d_.inertias_.size());
        return own;
    }

    // Add xᵀ (Gᵀ p + blows − M c), c one of the velocities; `wrenches` are those of p and −M c.
    void couple(int c, const std::vector<S>& x, const double* p,
                const std::vector<Spatial<double>>& wrenches, bool first) {
        std::vector<Spatial<S>>& momentum = wrench_of(c);
        gradient_.move(x.data(), twist_);
        for (std::size_t k = 1; k < twist_.size(); ++k)
            momentum[k] = momentum[k] - lifted<S>(d_.inertias_[k]) * twist_[k];
        by_masses(d_.twists_[c]);
        add_pairs(p, twist_, nullptr);
        if (first) add_blows(x.data());
        gradient_.add_parents(x.data(), twist_, wrenches);
    }

    // Impulses or weights of all rows meet twists; their wrenches are added where they are asked
    // for.
    template <typename T, typename P>
    void add_pairs(const P* p, const std::vector<Spatial<T>>& twist,
                   std::vector<Spatial<S>>* wrench) {
        int pair = 0;
        for (const Held& held : d_.scene_.held) {
            if (held.kind != Held::pair) continue;
            S six[6] = {};
            for (int r = 0; r < held.count; ++r) six[held.select[r]] = lift<S>(p[held.row + r]);
            add_pair(d_.held_pairs_[pair], six, twist, wrench, held_[pair]);
            ++pair;
        }
        for (int i = 0; i < n_; ++i) {
            if (d_.is_stop(i)) continue;
            S six[6] = {};
            for (int k = 0; k < 3; ++k) six[k] = lift<S>(p[m_ + 3 * i + k]);
            add_pair(d_.given_.pairs[i], six, twist, wrench, contacts_[i]);
        }
    }

    using PairGradient = typename TreeGradient<double, S>::PairGradient;

    template <typename T>
    void add_pair(const FramePairSlopes<double>& m, const S* six,
                  const std::vector<Spatial<T>>& twist, std::vector<Spatial<S>>* wrench,
                  PairGradient& pair_gradient) {
        const Mat3<S> axes = lift<S>(m.axes);
        const Spatial<S> f{axes * Vec3<S>{six[0], six[1], six[2]},
                           axes * Vec3<S>{six[3], six[4], six[5]}};
        gradient_.add_form(m, f, twist, pair_gradient);
        if (!wrench) return;
        gradient_.wrench_at(m.first, m.place, f, *wrench);
        gradient_.wrench_at(m.other, m.other_place, -f, *wrench);
    }

    // Known impulses: their numbers, and their points.
    void add_blows(const S* x) {
        for (std::size_t i = 0; i < blows_.size(); ++i) {
            const FramePairSlopes<double>& m = d_.blow_pairs_[i];
            S p[6];
            for (int k = 0; k < 6; ++k) p[k] = lift<S>(d_.given_.impulses[6 * i + k]);
            add_pair(m, p, twist_, nullptr, blows_[i]);
            const Spatial<S> u = gradient_.relative_twist(m, twist_);
            put(back(lift<S>(m.axes), u.linear), slopes_ + at_.impulses + 6 * i);
            put(back(lift<S>(m.axes), u.angular), slopes_ + at_.impulses + 6 * i + 3);
        }
        for (std::size_t i = 0; i < d_.scene_.kicks.size(); ++i)
            slopes_[at_.impulses + 6 * blows_.size() + i] += x[d_.scene_.kicks[i]];
    }

    // By factors on masses, and by the ten numbers of one body's inertia in its joint's axes.
    void by_masses(const std::vector<Spatial<double>>& changes) {
        const Tree<double>& tree = *d_.given_.tree;
        for (std::size_t i = 0; i < d_.scene_.loads.size(); ++i) {
            const Load& load = d_.scene_.loads[i];
            const int k = load.body;
            const Inertia<S> own = lifted<S>(tree.in_world(k, inertia_of<double>(load)));
            slopes_[at_.masses + i] -= dot(twist_[k], own * lift<S>(changes[k]));
        }
        const int k = d_.given_.inertia_of;
        if (k < 0) return;
        const Mat3<S> joint =
            lift<S>(tree.rotation[k] * transposed(mat3<double>(tree.model.bodies[k].turn)));
        const Spatial<S> change = lift<S>(changes[k]);
        const Vec3<S> a = back(joint, twist_[k].linear), w = back(joint, twist_[k].angular),
                      c = back(joint, change.linear), o = back(joint, change.angular);
        const Vec3<S> h = cross(a, o) + cross(c, w);
        const S all[10] = {dot(a, c),
                           h.x,
                           h.y,
                           h.z,
                           w.x * o.x,
                           w.x * o.y + w.y * o.x,
                           w.y * o.y,
                           w.x * o.z + w.z * o.x,
                           w.y * o.z + w.z * o.y,
                           w.z * o.z};
        for (int j = 0; j < 10; ++j) slopes_[at_.count + j] -= all[j];
    }

    // By e as it changes with the approach, then all that the configuration turns and moves.
    void finish() {
        for (int i = 0; i < n_; ++i) {
            const int entry = d_.given_.entries[i], normal = m_ + 3 * i + 2;
            slopes_[at_.restitution + entry] += e_[i];
            if (d_.own_[i].slope == 0.0) continue;
            add_demand(0, normal, -d_.own_[i].slope * e_[i]);
            for (int j = 0; j < nv_; ++j) end_[j] -= d_.own_[i].slope * d_.row(normal)[j] * e_[i];
        }
        for (int i = 0; i < nv_; ++i) slopes_[at_.v + i] += end_[i] + before_[i];
        for (std::size_t t = 0; t < met_.size(); ++t) {
            if (!met_[t].is_used && met_[t].wrench.empty()) continue;
            std::vector<Spatial<S>>& wrench = wrench_of(static_cast<int>(t));
            if (met_[t].is_used) add_pairs(rho_.data() + t * rows_, d_.twists_[t], &wrench);
            gradient_.sum(wrench);
            gradient_.add_parents(d_.velocities_[t].data(), d_.twists_[t], wrench);
        }
        carry();
        gradient_.finish(slopes_ + at_.q);
    }

    void carry() {
        const Tree<double>& tree = *d_.given_.tree;
        const auto frame = [&](const Site& site) {
            return lift<S>(tree.rotation[site.body] * mat3<double>(site.axes));
        };
        for (std::size_t i = 0; i < held_.size(); ++i)
            gradient_.distribute(d_.held_pairs_[i], held_[i]);
        for (std::size_t i = 0; i < blows_.size(); ++i) {
            gradient_.distribute(d_.blow_pairs_[i], blows_[i]);
            put(back(frame(d_.scene_.blows[i].site), blows_[i].pull),
                slopes_ + at_.blow_points + 3 * i);
        }
        for (int i = 0; i < n_; ++i) {
            if (d_.is_stop(i)) continue;
            const int entry = d_.given_.entries[i];
            const FramePairSlopes<double>& m = d_.given_.pairs[i];
            const Contact& contact = d_.scene_.contacts[entry];
            gradient_.distribute(m, contacts_[i]);
            if (contact.kind != Contact::point) continue;
            put(back(frame(contact.frames.first), contacts_[i].pull),
                slopes_ + at_.points + 3 * entry);
            const Vec3<S> by_normal =
                cross(contacts_[i].torque + contacts_[i].alone, lift<S>(m.axes.z));
            put(m.carrier == Carrier::world ? by_normal
                                            : back(frame(contact.frames.other), by_normal),
                slopes_ + at_.normals + 3 * entry);
        }
    }

    const Derivation& d_;
    const ImpactProblem& p_;
    const Parameters& at_;
    const int nv_, m_, n_, rows_;
    TreeGradient<double, S> gradient_;
    S* slopes_ = nullptr;
    std::vector<S> end_, before_, e_, share_, P_, lambda_, rho_;
    std::vector<Met> met_;
    std::vector<PairGradient> contacts_, held_, blows_;
    std::vector<S> x_, y_, g_;
    std::vector<Spatial<S>> twist_;
};

}  // namespace impulsekit
