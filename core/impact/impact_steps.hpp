// The steps of an impact that are the same whatever the law: one state, or eight side by side.
#pragma once

#include <algorithm>

#include "contact/tolerances.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"
#include "linalg/numbers.hpp"
#include "linalg/poll.hpp"
#include "spatial/mass_factor.hpp"

namespace impulsekit {

// M Δv = I + JᵀP of what has been half-solved: C = D^-½ L⁻ᵀ Jᵀ, so that W = Cᵀ C. All arrays are in
// the thread's scratch memory.
template <typename S>
class ImpactSteps {
  public:
    static constexpr int lanes = Number<S>::lanes;
    // Steps at most by which rounding of large shares is brought down.
    static constexpr int kRefinements = 3;

    const int nv, rows;
    const S *v, *J;         // (nv), (rows, nv)
    S *M, *before;          // (nv, nv) all of it; (rows) J v⁻
    const S* impulse;       // (nv) I of the known impulses; null for none
    S* right;               // (nv) I, and what fills up a singular M
    S *blow, *start;        // (nv) half-solved, and with what bilateral rows add to it
    S *half, *free, *W;     // (rows, nv) half-solved J; (rows); (rows, rows)
    S *P, *after, *in_use;  // (rows); 0 in lanes in which a row does not act, else 1
    S* dv;                  // (rows), (rows), (nv)
    int* touched;           // (nv) whether something touches the tree that begins there

    // `kept_half`, `kept_W`: where these stay after the call; null for scratch memory.
    ImpactSteps(const S* given_M, int size, const S* given_v, const S* given_impulse,
                const S* given_J, int count, S* kept_half = nullptr, S* kept_W = nullptr)
        : nv(size),
          rows(count),
          v(given_v),
          J(given_J),
          M(take(nv * nv)),
          before(take(rows)),
          impulse(given_impulse),
          right(take(nv)),
          blow(take(nv)),
          start(take(nv)),
          half(kept_half ? kept_half : take(rows * nv)),
          free(take(rows)),
          W(kept_W ? kept_W : take(rows * rows)),
          P(take(rows)),
          after(take(rows)),
          in_use(take(rows)),
          dv(take(nv)),
          touched(scratch().allocate_int(nv)) {
        for (int i = 0; i < nv; ++i)
            for (int j = 0; j <= i; ++j) M[i * nv + j] = M[j * nv + i] = given_M[i * nv + j];
        for (int r = 0; r < rows; ++r) before[r] = dot(J + r * nv, v, nv);
        if (impulse) std::copy(impulse, impulse + nv, right);
        std::fill(in_use, in_use + rows, number<S>(1.0));
    }

    // Trees that nothing touches stay as they are, whatever their inertia. `A`: (m, nv) further
    // rows that touch.
    void exclude_untouched(const int* parent, const S* A, int m) {
        int *tree = scratch().allocate_int(nv), left = 0;
        for (int k = 0; k < nv; ++k) {
            tree[k] = parent[k] < 0 ? k : tree[parent[k]];
            left += parent[k] < 0;
        }
        const auto mark = [&](const S* all, int count) {
            for (int r = 0; r < count; ++r)
                for (int k = 0; k < nv && left > 0; ++k) {
                    if (touched[tree[k]] || !any(all[r * nv + k] != 0.0)) continue;
                    touched[tree[k]] = 1;
                    --left;
                }
        };
        mark(A, m);
        mark(J, rows);
        if (impulse) mark(impulse, 1);
        for (int i = 0; i < nv && left > 0; ++i) {
            if (touched[tree[i]]) continue;
            std::fill(M + i * nv, M + (i + 1) * nv, S{});
            M[i * nv + i] = number<S>(1.0);
        }
    }

    // Half-solve the known impulses, and the contacts; and their velocities without contacts.
    void begin(const MassFactorOf<S>& mass) {
        std::copy(right, right + nv, start);
        mass.half(start);
        std::copy(start, start + nv, blow);
    }

    void add_contacts(const MassFactorOf<S>& mass) {
        std::copy(J, J + rows * nv, half);
        for (int r = 0; r < rows; r += 3) mass.template half<3>(half + r * nv);
    }
    void set_free() {
        for (int r = 0; r < rows; ++r) free[r] = before[r] + dot(half + r * nv, start, nv);
    }

    // W of half-solved rows, less what bilateral rows hold of them.
    void set_delassus(const S* left) {
        for (int i = 0; i < rows; ++i) {
            poll(i, nv);
            for (int j = 0; j <= i; ++j)
                W[i * rows + j] = W[j * rows + i] = dot(left + i * nv, left + j * nv, nv);
        }
    }

    // Δv of `start` and P; `change` (nv) is half of it.
    void add_impulses(S* change) const {
        std::copy(start, start + nv, change);
        add_transposed(half, rows, nv, P, change);
    }

    void finish(const MassFactorOf<S>& mass, const S* change) {
        std::copy(change, change + nv, dv);
        mass.rest(dv);
    }

