#include "contact/sequence.hpp"

#include <algorithm>
#include <cmath>

#include "contact/path.hpp"
#include "contact/simultaneous.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

constexpr int kMostHits = 10000;
// After so many hits a steady ratio is looked for, and again each time there are half as many more.
constexpr int kLong = 100;
// Speeds that grow by this factor have no end.
constexpr double kEndless = 1e30;

class Sequence {
  public:
    Sequence(const ContactProblem& problem, const Law& law)
        : problem_(problem),
          law_(law),
          n_(problem.contacts),
          rows_(3 * problem.contacts),
          scale_(velocity_scale(problem)) {
        for (int r = 0; r < rows_; ++r) lightest_ = std::max(lightest_, problem.W[r * (rows_ + 1)]);
        solution_.impulse.assign(rows_, 0.0);
        solution_.after.assign(problem.free, problem.free + rows_);
        solution_.start = solution_.after;
        solution_.normal_work.assign(n_, 0.0);
        solution_.friction_work.assign(n_, 0.0);
        solution_.unique.assign(n_, 1);
    }

    ContactSolution solve(std::vector<Hit>* kept) {
        int next_check = kLong;
        for (int count = 0;; ++count) {
            solution_.iterations = count;
            poll(rows_, rows_);
            int found = fastest();
            if (found < 0) break;
            if (!moves(found)) {
                // No impulse stops what approaches here.
                solution_.status = Status::no_solution;
                break;
            }
            double pace = pace_of(found);
            if (count < n_) first_ = std::max(first_, pace);
            if (pace <= tolerance::solved * first_) break;
            if (count >= kMostHits || pace > kEndless * first_) {
                solution_.status = Status::not_converged;
                break;
            }
            found = foremost(found, pace);
            if (!hit(found)) break;
            if (kept) kept->push_back(hits_.back());
            if (count == next_check) {
                next_check += next_check / 2;
                jump();
            }
        }
        finish();
        return solution_;
    }

  private:
    double mobility(int i) const { return problem_.W[(3 * i + 2) * (rows_ + 1)]; }
    double approach(int i) const { return -solution_.after[3 * i + 2]; }

    bool moves(int i) const { return mobility(i) > tolerance::immovable * lightest_; }

    double pace_of(int i) const {
        double nn = mobility(i);
        return moves(i) ? std::abs(solution_.after[3 * i + 2]) / std::sqrt(nn) : INFINITY;
    }

    // The terms that a row of u_free + W P is the sum of.
    double terms(int r) const {
        double total = std::abs(problem_.free[r]);
        for (int k = 0; k < rows_; ++k)
            total += std::abs(problem_.W[r * rows_ + k] * solution_.impulse[k]);
        return total;
    }

    int fastest() const {
        int found = -1;
        double most = 0.0;
        for (int i = 0; i < n_; ++i) {
            const double rounded = tolerance::rounding * rows_ * std::max(terms(3 * i + 2), scale_);
            if (!(approach(i) > rounded)) continue;
            if (!moves(i) && approach(i) <= tolerance::at_rest * scale_) continue;
            double pace = pace_of(i);
            if (pace > most) {
                found = i;
                most = pace;
            }
        }
        return found;
    }

    // Among equally fast contacts the one of most friction, restitution, sideways motion:
    // what no unit, axis or order of entries changes. Where all are alike it is the first, and
    // tied.
    int foremost(int found, double pace) {
        int best = -1;
        bool tied = false;
        double known[5] = {};
        for (int i = 0; i < n_; ++i) {
            if (!(approach(i) > 0.0) || !moves(i)) continue;
            if (std::abs(pace_of(i) - pace) > tolerance::handed_on * pace) continue;
            double own[5];
            traits(i, own);
            double apart = best < 0 ? 1.0 : 0.0;
            for (int k = 0; k < 5 && best >= 0 && apart == 0.0; ++k)
                if (std::abs(own[k] - known[k]) > tolerance::alike * (own[k] + known[k]))
                    apart = own[k] - known[k];
            if (apart > 0.0) {
                best = i;
                tied = false;
                std::copy(own, own + 5, known);
            } else if (apart == 0.0) {
                tied = true;
            }
        }
        solution_.tied = solution_.tied || tied;
        return best < 0 ? found : best;
    }

    void traits(int i, double* own) const {
        const double* W = problem_.W;
        int t = 3 * i, s = t + 1, n = t + 2;
        double nn = mobility(i);
        own[0] = problem_.friction[i];
        own[1] = problem_.restitution[i];
        own[2] = std::hypot(W[n * rows_ + t], W[n * rows_ + s]) / nn;
        own[3] = (W[t * rows_ + t] + W[s * rows_ + s]) / nn;
        own[4] = std::hypot(solution_.after[t], solution_.after[s]) / approach(i);
    }

