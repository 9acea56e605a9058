// Redundant contacts share their load as equally stiff springs do in the limit of rigidity.
#pragma once

#include "contact/cone_newton.hpp"

namespace impulsekit {

// Held rows, and the pivoted factor of their D^-½ A D^-½, D the shares of a compliance.
struct Held {
    int count = 0, rank = 0;
    bool is_factored = false;  // the factor is that of these rows
    int *rows = nullptr, *order = nullptr;
    double *root = nullptr, *factor = nullptr;  // D^½ (count), (count, count)
    double* projector = nullptr;                // (count, count) N onto its null space

    Held(const ConeSystem& s, Arena& arena)
        : rows(arena.allocate_int(s.rows)),
          order(arena.allocate_int(s.rows)),
          root(arena.allocate(s.rows)),
          factor(arena.allocate(s.rows, s.rows)),
          projector(arena.allocate(s.rows, s.rows)) {}

    bool is_redundant() const { return rank < count; }
};

// P by one factorization where all that acts sticks; where it is of full rank Newton's method goes
// on from there. False where neither is the answer.
bool solve_from_sticking(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena);

// Redundant contacts share their load as equally stiff springs do in the limit of rigidity: from
// answers of two small compliances, which tell the rows that are still there, to the limit itself.
bool solve_redundant(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena);

// P of velocities without what rounding of a motion left of them, as a start: where several answers
// are lawful the one of a symmetric impact is symmetric.
void start_without_noise(const ConeSystem& s, Held& held, double* P, int& steps, Arena& arena);

// (rows) the square of each held row in the null space of all of them: what can be shared
// otherwise. What touches without load could bear some.
void find_shares(const ConeSystem& s, const double* P, Held& held, double* shares, Arena& arena);

}  // namespace impulsekit
