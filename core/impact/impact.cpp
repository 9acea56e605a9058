#include "impact/impact.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "contact/simultaneous.hpp"
#include "contact/tolerances.hpp"
#include "impact/constrained_mass.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// Steps at most by which rounding of large shares is brought down.
constexpr int kRefinements = 3;

// Σ |row_k| (|v_k| + |Δv_k|): the terms that a row's velocities are sums of.
double terms_of(const double* row, const double* v, const double* dv, int nv) {
    double total = 0.0;
    for (int k = 0; k < nv; ++k) total += std::abs(row[k]) * (std::abs(v[k]) + std::abs(dv[k]));
    return total;
}

class Impact {
  public:
    Impact(const ImpactProblem& problem, ImpactSolution& solution)
        : p_(problem),
          s_(solution),
          nv_(problem.nv),
          m_(problem.bilateral),
          rows_(problem.contact.rows()),
          scope_(scratch()) {}

    void solve() {
        s_.failure = ImpactSolution::Failure::none;
        s_.failed.clear();
        s_.nearly_dependent = false;
        s_.dv.assign(nv_, 0.0);
        s_.multipliers.assign(m_, 0.0);
        s_.unique.assign(m_, 1);
        s_.before.assign(rows_, 0.0);
        s_.contact = ContactSolution();
        s_.contact.refused = refusal_of_size(std::max({nv_, m_, rows_}));
        if (!s_.contact.refused.empty()) {
            s_.failure = ImpactSolution::Failure::refused;
            return;
        }
        M_ = scratch().allocate(nv_, nv_);
        for (int i = 0; i < nv_; ++i)
            for (int j = 0; j <= i; ++j) M_[i * nv_ + j] = M_[j * nv_ + i] = p_.M[i * nv_ + j];
        for (int r = 0; r < rows_; ++r) s_.before[r] = dot(p_.J + r * nv_, p_.v, nv_);
        exclude_unloaded();
        if (!factor_mass() || !apply_constraints() || !apply_contacts()) return;
        finish();
    }

  private:
    // Trees that nothing touches stay as they are, whatever their inertia.
    void exclude_unloaded() {
        int* tree = scratch().allocate_int(nv_);
        int* touched = scratch().allocate_int(nv_);
        for (int k = 0; k < nv_; ++k) tree[k] = p_.parent[k] < 0 ? k : tree[p_.parent[k]];
        auto mark = [&](const double* rows, int count) {
            for (int r = 0; r < count; ++r)
                for (int k = 0; k < nv_; ++k)
                    if (rows[r * nv_ + k] != 0.0) touched[tree[k]] = 1;
        };
        mark(p_.A, m_);
        mark(p_.J, rows_);
        if (p_.impulse) mark(p_.impulse, 1);
        for (int i = 0; i < nv_; ++i) {
            if (touched[tree[i]]) continue;
            std::fill(M_ + i * nv_, M_ + (i + 1) * nv_, 0.0);
            M_[i * nv_ + i] = 1.0;
        }
    }

    bool factor_mass() {
        right_ = scratch().allocate(nv_);
        if (p_.impulse) std::copy(p_.impulse, p_.impulse + nv_, right_);
        demand_ = scratch().allocate(m_);
        for (int r = 0; r < m_; ++r) demand_[r] = p_.target[r] - dot(p_.A + r * nv_, p_.v, nv_);
        mass_.emplace(M_, p_.parent, nv_, ConstraintRows{m_, p_.A, p_.vectors, p_.wider});
        mass_->fill(demand_, right_);
        half_ = mass_->half();
        held_ = mass_->rows();
        if (mass_->weak() < 0) return true;
        s_.failure = ImpactSolution::Failure::singular_mass;
        s_.failed.assign(1, mass_->weak());
        return false;
    }

