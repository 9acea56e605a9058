#include "contact/friction.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

constexpr int kSteps = 60;

// The problem in units in which ellipses are circles.
class EllipticTransform {
  public:
    explicit EllipticTransform(const ContactProblem& problem)
        : given_(problem), own_(problem), rows_(problem.rows()), axes_(rows_ * rows_, 0.0) {
        for (int r = 0; r < rows_; ++r) axes_[r * rows_ + r] = 1.0;
        bool any = false;
        for (int i = 0; i < problem.contacts; ++i) {
            const Friction& f = problem.models[i];
            if (f.kind != Friction::Kind::elliptic) continue;
            any = true;
            double* top = axes_.data() + 3 * i * rows_ + 3 * i;
            top[0] = f.axis[0] * f.first;
            top[1] = -f.axis[1] * f.second;
            top[rows_] = f.axis[1] * f.first;
            top[rows_ + 1] = f.axis[0] * f.second;
        }
        if (!any) return;
        W_.assign(rows_ * rows_, 0.0);
        std::vector<double> half(rows_ * rows_, 0.0);
        for (int i = 0; i < rows_; ++i)
            for (int k = 0; k < rows_; ++k)
                for (int j = 0; j < rows_; ++j)
                    half[i * rows_ + j] += problem.W[i * rows_ + k] * axes_[k * rows_ + j];
        for (int i = 0; i < rows_; ++i)
            for (int k = 0; k < rows_; ++k)
                for (int j = 0; j < rows_; ++j)
                    W_[i * rows_ + j] += axes_[k * rows_ + i] * half[k * rows_ + j];
        to_circle_units(problem.before, before_);
        to_circle_units(problem.free, free_);
        own_.W = W_.data();
        own_.before = before_.data();
        own_.free = free_.data();
    }

    const ContactProblem& with_friction(const std::vector<double>& mu) {
        own_.friction = mu.data();
        return own_;
    }

    // The slip speed of a loaded contact in the end, in its own units; 0 for rounding.
    double slip(const ContactSolution& found, int i) const {
        // A contact that adheres rubs while it is pulled, too.
        double pressed = found.impulse[3 * i + 2] + (own_.adhesion ? own_.adhesion[i] : 0.0);
        if (!(pressed > 0.0)) return 0.0;
        double fastest = std::max({largest(own_.before, rows_), largest(own_.free, rows_),
                                   largest(found.after.data(), rows_)});
        double speed = std::hypot(found.after[3 * i], found.after[3 * i + 1]);
        return speed > tolerance::at_rest * fastest ? speed : 0.0;
    }

    // The solution in the units of the problem.
    ContactSolution back(ContactSolution found, const std::vector<double>& mu) const {
        std::vector<double> impulse(rows_, 0.0);
        for (int i = 0; i < rows_; ++i)
            impulse[i] = dot(axes_.data() + i * rows_, found.impulse.data(), rows_);
        found.friction = mu;
        for (int i = 0; i < given_.contacts; ++i) {
            // The µ of the direction in which friction acts.
            double size = std::hypot(found.impulse[3 * i], found.impulse[3 * i + 1]);
            if (size > 0.0)
                found.friction[i] *= std::hypot(impulse[3 * i], impulse[3 * i + 1]) / size;
        }
        found.impulse = impulse;
        multiply(given_.W, rows_, impulse.data(), given_.free, found.after.data());
        const double* start = found.start.data();
        bool from_free = std::equal(start, start + rows_, own_.free);
        found.start.assign(from_free ? given_.free : given_.before,
                           (from_free ? given_.free : given_.before) + rows_);
        return found;
    }

  private:
    void to_circle_units(const double* velocity, std::vector<double>& turned) const {
        turned.assign(rows_, 0.0);
        for (int k = 0; k < rows_; ++k)
            for (int j = 0; j < rows_; ++j) turned[j] += axes_[k * rows_ + j] * velocity[k];
    }

