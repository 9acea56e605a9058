// The mass matrix under bilateral rows: what impulses do where these hold.
#pragma once

#include <optional>
#include <vector>

#include "impact/bilateral.hpp"
#include "spatial/mass_factor.hpp"

namespace impulsekit {

// Bilateral rows A (count, nv) and what ImpactProblem says of them.
struct ConstraintRows {
    int count = 0;
    const double* A = nullptr;
    const int* vectors = nullptr;
    const double* wider = nullptr;
};

// M factored, or M + UᵀU with the bilateral rows U of unit length where M alone is singular: with
// A Δv = c prescribed, (M + UᵀU) Δv = I + Uᵀ u + Aᵀλ has the same solution. Half-solved rows are
// C = D^-½ L⁻ᵀ Aᵀ, so that A M⁻¹ Aᵀ = Cᵀ C.
class ConstrainedMass {
  public:
    // M (nv, nv) symmetric; `parent` as MassFactor takes it. False where a degree of freedom,
    // `weak`, has no mass that the rows make up for. A outlives what is asked of it.
    bool factor(const double* M, const int* parent, int nv, const ConstraintRows& rows);

    // The same of one of eight states without rows whose M was factored.
    void take(const MassFactorOf<Pack>& factored, int lane, int nv) {
        nv_ = nv;
        given_ = {};
        weak_ = -1;
        is_filled_ = false;
        rows_.reset();
        half_.clear();
        factored.extract(lane, mass_);
    }

    int weak() const { return weak_; }
    bool is_filled() const { return is_filled_; }
    // Add what goes with A Δv = target to an impulse (nv), where M is filled.
    void fill(const double* target, double* impulse) const;

    const MassFactor& mass() const { return mass_; }
    // (count, nv) half-solved rows, and their rank, which only they have.
    const double* half() const { return half_.data(); }
    const BilateralRows& rows() const { return *rows_; }

    // By how much rows that depend on each other demand different velocities, and the terms that
    // these are sums of.
    struct Disagreement {
        double apart = 0.0, terms = 0.0;
    };
    // Change a half-solved x (nv) by the impulses that bring its rows to `demand` (count), and add
    // these to λ (count). If dependent rows disagree, each gives way: demand is then what they
    // get.
    Disagreement apply_multipliers(double* demand, double* x, double* multipliers) const;

    // Take what the rows hold off half-solved rows of points, three of each: `left` (count, nv)
    // begins as `half`. (count) marks rows of which only rounding is left, which are cleared.
    std::vector<char> project_out_constraints(const double* half, int count, double* left) const;

    // For points' rows (count, nv), three of each: Δv (count, nv) and λ (count, rows) of unit
    // impulses, and W (count, count), where the rows hold.
    void respond(const double* points, int count, std::vector<double>& velocity_changes,
                 std::vector<double>& unit_multipliers, std::vector<double>& W) const;

  private:
    bool fill_mass(const double* M);

    int nv_ = 0, weak_ = -1;
    bool is_filled_ = false;
    ConstraintRows given_;
    MassFactor mass_;
    std::vector<double> half_,
        squares_;  // (count, nv); (count) of rows in the metric of M's diagonal
    std::optional<BilateralRows> rows_;
};

}  // namespace impulsekit