    // λ that brings the bilateral rows to their targets without contacts.
    bool apply_constraints() {
        start_ = scratch().allocate(nv_);
        std::copy(right_, right_ + nv_, start_);
        mass_->mass().half(start_);
        blow_ = scratch().allocate(nv_);
        std::copy(start_, start_ + nv_, blow_);
        if (m_ == 0) return true;
        s_.nearly_dependent = held_->nearly_dependent();
        s_.unique = held_->unique();
        double *target = scratch().allocate(m_), *shortfall = scratch().allocate(m_);
        double* free = scratch().allocate(nv_);
        std::copy(start_, start_ + nv_, free);
        mass_->mass().rest(free);
        double speed = 0.0;
        for (int r = 0; r < m_; ++r) {
            const double* row = half_ + r * nv_;
            target[r] = demand_[r] - dot(row, start_, nv_);
            double terms = terms_of(p_.A + r * nv_, p_.v, free, nv_);
            speed = std::max(speed, std::abs(demand_[r]) + terms * (p_.wider ? p_.wider[r] : 1.0));
        }
        held_->solve(target, s_.multipliers.data(), shortfall);
        double worst = largest(shortfall, m_);
        if (worst > tolerance::contradiction * speed) {
            s_.failure = ImpactSolution::Failure::contradiction;
            s_.apart = worst;
            for (int r = 0; r < m_; ++r)
                if (std::abs(shortfall[r]) > 0.1 * worst) s_.failed.push_back(r);
            return false;
        }
        // The shortfall of dependent rows is the inaccuracy of the model, and is left.
        for (int r = 0; r < m_; ++r) demand_[r] -= shortfall[r];
        add_transposed(half_, m_, nv_, s_.multipliers.data(), start_);
        for (int round = 0; round < kRefinements; ++round) {
            double off = 0.0, size = 0.0;
            for (int r = 0; r < m_; ++r) {
                target[r] = demand_[r] - dot(half_ + r * nv_, start_, nv_);
                off = std::max(off, std::abs(target[r]));
                size = std::max(size, std::abs(demand_[r]));
            }
            if (off <= tolerance::rounding * size) break;
            add_multipliers(target, start_);
        }
        return true;
    }

    // Add to λ what changes the rows' velocities by `wanted`, and to x its half-solved impulse.
    void add_multipliers(const double* target, double* x) {
        Arena::Scope scope(scratch());
        double *more = scratch().allocate(m_), *shortfall = scratch().allocate(m_);
        held_->solve(target, more, shortfall);
        for (int r = 0; r < m_; ++r) s_.multipliers[r] += more[r];
        add_transposed(half_, m_, nv_, more, x);
    }

    // P of the contacts in the system that is left when the bilateral rows are eliminated.
    bool apply_contacts() {
        double* change = scratch().allocate(nv_);
        if (rows_ == 0) {
            std::copy(start_, start_ + nv_, s_.dv.data());
            mass_->mass().rest(s_.dv.data());
            return true;
        }
        half_contacts_ = scratch().allocate(rows_, nv_);
        double *left = scratch().allocate(rows_, nv_), *free = scratch().allocate(rows_);
        std::copy(p_.J, p_.J + rows_ * nv_, half_contacts_);
        for (int r = 0; r < rows_; ++r) mass_->mass().half(half_contacts_ + r * nv_);
        std::copy(half_contacts_, half_contacts_ + rows_ * nv_, left);
        for (int r = 0; r < rows_; ++r)
            free[r] = s_.before[r] + dot(half_contacts_ + r * nv_, start_, nv_);
        project_out_constraints(left, free);
        W_ = scratch().allocate(rows_, rows_);
        for (int i = 0; i < rows_; ++i) {
            poll(i, nv_);
            for (int j = 0; j <= i; ++j)
                W_[i * rows_ + j] = W_[j * rows_ + i] = dot(left + i * nv_, left + j * nv_, nv_);
        }
        ContactProblem contact = p_.contact;
        contact.W = W_;
        contact.before = s_.before.data();
        contact.free = free;
        s_.contact = solve_contacts(contact, p_.law);
        if (!s_.contact.refused.empty()) {
            s_.failure = ImpactSolution::Failure::refused;
            return false;
        }
        std::vector<double> held = s_.multipliers;
        velocity_change(held, change);
        refine(contact, free, held, change);
        return true;
    }

    // Contact rows less what the bilateral rows hold; what these hold wholly stays as they want.
    void project_out_constraints(double* left, double* free) {
        const std::vector<char> held = mass_->project_out_constraints(half_contacts_, rows_, left);
        const double bar = held_ ? held_->rounding_of_span() : 0.0;
        for (int r = 0; r < rows_; ++r) {
            if (!held[r]) continue;
            double speed = 0.0;
            for (int k = r - r % 3; k < r - r % 3 + 3; ++k) {
                const double* row = half_contacts_ + k * nv_;
                double own = terms_of(p_.J + k * nv_, p_.v, s_.dv.data(), nv_);
                for (int i = 0; i < nv_; ++i) own += std::abs(row[i] * start_[i]);
                speed = std::max(speed, own);
            }
            // The sign of rounding must not say that what is held approaches.
            if (std::abs(free[r]) <= bar * speed) free[r] = 0.0;
            if (std::abs(s_.before[r]) <= bar * speed) s_.before[r] = 0.0;
        }
    }