    const ContactProblem& given_;
    ContactProblem own_;
    const int rows_;
    std::vector<double> axes_, W_, before_, free_;
};

bool obeys(const ContactSolution& found) {
    return found.status == Status::solved || found.status == Status::energy_gain;
}

// The solution in which µ = f(|u_t⁺|) at each contact of `smooth` (Broyden's method, from the
// fixed-point iteration).
ContactSolution solve_by_speed(EllipticTransform& transform, const ContactProblem& problem,
                               const std::vector<int>& smooth, std::vector<double>& mu,
                               const std::function<ContactSolution(const ContactProblem&)>& solve) {
    ContactSolution found = solve(transform.with_friction(mu));
    const int count = static_cast<int>(smooth.size());
    if (count == 0) return found;
    auto residual_of_mu = [&] {
        std::vector<double> left(count);
        for (int k = 0; k < count; ++k)
            left[k] = problem.models[smooth[k]].at_speed(transform.slip(found, smooth[k])) -
                      mu[smooth[k]];
        return left;
    };
    auto bar = [&](double share) { return share * (1.0 + largest(mu.data(), problem.contacts)); };
    std::vector<double> left = residual_of_mu(), inverse(count * count, 0.0), step(count),
                        change(count);
    for (int k = 0; k < count; ++k) inverse[k * count + k] = 1.0;
    for (int round = 0; round < kSteps; ++round) {
        if (!obeys(found) || largest(left.data(), count) <= bar(tolerance::solved)) break;
        for (int k = 0; k < count; ++k) {
            step[k] = dot(inverse.data() + k * count, left.data(), count);
            double next = std::max(mu[smooth[k]] + step[k], 0.0);
            change[k] = next - mu[smooth[k]];
            mu[smooth[k]] = next;
        }
        found = solve(transform.with_friction(mu));
        std::vector<double> now = residual_of_mu(), across(count, 0.0), along(count, 0.0);
        // inverse −= (moved + inverse change)(movedᵀ inverse)/(movedᵀ inverse change)
        double size = 0.0;
        for (int k = 0; k < count; ++k)
            for (int j = 0; j < count; ++j) {
                across[k] += inverse[k * count + j] * (now[j] - left[j]);
                along[j] += change[k] * inverse[k * count + j];
            }
        for (int j = 0; j < count; ++j) size += along[j] * (now[j] - left[j]);
        if (size != 0.0)
            for (int k = 0; k < count; ++k)
                for (int j = 0; j < count; ++j)
                    inverse[k * count + j] -= (change[k] + across[k]) * along[j] / size;
        left = now;
    }
    double off = largest(left.data(), count);
    if (off > bar(tolerance::residual)) found.status = Status::not_converged;
    found.residual = std::max(found.residual, off / bar(1.0));
    return found;
}

}  // namespace

ContactSolution solve_with_friction_models(
    const ContactProblem& problem, const Law&,
    const std::function<ContactSolution(const ContactProblem&)>& solve) {
    EllipticTransform transform(problem);
    std::vector<double> mu(problem.contacts);
    std::vector<int> smooth, steps;
    for (int i = 0; i < problem.contacts; ++i) {
        const Friction& f = problem.models[i];
        using Kind = Friction::Kind;
        mu[i] = f.kind == Kind::elliptic   ? 1.0
                : f.kind == Kind::by_speed ? f.at_speed(0.0)
                                           : f.first;
        if (f.kind == Kind::by_speed) smooth.push_back(i);
        if (f.kind == Kind::static_kinetic) steps.push_back(i);
    }
    ContactSolution found;
    while (true) {
        found = solve_by_speed(transform, problem, smooth, mu, solve);
        if (!obeys(found)) break;
        bool more = false;
        for (int& i : steps) {
            if (i < 0 || !(transform.slip(found, i) > 0.0)) continue;
            mu[i] = problem.models[i].second;
            i = -1;
            more = true;
        }
        if (!more) break;
    }
    return transform.back(found, mu);
}

}  // namespace impulsekit
