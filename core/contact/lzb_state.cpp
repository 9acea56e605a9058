#include "contact/lzb_state.hpp"

#include <algorithm>

#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// So many times as fast is stiff.
constexpr double kFast = 10.0;

}  // namespace

LzbState::LzbState(const ContactProblem& problem, const Law& law)
    : contacts(problem.contacts), exponent_(law.slip == Slip::compliant ? 1.0 : law.exponent) {
    const int n = problem.contacts, all = problem.rows();
    std::vector<int> given;
    double stiffest = 0.0;
    for (int i = 0; i < n; ++i) {
        LzbContact& c = contacts[i];
        c.mu = problem.friction[i] > tolerance::negligible ? problem.friction[i] : 0.0;
        const double e = problem.restitution[i];
        c.e2 = e > tolerance::negligible ? e * e : 0.0;
        if (problem.stiffness && problem.stiffness[i] < INFINITY)
            stiffest = std::max(stiffest, problem.stiffness[i]);
        if (law.slip == Slip::compliant && c.mu > 0.0) c.ratio = problem.stiffness_ratio[i];
        if (problem.damping) c.kept = 1.0 - problem.damping[i];
        if (c.mu > 0.0) c.tangents = static_cast<int>(given.size());
        for (int k = c.mu > 0.0 ? 0 : 2; k < 3; ++k) {
            const int r = 3 * i + k;
            given.push_back(r);
            speed = std::max(speed, std::abs(problem.free[r]));
            mobility = std::max(mobility, problem.W[r * (all + 1)]);
        }
        c.normal_row = static_cast<int>(given.size()) - 1;
        approach = std::max(approach, -problem.free[3 * i + 2]);
    }
    rows_ = static_cast<int>(given.size());
    size_ = rows_ + n;
    for (LzbContact& c : contacts)
        if (c.ratio < INFINITY) c.spring = size_, size_ += 2;
    for (LzbContact& c : contacts)
        if (c.rubs()) c.work = size_++;
    // Without any stiffness all are equally stiff.
    for (int i = 0; i < n && problem.stiffness; ++i)
        if (problem.stiffness[i] > 0.0)
            contacts[i].stiffness =
                std::isinf(problem.stiffness[i]) ? INFINITY : problem.stiffness[i] / stiffest;
    W.resize(rows_ * rows_);
    free.resize(rows_);
    u.resize(rows_);
    force.resize(rows_);
    for (int r = 0; r < rows_; ++r) {
        free[r] = problem.free[given[r]] / speed;
        for (int c = 0; c < rows_; ++c)
            W[r * rows_ + c] = problem.W[given[r] * all + given[c]] / mobility;
    }
}

double LzbState::spring(const LzbContact& c, double depth, bool slope) const {
    if (!c.springs() || !(depth > 0.0)) return 0.0;
    const double root = exponent_ == 1.0   ? 1.0
                        : exponent_ == 1.5 ? std::sqrt(depth)
                                           : std::pow(depth, exponent_ - 1.0);
    return c.stiffness * root * (slope ? exponent_ : depth);
}

double LzbState::rises(const LzbContact& c) const {
    return dot(W.data() + c.normal_row * rows_, force.data(), rows_);
}

bool LzbState::turns_fast(const double* y) const {
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const LzbContact& c = contacts[i];
        const double changes = std::max(std::abs(un(c)), y[rows_ + i]);
        if (c.is_elastic() && c.slip == Slipping::turning &&
            c.ratio * slip(c) > kFast * c.mu * changes)
            return true;
    }
    return false;
}

int LzbState::row_of(int resting_row) const {
    const LzbContact& c = contacts[resting.contact[resting_row / 3]];
    const int k = resting_row % 3;
    return k == 2 ? c.normal_row : c.rubs() ? c.tangents + k : -1;
}

