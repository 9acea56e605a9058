#include "contact/uniqueness.hpp"

#include <algorithm>
#include <cmath>

#include "contact/simultaneous.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"
#include "linalg/pivoted.hpp"

namespace impulsekit {
namespace {

// Contacts with friction whose modes are tried.
constexpr int kMostInSpace = 4, kMostInPlane = 5;
constexpr std::size_t kMostFound = 8;
// Directions of slip of one contact between which answers are looked for.
constexpr int kDirections = 360;

enum class Mode { open, sticking, slipping, slipping_back };

// A linear system that one mode of each contact makes, and its answer as a start or as an answer.
class Search {
  public:
    Search(const ContactProblem& problem, const Law& law, const double* shown)
        : p_(problem),
          law_(law),
          rows_(problem.rows()),
          scope_(scratch()),
          cones_(cones_of(problem)),
          scale_(velocity_scale(problem)),
          shown_(shown, shown + rows_),
          xi_(problem.free, problem.free + rows_) {
        if (law.restitution == Restitution::newton) add_newtons_shift(problem, xi_.data());
        group_.assign(problem.contacts, -1);
        for (int g = 0; g < cones_.groups; ++g) group_[cones_.contact[g]] = g;
        velocities(shown_.data(), after_shown_);
    }

    Uniqueness find() {
        Uniqueness found;
        int rubbing = 0;
        for (int i = 0; i < p_.contacts; ++i) rubbing += group_[i] >= 0;
        if (rubbing == 0) {
            found.verdict = Verdict::smooth;
            return found;
        }
        if (is_weak()) {
            found.verdict = Verdict::weak;
            return found;
        }
        const bool plane = in_plane();
        if (p_.contacts == 1) {
            scan_directions();
            found.verdict = all_tried();
        } else if (plane && p_.contacts <= kMostInPlane) {
            try_modes(4, true);
            found.verdict = all_tried();
        } else if (rubbing <= kMostInSpace && p_.contacts <= kMostInPlane) {
            try_modes(3, false);
            found.verdict = Verdict::searched;
        }
        found.impulses = found_;
        found.works = works_;
        found.gains = gains_;
        return found;
    }

  private:
    // For an expansion with floors one answer is found beside each compression.
    Verdict all_tried() const {
        const bool releases =
            law_.restitution == Restitution::poisson && largest(p_.restitution, p_.contacts) > 0.0;
        return releases ? Verdict::searched : Verdict::all_tried;
    }

    void velocities(const double* P, std::vector<double>& u) const {
        u.resize(rows_);
        multiply(p_.W, rows_, P, p_.free, u.data());
    }

    // µ² |W| |(W⁻¹)_nn| < 1, with contacts scaled so that W_nn = 1, norms of Frobenius.
    bool is_weak() const {
        Arena::Scope scope(scratch());
        const int n = p_.contacts;
        std::vector<double> unit(rows_, 0.0);
        std::vector<int> used;
        double mu = 0.0;
        for (int i = 0; i < n; ++i) {
            mu = std::max(mu, p_.friction[i]);
            double nn = p_.W[(3 * i + 2) * (rows_ + 1)];
            if (!(nn > 0.0)) return false;
            for (int k = group_[i] >= 0 ? 0 : 2; k < 3; ++k) {
                int r = 3 * i + k;
                unit[r] = 1.0 / std::sqrt(nn);
                if (p_.W[r * (rows_ + 1)] > tolerance::immovable * nn) used.push_back(r);
            }
        }
        const int m = static_cast<int>(used.size());
        double *W = scratch().allocate(m, m), *factor = scratch().allocate(m, m);
        double* column = scratch().allocate(m);
        int* order = scratch().allocate_int(m);
        double size = 0.0, inverse = 0.0;
        for (int i = 0; i < m; ++i)
            for (int j = 0; j < m; ++j) {
                double own = unit[used[i]] * p_.W[used[i] * rows_ + used[j]] * unit[used[j]];
                W[i * m + j] = factor[i * m + j] = own;
                size += own * own;
            }
        if (factor_pivoted(factor, m, order, tolerance::dependent) < m) return false;
        for (int j = 0; j < m; ++j) {
            if (used[j] % 3 != 2) continue;
            std::fill(column, column + m, 0.0);
            column[j] = 1.0;
            solve_pivoted(factor, order, m, m, column, scratch());
            for (int i = 0; i < m; ++i)
                if (used[i] % 3 == 2) inverse += column[i] * column[i];
        }
        return mu * mu * std::sqrt(size) * std::sqrt(inverse) < 1.0;
    }

