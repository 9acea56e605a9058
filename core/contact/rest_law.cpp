#include "contact/rest_law.hpp"

#include <algorithm>
#include <cmath>

#include "contact/cones.hpp"
#include "contact/islands.hpp"
#include "contact/tolerances.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

constexpr int kRefinements = 6;
// The least share of a load, which the steps of refinement still bring to its place.
constexpr double kLeastShare = 1e-2;
// Rounds in which points are let go or pressed again before the search over cones.
constexpr int kRounds = 4;
// Rounds in which points with loads find shares that all of them hold, and how much of what it is
// asked for too much a point gives way.
constexpr int kShares = 10;
constexpr double kGives = 0.7;

class RestLaw {
  public:
    RestLaw(const RestProblem& p, char* pressed, double* F, double* a)
        : p_(p), pressed_(pressed), F_(F), a_(a), rows_(p.rows()), scope_(scratch()) {
        C_ = scratch().allocate(rows_ * rows_);
        unit_ = scratch().allocate(rows_);
        used_ = scratch().allocate_int(rows_);
        force_ = scratch().allocate(rows_);
        couple();
    }

    bool solve() {
        // Moments are none where bodies do not turn without them: with moments a face that slides
        // on several points could share its load in many ways, each with another yaw.
        if (p_.turning > 0 && search_held(false)) return true;
        if (search_held(true)) return true;
        // Redundant points with loads that were asked for too much give way to the others.
        for (int round = 0; round < kShares && give_way(); ++round)
            if (solve_held() && obeys()) return true;
        return search();
    }

    void write_slopes(double* slopes) {
        turning_ = true;
        Arena::Scope scope(scratch());
        std::fill(slopes, slopes + rows_ * rows_, 0.0);
        double *A = nullptr, *soft = nullptr;
        int* pivot = nullptr;
        if (!factor_held(A, soft, pivot)) return;
        double* x = scratch().allocate(count_);
        for (int j = 0; j < count_; ++j) {
            std::fill(x, x + count_, 0.0);
            x[j] = -unit_[used_[j]];
            solve_lu(soft, pivot, count_, x);
            std::fill(force_, force_ + rows_, 0.0);
            for (int i = 0; i < count_; ++i) force_[used_[i]] = unit_[used_[i]] * x[i];
            finish();
            for (int r = 0; r < rows_; ++r) slopes[r * rows_ + used_[j]] = F_[r];
        }
    }

  private:
    // Smaller shares of points with loads beyond what they hold; false where none is.
    bool give_way() {
        bool any = false;
        for (int i = 0; i < p_.points; ++i) {
            if (!is_loaded(i) || !holds(i)) continue;
            const double most = p_.reach[i] * p_.load[i],
                         size = std::hypot(F_[3 * i], F_[3 * i + 1]);
            if (!(size > most)) continue;
            for (int j = 0; j < 2; ++j) unit_[3 * i + j] *= kGives * most / size;
            any = true;
        }
        return any;
    }
    double load_of(int i) const { return is_loaded(i) ? p_.load[i] : F_[normal(i)]; }
    bool search_held(bool turning) {
        turning_ = turning;
        for (int round = 0; round < kRounds; ++round) {
            if (!solve_held()) break;
            if (obeys()) return true;
            if (!changed_) break;
        }
        return false;
    }

    int normal(int i) const { return 3 * i + 2; }
    bool is_loaded(int i) const { return p_.load && !std::isnan(p_.load[i]); }
    int turn_row(int k) const { return 3 * (p_.points + k); }
    bool moves(int k) const { return p_.direction[2 * k] != 0.0 || p_.direction[2 * k + 1] != 0.0; }
    bool holds(int k) const { return p_.reach[k] > 0.0 && !moves(k); }

