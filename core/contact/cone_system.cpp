#include "contact/cone_system.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

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
void scale_system(ConeSystem& s, const double* W, int rows, const double* b, double scale,
                  const Cones& cones, Arena& arena) {
    s.A = arena.allocate(s.rows, s.rows);
    s.mobility = cones.mobility ? arena.allocate(s.rows, s.rows) : s.A;
    const auto in_units = [&](const double* matrix, double* own) {
        for (int i = 0; i < s.rows; ++i)
            for (int j = 0; j < s.rows; ++j)
                own[i * s.rows + j] =
                    s.unit[i] * matrix[s.source[i] * rows + s.source[j]] * s.unit[j];
    };
    in_units(W, s.A);
    if (cones.mobility) in_units(cones.mobility, s.mobility);
    s.b = arena.allocate(s.rows);
    double fastest = 0.0;
    for (int i = 0; i < s.rows; ++i) {
        s.b[i] = s.unit[i] * b[s.source[i]];
        fastest = std::max({fastest, std::abs(s.b[i]), s.unit[i] * scale * 1e-3});
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

}  // namespace

double hypot_of(const double* x, int size) {
    return size == 1 ? std::abs(x[0]) : std::sqrt(x[0] * x[0] + x[1] * x[1]);
}

ConeSystem build_system(const double* W, int rows, const double* b, double scale,
                        const Cones& cones, Arena& arena) {
    ConeSystem s;
    const int n = cones.contacts, g = cones.groups;
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
    s.even = arena.allocate(g);
    s.balance = arena.allocate(g);
    std::fill(s.even, s.even + g, 1.0);
    std::fill(s.balance, s.balance + g, 1.0);
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

double radius_of(const ConeSystem& s, int group, const double* P, const double* xi) {
    const int c = s.contact[group];
    if (c < 0) return s.friction[group];
    const int n = s.normal[c];
    return s.friction[group] * (std::max(s.floor[c], P[n] - xi[n]) + s.adhesion[c]);
}

void natural_map_residual(const ConeSystem& s, const double* balance, const double* P,
                          const double* xi, double* F) {
    for (int c = 0; c < s.contacts; ++c) {
        int r = s.normal[c];
        F[r] = P[r] - std::max(s.floor[c], P[r] - xi[r]);
    }
    for (int k = 0; k < s.groups; ++k) {
        int r = s.first[k], size = s.size[k];
        double radius = radius_of(s, k, P, xi), rho = balance[k], trial[2];
        for (int j = 0; j < size; ++j) trial[j] = P[r + j] - rho * xi[r + j];
        double length = hypot_of(trial, size);
        for (int j = 0; j < size; ++j)
            F[r + j] = length <= radius ? rho * xi[r + j] : P[r + j] - radius * trial[j] / length;
    }
}

void natural_map_jacobian(const ConeSystem& s, const double* A, const double* balance,
                          const double* P, const double* xi, double* J) {
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
        double radius = radius_of(s, k, P, xi), rho = balance[k], trial[2];
        for (int j = 0; j < size; ++j) trial[j] = P[r + j] - rho * xi[r + j];
        double length = hypot_of(trial, size);
        if (length <= radius) {
            for (int q = r * m; q < (r + size) * m; ++q) J[q] = rho * A[q];
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
                for (int q = 0; q < m; ++q) row[q] += weight * rho * own[q];
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

double residual_of(const ConeSystem& s, const double* P, Arena& arena) {
    Arena::Scope scope(arena);
    double* xi = arena.allocate(s.rows);
    double* F = arena.allocate(s.rows);
    multiply(s.A, s.rows, P, s.b, xi);
    natural_map_residual(s, s.even, P, xi, F);
    return largest(F, s.rows);
}

}  // namespace impulsekit
