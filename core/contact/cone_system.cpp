#include "contact/cone_system.hpp"

namespace impulsekit {

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

}  // namespace impulsekit