    // W with the friction of what slides in the columns of its normal forces; scales.
    void couple() {
        std::copy(p_.W, p_.W + rows_ * rows_, C_);
        const auto add = [&](int to, int from, double share) {
            if (share == 0.0) return;
            for (int r = 0; r < rows_; ++r) C_[r * rows_ + to] += share * p_.W[r * rows_ + from];
        };
        for (int i = 0; i < p_.points; ++i)
            for (int j = 0; j < 2 && !is_loaded(i); ++j)
                add(normal(i), 3 * i + j, -p_.reach[i] * p_.direction[2 * i + j]);
        for (int k = 0; k < p_.turning; ++k) {
            const int n = normal(p_.turning_of[k]), roll = p_.points + 2 * k, spin = roll + 1;
            for (int j = 0; j < 2; ++j)
                add(n, turn_row(k) + j, -p_.reach[roll] * p_.direction[2 * roll + j]);
            add(n, turn_row(k) + 2, -p_.reach[spin] * p_.direction[2 * spin]);
        }
        double most = 0.0;
        for (int r = 0; r < rows_; ++r) most = std::max(most, p_.W[r * rows_ + r]);
        for (int r = 0; r < rows_; ++r) {
            const double own = p_.W[r * rows_ + r];
            unit_[r] = own > tolerance::immovable * most ? 1.0 / std::sqrt(own) : 0.0;
            scale_ = std::max(scale_, unit_[r] * std::abs(p_.b[r]));
        }
        share_loads();
    }

    // Redundant points with loads share in proportion to what their friction holds.
    void share_loads() {
        double strongest = 0.0;
        for (int i = 0; i < p_.points; ++i)
            if (is_loaded(i)) strongest = std::max(strongest, p_.reach[i] * p_.load[i]);
        for (int i = 0; i < p_.points && strongest > 0.0; ++i)
            for (int j = 0; j < 2 && is_loaded(i); ++j)
                unit_[3 * i + j] *=
                    std::sqrt(std::max(p_.reach[i] * p_.load[i] / strongest, kLeastShare));
    }

    // The rows of all that is pressed and of what holds, and their matrix, factored.
    bool factor_held(double*& A, double*& soft, int*& pivot) {
        count_ = 0;
        const auto use = [&](int r) {
            if (unit_[r] > 0.0) used_[count_++] = r;
        };
        for (int i = 0; i < p_.points; ++i) {
            if (!pressed_[i]) continue;
            if (!is_loaded(i)) use(normal(i));
            if (holds(i)) use(3 * i), use(3 * i + 1);
        }
        for (int k = 0; k < p_.turning && turning_; ++k) {
            if (!pressed_[p_.turning_of[k]]) continue;
            if (holds(p_.points + 2 * k)) use(turn_row(k)), use(turn_row(k) + 1);
            if (holds(p_.points + 2 * k + 1)) use(turn_row(k) + 2);
        }
        for (int j = 0; j < p_.joints; ++j)
            if (p_.bound[j] > 0.0) use(3 * (p_.points + p_.turning) + j);
        const int m = count_;
        A = scratch().allocate(m * m);
        soft = scratch().allocate(m * m);
        pivot = scratch().allocate_int(m);
        for (int i = 0; i < m; ++i) {
            for (int j = 0; j < m; ++j)
                A[i * m + j] = unit_[used_[i]] * C_[used_[i] * rows_ + used_[j]] * unit_[used_[j]];
            std::copy(A + i * m, A + (i + 1) * m, soft + i * m);
            soft[i * m + i] += tolerance::compliance;
        }
        return m == 0 || factor_lu(soft, m, pivot);
    }

    // All that is pressed keeps still, and what holds holds.
    bool solve_held() {
        Arena::Scope scope(scratch());
        double *A = nullptr, *soft = nullptr;
        int* pivot = nullptr;
        if (!factor_held(A, soft, pivot)) return false;
        const int m = count_;
        double *x = scratch().allocate(m), *left = scratch().allocate(m);
        double off = 0.0;
        for (int step = 0; step <= kRefinements; ++step) {
            off = 0.0;
            for (int i = 0; i < m; ++i) {
                left[i] = -unit_[used_[i]] * p_.b[used_[i]] - dot(A + i * m, x, m);
                off = std::max(off, std::abs(left[i]));
            }
            if (off <= tolerance::rounding * scale_ || step == kRefinements) break;
            solve_lu(soft, pivot, m, left);
            for (int i = 0; i < m; ++i) x[i] += left[i];
        }
        std::fill(force_, force_ + rows_, 0.0);
        for (int i = 0; i < m; ++i) force_[used_[i]] = unit_[used_[i]] * x[i];
        finish();
        return off <= tolerance::residual * scale_;
    }

