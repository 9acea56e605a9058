// Bilateral rows eliminated: W λ = r with W = A M⁻¹ Aᵀ, and the one decision of their rank.
#pragma once

#include <vector>

namespace impulsekit {

// Half-solved rows C = D^-½ L⁻ᵀ Aᵀ of one configuration, W = Cᵀ C. A row is dependent if it stands
// less than 1e-7 out of the span of the others, in units of the longest row of its vector (the axes
// of one velocity), so that neither units nor axes in which rows are written decide.
class BilateralRows {
  public:
    // half: (m, nv) row by row; vectors: (m) a number for each row, the same for axes of one
    // vector; wider: (m) by how much each vector is longer than its longest row; null where all
    // are 1.
    BilateralRows(const double* half, int m, int nv, const int* vectors,
                  const double* wider = nullptr);

    // λ (m) with W λ = wanted, of least scaled norm where rows are redundant, and what the rows
    // lack of `wanted` (m): above rounding where dependent rows want different things.
    void solve(const double* target, double* impulse, double* shortfall) const;

    // x (nv) less its part in the span of the rows.
    void project_out(double* x) const;

    int rank() const { return rank_; }
    int count() const { return m_; }
    int size() const { return nv_; }
    // (m) the independent rows first, then those that they imply or that move nothing.
    const std::vector<int>& order() const { return order_; }
    // True if rows were taken for dependent that are so within the tolerance only.
    bool nearly_dependent() const { return nearly_; }
    // (m) whether a row's impulse is determined.
    const std::vector<char>& unique() const { return unique_; }
    // Share of its terms below which what the rows leave of another row is rounding.
    double rounding_of_span() const;

  private:
    void orthogonalize(std::vector<double>& rows);
    void find_shares();
    // z ← (1 + S Sᵀ)⁻¹ z
    void solve_gram(double* z) const;

    int m_, nv_, rank_ = 0;
    bool nearly_ = false;
    double least_ = 1.0;          // smallest pivot, of unit rows
    std::vector<double> length_;  // (m) scale of each row; 0 for rows of no effect
    std::vector<int> order_;      // (m) independent rows first
    std::vector<double> basis_;   // (rank, nv) orthonormal
    std::vector<double> upper_;   // (rank, m) R: scaled row order[j] = Σ_i R(i, j) basis_i
    std::vector<double> shares_;  // (m − rank, rank) of independent rows in the others
    std::vector<double> gram_;    // Cholesky factor of 1 + S Sᵀ
    std::vector<char> unique_;
};

}  // namespace impulsekit