    // If W P has lost digits in a lane, its law is solved again with the velocities that Δv makes:
    // `solve` of a lane sets P and `after` there and returns whether it has an answer, `respond`
    // sets Δv of P. `has_answer`: (lanes).
    template <typename Solve, typename Respond, typename Sharpen>
    void refine(bool* has_answer, Solve solve, Respond respond, Sharpen sharpen) {
        S *made = take(rows), *kept = take(nv);
        const double rounding = std::max(tolerance::sums, rows * tolerance::rounding);
        for (int round = 0; round < kRefinements; ++round) {
            S off{}, size{};
            for (int r = 0; r < rows; ++r) {
                made[r] = before[r] + dot(J + r * nv, dv, nv);
                off = larger(off, in_use[r] * magnitude(made[r] - after[r]));
                size = larger(size, in_use[r] * larger(magnitude(made[r]), magnitude(before[r])));
            }
            bool lost[lanes], is_lost = false;
            for (int k = 0; k < lanes; ++k) {
                const double bar = rounding * Number<S>::get(size, k);
                lost[k] = has_answer[k] && !(Number<S>::get(off, k) <= bar);
                is_lost = is_lost || lost[k];
            }
            if (!is_lost) return;
            std::copy(dv, dv + nv, kept);
            for (int k = 0; k < lanes; ++k) {
                if (!lost[k]) continue;
                for (int r = 0; r < rows; ++r)
                    // A row that bilateral rows hold wholly no impulse changes: rounding must not
                    // say that it approaches.
                    if (Number<S>::get(W[r * rows + r], k) > 0.0)
                        Number<S>::set(free[r], k, Number<S>::get(free[r] + made[r] - after[r], k));
                has_answer[k] = solve(k);
            }
            respond();
            sharpen();
            for (int k = 0; k < lanes; ++k)
                for (int i = 0; i < nv && !lost[k]; ++i)
                    Number<S>::set(dv[i], k, Number<S>::get(kept[i], k));
        }
    }

    // Δv once more from what M Δv lacks of the impulses of all rows, `left` (nv) those of others.
    void sharpen(const MassFactorOf<S>& mass, S* left) {
        for (int i = 0; i < nv && impulse; ++i) left[i] += impulse[i];
        add_transposed(J, rows, nv, P, left);
        for (int i = 0; i < nv; ++i) left[i] -= dot(M + i * nv, dv, nv);
        mass.solve(left);
        for (int i = 0; i < nv; ++i) dv[i] += left[i];
    }

    // Σ |row_k| (|v_k| + |Δv_k|): the terms that a row's velocities are sums of; `speeds` are those
    // of `add_up_speeds`.
    S* add_up_speeds() const {
        S* speeds = take(nv);
        for (int k = 0; k < nv; ++k) speeds[k] = magnitude(v[k]) + magnitude(dv[k]);
        return speeds;
    }
    S terms_of(const S* row, const S* speeds) const { return dot_of_sizes(row, speeds, nv); }

    // The backward error of M Δv = I + JᵀP + rows that `add(left, size)` adds, relative to its
    // terms, |Δv| of them in the metric of M.
    template <typename Add>
    S momentum_residual(Add add) const {
        S *left = take(nv), *size = take(nv);
        // For resting bodies that are struck the velocities that the blow alone would make are the
        // measure.
        S twice = impulse ? dot(blow, blow, nv) : S{};
        int first = 0;
        for (; first + 4 <= nv; first += 4) subtract_momentum<4>(first, left, size);
        for (; first < nv; ++first) subtract_momentum<1>(first, left, size);
        twice -= dot(left, dv, nv);
        if (impulse) add_sizes(impulse, 1, nv, nullptr, left, size);
        add(left, size);
        add_sizes(J, rows, nv, P, left, size);
        S worst{};
        for (int i = 0; i < nv; ++i) {
            // With unphysical inertias either may be negative: then they measure nothing.
            const S own = size[i] + root(larger(S{}, twice * M[i * nv + i]));
            worst = larger(worst, ratio_of(magnitude(left[i]), own));
        }
        return worst;
    }

    // Rows times x, or as they are, to sums and to sums of sizes.
    static void add_sizes(const S* all, int count, int size, const S* x, S* sum, S* sizes) {
        for (int r = 0; r < count; ++r)
            for (int i = 0; i < size; ++i) {
                const S own = x ? all[r * size + i] * x[r] : all[r * size + i];
                sum[i] += own;
                sizes[i] += magnitude(own);
            }
    }

    // J v⁺ beside the law's u⁺ in the first `count` rows, relative to their terms.
    S contact_residual(const S* speeds, int count) const {
        S off{}, terms{};
        for (int r = 0; r < count; ++r) {
            const S* row = J + r * nv;
            off = larger(off, in_use[r] * magnitude(before[r] + dot(row, dv, nv) - after[r]));
            S own = terms_of(row, speeds);
            if (impulse) own += magnitude(dot(half + r * nv, blow, nv));
            terms = larger(terms, in_use[r] * own);
        }
        return ratio_of(off, terms);
    }

  private:
    static S* take(int count) { return scratch().allocate_of<S>(count); }

    // Rows of M Δv from the first on, and the sizes of their terms; side by side in registers.
    template <int count>
    void subtract_momentum(int first, S* left, S* size) const {
        S off[count] = {}, all[count] = {};
        for (int k = 0; k < nv; ++k)
            for (int i = 0; i < count; ++i) {
                const S own = M[k * nv + first + i] * dv[k];
                off[i] -= own;
                all[i] += magnitude(own);
            }
        std::copy(off, off + count, left + first);
        std::copy(all, all + count, size + first);
    }

    static S ratio_of(const S& part, const S& whole) { return whole > 0.0 ? part / whole : S{}; }
};

}  // namespace impulsekit