// The way and the tangential force of a contact whose velocity and normal force are known.
void LzbState::set_tangents(LzbContact& c, const double* y) {
    const double F = force[c.normal_row], *v = u.data() + c.tangents;
    if (c.is_elastic()) {
        const double *chi = y + c.spring, length = std::hypot(chi[0], chi[1]);
        for (int k = 0; k < 2; ++k) {
            c.way[k] = c.slip == Slipping::straight ? c.last[k]
                       : length > 0.0               ? chi[k] / length
                                                    : 0.0;
            force[c.tangents + k] = c.slips() ? -c.mu * F * c.way[k] : -c.stiffness * chi[k];
        }
        return;
    }
    // Rigid slip that has passed zero keeps its way until the end of the step.
    const bool keeps = c.slip == Slipping::straight || (c.slips() && ahead(c) <= 0.0);
    for (int k = 0; k < 2; ++k) {
        c.way[k] = !c.slips() ? 0.0 : keeps ? c.last[k] : v[k] / slip(c);
        force[c.tangents + k] = -c.mu * F * c.way[k];
    }
}

// Velocities, ways of slip, and the forces of springs and of slip; then what rests.
void LzbState::find_resting(const double* y) {
    poll(rows_, rows_);
    multiply(W.data(), rows_, y, free.data(), u.data());
    std::fill(force.begin(), force.end(), 0.0);
    Resting& r = resting;
    r.contact.clear();
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        LzbContact& c = contacts[i];
        const double F = force[c.normal_row] = spring(c, y[rows_ + i]);
        if (c.rubs()) set_tangents(c, y);
        if (c.holds() || (F > 0.0 && c.rubs() && !c.slips() && !c.is_elastic()))
            r.contact.push_back(static_cast<int>(i));
    }
    const int m = static_cast<int>(r.contact.size()), size = 3 * m;
    if (m == 0) return;
    r.W.assign(size * size, 0.0);
    r.b.assign(size, 0.0);
    r.reach.resize(m);
    r.direction.resize(2 * m);
    r.load.resize(m);
    r.pressed.assign(m, 1);
    for (int a = 0; a < m; ++a) {
        const LzbContact& c = contacts[r.contact[a]];
        r.reach[a] = c.mu;
        r.load[a] = c.holds() ? NAN : force[c.normal_row];
        for (int k = 0; k < 2; ++k) r.direction[2 * a + k] = c.way[k];
    }
    for (int a = 0; a < size; ++a) {
        const int row = row_of(a);
        if (row < 0) continue;
        r.b[a] = dot(W.data() + row * rows_, force.data(), rows_);
        for (int b = 0; b < size; ++b)
            if (row_of(b) >= 0) r.W[a * size + b] = W[row * rows_ + row_of(b)];
    }
    r.problem.points = m;
    r.problem.W = r.W.data();
    r.problem.b = r.b.data();
    r.problem.reach = r.reach.data();
    r.problem.direction = r.direction.data();
    r.problem.load = r.load.data();
}

void LzbState::rates(const double* y, double* dy) {
    find_resting(y);
    const int m = resting.rows();
    if (m > 0) {
        Arena::Scope scope(scratch());
        double* F = scratch().allocate(m);
        resting.rate.resize(m);
        solve_rest(resting.problem, resting.pressed.data(), F, resting.rate.data());
        for (int r = 0; r < m; ++r)
            if (row_of(r) >= 0) force[row_of(r)] += F[r];
    }
    if (!dy) return;
    std::copy(force.begin(), force.end(), dy);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const LzbContact& c = contacts[i];
        const double rises = dy[rows_ + i] = -c.gives() * un(c);
        if (!c.rubs()) continue;
        const double *f = force.data() + c.tangents, *v = u.data() + c.tangents;
        dy[c.work] = f[0] * v[0] + f[1] * v[1];
        if (c.spring < 0) continue;
        const double speed_along = along(c);
        for (int k = 0; k < 2; ++k) {
            const double turn = c.slip == Slipping::straight ? 0.0 : v[k] - speed_along * c.way[k];
            const double loss = c.releases ? (1.0 / c.kept - 1.0) * speed_along * c.way[k] : 0.0;
            dy[c.spring + k] = !c.is_elastic() ? 0.0
                               : c.slips()     ? c.ratio * turn + c.mu * rises * c.way[k]
                                               : c.ratio * (v[k] + loss);
        }
    }
}