    // True if each contact that rubs has one tangent that moves.
    bool in_plane() const {
        for (int i = 0; i < p_.contacts; ++i) {
            if (group_[i] < 0) continue;
            int moving = 0;
            for (int k = 0; k < 2; ++k) moving += moves(3 * i + k);
            if (moving != 1) return false;
        }
        return true;
    }

    bool moves(int r) const {
        double nn = p_.W[(r - r % 3 + 2) * (rows_ + 1)];
        return p_.W[r * (rows_ + 1)] > tolerance::immovable * nn ||
               std::abs(xi_[r]) > tolerance::at_rest * scale_;
    }

    // Keep an answer that obeys with other velocities, and gains no energy.
    void keep(std::vector<double> P) {
        if (found_.size() >= kMostFound) return;
        double residual = cone_residual(p_.W, rows_, xi_.data(), scale_, cones_, P.data());
        if (!(residual <= tolerance::residual)) return;
        if (law_.restitution == Restitution::poisson) release(P);
        std::vector<double> u, other;
        velocities(P.data(), u);
        auto same = [&](const std::vector<double>& known) {
            double apart = 0.0;
            for (int r = 0; r < rows_; ++r) apart = std::max(apart, std::abs(u[r] - known[r]));
            return apart <= tolerance::same * std::max(scale_, largest(u.data(), rows_));
        };
        if (same(after_shown_)) return;
        for (const std::vector<double>& known : found_) {
            velocities(known.data(), other);
            if (same(other)) return;
        }
        const double* start = law_.restitution == Restitution::newton ? p_.before : p_.free;
        double work = 0.0, size = 0.0;
        for (int r = 0; r < rows_; ++r) {
            double own = 0.5 * P[r] * (start[r] + u[r]);
            work += own;
            size += std::abs(own);
        }
        if (gains_energy(P.data(), start, p_.free, rows_, work, size)) {
            gains_ = true;
            return;
        }
        found_.push_back(P);
        works_.push_back(work);
    }

    // From a compression to the whole impulse of Poisson's law.
    void release(std::vector<double>& P) const {
        const Arena::Scope scope(scratch());
        Cones floors = cones_of(p_);
        bool any = false;
        for (int i = 0; i < p_.contacts; ++i) {
            floors.floor[i] = p_.restitution[i] * P[3 * i + 2];
            any = any || floors.floor[i] > 0.0;
        }
        if (!any) return;
        std::vector<double> middle, back(rows_, 0.0);
        velocities(P.data(), middle);
        solve_cones(p_.W, rows_, middle.data(), scale_, floors, back.data());
        for (int r = 0; r < rows_; ++r) P[r] += back[r];
    }

    // One contact: open, sticking, and slip along s where cross(u_t, s) = 0 and u_t·s > 0, with
    // P_n = −ξ_n/(W_nn − µ W_nt·s): a trigonometric polynomial of second degree in the angle.
    void scan_directions() {
        std::vector<double> P(3, 0.0);
        keep(P);
        try_mode({Mode::sticking}, true);
        const double mu = p_.friction[0];
        const double* W = p_.W;
        auto at = [&](double angle, double* impulse) {
            double s1 = std::cos(angle), s2 = std::sin(angle);
            double q1 = W[2] - mu * (W[0] * s1 + W[1] * s2);
            double q2 = W[5] - mu * (W[3] * s1 + W[4] * s2);
            double qn = W[8] - mu * (W[6] * s1 + W[7] * s2);
            if (impulse) {
                double pn = -xi_[2] / qn;
                impulse[0] = -mu * pn * s1;
                impulse[1] = -mu * pn * s2;
                impulse[2] = pn;
            }
            return (s1 * xi_[1] - s2 * xi_[0]) * qn - xi_[2] * (s1 * q2 - s2 * q1);
        };
        const double step = 2.0 * std::acos(-1.0) / kDirections;
        // Off the axes, where directions of planar problems lie.
        double low = 0.123 * step, value = at(low, nullptr);
        for (int k = 0; k < kDirections; ++k) {
            double high = low + step, next = at(high, nullptr);
            if ((value < 0.0) != (next < 0.0)) {
                double a = low, b = high;
                for (int count = 0; count < 60; ++count) {
                    double middle = 0.5 * (a + b);
                    ((at(middle, nullptr) < 0.0) == (value < 0.0) ? a : b) = middle;
                }
                at(0.5 * (a + b), P.data());
                solve_near(P);
            }
            low = high;
            value = next;
        }
    }