    // Δv of all impulses, with what the bilateral rows bear of the contacts' added to `held`.
    void velocity_change(const std::vector<double>& held, double* change) {
        std::copy(start_, start_ + nv_, change);
        add_transposed(half_contacts_, rows_, nv_, s_.contact.impulse.data(), change);
        s_.multipliers = held;
        if (held_) {
            Arena::Scope scope(scratch());
            double* target = scratch().allocate(m_);
            for (int round = 0; round < kRefinements; ++round) {
                double off = 0.0, size = largest(demand_, m_);
                for (int r = 0; r < m_; ++r) {
                    double own = dot(half_ + r * nv_, change, nv_);
                    target[r] = demand_[r] - own;
                    off = std::max(off, std::abs(target[r]));
                    size = std::max(size, std::abs(own));
                }
                if (off <= tolerance::rounding * size) break;
                add_multipliers(target, change);
            }
        }
        std::copy(change, change + nv_, s_.dv.data());
        mass_->mass().rest(s_.dv.data());
    }

    // If W P has lost digits the law is solved again with the velocities that Δv makes.
    void refine(ContactProblem& contact, double* free, const std::vector<double>& held,
                double* change) {
        double* made = scratch().allocate(rows_);
        for (int round = 0; round < kRefinements; ++round) {
            double off = 0.0, size = 0.0;
            for (int r = 0; r < rows_; ++r) {
                made[r] = s_.before[r] + dot(p_.J + r * nv_, s_.dv.data(), nv_);
                off = std::max(off, std::abs(made[r] - s_.contact.after[r]));
                size = std::max({size, std::abs(made[r]), std::abs(s_.before[r])});
            }
            if (off <= tolerance::refined * size || s_.contact.status >= Status::no_solution) break;
            // What bilateral rows hold wholly no impulse changes: rounding must not say it
            // approaches.
            for (int r = 0; r < rows_; ++r)
                if (W_[r * rows_ + r] > 0.0) free[r] += made[r] - s_.contact.after[r];
            s_.contact = solve_contacts(contact, p_.law);
            velocity_change(held, change);
            sharpen();
        }
    }

    // Δv once more from what M Δv lacks.
    void sharpen() {
        if (mass_->is_filled()) return;
        Arena::Scope scope(scratch());
        double* left = scratch().allocate(nv_);
        if (p_.impulse) std::copy(p_.impulse, p_.impulse + nv_, left);
        add_transposed(p_.A, m_, nv_, s_.multipliers.data(), left);
        add_transposed(p_.J, rows_, nv_, s_.contact.impulse.data(), left);
        for (int i = 0; i < nv_; ++i) left[i] -= dot(M_ + i * nv_, s_.dv.data(), nv_);
        mass_->mass().solve(left);
        for (int i = 0; i < nv_; ++i) s_.dv[i] += left[i];
    }

    // Speeds that rows prescribe, locks of what has no mass, energy and residuals.
    void finish() {
        for (int r = 0; r < m_; ++r)
            if (p_.locks && p_.locks[r] >= 0 && s_.unique[r])
                s_.dv[p_.locks[r]] = demand_[r] / p_.A[r * nv_ + p_.locks[r]];
        if (mass_->is_filled()) balance_locks();
        measure();
        if (p_.law.restitution == Restitution::newton && p_.law.slip == Slip::end &&
            p_.law.order == Order::simultaneous)
            judge_energy();
    }

    // Without mass 0 = I + Aᵀλ + JᵀP says what a lock carries.
    void balance_locks() {
        double* total = scratch().allocate(nv_);
        for (int r = 0; r < m_; ++r) {
            if (!p_.locks || p_.locks[r] < 0 || !s_.unique[r]) continue;
            int k = p_.locks[r];
            if (largest(M_ + k * nv_, nv_) > 0.0) continue;
            std::fill(total, total + nv_, 0.0);
            if (p_.impulse) std::copy(p_.impulse, p_.impulse + nv_, total);
            s_.multipliers[r] = 0.0;
            add_transposed(p_.A, m_, nv_, s_.multipliers.data(), total);
            if (rows_ > 0) add_transposed(p_.J, rows_, nv_, s_.contact.impulse.data(), total);
            s_.multipliers[r] = -total[k] / p_.A[r * nv_ + k];
        }
    }

