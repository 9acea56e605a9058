#include "integrator/stepper.hpp"

#include <algorithm>
#include <cmath>

#include "integrator/dop853.hpp"

namespace impulsekit {
namespace {

// After so many steps as long as stability lets them be the motion is stiff, and so many shorter
// ones forget them (Hairer, Norsett & Wanner 1993, section II.10).
constexpr int kStiff = 15, kMild = 6;
// Steps of order 5 go as far as this part of those of order 8, unless it was found otherwise; by so
// much more after each of these.
constexpr double kReach = 0.3, kForget = 1.5;

}  // namespace

void Step::begin_at(double t, double h, const double* y, int n) {
    start = begin = t;
    end = t + h;
    length = h;
    before.assign(y, y + n);
    shape.assign(7 * n, 0.0);
}

void Step::at(double t, double* y) const {
    const std::size_t n = before.size();
    const double x = length > 0.0 ? (t - begin) / length : 0.0;
    std::fill(y, y + n, 0.0);
    for (int i = 6; i >= 0; --i) {
        const double* own = shape.data() + i * n;
        const double by = i % 2 == 0 ? x : 1.0 - x;
        for (std::size_t j = 0; j < n; ++j) y[j] = (y[j] + own[j]) * by;
    }
    for (std::size_t j = 0; j < n; ++j) y[j] += before[j];
}

Stepper::Stepper(Method method, int places, int size, Accuracy accuracy, double fixed_length)
    : method_(method),
      places_(places),
      n_(size),
      accuracy_(accuracy),
      fixed_length_(fixed_length),
      k_(dop853::all_stages * size),
      trial_(size),
      end_(size) {}

// All stages from the first, which stands in k_, to the end.
bool Stepper::stages(const Rate& f, double t, const double* y, double h, double* end) {
    namespace d = dop853;
    for (int s = 1; s < d::stages; ++s) {
        for (int j = 0; j < n_; ++j) {
            double sum = 0.0;
            for (int i = 0; i < s; ++i) sum += d::a[s][i] * k_[i * n_ + j];
            trial_[j] = y[j] + h * sum;
        }
        if (!f(t + d::c[s] * h, trial_.data(), k_.data() + s * n_)) return false;
    }
    for (int j = 0; j < n_; ++j) {
        double sum = 0.0;
        for (int i = 0; i < d::stages; ++i) sum += d::b[i] * k_[i * n_ + j];
        end[j] = y[j] + h * sum;
    }
    return true;
}

// The error of a step whose stages and rate at the end stand in k_.
bool Stepper::dense(const Rate& f, double t, const double* y, double h, const double* end,
                    Step& found) {
    namespace d = dop853;
    for (int s = d::stages + 1; s < d::all_stages; ++s) {
        for (int j = 0; j < n_; ++j) {
            double sum = 0.0;
            for (int i = 0; i < s; ++i) sum += d::a[s][i] * k_[i * n_ + j];
            trial_[j] = y[j] + h * sum;
        }
        if (!f(t + d::c[s] * h, trial_.data(), k_.data() + s * n_)) return false;
    }
    found.begin_at(t, h, y, n_);
    double* shape = found.shape.data();
    const double *first = k_.data(), *last = k_.data() + d::stages * n_;
    for (int j = 0; j < n_; ++j) {
        const double change = end[j] - y[j];
        shape[j] = change;
        shape[n_ + j] = h * first[j] - change;
        shape[2 * n_ + j] = 2.0 * change - h * (last[j] + first[j]);
        for (int r = 0; r < 4; ++r) {
            double sum = 0.0;
            for (int i = 0; i < d::all_stages; ++i) sum += d::dense[r][i] * k_[i * n_ + j];
            shape[(3 + r) * n_ + j] = h * sum;
        }
    }
    return true;
}

// The error of a step over what is allowed (Hairer, Norsett & Wanner 1993, eq. (II.10.17)).
double Stepper::error(const double* y, const double* end, double h) const {
    namespace d = dop853;
    double five = 0.0, three = 0.0;
    for (int j = 0; j < n_; ++j) {
        const double scale = allowed(j, y[j], end[j]);
        double e5 = 0.0, e3 = 0.0;
        for (int i = 0; i <= d::stages; ++i) {
            e5 += d::error5[i] * k_[i * n_ + j];
            e3 += d::error3[i] * k_[i * n_ + j];
        }
        five += e5 * e5 / (scale * scale);
        three += e3 * e3 / (scale * scale);
    }
    // Squares of rounding may vanish. A NaN stays one: no step with it is taken.
    const double both = (five + 0.01 * three) * n_;
    return both == 0.0 ? 0.0 : std::abs(h) * five / std::sqrt(both);
}

// From the last stage, whose y stands in trial_, beside the end of the step.
void Stepper::note_stiffness(double h) {
    const double *last = k_.data() + dop853::stages * n_, *stage = last - n_;
    double rates = 0.0, places = 0.0;
    for (int j = 0; j < n_; ++j) {
        rates += (last[j] - stage[j]) * (last[j] - stage[j]);
        places += (end_[j] - trial_[j]) * (end_[j] - trial_[j]);
    }
    if (h * h * rates > kStable * kStable * places)
        ++stiff_, mild_ = 0;
    else if (++mild_ == kMild)
        stiff_ = 0;
}

bool Stepper::step(const Rate& f, const std::function<void(double*)>& project, double t, double* y,
                   double* rate, double longest, Step& found) {
    implicit_ = method_ == Method::radau || stiff_ >= kStiff;
    is_dopri5_ = false;
    if (implicit_) return implicit(f, project, t, y, rate, longest, found);
    if (method_ != Method::dop853) return fixed(f, project, t, y, rate, longest, found);
    std::copy(rate, rate + n_, k_.begin());
    double h = std::min(next, longest);
    // The rest behind a step is no crumb.
    if (h < longest && 1.01 * h >= longest) h = longest;
    if (longest < reach_ * next && longest > shortest_step(t)) {
        const double size = dopri5(f, project, t, y, longest, found);
        const double factor = std::min(kMost, std::max(kLeast, kSafety * std::pow(size, -0.2)));
        reach_ = std::min(1.0, std::max(size > 1.0 ? 0.0 : reach_, factor * longest / next));
        is_dopri5_ = size <= 1.0;
        if (is_dopri5_) {
            std::copy(end_.begin(), end_.end(), y);
            std::copy(k_.begin() + 6 * n_, k_.begin() + 7 * n_, rate);
            ++steps;
            return true;
        }
    }
    bool failed = false;
    for (int trial = 0; trial < kMostTrials; ++trial) {
        if (!(h > shortest_step(t))) return false;
        double size = INFINITY;
        if (stages(f, t, y, h, end_.data())) {
            double* last = k_.data() + dop853::stages * n_;
            project(end_.data());
            size = f(t + h, end_.data(), last) ? error(y, end_.data(), h) : INFINITY;
            if (size <= 1.0) note_stiffness(h);
        }
        if (size <= 1.0 && dense(f, t, y, h, end_.data(), found)) {
            double factor = size > 0.0 ? kSafety * std::pow(size, -1.0 / 8.0) : kMost;
            factor = std::min(failed ? 1.0 : kMost, std::max(kLeast, factor));
            reach_ = std::min(kReach, std::max(0.1 * kReach, kForget * reach_));
            // A step that was cut short by what lies ahead says little of the next.
            next = !failed && h < next && factor >= 1.0 ? std::max(next, h * factor) : h * factor;
            std::copy(end_.begin(), end_.end(), y);
            std::copy(k_.begin() + dop853::stages * n_, k_.begin() + (dop853::stages + 1) * n_,
                      rate);
            ++steps;
            return true;
        }
        failed = true;
        const bool finite = std::isfinite(size) && size > 1.0;
        h *= finite ? std::max(kLeast, kSafety * std::pow(size, -1.0 / 8.0)) : 0.25;
    }
    return false;
}

bool Stepper::shortened(const Rate& f, const Step& whole, double end, Step& found) {
    const double* y = whole.before.data();
    const double h = end - whole.begin;
    if (implicit_) {
        std::vector<double> Z(3 * n_);
        if (!f(whole.begin, y, k_.data())) return false;
        differentiate(f, whole.begin, y, k_.data());
        if (!collocate(f, whole.begin, y, h, Z.data())) return false;
        keep_cubic(whole.begin, y, h, Z.data(), found);
        return true;
    }
    if (method_ != Method::dop853) {
        found = whole;
        found.end = end;
        return true;
    }
    if (is_dopri5_)
        return f(whole.begin, y, k_.data()) &&
               dopri5(f, [](double*) {}, whole.begin, y, h, found) < INFINITY;
    if (!f(whole.begin, y, k_.data()) || !stages(f, whole.begin, y, h, end_.data())) return false;
    if (!f(end, end_.data(), k_.data() + dop853::stages * n_)) return false;
    return dense(f, whole.begin, y, h, end_.data(), found);
}

// Fixed steps: their dense output is the cubic through both ends.
bool Stepper::fixed(const Rate& f, const std::function<void(double*)>& project, double t, double* y,
                    double* rate, double longest, Step& found) {
    const double h = std::min(fixed_length_, longest);
    double *k1 = k_.data(), *k2 = k1 + n_, *k3 = k2 + n_, *k4 = k3 + n_;
    std::copy(rate, rate + n_, k1);
    if (method_ == Method::rk4) {
        const auto at = [&](const double* k, double part) {
            for (int j = 0; j < n_; ++j) trial_[j] = y[j] + part * h * k[j];
            return trial_.data();
        };
        if (!f(t + 0.5 * h, at(k1, 0.5), k2) || !f(t + 0.5 * h, at(k2, 0.5), k3) ||
            !f(t + h, at(k3, 1.0), k4))
            return false;
        for (int j = 0; j < n_; ++j)
            end_[j] = y[j] + h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j]);
    } else {
        for (int j = 0; j < n_; ++j) trial_[j] = j < places_ ? y[j] : y[j] + h * k1[j];
        if (!f(t, trial_.data(), k2)) return false;
        for (int j = 0; j < n_; ++j) end_[j] = j < places_ ? y[j] + h * k2[j] : trial_[j];
    }
    project(end_.data());
    double* last = k_.data() + dop853::stages * n_;
    if (!f(t + h, end_.data(), last)) return false;
    found.begin_at(t, h, y, n_);
    for (int j = 0; j < n_; ++j) {
        const double change = end_[j] - y[j];
        found.shape[j] = change;
        found.shape[n_ + j] = h * k1[j] - change;
        found.shape[2 * n_ + j] = 2.0 * change - h * (last[j] + k1[j]);
    }
    std::copy(end_.begin(), end_.end(), y);
    std::copy(last, last + n_, rate);
    ++steps;
    return true;
}

}  // namespace impulsekit