    // Newton's method from P, kept if it is an answer.
    void solve_near(std::vector<double> P) {
        newton_on_cones(p_.W, rows_, xi_.data(), scale_, cones_, P.data());
        keep(P);
    }

    void try_modes(int kinds, bool exact) {
        std::vector<Mode> modes(p_.contacts, Mode::open);
        while (true) {
            try_mode(modes, exact);
            int i = 0;
            for (; i < p_.contacts; ++i) {
                int last = group_[i] >= 0 ? kinds - 1 : 1;
                if (static_cast<int>(modes[i]) < last) {
                    modes[i] = static_cast<Mode>(static_cast<int>(modes[i]) + 1);
                    break;
                }
                modes[i] = Mode::open;
            }
            if (i == p_.contacts) return;
        }
    }

    // The linear system of a mode: ξ = 0 along what is held, friction along the slip.
    void try_mode(const std::vector<Mode>& modes, bool exact) {
        Arena::Scope scope(scratch());
        int *held = scratch().allocate_int(rows_), *pivot = scratch().allocate_int(rows_);
        double* unit_force = scratch().allocate(rows_, rows_);
        int count = 0;
        for (int i = 0; i < p_.contacts; ++i) {
            if (modes[i] == Mode::open) continue;
            double* along = unit_force + count * rows_;
            held[count++] = 3 * i + 2;
            along[3 * i + 2] = 1.0;
            if (group_[i] < 0) continue;
            if (modes[i] == Mode::sticking) {
                for (int k = 0; k < 2; ++k) {
                    if (!moves(3 * i + k)) continue;
                    unit_force[count * rows_ + 3 * i + k] = 1.0;
                    held[count++] = 3 * i + k;
                }
                continue;
            }
            double s[2] = {xi_[3 * i], xi_[3 * i + 1]};
            for (int k = 0; k < 2 && exact; ++k) s[k] = moves(3 * i + k) ? 1.0 : 0.0;
            double length = std::hypot(s[0], s[1]);
            double sign = modes[i] == Mode::slipping ? -1.0 : 1.0;
            for (int k = 0; k < 2 && length > 0.0; ++k)
                along[3 * i + k] = sign * p_.friction[i] * s[k] / length;
        }
        double *A = scratch().allocate(count, count), *x = scratch().allocate(count);
        for (int a = 0; a < count; ++a) {
            x[a] = -xi_[held[a]];
            for (int b = 0; b < count; ++b)
                A[a * count + b] = dot(p_.W + held[a] * rows_, unit_force + b * rows_, rows_);
        }
        if (!factor_lu(A, count, pivot)) return;
        solve_lu(A, pivot, count, x);
        std::vector<double> P(rows_, 0.0);
        for (int b = 0; b < count; ++b)
            for (int r = 0; r < rows_; ++r) P[r] += x[b] * unit_force[b * rows_ + r];
        for (double value : P)
            if (!std::isfinite(value)) return;
        if (exact)
            keep(P);
        else
            solve_near(P);
    }

    const ContactProblem& p_;
    const Law law_;
    const int rows_;
    const Arena::Scope scope_;
    const Cones cones_;
    const double scale_;
    std::vector<double> shown_, xi_, after_shown_;
    std::vector<int> group_;
    std::vector<std::vector<double>> found_;
    std::vector<double> works_;
    bool gains_ = false;
};

}  // namespace

Uniqueness find_others(const ContactProblem& problem, const Law& law, const double* impulse) {
    return Search(problem, law, impulse).find();
}

}  // namespace impulsekit