    // F with the friction of what slides, and a.
    void finish() {
        std::copy(force_, force_ + rows_, F_);
        for (int i = 0; i < p_.points; ++i)
            for (int j = 0; j < 2; ++j)
                F_[3 * i + j] -= p_.reach[i] * p_.direction[2 * i + j] * force_[normal(i)];
        for (int k = 0; k < p_.turning; ++k) {
            const double load = force_[normal(p_.turning_of[k])];
            const int roll = p_.points + 2 * k, spin = roll + 1;
            for (int j = 0; j < 2; ++j)
                F_[turn_row(k) + j] -= p_.reach[roll] * p_.direction[2 * roll + j] * load;
            F_[turn_row(k) + 2] -= p_.reach[spin] * p_.direction[2 * spin] * load;
        }
        for (int r = 0; r < rows_; ++r) a_[r] = p_.b[r] + dot(p_.W + r * rows_, F_, rows_);
    }

    // True if the forces found push and stay within their cones. Else load what would be pressed
    // in and lets go of what would pull.
    bool obeys() {
        double most = 0.0;
        for (int r = 0; r < rows_; ++r)
            if (unit_[r] > 0.0) most = std::max(most, std::abs(F_[r]) / unit_[r]);
        const double least = tolerance::handed_on * std::max(most, scale_);
        bool good = true;
        changed_ = false;
        for (int i = 0; i < p_.points; ++i) {
            const int n = normal(i);
            if (is_loaded(i)) continue;
            if (!(unit_[n] > 0.0)) {
                pressed_[i] = 0;
                continue;
            }
            if (pressed_[i] && F_[n] / unit_[n] < -least) {
                pressed_[i] = 0;
                changed_ = true;
                good = false;
            } else if (!pressed_[i] && unit_[n] * a_[n] < -least) {
                pressed_[i] = 1;
                changed_ = true;
                good = false;
            }
        }
        const auto within = [&](int r, int size, double radius) {
            const double length = size == 1 ? std::abs(F_[r]) : std::hypot(F_[r], F_[r + 1]);
            const double unit = unit_[r] > 0.0 ? unit_[r] : 1.0;
            return length / unit <= radius / unit + least;
        };
        bool held = true;
        for (int i = 0; i < p_.points; ++i)
            if (pressed_[i] && holds(i)) held = held && within(3 * i, 2, p_.reach[i] * load_of(i));
        for (int k = 0; k < p_.turning; ++k) {
            const double load = F_[normal(p_.turning_of[k])];
            const int roll = p_.points + 2 * k;
            if (!pressed_[p_.turning_of[k]]) continue;
            for (int j = 0; j < 3 && !turning_; ++j) {
                const int r = turn_row(k) + j;
                if (holds(j < 2 ? roll : roll + 1))
                    held = held &&
                           unit_[r] * std::abs(a_[r]) <= tolerance::alike * std::max(most, scale_);
            }
            if (holds(roll)) held = held && within(turn_row(k), 2, p_.reach[roll] * load);
            if (holds(roll + 1))
                held = held && within(turn_row(k) + 2, 1, p_.reach[roll + 1] * load);
        }
        for (int j = 0; j < p_.joints; ++j)
            held = held && within(3 * (p_.points + p_.turning) + j, 1, p_.bound[j]);
        if (!held) changed_ = false;
        return good && held;
    }