    // Backward errors of M Δv = I + Aᵀλ + JᵀP, of A v⁺ = b, and of J v⁺ beside the law's u⁺.
    void measure() {
        double *left = scratch().allocate(nv_), *size = scratch().allocate(nv_);
        // For resting bodies that are struck the velocities that the blow alone would make are the
        // measure.
        double twice = p_.impulse ? dot(blow_, blow_, nv_) : 0.0;
        auto blown = [&](const double* half) {
            return p_.impulse ? std::abs(dot(half, blow_, nv_)) : 0.0;
        };
        for (int i = 0; i < nv_; ++i) {
            for (int k = 0; k < nv_; ++k) {
                double own = M_[i * nv_ + k] * s_.dv[k];
                left[i] -= own;
                size[i] += std::abs(own);
            }
            twice -= left[i] * s_.dv[i];
            if (p_.impulse) {
                left[i] += p_.impulse[i];
                size[i] += std::abs(p_.impulse[i]);
            }
        }
        auto add = [&](const double* rows, int count, const double* x) {
            for (int r = 0; r < count; ++r)
                for (int i = 0; i < nv_; ++i) {
                    double own = rows[r * nv_ + i] * x[r];
                    left[i] += own;
                    size[i] += std::abs(own);
                }
        };
        add(p_.A, m_, s_.multipliers.data());
        add(p_.J, rows_, s_.contact.impulse.data());
        s_.momentum_residual = 0.0;
        for (int i = 0; i < nv_; ++i) {
            // With unphysical inertias either may be negative: then they measure nothing.
            double own = size[i] + std::sqrt(std::max(twice * M_[i * nv_ + i], 0.0));
            if (own > 0.0)
                s_.momentum_residual = std::max(s_.momentum_residual, std::abs(left[i]) / own);
        }
        // Rows that are held before an impact and after change by the contacts' impulses alone.
        double off = 0.0, terms = 0.0, *struck = scratch().allocate(nv_);
        if (m_ > 0) add_transposed(half_contacts_, rows_, nv_, s_.contact.impulse.data(), struck);
        for (int r = 0; r < m_; ++r) {
            const double *row = p_.A + r * nv_, *half = half_ + r * nv_;
            off = std::max(off, std::abs(demand_[r] - dot(row, s_.dv.data(), nv_)));
            terms =
                std::max(terms, std::abs(p_.target[r]) + terms_of(row, p_.v, s_.dv.data(), nv_) +
                                    blown(half) + std::abs(dot(half, struck, nv_)));
        }
        s_.constraint_residual = terms > 0.0 ? off / terms : 0.0;
        off = terms = 0.0;
        for (int r = 0; r < 3 * p_.contact.contacts; ++r) {
            const double* row = p_.J + r * nv_;
            double made = s_.before[r] + dot(row, s_.dv.data(), nv_);
            off = std::max(off, std::abs(made - s_.contact.after[r]));
            terms = std::max(
                terms, terms_of(row, p_.v, s_.dv.data(), nv_) + blown(half_contacts_ + r * nv_));
        }
        s_.contact_residual = std::max(s_.contact.residual, terms > 0.0 ? off / terms : 0.0);
    }

    // Contacts aim at velocities of before the constraints act, too: together they may gain energy.
    void judge_energy() {
        if (m_ == 0 || rows_ == 0 || s_.contact.status != Status::solved) return;
        double work = 0.0, size = 0.0, by_blows = 0.0;
        double* blow = scratch().allocate(nv_);
        std::copy(right_, right_ + nv_, blow);
        mass_->mass().solve(blow);
        auto add = [&](const double* row, double impulse) {
            double before = dot(row, p_.v, nv_), change = dot(row, s_.dv.data(), nv_);
            double blown = dot(row, blow, nv_);
            work += impulse * (before + 0.5 * change);
            size += std::abs(impulse) * (std::abs(before) + std::abs(0.5 * change));
            by_blows += 0.5 * impulse * blown;
            if (p_.impulse) size += std::abs(impulse) * std::abs(before + blown);
        };
        for (int r = 0; r < m_; ++r)
            if (p_.passive[r]) add(p_.A + r * nv_, s_.multipliers[r]);
        for (int r = 0; r < rows_; ++r) add(p_.J + r * nv_, s_.contact.impulse[r]);
        if (std::min(work, work + by_blows) > tolerance::gain * size)
            s_.contact.status = Status::energy_gain;
    }

    const ImpactProblem& p_;
    ImpactSolution& s_;
    const int nv_, m_, rows_;
    Arena::Scope scope_;
    std::optional<ConstrainedMass> mass_;
    const BilateralRows* held_ = nullptr;
    const double* half_ = nullptr;
    double *M_ = nullptr, *blow_ = nullptr;
    double *right_ = nullptr, *demand_ = nullptr, *start_ = nullptr;
    double *half_contacts_ = nullptr, *W_ = nullptr;
};

}  // namespace

void solve_impact(const ImpactProblem& problem, ImpactSolution& solution) {
    Impact(problem, solution).solve();
}

Status status_of(const ImpactSolution& s) {
    using Failure = ImpactSolution::Failure;
    if (s.failure == Failure::singular_mass) return Status::singular_mass;
    if (s.failure == Failure::contradiction) return Status::contradiction;
    if (s.failure == Failure::refused) return Status::refused;
    if (s.contact.status != Status::solved) return s.contact.status;
    const double worst = std::max({s.momentum_residual, s.constraint_residual, s.contact_residual});
    if (!(worst <= tolerance::residual)) return Status::inaccurate;
    return s.nearly_dependent ? Status::nearly_dependent : Status::solved;
}

bool is_valid(Status status) {
    return status == Status::solved || status == Status::nearly_dependent;
}

}  // namespace impulsekit
