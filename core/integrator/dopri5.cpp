// Steps of order 5 by the pair of Dormand and Prince (Hairer, Norsett & Wanner 1993, table II.5.2),
// for steps that are cut short by what lies ahead: a third of the work of order 8, and the last
// rate is that of the end.
#include <algorithm>
#include <cmath>

#include "integrator/stepper.hpp"

namespace impulsekit {
namespace {

constexpr int kStages = 7;
constexpr double kPlaces[kStages] = {0.0, 1.0 / 5, 3.0 / 10, 4.0 / 5, 8.0 / 9, 1.0, 1.0};
constexpr double kWeights[kStages][6] = {
    {},
    {1.0 / 5},
    {3.0 / 40, 9.0 / 40},
    {44.0 / 45, -56.0 / 15, 32.0 / 9},
    {19372.0 / 6561, -25360.0 / 2187, 64448.0 / 6561, -212.0 / 729},
    {9017.0 / 3168, -355.0 / 33, 46732.0 / 5247, 49.0 / 176, -5103.0 / 18656},
    {35.0 / 384, 0.0, 500.0 / 1113, 125.0 / 192, -2187.0 / 6784, 11.0 / 84}};
constexpr double kError[kStages] = {71.0 / 57600,        0.0,        -71.0 / 16695, 71.0 / 1920,
                                    -17253.0 / 339200.0, 22.0 / 525, -1.0 / 40};
constexpr double kDense[kStages] = {-12715105075.0 / 11282082432.0,  0.0,
                                    87487479700.0 / 32700410799.0,   -10690763975.0 / 1880347072.0,
                                    701980252875.0 / 199316789632.0, -1453857185.0 / 822651844.0,
                                    69997945.0 / 29380423.0};

}  // namespace

// A step of length h from y, whose rate stands in k_, to end_; its error over what is allowed.
double Stepper::dopri5(const Rate& f, const std::function<void(double*)>& project, double t,
                       const double* y, double h, Step& found) {
    for (int s = 1; s < kStages; ++s) {
        double* to = s == kStages - 1 ? end_.data() : trial_.data();
        for (int j = 0; j < n_; ++j) {
            double sum = 0.0;
            for (int i = 0; i < s; ++i) sum += kWeights[s][i] * k_[i * n_ + j];
            to[j] = y[j] + h * sum;
        }
        if (s == kStages - 1) project(to);
        if (!f(t + kPlaces[s] * h, to, k_.data() + s * n_)) return INFINITY;
    }
    found.begin_at(t, h, y, n_);
    double* shape = found.shape.data();
    const double *first = k_.data(), *last = first + (kStages - 1) * n_;
    double size = 0.0;
    for (int j = 0; j < n_; ++j) {
        const double change = end_[j] - y[j];
        double off = 0.0, bend = 0.0;
        for (int i = 0; i < kStages; ++i) {
            off += kError[i] * k_[i * n_ + j];
            bend += kDense[i] * k_[i * n_ + j];
        }
        const double part = h * off / allowed(j, y[j], end_[j]);
        size += part * part / n_;
        shape[j] = change;
        shape[n_ + j] = h * first[j] - change;
        shape[2 * n_ + j] = 2.0 * change - h * (last[j] + first[j]);
        shape[3 * n_ + j] = h * bend;
    }
    return std::sqrt(size);
}

}  // namespace impulsekit
