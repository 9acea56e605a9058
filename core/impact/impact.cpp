#include "impact/impact.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "contact/simultaneous.hpp"
#include "contact/tolerances.hpp"
#include "impact/constrained_mass.hpp"
#include "impact/impact_steps.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

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
        steps_.emplace(p_.M, nv_, p_.v, p_.impulse, p_.J, rows_);
        steps_->exclude_untouched(p_.parent, p_.A, m_);
        const bool is_solved = factor_mass() && apply_constraints() && apply_contacts();
        std::copy(steps_->before, steps_->before + rows_, s_.before.begin());
        if (!is_solved) return;
        finish();
        std::copy(steps_->dv, steps_->dv + nv_, s_.dv.begin());
    }

  private:
    bool factor_mass() {
        demand_ = scratch().allocate(m_);
        for (int r = 0; r < m_; ++r) demand_[r] = p_.target[r] - dot(p_.A + r * nv_, p_.v, nv_);
        const bool is_regular =
            mass_.factor(steps_->M, p_.parent, nv_, {m_, p_.A, p_.vectors, p_.wider});
        mass_.fill(demand_, steps_->right);
        if (is_regular) return true;
        s_.failure = ImpactSolution::Failure::singular_mass;
        s_.failed.assign(1, mass_.weak());
        return false;
    }

    // λ that brings the bilateral rows to their targets without contacts.
    bool apply_constraints() {
        steps_->begin(mass_.mass());
        if (m_ == 0) return true;
        s_.nearly_dependent = mass_.rows().nearly_dependent();
        s_.unique = mass_.rows().unique();
        steps_->finish(mass_.mass(), steps_->start);
        const double* speeds = steps_->add_up_speeds();
        const std::vector<double> demand(demand_, demand_ + m_);
        double speed = 0.0;
        for (int r = 0; r < m_; ++r) {
            const double terms = steps_->terms_of(p_.A + r * nv_, speeds);
            speed = std::max(speed, std::abs(demand[r]) + terms * (p_.wider ? p_.wider[r] : 1.0));
        }
        // Demands that dependent rows miss are the inaccuracy of the model, and are left.
        s_.apart = mass_.apply_multipliers(demand_, steps_->start, s_.multipliers.data()).apart;
        if (!(s_.apart > tolerance::contradiction * speed)) return true;
        s_.failure = ImpactSolution::Failure::contradiction;
        for (int r = 0; r < m_; ++r)
            if (std::abs(demand[r] - demand_[r]) > 0.1 * s_.apart) s_.failed.push_back(r);
        return false;
    }

    // P of the contacts in the system that is left when the bilateral rows are eliminated.
    bool apply_contacts() {
        ImpactSteps<double>& steps = *steps_;
        if (rows_ == 0) {
            steps.finish(mass_.mass(), steps.start);
            return true;
        }
        steps.add_contacts(mass_.mass());
        steps.set_free();
        if (m_ > 0) {
            double* left = scratch().allocate(rows_, nv_);
            std::copy(steps.half, steps.half + rows_ * nv_, left);
            project_out_constraints(left);
            steps.set_delassus(left);
        } else {
            steps.set_delassus(steps.half);
        }
        contact_ = p_.contact;
        contact_.W = steps.W;
        contact_.before = steps.before;
        contact_.free = steps.free;
        bool has_answer = solve_law();
        if (!s_.contact.refused.empty()) {
            s_.failure = ImpactSolution::Failure::refused;
            return false;
        }
        const std::vector<double> held = s_.multipliers;
        const auto respond = [&] { set_velocity_change(held); };
        respond();
        steps.refine(&has_answer, [&](int) { return solve_law(); }, respond, [&] { sharpen(); });
        return true;
    }

    // True if the law has an answer.
    bool solve_law() {
        s_.contact = solve_contacts(contact_, p_.law);
        if (!s_.contact.refused.empty()) return false;
        std::copy(s_.contact.impulse.begin(), s_.contact.impulse.end(), steps_->P);
        std::copy(s_.contact.after.begin(), s_.contact.after.end(), steps_->after);
        return s_.contact.status < Status::no_solution;
    }

    // Contact rows less what the bilateral rows hold; what these hold wholly stays as they want.
    void project_out_constraints(double* left) {
        const ImpactSteps<double>& steps = *steps_;
        const std::vector<char> held = mass_.project_out_constraints(steps.half, rows_, left);
        const double bar = mass_.rows().rounding_of_span(), *speeds = steps.add_up_speeds();
        for (int r = 0; r < rows_; ++r) {
            if (!held[r]) continue;
            double speed = 0.0;
            for (int k = r - r % 3; k < r - r % 3 + 3; ++k) {
                const double* row = steps.half + k * nv_;
                double own = steps.terms_of(p_.J + k * nv_, speeds);
                for (int i = 0; i < nv_; ++i) own += std::abs(row[i] * steps.start[i]);
                speed = std::max(speed, own);
            }
            // The sign of rounding must not say that what is held approaches.
            if (std::abs(steps.free[r]) <= bar * speed) steps.free[r] = 0.0;
            if (std::abs(steps.before[r]) <= bar * speed) steps.before[r] = 0.0;
        }
    }

    // Δv of all impulses, with what the bilateral rows bear of the contacts' added to `held`.
    void set_velocity_change(const std::vector<double>& held) {
        Arena::Scope scope(scratch());
        double* change = scratch().allocate(nv_);
        steps_->add_impulses(change);
        s_.multipliers = held;
        mass_.apply_multipliers(demand_, change, s_.multipliers.data());
        steps_->finish(mass_.mass(), change);
    }

    void sharpen() {
        if (mass_.is_filled()) return;
        Arena::Scope scope(scratch());
        double* left = scratch().allocate(nv_);
        add_transposed(p_.A, m_, nv_, s_.multipliers.data(), left);
        steps_->sharpen(mass_.mass(), left);
    }

    // Speeds that rows prescribe, locks of what has no mass, energy and residuals.
    void finish() {
        for (int r = 0; r < m_; ++r)
            if (p_.locks && p_.locks[r] >= 0 && s_.unique[r])
                steps_->dv[p_.locks[r]] = demand_[r] / p_.A[r * nv_ + p_.locks[r]];
        if (mass_.is_filled()) balance_locks();
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
            if (largest(steps_->M + k * nv_, nv_) > 0.0) continue;
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
        const ImpactSteps<double>& steps = *steps_;
        s_.momentum_residual = steps.momentum_residual([&](double* left, double* size) {
            steps.add_sizes(p_.A, m_, nv_, s_.multipliers.data(), left, size);
        });
        const double* speeds = steps.add_up_speeds();
        s_.constraint_residual = m_ > 0 ? constraint_residual(speeds) : 0.0;
        s_.contact_residual =
            std::max(s_.contact.residual, steps.contact_residual(speeds, 3 * p_.contact.contacts));
    }

    // Rows that are held before an impact and after change by the contacts' impulses alone.
    double constraint_residual(const double* speeds) const {
        double off = 0.0, terms = 0.0, *struck = scratch().allocate(nv_);
        add_transposed(steps_->half, rows_, nv_, steps_->P, struck);
        for (int r = 0; r < m_; ++r) {
            const double *row = p_.A + r * nv_, *half = mass_.half() + r * nv_;
            double own = std::abs(p_.target[r]) + steps_->terms_of(row, speeds) +
                         std::abs(dot(half, struck, nv_));
            if (p_.impulse) own += std::abs(dot(half, steps_->blow, nv_));
            off = std::max(off, std::abs(demand_[r] - dot(row, steps_->dv, nv_)));
            terms = std::max(terms, own);
        }
        return terms > 0.0 ? off / terms : 0.0;
    }

    // Contacts aim at velocities of before the constraints act, too: together they may gain energy.
    void judge_energy() {
        if (m_ == 0 || rows_ == 0 || s_.contact.status != Status::solved) return;
        double work = 0.0, size = 0.0, by_blows = 0.0;
        double* blow = scratch().allocate(nv_);
        std::copy(steps_->right, steps_->right + nv_, blow);
        mass_.mass().solve(blow);
        auto add = [&](const double* row, double impulse) {
            double before = dot(row, p_.v, nv_), change = dot(row, steps_->dv, nv_);
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
    ConstrainedMass mass_;
    double* demand_ = nullptr;
    std::optional<ImpactSteps<double>> steps_;
    ContactProblem contact_;
};

}  // namespace

void solve_impact(const ImpactProblem& problem, ImpactSolution& solution) {
    Impact(problem, solution).solve();
}

Status judge(Status contacts, const std::array<double, 3>& residuals, bool nearly_dependent) {
    if (contacts != Status::solved) return contacts;
    // A NaN is large.
    for (double residual : residuals)
        if (!(residual <= tolerance::residual)) return Status::inaccurate;
    return nearly_dependent ? Status::nearly_dependent : Status::solved;
}

Status status_of(const ImpactSolution& s) {
    using Failure = ImpactSolution::Failure;
    if (s.failure == Failure::singular_mass) return Status::singular_mass;
    if (s.failure == Failure::contradiction) return Status::contradiction;
    if (s.failure == Failure::refused) return Status::refused;
    return judge(s.contact.status, {s.momentum_residual, s.constraint_residual, s.contact_residual},
                 s.nearly_dependent);
}

bool is_valid(Status status) {
    return status == Status::solved || status == Status::nearly_dependent;
}

}  // namespace impulsekit
