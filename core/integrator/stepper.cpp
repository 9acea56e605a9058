#include "integrator/stepper.hpp"

#include <algorithm>
#include <cmath>

namespace impulsekit {
namespace {

// After so many steps as long as stability lets them be the motion is stiff, and so many shorter
// ones forget them (Hairer, Norsett & Wanner 1993, section II.10).
constexpr int kStiff = 15, kMild = 6;
// The ladder, and the rung from which the others are seen.
constexpr const Tableau* kLadder[] = {&kKutta, &kDopri5, &kDop853};
constexpr int kTop = 2;
// Steps of lower order that went less far than they should go so much further after each of the
// highest.
constexpr double kForget = 1.5;

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
      end_(size) {
    for (int i = 0; i <= kTop; ++i) reach_[i] = usual(i);
}

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

// From the last stage, whose y stands in trial_, beside the end of the step. What was stiff before
// a jump is so again at once.
void Stepper::note_stiffness(double h) {
    const double *last = k_.data() + kDop853.stages * n_, *stage = last - n_;
    double rates = 0.0, places = 0.0;
    for (int j = 0; j < n_; ++j) {
        rates += (last[j] - stage[j]) * (last[j] - stage[j]);
        places += (end_[j] - trial_[j]) * (end_[j] - trial_[j]);
    }
    if (h * h * rates > kStable * kStable * places)
        stiff_ = fastest_ > 0.0 ? kStiff : stiff_ + 1, mild_ = 0;
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

// The part of a step of the highest order that one of a rung goes, of the same error.
double Stepper::usual(int rung) const {
    return std::pow(accuracy_.rtol, 1.0 / kLadder[rung]->order - 1.0 / kLadder[kTop]->order);
}

// The lowest rung that gets there in one step.
int Stepper::lowest(double longest) const {
    int rung = 0;
    while (rung < kTop && !(longest < reach_[rung] * next)) ++rung;
    return rung;
}

// How far steps of this rung go; those below as much further, or less, than before.
void Stepper::set_reach(double reach) {
    const double by = reach / reach_[rung_];
    for (int i = 0; i <= rung_; ++i) reach_[i] *= by;
}

// What a step of length h that was taken says of the length of the next.
void Stepper::learn(double h, bool failed) {
    const double length = reach_[rung_] * next, grown = h * std::min(failed ? 1.0 : kMost, factor_);
    if (rung_ < kTop) return set_reach(std::min(1.0, std::max(length, grown) / next));
    // A step that was cut short by what lies ahead says little of the next.
    next = !failed && h < next && factor_ >= 1.0 ? std::max(next, grown) : grown;
    for (int i = 0; i < kTop; ++i)
        reach_[i] = std::min(usual(i), std::max(0.1 * usual(i), kForget * reach_[i]));
}

bool Stepper::step(const Rate& f, const std::function<void(double*)>& project, double t, double* y,
                   double* rate, double longest, Step& found) {
    implicit_ = method_ == Method::radau || is_stiff || stiff_ >= kStiff;
    factor_ = INFINITY;
    if (implicit_) return implicit(f, project, t, y, rate, longest, found);
    std::copy(rate, rate + n_, k_.begin());
    if (method_ != Method::dop853) {
        const Tableau& m = method_ == Method::rk4 ? kRk4 : kSemiImplicit;
        const double h = std::min(fixed_length_, longest);
        return stages(m, f, project, t, y, h) && dense(m, f, t, y, h, found) && take(m, y, rate);
    }
    const double wanted = next;
    int failed = -1;
    for (int trial = 0; trial < kMostTrials; ++trial) {
        rung_ = lowest(longest);
        const Tableau& m = *kLadder[rung_];
        double h = std::min(reach_[rung_] * next, longest);
        // The rest behind a step is no crumb.
        if (h < longest && 1.01 * h >= longest) h = longest;
        if (!(h > shortest_step(t))) break;
        const double size = stages(m, f, project, t, y, h) ? error(m, y, h) : INFINITY;
        factor_ = std::max(kLeast, kSafety * std::pow(size, -1.0 / m.order));
        if (size <= 1.0 && rung_ == kTop) note_stiffness(h);
        if (size <= 1.0 && dense(m, f, t, y, h, found)) {
            learn(h, failed == rung_);
            return take(m, y, rate);
        }
        failed = rung_;
        const double shorter = h * (std::isfinite(size) && size > 1.0 ? factor_ : 0.25);
        if (rung_ == kTop)
            next = shorter;
        else
            set_reach(shorter / next);
    }
    next = wanted;
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
    const Tableau& m = *kLadder[rung_];
    return stages(m, f, [](double*) {}, whole.begin, y, h) && dense(m, f, whole.begin, y, h, found);
}

}  // namespace impulsekit