// The rows of J for the tangential force of a contact and for its spring.
void LzbState::write_tangents(const LzbContact& c, const double* y, double* J) const {
    const double *W_t = W.data() + c.tangents * rows_, *s = c.way;
    const int i = static_cast<int>(&c - contacts.data());
    const double F = spring(c, y[rows_ + i]), rise = spring(c, y[rows_ + i], true);
    // D: how the way turns, by the spring's deflection or by the velocity.
    const double length = c.is_elastic() ? std::hypot(y[c.spring], y[c.spring + 1]) : slip(c);
    const bool turns = length > 0.0 && c.slip != Slipping::straight;
    double D[2][2], aside[2];
    for (int k = 0; k < 2; ++k)
        for (int j = 0; j < 2; ++j) D[k][j] = turns ? ((k == j) - s[k] * s[j]) / length : 0.0;
    for (int k = 0; k < 2; ++k) aside[k] = D[k][0] * u[c.tangents] + D[k][1] * u[c.tangents + 1];
    for (int k = 0; k < 2; ++k) {
        double* row = J + (c.tangents + k) * size_;
        if (c.slips()) row[rows_ + i] = -c.mu * rise * s[k];
        if (!c.is_elastic()) {
            for (int r = 0; r < rows_ && c.slips(); ++r)
                row[r] = -c.mu * F * (D[k][0] * W_t[r] + D[k][1] * W_t[rows_ + r]);
            continue;
        }
        for (int j = 0; j < 2; ++j)
            row[c.spring + j] = c.slips() ? -c.mu * F * D[k][j] : (k == j ? -c.stiffness : 0.0);
        // Its spring: the velocity across its way, or all of it and what is lost along it.
        double* own = J + (c.spring + k) * size_;
        const double *W_n = W.data() + c.normal_row * rows_, g = c.gives();
        const double part = c.slips() ? -1.0 : c.releases ? 1.0 / c.kept - 1.0 : 0.0;
        const double straight = c.slip == Slipping::straight ? 0.0 : c.ratio;
        for (int r = 0; r < rows_; ++r) {
            const double W_along = s[0] * W_t[r] + s[1] * W_t[rows_ + r];
            own[r] = straight * (W_t[k * rows_ + r] + part * s[k] * W_along);
            if (c.slips()) own[r] -= c.mu * g * W_n[r] * s[k];
        }
        for (int j = 0; j < 2; ++j) {
            own[c.spring + j] = straight * part * (s[k] * aside[j] + along(c) * D[k][j]);
            if (c.slips()) own[c.spring + j] -= c.mu * g * un(c) * D[k][j];
        }
    }
}

void LzbState::slopes(const double* y, double* J) {
    rates(y, nullptr);
    std::fill(J, J + size_ * size_, 0.0);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const LzbContact& c = contacts[i];
        const double* W_n = W.data() + c.normal_row * rows_;
        for (int r = 0; r < rows_; ++r) J[(rows_ + i) * size_ + r] = -c.gives() * W_n[r];
        J[c.normal_row * size_ + rows_ + i] = spring(c, y[rows_ + i], true);
        if (c.rubs()) write_tangents(c, y, J);
    }
    const int m = resting.rows();
    if (m == 0) return;
    // Contacts at rest answer to the forces of all others.
    Arena::Scope scope(scratch());
    double *answer = scratch().allocate(m * m), *b = scratch().allocate(m),
           *known = scratch().allocate(rows_);
    rest_slopes(resting.problem, resting.pressed.data(), answer);
    for (int col = 0; col < size_; ++col) {
        for (int r = 0; r < rows_; ++r) known[r] = J[r * size_ + col];
        for (int r = 0; r < m; ++r)
            b[r] = row_of(r) < 0 ? 0.0 : dot(W.data() + row_of(r) * rows_, known, rows_);
        for (int r = 0; r < m; ++r)
            if (row_of(r) >= 0) J[row_of(r) * size_ + col] += dot(answer + r * m, b, m);
    }
}

const std::vector<double>& LzbState::rises_of_held(const double* y) {
    rise_.assign(contacts.size(), 0.0);
    const auto may = [](const LzbContact& c) { return c.holds() && c.stiffness < INFINITY; };
    if (std::none_of(contacts.begin(), contacts.end(), may)) return rise_;
    std::vector<double> dy(size_), later(y, y + size_);
    rates(y, dy.data());
    for (int q = 0; q < size_; ++q) later[q] += kAhead * dy[q];
    rates(later.data(), nullptr);
    for (std::size_t i = 0; i < contacts.size(); ++i) {
        const LzbContact& c = contacts[i];
        if (may(c)) rise_[i] = force[c.normal_row] - dy[c.normal_row];
    }
    rates(y, nullptr);
    return rise_;
}

}  // namespace impulsekit
