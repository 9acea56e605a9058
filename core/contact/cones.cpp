#include "contact/cones.hpp"

#include <algorithm>

#include "contact/even_shares.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Impulses so many times as large as those of the velocities are none.
constexpr double kBeyond = 1e5;

// P as it is on its cones: what parts, and what nothing presses, carries nothing.
void clear_open(const ConeSystem& s, double* P, Arena& arena) {
    Arena::Scope scope(arena);
    double* xi = arena.allocate(s.rows);
    multiply(s.A, s.rows, P, s.b, xi);
    for (int c = 0; c < s.contacts; ++c)
        if (P[s.normal[c]] - xi[s.normal[c]] <= s.floor[c]) P[s.normal[c]] = s.floor[c];
    for (int k = 0; k < s.groups; ++k)
        if (!(radius_of(s, k, P, xi) > 0.0))
            for (int j = 0; j < s.size[k]; ++j) P[s.first[k] + j] = 0.0;
}

// True if no impulse makes all ξ_n >= 0, by Farkas: normal impulses d >= 0 that move nothing,
// W d = 0, have d·ξ = d·b for whatever P, and here d·b < 0. Such d is the direction in which
// impulses grow without friction while their compliance falls. With W d = 0 to rounding only,
// impulses that obey would have to be `kBeyond` times as large as those of the velocities.
bool is_infeasible(const double* W, int rows, const double* b, double scale, const Cones& cones,
                   Arena& arena) {
    Arena::Scope scope(arena);
    Cones bare(cones.contacts, 0, arena);
    for (int c = 0; c < cones.contacts; ++c) bare.add_contact(cones.normal[c], 0.0, 0.0);
    const ConeSystem s = build_system(W, rows, b, scale, bare, arena);
    double *d = arena.allocate(s.rows), *velocity = arena.allocate(s.rows),
           *soft = arena.allocate(s.rows, s.rows);
    int steps = 0;
    add_to_diagonal(s, 1.0 / (kBeyond * kBeyond), soft);
    solve_from(s, soft, d, steps, arena);
    for (int i = 0; i < s.rows; ++i) d[i] = std::max(d[i], 0.0);
    const double size = largest(d, s.rows);
    for (int i = 0; i < s.rows; ++i) velocity[i] = dot(s.A + i * s.rows, d, s.rows) / size;
    return size > kBeyond && -dot(d, s.b, s.rows) / size > kBeyond * largest(velocity, s.rows);
}

// P in the units that were given; what is at its floor to the last digit.
void write_back(const ConeSystem& s, const Cones& cones, const double* own, int rows, double* P) {
    std::fill(P, P + rows, 0.0);
    // An impulse of nothing has no sign.
    for (int i = 0; i < s.rows; ++i) P[s.source[i]] = own[i] * s.unit[i] * s.velocity + 0.0;
    for (int c = 0; c < s.contacts; ++c)
        if (own[s.normal[c]] == s.floor[c]) P[s.source[s.normal[c]]] = cones.floor[s.owner[c]];
}

}  // namespace

ConeSolution solve_cones(const double* W, int rows, const double* b, double scale,
                         const Cones& cones, double* P) {
    Arena& arena = scratch();
    Arena::Scope scope(arena);
    ConeSystem s = build_system(W, rows, b, scale, cones, arena);
    ConeSolution solution;
    solution.unique.assign(cones.contacts, 1);
    double* own = arena.allocate(s.rows);
    double* shares = arena.allocate(s.rows);
    Held held(s, arena);
    if (!solve_from_sticking(s, held, own, solution.steps, arena)) {
        start_without_noise(s, held, own, solution.steps, arena);
        solve_redundant(s, held, own, solution.steps, arena);
        find_shares(s, own, held, shares, arena);
    } else if (held.is_redundant()) {
        find_shares(s, own, held, shares, arena);
    }
    clear_open(s, own, arena);
    solution.residual = residual_of(s, own, arena);
    solution.immovable = s.blocked;
    solution.infeasible = !(solution.residual <= tolerance::residual) &&
                          is_infeasible(W, rows, b, scale, cones, arena);
    for (int c = 0; c < s.contacts; ++c) {
        double share = shares[s.normal[c]];
        for (int k = 0; k < s.groups; ++k)
            if (s.contact[k] == c)
                for (int j = 0; j < s.size[k]; ++j) share += shares[s.first[k] + j];
        solution.unique[s.owner[c]] = share <= tolerance::shared;
    }
    write_back(s, cones, own, rows, P);
    return solution;
}

double cone_residual(const double* W, int rows, const double* b, double scale, const Cones& cones,
                     const double* P) {
    Arena& arena = scratch();
    Arena::Scope scope(arena);
    ConeSystem s = build_system(W, rows, b, scale, cones, arena);
    double* own = arena.allocate(s.rows);
    for (int i = 0; i < s.rows; ++i) own[i] = P[s.source[i]] / (s.unit[i] * s.velocity);
    return residual_of(s, own, arena);
}

void newton_on_cones(const double* W, int rows, const double* b, double scale, const Cones& cones,
                     double* P) {
    Arena& arena = scratch();
    Arena::Scope scope(arena);
    ConeSystem s = build_system(W, rows, b, scale, cones, arena);
    double* own = arena.allocate(s.rows);
    for (int i = 0; i < s.rows; ++i) own[i] = P[s.source[i]] / (s.unit[i] * s.velocity);
    int steps = 0;
    newton(s, s.A, own, steps, arena);
    write_back(s, cones, own, rows, P);
}

}  // namespace impulsekit
