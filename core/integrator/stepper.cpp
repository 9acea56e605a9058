#include "integrator/stepper.hpp"

#include <algorithm>
#include <cmath>

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
      k_(kDop853.all * size),
      trial_(size),
      end_(size) {}

// y + h Σ weights rate of the first stages.
void Stepper::weigh(const Tableau& m, int stage, const double* y, double h, double* to) const {
    std::fill(to, to + n_, 0.0);
    const auto add = [&](const double* rows, int begin, int end) {
        const double* weights = rows + stage * m.all + 1;
        for (int i = 0; i < stage; ++i) {
            const double *k = k_.data() + i * n_, own = weights[i];
            if (own == 0.0) continue;
            for (int j = begin; j < end; ++j) to[j] += own * k[j];
        }
    };
    add(m.places, 0, places_);
    add(m.velocities, places_, n_);
    for (int j = 0; j < n_; ++j) to[j] = y[j] + h * to[j];
}

// All stages from the first, which stands in k_, to the end, which is kept in end_.
bool Stepper::stages(const Tableau& m, const Rate& f, const std::function<void(double*)>& project,
                     double t, const double* y, double h) {
    for (int s = 1; s <= m.stages; ++s) {
        double* to = s == m.stages ? end_.data() : trial_.data();
        weigh(m, s, y, h, to);
        if (s == m.stages) project(to);
        if (!f(t + m.velocities[s * m.all] * h, to, k_.data() + s * n_)) return false;
    }
    return true;
}

// Dense output of a step whose stages stand in k_: the cubic through both ends, and what bends it.
bool Stepper::dense(const Tableau& m, const Rate& f, double t, const double* y, double h,
                    Step& found) {
    for (int s = m.stages + 1; s < m.all; ++s) {
        weigh(m, s, y, h, trial_.data());
        if (!f(t + m.velocities[s * m.all] * h, trial_.data(), k_.data() + s * n_)) return false;
    }
    found.begin_at(t, h, y, n_);
    double* shape = found.shape.data();
    const double *first = k_.data(), *last = k_.data() + m.stages * n_;
    for (int j = 0; j < n_; ++j) {
        const double change = end_[j] - y[j];
        shape[j] = change;
        shape[n_ + j] = h * first[j] - change;
        shape[2 * n_ + j] = 2.0 * change - h * (last[j] + first[j]);
        for (int r = 0; r < m.count; ++r) {
            double sum = 0.0;
            for (int i = 0; i < m.all; ++i) sum += m.bends[r * m.all + i] * k_[i * n_ + j];
            shape[(3 + r) * n_ + j] = h * sum;
        }
    }
    return true;
}

// The error of a step over what is allowed (Hairer, Norsett & Wanner 1993, eq. (II.10.17)).
double Stepper::error(const Tableau& m, const double* y, double h) const {
    double sums[2] = {};
    for (int j = 0; j < n_; ++j) {
        const double scale = allowed(j, y[j], end_[j]);
        for (int e = 0; e < m.estimates; ++e) {
            double own = 0.0;
            for (int i = 0; i <= m.stages; ++i)
                own += m.errors[e * (m.stages + 1) + i] * k_[i * n_ + j];
            sums[e] += own * own / (scale * scale);
        }
    }
    // Squares of rounding may vanish. A NaN stays one: no step with it is taken.
    const double both = (sums[0] + 0.01 * sums[1]) * n_;
    return both == 0.0 ? 0.0 : std::abs(h) * sums[0] / std::sqrt(both);
}

// From the last stage, whose y stands in trial_, beside the end of the step.
void Stepper::note_stiffness(double h) {
    const double *last = k_.data() + kDop853.stages * n_, *stage = last - n_;
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

// Make the end of a step the state.
bool Stepper::take(const Tableau& m, double* y, double* rate) {
    std::copy(end_.begin(), end_.end(), y);
    std::copy_n(k_.begin() + m.stages * n_, n_, rate);
    ++steps;
    return true;
}

bool Stepper::step(const Rate& f, const std::function<void(double*)>& project, double t, double* y,
                   double* rate, double longest, Step& found) {
    implicit_ = method_ == Method::radau || is_stiff || stiff_ >= kStiff;
    is_dopri5_ = false;
    factor_ = INFINITY;
    if (implicit_) return implicit(f, project, t, y, rate, longest, found);
    std::copy(rate, rate + n_, k_.begin());
    if (method_ != Method::dop853) {
        const Tableau& m = method_ == Method::rk4 ? kRk4 : kSemiImplicit;
        const double h = std::min(fixed_length_, longest);
        return stages(m, f, project, t, y, h) && dense(m, f, t, y, h, found) && take(m, y, rate);
    }
    const auto attempt = [&](const Tableau& m, double h) {
        return stages(m, f, project, t, y, h) ? error(m, y, h) : INFINITY;
    };
    const auto factor_of = [](const Tableau& m, double size) {
        return std::max(kLeast, kSafety * std::pow(size, -1.0 / m.order));
    };
    if (longest < reach_ * next && longest > shortest_step(t)) {
        const double size = attempt(kDopri5, longest);
        factor_ = factor_of(kDopri5, size);
        reach_ = std::min(
            1.0, std::max(size > 1.0 ? 0.0 : reach_, std::min(kMost, factor_) * longest / next));
        is_dopri5_ = size <= 1.0 && dense(kDopri5, f, t, y, longest, found);
        if (is_dopri5_) return take(kDopri5, y, rate);
    }
    double h = std::min(next, longest);
    // The rest behind a step is no crumb.
    if (h < longest && 1.01 * h >= longest) h = longest;
    bool failed = false;
    for (int trial = 0; trial < kMostTrials; ++trial) {
        if (!(h > shortest_step(t))) return false;
        const double size = attempt(kDop853, h);
        factor_ = factor_of(kDop853, size);
        if (size <= 1.0) note_stiffness(h);
        if (size <= 1.0 && dense(kDop853, f, t, y, h, found)) {
            const double factor = std::min(failed ? 1.0 : kMost, factor_);
            reach_ = std::min(kReach, std::max(0.1 * kReach, kForget * reach_));
            // A step that was cut short by what lies ahead says little of the next.
            next = !failed && h < next && factor >= 1.0 ? std::max(next, h * factor) : h * factor;
            return take(kDop853, y, rate);
        }
        failed = true;
        h *= std::isfinite(size) && size > 1.0 ? factor_ : 0.25;
    }
    return false;
}

bool Stepper::shortened(const Rate& f, const Step& whole, double end, Step& found) {
    const double* y = whole.before.data();
    const double h = end - whole.begin;
    if (!implicit_ && method_ != Method::dop853) {
        found = whole;
        found.end = end;
        return true;
    }
    if (!f(whole.begin, y, k_.data())) return false;
    if (implicit_) {
        std::vector<double> Z(3 * n_);
        differentiate(f, whole.begin, y, k_.data());
        if (!collocate(f, whole.begin, y, h, Z.data())) return false;
        keep_cubic(whole.begin, y, h, Z.data(), found);
        return true;
    }
    const Tableau& m = is_dopri5_ ? kDopri5 : kDop853;
    return stages(m, f, [](double*) {}, whole.begin, y, h) && dense(m, f, whole.begin, y, h, found);
}

}  // namespace impulsekit
