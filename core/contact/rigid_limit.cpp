#include "contact/rigid_limit.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Most steps from an answer that is near, and halvings of one.
constexpr int kSteps = 15, kHalvings = 8;

// P = Π(z), and ∂P/∂z of each row: by the two rows of its group, and by the normal of its contact.
struct Projection {
    double *P, *by_group, *by_normal;  // (rows), (rows, 2), (rows)

    Projection(int rows, Arena& arena)
        : P(arena.allocate(rows)),
          by_group(arena.allocate(rows, 2)),
          by_normal(arena.allocate(rows)) {}
};

void project(const ConeSystem& s, const double* z, Projection& to) {
    for (int c = 0; c < s.contacts; ++c) {
        const int r = s.normal[c];
        const bool pushes = z[r] > s.floor[c];
        to.P[r] = pushes ? z[r] : s.floor[c];
        to.by_group[2 * r] = pushes ? 1.0 : 0.0;
    }
    for (int k = 0; k < s.groups; ++k) {
        const int r = s.first[k], size = s.size[k], c = s.contact[k];
        const int n = c < 0 ? -1 : s.normal[c];
        const double radius = s.friction[k] * (c < 0 ? 1.0 : to.P[n] + s.adhesion[c]);
        const double length = hypot_of(z + r, size);
        const bool is_inside = length <= radius;
        for (int j = 0; j < size; ++j) {
            const double along = is_inside ? 0.0 : z[r + j] / length;
            to.P[r + j] = is_inside ? z[r + j] : radius * along;
            to.by_normal[r + j] = c < 0 ? 0.0 : s.friction[k] * along * to.by_group[2 * n];
            for (int i = 0; i < size; ++i) {
                const double own = i == j ? 1.0 : 0.0;
                to.by_group[2 * (r + j) + i] =
                    is_inside ? own : radius / length * (own - along * z[r + i] / length);
            }
        }
    }
}

// J = B ∂P/∂z + C.
void build_jacobian(const ConeSystem& s, const Projection& at, const double* B, const double* C,
                    double* J) {
    const int m = s.rows;
    for (int row = 0; row < m; ++row) {
        const double *b = B + row * m, *own = C + row * m;
        double* out = J + row * m;
        for (int c = 0; c < s.contacts; ++c) {
            const int n = s.normal[c];
            out[n] = own[n] + b[n] * at.by_group[2 * n];
        }
        for (int k = 0; k < s.groups; ++k) {
            const int r = s.first[k], size = s.size[k], c = s.contact[k];
            for (int i = 0; i < size; ++i) {
                out[r + i] = own[r + i];
                for (int j = 0; j < size; ++j)
                    out[r + i] += b[r + j] * at.by_group[2 * (r + j) + i];
                if (c >= 0) out[s.normal[c]] += b[r + i] * at.by_normal[r + i];
            }
        }
    }
}

// A zero of B Π(z) + C z + b near z by Newton's method, with P = Π(z).
bool find_zero(const ConeSystem& s, const double* B, const double* C, double* z, double* P,
               int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    Projection at(m, arena);
    double *left = arena.allocate(m), *J = arena.allocate(m, m), *step = arena.allocate(m),
           *trial = arena.allocate(m);
    int* pivot = arena.allocate_int(m);
    const auto norm_at = [&](const double* x) {
        project(s, x, at);
        multiply(C, m, x, s.b, left);
        multiply(B, m, at.P, left, left);
        return dot(left, left, m);
    };
    double norm = norm_at(z);
    for (int count = 0; count < kSteps; ++count, ++steps) {
        const double size = tolerance::sums * std::max(1.0, largest(at.P, m));
        if (norm <= size * size) {
            std::copy(at.P, at.P + m, P);
            return true;
        }
        build_jacobian(s, at, B, C, J);
        if (!factor_lu(J, m, pivot)) return false;
        std::copy(left, left + m, step);
        solve_lu(J, pivot, m, step);
        double share = 1.0, found = INFINITY;
        for (int half = 0; half <= kHalvings && !(found < norm); ++half, share *= 0.5) {
            for (int i = 0; i < m; ++i) trial[i] = z[i] - share * step[i];
            found = norm_at(trial);
        }
        if (!(found < norm)) return false;
        std::copy(trial, trial + m, z);
        norm = found;
    }
    return false;
}

}  // namespace

bool solve_rigid_limit(const ConeSystem& s, double compliance, const int* still, int count,
                       const double* projector, double* P, int& steps, Arena& arena) {
    Arena::Scope scope(arena);
    const int m = s.rows;
    // The equations as B Π(z) + C z + b.
    double *B = arena.allocate(m, m), *C = arena.allocate(m, m), *xi = arena.allocate(m),
           *z = arena.allocate(m);
    multiply(s.A, m, P, s.b, xi);
    balance_groups(s, P, xi);
    std::copy(s.A, s.A + m * m, B);
    const auto add_moving = [&](int r, double rho) {
        z[r] = P[r] - rho * (xi[r] + compliance * s.mobility_ratio[r] * P[r]);
        B[r * m + r] -= 1.0 / rho;
        C[r * m + r] = 1.0 / rho;
    };
    for (int c = 0; c < s.contacts; ++c) add_moving(s.normal[c], 1.0);
    for (int k = 0; k < s.groups; ++k)
        for (int j = 0; j < s.size[k]; ++j) add_moving(s.first[k] + j, s.balance[k]);
    for (int i = 0; i < count; ++i) {
        const int r = still[i];
        z[r] = P[r] - xi[r] / compliance - s.mobility_ratio[r] * P[r];
        std::copy(s.A + r * m, s.A + (r + 1) * m, B + r * m);
        std::fill(C + r * m, C + (r + 1) * m, 0.0);
        const double root = std::sqrt(s.mobility_ratio[r]);
        for (int j = 0; j < count; ++j) {
            const double own = std::sqrt(s.mobility_ratio[still[j]]);
            const double shared = root * projector[i * count + j];
            B[r * m + still[j]] += shared * (own - 1.0 / own);
            C[r * m + still[j]] = shared / own;
        }
    }
    return find_zero(s, B, C, z, P, steps, arena);
}

}  // namespace impulsekit