    // The search over all cones.
    bool search() {
        const Arena::Scope scope(scratch());
        Cones cones(p_.points, p_.points + 2 * p_.turning + p_.joints, scratch());
        std::vector<int> own(p_.points, -1);
        for (int i = 0; i < p_.points; ++i) {
            if (is_loaded(i)) continue;
            own[i] = cones.contacts;
            cones.add_contact(normal(i), 0.0, 0.0);
        }
        const auto add = [&](int k, int row, int size, int contact, double reach) {
            if (k < 0 || holds(k)) cones.add_group(row, size, contact, reach);
        };
        for (int i = 0; i < p_.points; ++i)
            add(i, 3 * i, 2, own[i], p_.reach[i] * (is_loaded(i) ? p_.load[i] : 1.0));
        for (int k = 0; k < p_.turning; ++k) {
            const int roll = p_.points + 2 * k;
            add(roll, turn_row(k), 2, own[p_.turning_of[k]], p_.reach[roll]);
            add(roll + 1, turn_row(k) + 2, 1, own[p_.turning_of[k]], p_.reach[roll + 1]);
        }
        for (int j = 0; j < p_.joints; ++j)
            add(-1, 3 * (p_.points + p_.turning) + j, 1, -1, p_.bound[j]);
        cones.mobility = p_.W;
        double scale = 0.0;
        for (int r = 0; r < rows_; ++r) scale = std::max(scale, std::abs(p_.b[r]));
        const ConeSolution found = solve_cones(C_, rows_, p_.b, scale, cones, force_);
        finish();
        for (int i = 0; i < p_.points; ++i)
            if (!is_loaded(i)) pressed_[i] = force_[normal(i)] > 0.0;
        return found.residual <= tolerance::residual && !found.immovable;
    }

    const RestProblem& p_;
    char* pressed_;
    double *F_, *a_;
    int rows_, count_ = 0;
    Arena::Scope scope_;
    double *C_, *unit_, *force_;
    int* used_;
    double scale_ = 0.0;
    bool changed_ = false, turning_ = true;
};

// The rows and points of one island obey by themselves.
bool solve_island(const RestIsland& island, char* pressed, double* F, double* a) {
    Arena& arena = scratch();
    const int rows = island.problem.rows(), points = island.problem.points;
    double *own_F = arena.allocate(rows), *own_a = arena.allocate(rows);
    char* own_pressed = arena.allocate_of<char>(points);
    for (int i = 0; i < points; ++i) own_pressed[i] = pressed[island.points[i]];
    const bool obeys = RestLaw(island.problem, own_pressed, own_F, own_a).solve();
    for (int r = 0; r < rows; ++r) F[island.rows[r]] = own_F[r], a[island.rows[r]] = own_a[r];
    for (int i = 0; i < points; ++i) pressed[island.points[i]] = own_pressed[i];
    return obeys;
}

}  // namespace

bool solve_rest(const RestProblem& problem, char* pressed, double* F, double* a) {
    Arena::Scope scope(scratch());
    const int rows = problem.rows(), points = problem.points;
    int *island = scratch().allocate_int(rows), *owner = scratch().allocate_int(rows);
    for (int r = 0; r < rows; ++r) owner[r] = r < 3 * points ? r / 3 : r;
    for (int r = 0; r < 3 * problem.turning; ++r) owner[3 * points + r] = problem.turning_of[r / 3];
    const int count = find_islands(problem.W, rows, owner, island);
    if (count == 1) return RestLaw(problem, pressed, F, a).solve();
    bool obey = true;
    for (int i = 0; i < count; ++i) {
        Arena::Scope one(scratch());
        obey = solve_island(RestIsland(problem, island, i), pressed, F, a) && obey;
    }
    return obey;
}

void rest_slopes(const RestProblem& problem, char* pressed, double* slopes) {
    Arena::Scope scope(scratch());
    const int rows = problem.rows();
    RestLaw(problem, pressed, scratch().allocate(rows), scratch().allocate(rows))
        .write_slopes(slopes);
}

}  // namespace impulsekit
