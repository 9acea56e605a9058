// The bilateral rows of a scene at a state, for one state or eight side by side.
#pragma once

#include <algorithm>
#include <cmath>

#include "linalg/arena.hpp"
#include "scene/frame_pair.hpp"

namespace impulsekit {

// Mark the lanes in which two points of a line coincide.
template <typename S>
void find_line(const FramePairState<S>& pair, bool* has_line) {
    const Vec3<S> offset = pair.place - pair.other_place;
    const S square = dot(offset, offset);
    for (int k = 0; k < Number<S>::lanes; ++k)
        if (!(Number<S>::get(square, k) > tolerance::no_length * tolerance::no_length))
            has_line[k] = false;
}

// Length of the vectors of an entry over that of its rows: a vector is as long as its longest
// axis, held or not. Of one that is shorter than rounding (`least` [m]) rows are cleared. `six`:
// (6, nv) of the pair; `A` (count, nv) and `wider` (count) of the entry.
template <typename S>
void set_widening(const Held& held, const S* six, const S& least, int nv, S* A, S* wider) {
    const auto get = [](const S& x, int k) { return Number<S>::get(x, k); };
    S squares[6] = {};
    for (int r = 0; r < 6; ++r)
        for (int i = 0; i < nv; ++i) squares[r] += six[r * nv + i] * six[r * nv + i];
    for (int k = 0; k < Number<S>::lanes; ++k) {
        const double bars[2] = {get(least, k), tolerance::sums};
        double longest[2] = {}, own[2] = {};
        for (int r = 0; r < 6; ++r) longest[r / 3] = std::max(longest[r / 3], get(squares[r], k));
        for (int r = 0; r < held.count; ++r) {
            const int axis = held.select[r];
            own[axis / 3] = std::max(own[axis / 3], get(squares[axis], k));
        }
        for (int r = 0; r < held.count; ++r) {
            const int vector = held.select[r] / 3;
            const double ratio = own[vector] > 0.0 ? longest[vector] / own[vector] : 1.0;
            Number<S>::set(wider[r], k, std::sqrt(ratio));
            if (longest[vector] > bars[vector] * bars[vector]) continue;
            for (int i = 0; i < nv; ++i) Number<S>::set(A[r * nv + i], k, 0.0);
        }
    }
}

// Write A (rows, nv) of the first `entries` and `wider` (rows), see StateRows; the tree with
// places. `given`: of each lane. Lanes in which a line has no direction are marked in `has_line`.
template <typename S>
void write_constraint_rows(const Scene& scene, int entries, const Tree<S>& tree,
                           const GivenState* given, S* A, S* wider, bool* has_line) {
    const int nv = scene.model->nv;
    const Arena::Scope scope(scratch());
    S* six = scratch().allocate_of<S>(6 * nv);
    int function = 0;
    for (int e = 0; e < entries; ++e) {
        const Held& held = scene.held[e];
        S* rows = A + held.row * nv;
        std::fill(rows, rows + held.count * nv, S{});
        std::fill(wider + held.row, wider + held.row + held.count, number<S>(1.0));
        if (held.kind == Held::pair) {
            const FramePairState<S> pair = frame_pair_state(tree, held.frames);
            if (pair.carrier == Carrier::line) find_line(pair, has_line);
            std::fill(six, six + 6 * nv, S{});
            add_rows(tree, pair, six, six + 3 * nv);
            for (int r = 0; r < held.count; ++r)
                std::copy_n(six + held.select[r] * nv, nv, rows + r * nv);
            set_widening(held, six, rounding_of(pair.place), nv, rows, wider + held.row);
        }
        for (const Held::Term& term : held.terms)
            rows[term.row * nv + term.v] += number<S>(term.factor);
        if (held.kind == Held::functions) {
            for (int i = 0; i < held.count * nv; ++i)
                for (int k = 0; k < Number<S>::lanes; ++k)
                    Number<S>::set(rows[i], k, given[k].function_rows[function * nv + i]);
            function += held.count;
        }
    }
}

}  // namespace impulsekit
