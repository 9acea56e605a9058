#include "contact/law_slopes.hpp"

#include <algorithm>
#include <cmath>

#include "contact/lzb.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Differences reach this share of a number: steps of the law leave some 1e-13 of the impulse, and
// its fifth derivative times the fourth power of this is less.
constexpr double kShift = 1e-4;
class Differences {
  public:
    Differences(const ContactProblem& problem, const Law& law)
        : law_(law),
          n_(problem.contacts),
          rows_(3 * n_),
          p_(problem),
          W_(problem.W, problem.W + rows_ * rows_),
          free_(problem.free, problem.free + rows_),
          e_(problem.restitution, problem.restitution + n_),
          mu_(problem.friction, problem.friction + n_) {
        p_.W = W_.data();
        p_.free = p_.before = free_.data();
        p_.restitution = e_.data();
        p_.friction = mu_.data();
    }

    bool find(std::vector<double>& slopes, std::vector<char>& edges) {
        count_ = law_parameters(n_);
        slopes.assign(rows_ * count_, 0.0);
        edges.assign(n_, 0);
        const double speed = largest(free_.data(), rows_);
        int q = 0;
        for (int j = 0; j < rows_; ++j)
            for (int i = 0; i <= j; ++i, ++q) {
                const double size = std::sqrt(W_[i * (rows_ + 1)] * W_[j * (rows_ + 1)]);
                if (uses(i) && uses(j) && size > 0.0)
                    add({&W_[i * rows_ + j], &W_[j * rows_ + i], size, -INFINITY, INFINITY, q,
                         j / 3},
                        slopes, edges);
            }
        for (int i = 0; i < rows_; ++i, ++q)
            if (uses(i))
                add({&free_[i], &free_[i], speed, -INFINITY, INFINITY, q, i / 3}, slopes, edges);
        q += n_;
        for (int i = 0; i < n_; ++i, ++q) add({&e_[i], &e_[i], 1.0, 0.0, 1.0, q, i}, slopes, edges);
        for (int i = 0; i < n_; ++i, ++q)
            add({&mu_[i], &mu_[i], std::max(mu_[i], kShift), 0.0, INFINITY, q, i}, slopes, edges);
        return good_;
    }

  private:
    struct Number {
        double *first, *second;    // the same number, of a matrix in both places
        double size, least, most;  // its scale, and between which it may be
        int column, contact;
    };

    bool uses(int row) const { return row % 3 == 2 || mu_[row / 3] > 0.0; }

    std::vector<double> impulses(const Number& x, double value) {
        const double kept = *x.first;
        *x.first = *x.second = value;
        const ContactSolution found = solve_lzb(p_, law_);
        *x.first = *x.second = kept;
        good_ = good_ && found.status == Status::solved && found.refused.empty();
        return found.impulse;
    }

    // Slopes by differences of one length (central, or from one side), of second order.
    std::vector<double> difference(const Number& x, double h) {
        const double at = *x.first;
        std::vector<double> slope(rows_);
        if (at - h < x.least || at + h > x.most) {
            const double side = at + h > x.most ? -h : h;
            const std::vector<double> here = impulses(x, at), next = impulses(x, at + side),
                                      far = impulses(x, at + 2.0 * side);
            for (int r = 0; r < rows_; ++r)
                slope[r] = (4.0 * next[r] - 3.0 * here[r] - far[r]) / (2.0 * side);
            return slope;
        }
        const std::vector<double> more = impulses(x, at + h), less = impulses(x, at - h);
        for (int r = 0; r < rows_; ++r) slope[r] = (more[r] - less[r]) / (2.0 * h);
        return slope;
    }

    void add(const Number& x, std::vector<double>& slopes, std::vector<char>& edges) {
        const double h = kShift * x.size;
        const std::vector<double> whole = difference(x, h), half = difference(x, 0.5 * h);
        double off = 0.0, most = 0.0;
        for (int r = 0; r < rows_; ++r) {
            off = std::max(off, std::abs(whole[r] - half[r]));
            most = std::max(most, std::abs(half[r]));
            slopes[r * count_ + x.column] = (4.0 * half[r] - whole[r]) / 3.0;
        }
        // A smooth law's differ by the square of the length, at a mode's end by it.
        if (off > kShift * most) edges[x.contact] = 1;
    }

    const Law& law_;
    const int n_, rows_;
    ContactProblem p_;
    std::vector<double> W_, free_, e_, mu_;
    int count_ = 0;
    bool good_ = true;
};

}  // namespace

bool difference_law(const ContactProblem& problem, const Law& law, std::vector<double>& slopes,
                    std::vector<char>& edges) {
    return Differences(problem, law).find(slopes, edges);
}

}  // namespace impulsekit
