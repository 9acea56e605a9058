#include "contact/cone_newton.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// Most steps of one Newton iteration, and of its line search.
constexpr int kNewtonSteps = 60, kHalvings = 10;
// A step is taken if it is no worse than the worst of so many before it (non-monotone search).
constexpr int kMemory = 4;
// A share of the decrease that a line foretells, which a step must give at least (Armijo).
constexpr double kDecrease = 1e-4;
// Bounds of the balance of a group: beyond them the smaller part is rounding of the larger.
constexpr double kMostBalance = 1e5;
// Steps in which a compliance of 1 falls tenfold.
constexpr int kSofter = 9;

// Gauss-Seidel over normals and groups, each in turn onto its cone.
void sweep(const ConeSystem& s, const double* A, double* P, int count) {
    const int m = s.rows;
    auto project_to_coulomb_cone = [&](int k) {
        const int f = s.first[k], size = s.size[k], c = s.contact[k];
        double trial[2] = {}, mobility = 0.0;
        for (int j = 0; j < size; ++j) mobility += A[(f + j) * m + f + j];
        for (int j = 0; j < size; ++j) {
            double slip = s.b[f + j] + dot(A + (f + j) * m, P, m);
            trial[j] = P[f + j] - slip / (mobility > 0.0 ? mobility : 1.0);
        }
        double radius = s.friction[k] * (c < 0 ? 1.0 : P[s.normal[c]] + s.adhesion[c]);
        double length = hypot_of(trial, size), share = length > radius ? radius / length : 1.0;
        for (int j = 0; j < size; ++j) P[f + j] = share * trial[j];
    };
    for (int round = 0; round < count; ++round) {
        poll(m, m);
        for (int c = 0; c < s.contacts; ++c) {
            int r = s.normal[c];
            double xi = s.b[r] + dot(A + r * m, P, m);
            P[r] = std::max(s.floor[c], P[r] - xi / A[r * m + r]);
        }
        for (int k = 0; k < s.groups; ++k) project_to_coulomb_cone(k);
    }
}

}  // namespace

void balance_groups(const ConeSystem& s, const double* P, const double* xi) {
    for (int k = 0; k < s.groups; ++k) {
        const int r = s.first[k], size = s.size[k];
        const double slip = hypot_of(xi + r, size), carried = hypot_of(P + r, size);
        const double ratio = carried > slip ? std::min(carried / slip, kMostBalance) : 1.0;
        s.balance[k] = std::sqrt(s.balance[k] * ratio);
    }
}

bool newton(const ConeSystem& s, const double* A, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    double *xi = arena.allocate(m), *F = arena.allocate(m), *J = arena.allocate(m, m),
           *step = arena.allocate(m);
    double *trial = arena.allocate(m), *best = arena.allocate(m);
    int* pivot = arena.allocate_int(m);
    double recent[kMemory];
    std::fill(recent, recent + kMemory, INFINITY);
    const auto norm_of = [&](const double* x, const double* rho) {
        natural_map_residual(s, rho, x, xi, F);
        return dot(F, F, m);
    };
    multiply(A, m, P, s.b, xi);
    double least = norm_of(P, s.even);
    std::copy(P, P + m, best);
    bool polished = false;
    for (int count = 0; count < kNewtonSteps; ++count, ++steps) {
        double size = std::max(1.0, largest(P, m));
        poll(m, m, 1 + kHalvings);
        const double left = count == 0 ? least : norm_of(P, s.even);
        if (left < least) {
            least = left;
            std::copy(P, P + m, best);
        } else if (polished) {
            break;
        }
        if (is_rounding(least, P, m)) break;
        polished = least <= tolerance::immovable * size * size;
        if (count > 0) balance_groups(s, P, xi);
        const double norm = norm_of(P, s.balance);
        natural_map_jacobian(s, A, s.balance, P, xi, J);
        if (!factor_lu(J, m, pivot)) break;
        for (int i = 0; i < m; ++i) step[i] = -F[i];
        solve_lu(J, pivot, m, step);
        recent[count % kMemory] = norm;
        double bar = 0.0;
        for (double value : recent)
            if (value < INFINITY) bar = std::max(bar, value);
        double share = 1.0, found = norm;
        for (int half = 0; half <= kHalvings; ++half, share *= 0.5) {
            for (int i = 0; i < m; ++i) trial[i] = P[i] + share * step[i];
            multiply(A, m, trial, s.b, xi);
            found = norm_of(trial, s.balance);
            if (found <= (1.0 - kDecrease * share) * bar) break;
        }
        if (!(found < INFINITY)) break;
        std::copy(trial, trial + m, P);
    }
    std::copy(best, best + m, P);
    double size = std::max(1.0, largest(P, m));
    return least <= tolerance::immovable * size * size;
}

void add_to_diagonal(const ConeSystem& s, double compliance, double* A) {
    std::copy(s.A, s.A + s.rows * s.rows, A);
    for (int i = 0; i < s.rows; ++i) A[i * s.rows + i] += compliance * s.mobility_ratio[i];
}

bool solve_from(const ConeSystem& s, const double* A, double* P, int& steps, Arena& arena) {
    if (newton(s, A, P, steps, arena)) return true;
    Arena::Scope scope(arena);
    double* soft = arena.allocate(s.rows, s.rows);
    std::fill(P, P + s.rows, 0.0);
    std::fill(s.balance, s.balance + s.groups, 1.0);
    double compliance = 1.0;
    for (int step = 0; step < kSofter; ++step, compliance *= 0.1) {
        std::copy(A, A + s.rows * s.rows, soft);
        for (int i = 0; i < s.rows; ++i) soft[i * s.rows + i] += compliance;
        newton(s, soft, P, steps, arena);
    }
    if (newton(s, A, P, steps, arena)) return true;
    for (int count : {40, 400, 4000}) {
        sweep(s, A, P, count);
        if (newton(s, A, P, steps, arena)) return true;
    }
    return false;
}

}  // namespace impulsekit
