// Steps of y = (q, v) by methods of orders 4, 5 and 8 with dense output, whichever needs fewest
// evaluations, and of stiff stretches by Radau's of order 5; by Radau's alone; or steps of fixed
// length of lower order.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

#include "integrator/tableau.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit {

// Steps change by these factors at most, and aim a little below what would do; after so many
// trials, or as short as rounding of the time, there is none.
inline constexpr double kSafety = 0.9, kLeast = 0.2, kMost = 8.0;
inline constexpr int kMostTrials = 60;
// Explicit steps are stable up to this h|λ|.
inline constexpr double kStable = 6.1;
inline double shortest_step(double t) { return tolerance::rounding * std::max(std::abs(t), 1e-3); }

// One step, and y within it.
struct Step {
    double start = 0.0, end = 0.0;     // the part that counts [s]
    double begin = 0.0, length = 0.0;  // of the polynomial
    std::vector<double> before;        // (n) y where it begins
    std::vector<double> shape;         // (7, n) its coefficients

    // The whole of a step of length h from y (n) at t, its coefficients still zero.
    void begin_at(double t, double h, const double* y, int n);
    // y (n) at a time.
    void at(double t, double* y) const;
};

enum class Method { dop853, radau, rk4, semi_implicit };

class Stepper {
  public:
    // ẏ (n) at a time; false where there is none.
    using Rate = std::function<bool(double t, const double* y, double* rate)>;
    // Error allowed to a step: atol + rtol of how far places move, and of velocities.
    struct Accuracy {
        double rtol = 1e-8, atol = 1e-12;
        // Radau's estimate is of order 3, its steps of order 5: it may be so much larger.
        double implicit = 1.0;
        // Below this nothing is told apart: forces at rest are known to some 1e-12.
        double noise = 1e-9;
    };

    Stepper(Method method, int places, int size, Accuracy accuracy, double fixed_length);

    // A step from y, whose rate is known, of at most `longest` [s]; false where none is short
    // enough. `y` and `rate` are then those of the end, unless rates fail there. `settle`: brings
    // y onto its manifold, at the end of a step alone, whose rate is then asked for.
    bool step(const Rate& f, const std::function<void(double*)>& project, double t, double* y,
              double* rate, double longest, Step& found);
    // Behind an event: what was stiff may be no more.
    void restart() {
        stiff_ = mild_ = 0;
        keeps_J_ = false;
        fastest_ = 0.0;
        last_ = Step();
    }
    // Behind a jump of rates whose slopes stay: what is fast moves first, and the last step
    // foretells nothing.
    void jump() {
        last_ = Step();
        if (!(next * fastest_ > kStable)) return;
        stiff_ = 0;
        next = kStable / fastest_;
    }
    // True if the polynomial within the last step is as accurate as its end: it is off by up to 1.5
    // times the estimated error, which is next to none where steps may grow by the most.
    bool is_accurate_within() const { return factor_ >= kMost; }
    // A step of this length whatever its error, to a time within one that was made.
    bool shortened(const Rate& f, const Step& whole, double end, Step& found);

    // ∂(rate)/∂y (size, size) at y, where it does not depend on time; else it is found by
    // differences.
    std::function<void(const double* y, double* J)> slopes;
    // The length to try next [s].
    double next = 0.0;
    bool is_stiff = false;  // known to be, without waiting for steps to show it
    int steps = 0;

  private:
    void weigh(const Tableau& m, int stage, const double* y, double h, double* to) const;
    bool stages(const Tableau& m, const Rate& f, const std::function<void(double*)>& project,
                double t, const double* y, double h);
    bool dense(const Tableau& m, const Rate& f, double t, const double* y, double h, Step& found);
    double error(const Tableau& m, const double* y, double h) const;
    double usual(int rung) const;
    int lowest(double longest) const;
    void set_reach(double reach);
    void learn(double h, bool failed);
    bool take(const Tableau& m, double* y, double* rate);
    // The error allowed to an entry that a step changes.
    double allowed(int entry, double before, double after) const {
        const double size = entry < places_ ? std::abs(after - before)
                                            : std::max(std::abs(before), std::abs(after));
        return accuracy_.atol + accuracy_.rtol * size;
    }
    void note_stiffness(double h);
    bool implicit(const Rate& f, const std::function<void(double*)>& project, double t, double* y,
                  double* rate, double longest, Step& found);
    bool collocate(const Rate& f, double t, const double* y, double h, double* Z);
    void differentiate(const Rate& f, double t, const double* y, const double* rate);
    void foresee(double t, double h, double* Z) const;
    void keep_cubic(double t, const double* y, double h, const double* Z, Step& found) const;

    Method method_;
    int places_, n_;
    Accuracy accuracy_;
    double fixed_length_;
    int stiff_ = 0, mild_ = 0;  // steps whose length stability limits, and others since
    bool implicit_ = false;     // whether the last step was Radau's
    double factor_ = 0.0;       // how many times as long it might have been
    int rung_ = 0;              // by which of the methods of rising order it was
    double reach_[3];           // how far steps of each go, of `next`
    bool keeps_J_ = false;      // whether J_ will do for another step
    double fastest_ = 0.0;      // the largest |λ| of J_ [1/s]
    Step last_;                 // the last implicit step
    std::vector<double> k_, trial_, end_, J_, real_;  // real_: γ/h − J_, factored
    std::vector<int> pivot_;
};

}  // namespace impulsekit
