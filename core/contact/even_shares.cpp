#include "contact/even_shares.hpp"

#include <algorithm>
#include <cmath>

#include "contact/rigid_limit.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Compliances that are tried beside the first, each a share of the one before.
constexpr int kRounds = 4;
constexpr double kFall = 1e-2;

// Rows that are still in the limit of rigidity: their velocities fall with the compliance from that
// of `softer` to that of P, by `kFall`, and others stay.
void find_still(const ConeSystem& s, const double* softer, const double* P, double compliance,
                HeldRows& held, Arena& arena) {
    Arena::Scope scope(arena);
    double *before = arena.allocate(s.rows), *now = arena.allocate(s.rows);
    multiply(s.A, s.rows, softer, s.b, before);
    multiply(s.A, s.rows, P, s.b, now);
    const double rounding = tolerance::solved * largest(P, s.rows), fall = std::sqrt(kFall);
    const auto is_still = [&](int r, int size) {
        return hypot_of(now + r, size) <= fall * hypot_of(before + r, size) + rounding;
    };
    held.count = 0;
    for (int c = 0; c < s.contacts; ++c)
        if (is_still(s.normal[c], 1)) held.rows[held.count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k) {
        const int r = s.first[k], c = s.contact[k], n = c < 0 ? -1 : s.normal[c];
        const double soft = n < 0 ? 0.0 : now[n] + compliance * s.mobility_ratio[n] * P[n];
        const bool is_loaded = n < 0 || P[n] - soft + s.adhesion[c] > 0.0;
        if (is_loaded && is_still(r, s.size[k]))
            for (int j = 0; j < s.size[k]; ++j) held.rows[held.count++] = r + j;
    }
}

}  // namespace

bool solve_redundant(const ConeSystem& s, HeldRows& held, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    double *soft = arena.allocate(m, m), *softer = arena.allocate(m), *firm = arena.allocate(m);
    Alike<double> alike;
    double compliance = tolerance::compliance;
    add_to_diagonal(s, compliance, soft);
    bool solved = solve_from(s, soft, P, steps, arena);
    // If redundant rows contradict each other, a smaller compliance tells which gives way.
    for (int round = 0; round < kRounds; ++round) {
        std::copy(P, P + m, softer);
        compliance *= kFall;
        add_to_diagonal(s, compliance, soft);
        solved = solve_from(s, soft, P, steps, arena);
        std::copy(P, P + m, firm);
        find_still(s, softer, P, compliance, held, arena);
        factor_held(s, held, alike, arena);
        if (solve_rigid_limit(s, compliance, held.rows, held.count, held.projector, P, steps,
                              arena) &&
            residual_of(s, P, arena) <= tolerance::at_rest)
            return true;
        std::copy(firm, firm + m, P);
    }
    return solved;
}

void start_without_noise(const ConeSystem& s, HeldRows& held, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    ConeSystem clear = s;
    clear.b = arena.allocate(s.rows);
    const double noise = tolerance::at_rest * largest(s.b, s.rows);
    bool is_noisy = false;
    for (int i = 0; i < s.rows; ++i) {
        const bool is_noise = s.b[i] != 0.0 && std::abs(s.b[i]) < noise;
        clear.b[i] = is_noise ? 0.0 : s.b[i];
        is_noisy = is_noisy || is_noise;
    }
    if (!is_noisy) return;
    // Noise is in the sticking answer, too.
    std::fill(P, P + s.rows, 0.0);
    solve_redundant(clear, held, P, steps, arena);
}

}  // namespace impulsekit
