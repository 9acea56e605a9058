#include "contact/cones.hpp"

#include <algorithm>

#include "contact/cone_solution.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Impulses so many times as large as those of the velocities are none.
constexpr double kBeyond = 1e5;

}  // namespace

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

void solve_beyond_sticking(const ConeSystem& s, HeldRows& held, double* P, double* shares,
                           int& steps, Arena& arena) {
    start_without_noise(s, held, P, steps, arena);
    solve_redundant(s, held, P, steps, arena);
    Alike<double> alike;
    find_shares(s, P, held, shares, alike, arena);
}

ConeSolution solve_cones(const double* W, int rows, const double* b, double scale,
                         const Cones& cones, double* P, double* shares) {
    Alike<double> alike;
    return solve_cones(W, rows, b, scale, cones, P, shares, alike);
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
