// Steps of y = (q, v) by the method of Dormand and Prince of order 8, with dense output, which
// leaves stiff stretches to Radau's of order 5; by that alone; or steps of fixed length of lower
// order.
#pragma once

#include <algorithm>
#include <cmath>
#include <functional>
#include <vector>

namespace impulsekit {

// Steps change by these factors at most, and aim a little below what would do; after so many
// trials, or as short as rounding of the time, there is none.
inline constexpr double kSafety = 0.9, kLeast = 0.2, kMost = 8.0;
inline constexpr int kMostTrials = 60;
inline double shortest_step(double t) { return 1e-15 * std::max(std::abs(t), 1e-3); }

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
    // What a step allows of errors: atol + rtol of how far places move, and of velocities.
    struct Accuracy {
        double rtol = 1e-8, atol = 1e-12;
    };

    Stepper(Method method, int places, int size, Accuracy accuracy, double fixed_length);

    // A step from y, whose rate is known, of at most `longest` [s]; false where none is short
    // enough. `y` and `rate` are then those of the end, unless rates fail there. `settle`: brings
    // y onto its manifold.
    bool step(const Rate& f, const std::function<void(double*)>& settle, double t, double* y,
              double* rate, double longest, Step& found);
    // Behind an event: what was stiff may be no more.
    void restart() { stiff_ = mild_ = 0; }
    // A step of this length whatever its error, to a time within one that was made.
    bool shortened(const Rate& f, const Step& whole, double end, Step& found);

    // The length to try next [s].
    double next = 0.0;
    int steps = 0;

  private:
    bool stages(const Rate& f, double t, const double* y, double h, double* end);
    bool dense(const Rate& f, double t, const double* y, double h, const double* end, Step& found);
    double error(const double* y, const double* end, double h) const;
    void note_stiffness(double h);
    bool implicit(const Rate& f, const std::function<void(double*)>& settle, double t, double* y,
                  double* rate, double longest, Step& found);
    bool collocate(const Rate& f, double t, const double* y, double h, double* Z);
    void differentiate(const Rate& f, double t, const double* y, const double* rate, double* J);
    void keep_cubic(double t, const double* y, double h, const double* Z, Step& found) const;
    bool fixed(const Rate& f, const std::function<void(double*)>& settle, double t, double* y,
               double* rate, double longest, Step& found);

    Method method_;
    int places_, n_;
    Accuracy accuracy_;
    double fixed_length_;
    int stiff_ = 0, mild_ = 0;  // steps whose length stability limits, and others since
    bool implicit_ = false;     // whether the last step was Radau's
    std::vector<double> k_, trial_, end_, J_;
};

}  // namespace impulsekit