    // One contact's impulse from the velocities as they are; whether the sequence goes on.
    bool hit(int i) {
        double W[9], u[3];
        for (int k = 0; k < 3; ++k) {
            u[k] = solution_.after[3 * i + k];
            for (int j = 0; j < 3; ++j) W[3 * k + j] = problem_.W[(3 * i + k) * rows_ + 3 * i + j];
        }
        double impulse[3], normal, friction, residual;
        Status status;
        if (law_.slip == Slip::path) {
            PathImpact found = follow_path(W, u[2], u, problem_.restitution[i],
                                           problem_.friction[i], law_.restitution);
            std::copy(found.impulse, found.impulse + 3, impulse);
            normal = found.normal_work;
            friction = found.friction_work;
            residual = found.residual;
            status = found.status;
        } else {
            ContactProblem one;
            one.contacts = 1;
            one.W = W;
            one.before = one.free = u;
            one.restitution = problem_.restitution + i;
            one.friction = problem_.friction + i;
            one.tangential = problem_.tangential + i;
            ContactSolution found = solve_simultaneous(one, law_);
            std::copy(found.impulse.begin(), found.impulse.end(), impulse);
            normal = found.normal_work[0];
            friction = found.friction_work[0];
            residual = found.residual;
            status = found.status;
            solution_.unique[i] &= found.unique[0];
        }
        for (int k = 0; k < 3; ++k) {
            size_ += std::abs(impulse[k] * u[k]);
            solution_.impulse[3 * i + k] += impulse[k];
        }
        size_ += std::abs(normal) + std::abs(friction);
        solution_.normal_work[i] += normal;
        solution_.friction_work[i] += friction;
        solution_.residual = std::max(solution_.residual, residual);
        hits_.push_back({i, {impulse[0], impulse[1], impulse[2]}, normal, friction});
        // From what moved last: sums of all impulses would hide ever smaller hits in rounding.
        for (int r = 0; r < rows_; ++r)
            solution_.after[r] += dot(problem_.W + r * rows_ + 3 * i, impulse, 3);
        if (status == Status::solved || status == Status::energy_gain) return true;
        solution_.status = status;
        return false;
    }

    // After how many hits the same contacts follow each other again, three times over; or 0.
    int period() const {
        const int count = static_cast<int>(hits_.size());
        for (int p = 1; p <= 6 * n_ && 3 * p <= count; ++p) {
            bool same = true;
            for (int k = 1; k <= 2 * p && same; ++k)
                same = hits_[count - k].contact == hits_[count - k - p].contact;
            if (same) return p;
        }
        return 0;
    }

    // What the works of contacts (2 n: along normals, of friction) in the last two periods go on to
    // add: those of a velocity that stays fall with r, those of what falls itself with r².
    void add_works(const std::vector<double>& before, const std::vector<double>& last,
                   double ratio) {
        const double square = ratio * ratio;
        for (int k = 0; k < 2 * n_; ++k) {
            const double falling = (last[k] - ratio * before[k]) / (square - ratio),
                         staying = before[k] - falling,
                         more = staying * square / (1.0 - ratio) +
                                falling * square * square / (1.0 - square);
            (k % 2 == 0 ? solution_.normal_work : solution_.friction_work)[k / 2] += more;
        }
    }

    // Sum a series of steady ratio: impulses of the last period, times r/(1 − r). What the sum is
    // off, later hits answer.
    void jump() {
        const int p = period(), count = static_cast<int>(hits_.size());
        if (p == 0) return;
        std::vector<double> last(rows_, 0.0), before(rows_, 0.0);
        std::vector<double> last_works(2 * n_, 0.0), works_before(2 * n_, 0.0);
        for (int k = 1; k <= 2 * p; ++k) {
            const Hit& own = hits_[count - k];
            double* sum = k <= p ? last.data() : before.data();
            for (int j = 0; j < 3; ++j) sum[3 * own.contact + j] += own.impulse[j];
            double* works = (k <= p ? last_works : works_before).data() + 2 * own.contact;
            works[0] += own.normal_work;
            works[1] += own.friction_work;
        }
        double ratio =
            dot(last.data(), before.data(), rows_) / dot(before.data(), before.data(), rows_);
        if (!(ratio > 0.0 && ratio < 1.0 - tolerance::alike)) return;
        double off = 0.0;
        for (int r = 0; r < rows_; ++r) off = std::max(off, std::abs(last[r] - ratio * before[r]));
        double left = 1.0 - ratio;
        if (off / (left * left) > tolerance::handed_on * largest(solution_.impulse.data(), rows_))
            return;
        add_works(works_before, last_works, ratio);
        for (int r = 0; r < rows_; ++r) {
            last[r] *= ratio / left;
            solution_.impulse[r] += last[r];
        }
        for (int r = 0; r < rows_; ++r)
            solution_.after[r] += dot(problem_.W + r * rows_, last.data(), rows_);
        hits_.clear();
    }

    void finish() {
        multiply(problem_.W, rows_, solution_.impulse.data(), problem_.free,
                 solution_.after.data());
        double work = 0.0;
        for (int i = 0; i < n_; ++i) work += solution_.normal_work[i] + solution_.friction_work[i];
        if (solution_.status == Status::solved && work > tolerance::gain * size_)
            solution_.status = Status::energy_gain;
    }

    const ContactProblem& problem_;
    const Law law_;
    const int n_, rows_;
    const double scale_;
    ContactSolution solution_;
    std::vector<Hit> hits_;
    double first_ = 0.0, size_ = 0.0, lightest_ = 0.0;  // of the lightest the mobility
};

}  // namespace

ContactSolution solve_sequence(const ContactProblem& problem, const Law& law,
                               std::vector<Hit>* hits) {
    return Sequence(problem, law).solve(hits);
}

}  // namespace impulsekit
