#include "contact/cones.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"
#include "linalg/poll.hpp"

namespace impulsekit {
namespace {

// Most steps of one Newton iteration, and of its line search.
constexpr int kNewtonSteps = 60, kHalvings = 10;
constexpr int kProximalSteps = 8;
// Impulses so many times as large as those of the velocities are none.
constexpr double kBeyond = 1e5;
// A step is taken if it is no worse than the worst of so many before it (non-monotone search).
constexpr int kMemory = 4;

// The used rows alone, each contact and group in units in which its own mobility is 1, velocities
// in units of the largest: then P and ξ have one unit, and the natural map has no parameter.
struct System {
    int rows = 0, contacts = 0, groups = 0;
    double* A = nullptr;               // (rows, rows)
    double* b = nullptr;               // (rows)
    int* source = nullptr;             // (rows) row of the given problem
    double* unit = nullptr;            // (rows) P_given = unit · P · velocity
    double* mobility_ratio = nullptr;  // (rows) the largest mobility in any direction of a group
    int* normal = nullptr;             // (contacts)
    int* owner = nullptr;              // (contacts) number of the given contact
    double* floor = nullptr;           // (contacts)
    double* adhesion = nullptr;        // (contacts)
    int* first = nullptr;              // (groups)
    int* size = nullptr;               // (groups)
    int* contact = nullptr;            // (groups)
    double* friction = nullptr;        // (groups)
    double velocity = 1.0;
    bool blocked = false;
};

double hypot_of(const double* x, int size) {
    return size == 1 ? std::abs(x[0]) : std::sqrt(x[0] * x[0] + x[1] * x[1]);
}

// Rows of a group that move, or slip although no impulse moves them.
int moving_rows(const double* W, int rows, const double* b, double scale, double mobility,
                int first, int size, int* kept) {
    int count = 0;
    for (int r = first; r < first + size; ++r)
        if (W[r * rows + r] > tolerance::immovable * mobility ||
            std::abs(b[r]) > tolerance::at_rest * scale)
            kept[count++] = r;
    return count;
}

// The larger eigenvalue of two rows of W: unlike its diagonal, the same for whatever tangents.
double largest_mobility(const double* W, int rows, int i, int j) {
    const double a = W[i * rows + i], b = W[i * rows + j], c = W[j * rows + j];
    return 0.5 * (a + c) + std::hypot(0.5 * (a - c), b);
}

// W, b, floors and radii of a system in the units of its rows.
void scale_system(System& s, const double* W, int rows, const double* b, double scale,
                  const Cones& cones, Arena& arena) {
    s.A = arena.allocate(s.rows, s.rows);
    s.b = arena.allocate(s.rows);
    double fastest = 0.0;
    for (int i = 0; i < s.rows; ++i) {
        s.b[i] = s.unit[i] * b[s.source[i]];
        fastest = std::max({fastest, std::abs(s.b[i]), s.unit[i] * scale * 1e-3});
        for (int j = 0; j < s.rows; ++j)
            s.A[i * s.rows + j] = s.unit[i] * W[s.source[i] * rows + s.source[j]] * s.unit[j];
    }
    for (int c = 0; c < s.contacts; ++c) {
        s.floor[c] = cones.floor[s.owner[c]] / s.unit[s.normal[c]];
        s.adhesion[c] = cones.adhesion[s.owner[c]] / s.unit[s.normal[c]];
        fastest = std::max(fastest, s.floor[c]);
    }
    s.velocity = fastest > 0.0 ? fastest : 1.0;
    for (int i = 0; i < s.rows; ++i) s.b[i] /= s.velocity;
    for (int c = 0; c < s.contacts; ++c) {
        s.floor[c] /= s.velocity;
        s.adhesion[c] /= s.velocity;
    }
    for (int k = 0; k < s.groups; ++k)
        if (s.contact[k] < 0) s.friction[k] /= s.velocity;
}

System build_system(const double* W, int rows, const double* b, double scale, const Cones& cones,
                    Arena& arena) {
    System s;
    const int n = static_cast<int>(cones.normal.size()), g = static_cast<int>(cones.first.size());
    s.source = arena.allocate_int(rows);
    s.unit = arena.allocate(rows);
    s.mobility_ratio = arena.allocate(rows);
    s.normal = arena.allocate_int(n);
    s.owner = arena.allocate_int(n);
    s.floor = arena.allocate(n);
    s.adhesion = arena.allocate(n);
    s.first = arena.allocate_int(g);
    s.size = arena.allocate_int(g);
    s.contact = arena.allocate_int(g);
    s.friction = arena.allocate(g);
    double mobility = 0.0;
    for (int r = 0; r < rows; ++r) mobility = std::max(mobility, W[r * rows + r]);
    int* place = arena.allocate_int(n);
    for (int i = 0; i < n; ++i) {
        int r = cones.normal[i];
        double own = W[r * rows + r];
        place[i] = -1;
        if (!(own > tolerance::immovable * mobility)) {
            s.blocked = s.blocked || b[r] < -tolerance::at_rest * scale;
            continue;
        }
        place[i] = s.contacts;
        s.owner[s.contacts] = i;
        s.normal[s.contacts++] = s.rows;
        s.source[s.rows] = r;
        s.mobility_ratio[s.rows] = 1.0;
        s.unit[s.rows++] = 1.0 / std::sqrt(own);
    }
    for (int k = 0; k < g; ++k) {
        const bool fixed = cones.contact[k] < 0;
        int c = fixed ? -1 : place[cones.contact[k]], kept[2];
        if ((c < 0 && !fixed) || !(cones.friction[k] > tolerance::negligible)) continue;
        int count = moving_rows(W, rows, b, scale, mobility, cones.first[k], cones.size[k], kept);
        if (count == 0) continue;
        double own = 0.0;
        for (int j = 0; j < count; ++j) own = std::max(own, W[kept[j] * rows + kept[j]]);
        // The radius is a share of the normal impulse, or an impulse.
        double normal_unit = fixed ? 1.0 : s.unit[s.normal[c]];
        double unit = own > 0.0 ? 1.0 / std::sqrt(own) : 1.0;
        s.first[s.groups] = s.rows;
        s.size[s.groups] = count;
        s.contact[s.groups] = c;
        s.friction[s.groups++] = cones.friction[k] * normal_unit / unit;
        const double most = count == 2 ? largest_mobility(W, rows, kept[0], kept[1]) : own;
        for (int j = 0; j < count; ++j) {
            s.source[s.rows] = kept[j];
            s.mobility_ratio[s.rows] = own > 0.0 ? most / own : 1.0;
            s.unit[s.rows++] = unit;
        }
    }
    scale_system(s, W, rows, b, scale, cones, arena);
    return s;
}

// The largest |P_g| of a group: µ times A and the normal impulse that P − ξ is projected to.
double radius_of(const System& s, int group, const double* P, const double* xi) {
    const int c = s.contact[group];
    if (c < 0) return s.friction[group];
    const int n = s.normal[c];
    return s.friction[group] * (std::max(s.floor[c], P[n] - xi[n]) + s.adhesion[c]);
}

// F of the natural map (Alart & Curnier 1991): P − Π(P − ξ), zero where P obeys the law.
void natural_map_residual(const System& s, const double* P, const double* xi, double* F) {
    for (int c = 0; c < s.contacts; ++c) {
        int r = s.normal[c];
        F[r] = P[r] - std::max(s.floor[c], P[r] - xi[r]);
    }
    for (int k = 0; k < s.groups; ++k) {
        int r = s.first[k], size = s.size[k];
        double radius = radius_of(s, k, P, xi), trial[2];
        for (int j = 0; j < size; ++j) trial[j] = P[r + j] - xi[r + j];
        double length = hypot_of(trial, size);
        for (int j = 0; j < size; ++j)
            F[r + j] = length <= radius ? xi[r + j] : P[r + j] - radius * trial[j] / length;
    }
}

// A derivative of F by P, with `A` the matrix of ξ.
void natural_map_jacobian(const System& s, const double* A, const double* P, const double* xi,
                          double* J) {
    const int m = s.rows;
    for (int c = 0; c < s.contacts; ++c) {
        int r = s.normal[c];
        double* row = J + r * m;
        if (P[r] - xi[r] > s.floor[c]) {
            std::copy(A + r * m, A + (r + 1) * m, row);
        } else {
            std::fill(row, row + m, 0.0);
            row[r] = 1.0;
        }
    }
    for (int k = 0; k < s.groups; ++k) {
        const int r = s.first[k], size = s.size[k], c = s.contact[k];
        const int n = c < 0 ? -1 : s.normal[c];
        double radius = radius_of(s, k, P, xi), trial[2];
        for (int j = 0; j < size; ++j) trial[j] = P[r + j] - xi[r + j];
        double length = hypot_of(trial, size);
        if (length <= radius) {
            std::copy(A + r * m, A + (r + size) * m, J + r * m);
            continue;
        }
        // F = P_g − µ z_n s with s = z/|z|: ds = (1 − s sᵀ) dz/|z|.
        double turn = radius / length;
        for (int i = 0; i < size; ++i) {
            double* row = J + (r + i) * m;
            std::fill(row, row + m, 0.0);
            row[r + i] = 1.0;
            for (int j = 0; j < size; ++j) {
                double across = (i == j ? 1.0 : 0.0) - trial[i] * trial[j] / (length * length);
                double weight = turn * across;
                if (weight == 0.0) continue;
                row[r + j] -= weight;
                const double* own = A + (r + j) * m;
                for (int q = 0; q < m; ++q) row[q] += weight * own[q];
            }
            if (n >= 0 && P[n] - xi[n] > s.floor[c]) {
                double weight = s.friction[k] * trial[i] / length;
                row[n] -= weight;
                const double* own = A + n * m;
                for (int q = 0; q < m; ++q) row[q] += weight * own[q];
            }
        }
    }
}

// The largest entry of F in units of the largest velocity: where no answer is, impulses grow until
// what is left is nothing beside them, but not beside the velocities.
double residual_of(const System& s, const double* P, Arena& arena) {
    Arena::Scope scope(arena);
    double* xi = arena.allocate(s.rows);
    double* F = arena.allocate(s.rows);
    multiply(s.A, s.rows, P, s.b, xi);
    natural_map_residual(s, P, xi, F);
    return largest(F, s.rows);
}

// Newton's method on the natural map of ξ = A P + b, P its start and the best that it met; whether
// F came down to rounding or near it.
bool newton(const System& s, const double* A, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    double *xi = arena.allocate(m), *F = arena.allocate(m), *J = arena.allocate(m, m),
           *step = arena.allocate(m);
    double *trial = arena.allocate(m), *best = arena.allocate(m);
    int* pivot = arena.allocate_int(m);
    double recent[kMemory];
    std::fill(recent, recent + kMemory, INFINITY);
    auto evaluate = [&](const double* x) {
        multiply(A, m, x, s.b, xi);
        natural_map_residual(s, x, xi, F);
        return dot(F, F, m);
    };
    double norm = evaluate(P), least = norm;
    std::copy(P, P + m, best);
    bool polished = false;
    for (int count = 0; count < kNewtonSteps; ++count, ++steps) {
        double size = std::max(1.0, largest(P, m));
        poll(m, m, 1 + kHalvings);
        if (norm <= tolerance::rounding * tolerance::rounding * size * size) break;
        natural_map_jacobian(s, A, P, xi, J);
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
            found = evaluate(trial);
            if (found <= (1.0 - 1e-4 * share) * bar) break;
        }
        if (!(found < INFINITY)) break;
        std::copy(trial, trial + m, P);
        norm = found;
        if (norm < least) {
            least = norm;
            std::copy(P, P + m, best);
        } else if (polished) {
            break;
        }
        polished = least <= 1e-24 * size * size;
    }
    std::copy(best, best + m, P);
    double size = std::max(1.0, largest(P, m));
    return least <= 1e-24 * size * size;
}

// Gauss-Seidel over normals and groups, each in turn onto its cone.
void sweep(const System& s, const double* A, double* P, int count) {
    const int m = s.rows;
    auto project_to_coulomb_cone = [&](int k) {
        const int f = s.first[k], size = s.size[k], c = s.contact[k];
        double trial[2], mobility = 0.0;
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

void add_to_diagonal(const System& s, double compliance, double* A) {
    std::copy(s.A, s.A + s.rows * s.rows, A);
    for (int i = 0; i < s.rows; ++i) A[i * s.rows + i] += compliance * s.mobility_ratio[i];
}

// Newton's method, and where it stalls again from what proximal steps or sweeps come to: a
// compliance that falls from 1 leads along a path of well-posed problems to the one at hand.
bool solve_from(const System& s, const double* A, double* P, int& steps, Arena& arena) {
    if (newton(s, A, P, steps, arena)) return true;
    Arena::Scope scope(arena);
    double* soft = arena.allocate(s.rows, s.rows);
    std::fill(P, P + s.rows, 0.0);
    for (double compliance = 1.0; compliance > 1e-8; compliance *= 0.1) {
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

// Rows that are loaded and held at P: normals that press, and groups that do not slip, wherever in
// their cones their impulses are.
int held_rows(const System& s, const double* P, const double* xi, int* held) {
    int count = 0;
    for (int c = 0; c < s.contacts; ++c)
        if (P[s.normal[c]] - xi[s.normal[c]] > s.floor[c]) held[count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k) {
        int r = s.first[k];
        if (radius_of(s, k, P, xi) > 0.0 && hypot_of(xi + r, s.size[k]) <= tolerance::at_rest)
            for (int j = 0; j < s.size[k]; ++j) held[count++] = r + j;
    }
    return count;
}

// Redundant contacts share their load as equally stiff springs do in the limit of rigidity: the
// answer of W + g 1 for g → 0, from two small g by extrapolation. Proximal steps, W + g 1 beside
// b − g P of the step before, then bring that to an answer of W itself.
bool solve_redundant(const System& s, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    double *soft = arena.allocate(m, m), *softer = arena.allocate(m);
    add_to_diagonal(s, 2.0 * tolerance::compliance, soft);
    bool solved = solve_from(s, soft, P, steps, arena);
    std::copy(P, P + m, softer);
    add_to_diagonal(s, tolerance::compliance, soft);
    solved = solve_from(s, soft, P, steps, arena) && solved;
    for (int i = 0; i < m; ++i) P[i] = 2.0 * P[i] - softer[i];
    System step = s;
    step.b = arena.allocate(m);
    // If redundant rows contradict each other, a smaller compliance tells sooner which gives way.
    double compliance = tolerance::compliance;
    for (int count = 0; count < kProximalSteps; ++count, compliance *= 0.1) {
        for (int i = 0; i < m; ++i) step.b[i] = s.b[i] - compliance * s.mobility_ratio[i] * P[i];
        add_to_diagonal(s, compliance, soft);
        solved = solve_from(step, soft, P, steps, arena);
        if (residual_of(s, P, arena) <= tolerance::rounding * m) break;
    }
    return solved;
}

// P of velocities without what rounding of a motion left of them, as a start: where several answers
// are lawful the one of a symmetric impact is symmetric.
void start_without_noise(const System& s, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    System clear = s;
    clear.b = arena.allocate(s.rows);
    const double noise = tolerance::at_rest * largest(s.b, s.rows);
    bool is_noisy = false;
    for (int i = 0; i < s.rows; ++i) {
        const bool is_noise = s.b[i] != 0.0 && std::abs(s.b[i]) < noise;
        clear.b[i] = is_noise ? 0.0 : s.b[i];
        is_noisy = is_noisy || is_noise;
    }
    if (is_noisy) solve_redundant(clear, P, steps, arena);
}

// (rows) the square of each loaded row in the null space of all of them: what can be shared
// otherwise. Loaded are normals that press and, with them, groups within their cones.
void find_shares(const System& s, const double* P, double* shares, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    double *xi = arena.allocate(m), *own = arena.allocate(m, m), *projector = arena.allocate(m, m);
    int *held = arena.allocate_int(m), *order = arena.allocate_int(m);
    multiply(s.A, m, P, s.b, xi);
    int count = held_rows(s, P, xi, held);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) own[i * count + j] = s.A[held[i] * m + held[j]];
    int rank = factor_pivoted(own, count, order, tolerance::dependent);
    null_projector(own, order, count, rank, projector, arena);
    for (int i = 0; i < count; ++i) shares[held[i]] = projector[i * count + i];
}

// Start with all that approaches or adheres sticking, by one factorization; false where
// the rows that approach are of lower rank.
bool start_sticking(const System& s, double* P, Arena& arena) {
    Arena::Scope scope(arena);
    int *rows = arena.allocate_int(s.rows), *order = arena.allocate_int(s.rows);
    int count = 0;
    const auto acts = [&](int c) {
        return s.b[s.normal[c]] < 0.0 || s.floor[c] > 0.0 || s.adhesion[c] > 0.0;
    };
    for (int c = 0; c < s.contacts; ++c)
        if (acts(c)) rows[count++] = s.normal[c];
    for (int k = 0; k < s.groups; ++k) {
        int c = s.contact[k];
        if (c < 0 || acts(c))
            for (int j = 0; j < s.size[k]; ++j) rows[count++] = s.first[k] + j;
    }
    double *factor = arena.allocate(count, count), *x = arena.allocate(count);
    for (int i = 0; i < count; ++i) {
        x[i] = -s.b[rows[i]];
        for (int j = 0; j < count; ++j) factor[i * count + j] = s.A[rows[i] * s.rows + rows[j]];
    }
    if (factor_pivoted(factor, count, order, tolerance::dependent) < count) return false;
    solve_pivoted(factor, order, count, x, arena);
    for (int i = 0; i < count; ++i) P[rows[i]] = x[i];
    return true;
}

// P as it is on its cones: what parts, and what nothing presses, carries nothing.
void clear_open(const System& s, double* P, Arena& arena) {
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
    Cones bare;
    bare.normal = cones.normal;
    bare.floor.assign(cones.normal.size(), 0.0);
    bare.adhesion = bare.floor;
    const System s = build_system(W, rows, b, scale, bare, arena);
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
void write_back(const System& s, const Cones& cones, const double* own, int rows, double* P) {
    std::fill(P, P + rows, 0.0);
    for (int i = 0; i < s.rows; ++i) P[s.source[i]] = own[i] * s.unit[i] * s.velocity;
    for (int c = 0; c < s.contacts; ++c)
        if (own[s.normal[c]] == s.floor[c]) P[s.source[s.normal[c]]] = cones.floor[s.owner[c]];
}

}  // namespace

ConeSolution solve_cones(const double* W, int rows, const double* b, double scale,
                         const Cones& cones, double* P) {
    Arena& arena = scratch();
    Arena::Scope scope(arena);
    System s = build_system(W, rows, b, scale, cones, arena);
    ConeSolution solution;
    solution.unique.assign(cones.normal.size(), 1);
    double* own = arena.allocate(s.rows);
    double* shares = arena.allocate(s.rows);
    if (!start_sticking(s, own, arena) || !newton(s, s.A, own, solution.steps, arena)) {
        std::fill(own, own + s.rows, 0.0);
        start_without_noise(s, own, solution.steps, arena);
        solve_redundant(s, own, solution.steps, arena);
        find_shares(s, own, shares, arena);
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
    System s = build_system(W, rows, b, scale, cones, arena);
    double* own = arena.allocate(s.rows);
    for (int i = 0; i < s.rows; ++i) own[i] = P[s.source[i]] / (s.unit[i] * s.velocity);
    return residual_of(s, own, arena);
}

void newton_on_cones(const double* W, int rows, const double* b, double scale, const Cones& cones,
                     double* P) {
    Arena& arena = scratch();
    Arena::Scope scope(arena);
    System s = build_system(W, rows, b, scale, cones, arena);
    double* own = arena.allocate(s.rows);
    for (int i = 0; i < s.rows; ++i) own[i] = P[s.source[i]] / (s.unit[i] * s.velocity);
    int steps = 0;
    newton(s, s.A, own, steps, arena);
    write_back(s, cones, own, rows, P);
}

}  // namespace impulsekit
