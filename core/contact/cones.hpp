// The one cone solver: contacts that push, each with cones of friction over its normal impulse.
#pragma once

#include <vector>

#include "linalg/arena.hpp"

namespace impulsekit {

// n contacts in the rows of P, ξ = W P + b. With P_n the impulse along a contact's normal,
//     P_n >= floor,  ξ_n >= 0,  (P_n − floor) ξ_n = 0,
// and for each group g of one or two rows
//     |P_g| <= µ_g (P_n + A),  P_g = −µ_g (P_n + A) ξ_g/|ξ_g| where ξ_g is not 0.
// A contact that only pushes has floor 0 and A = 0; one that holds a pull of A has floor −A
// (Moreau's unilateral contact shifted along its normal; Raous, Cangémi & Cocu 1999 for the cone).
// A group whose contact is −1 has a radius of its own in place of µ (P_n + A): |P_g| <= µ_g [N s].
// Coulomb's friction is a group of the two tangents; rolling friction one of two moments, torsional
// friction one of one moment, with µ_g a length.
template <typename S>
struct ConesOf {
    int contacts = 0, groups = 0;  // n and g
    int* normal;                   // (n) row of each contact's normal
    S *floor, *adhesion;           // (n) [N s], A [N s]
    int *first, *size;             // (g) first row of each group; 1 or 2
    int* contact;                  // (g) whose normal impulse bounds it; −1 for none
    S* friction;                   // (g) µ_g
    // (rows, rows) W, where the columns of normals have the friction of what slides in them besides
    const S* mobility = nullptr;

    // Room for so many, for as long as the scratch memory is not given back.
    ConesOf(int most_contacts, int most_groups, Arena& arena)
        : normal(arena.allocate_int(most_contacts)),
          floor(arena.allocate_of<S>(most_contacts)),
          adhesion(arena.allocate_of<S>(most_contacts)),
          first(arena.allocate_int(most_groups)),
          size(arena.allocate_int(most_groups)),
          contact(arena.allocate_int(most_groups)),
          friction(arena.allocate_of<S>(most_groups)) {}

    void add_contact(int row, const S& least, const S& pull) {
        normal[contacts] = row;
        floor[contacts] = least;
        adhesion[contacts++] = pull;
    }
    void add_group(int row, int count, int of_contact, const S& reach) {
        first[groups] = row;
        size[groups] = count;
        contact[groups] = of_contact;
        friction[groups++] = reach;
    }
};

using Cones = ConesOf<double>;

template <typename S>
struct ConeSolutionOf {
    S residual{};             // of the natural map, relative
    int steps = 0;            // of Newton's method
    bool immovable = false;   // a contact approaches that no impulse moves
    bool infeasible = false;  // no impulse makes all ξ_n >= 0
};

using ConeSolution = ConeSolutionOf<double>;

// Solve for P (rows), which is overwritten. `scale`: the size of the velocities from which b came
// [m/s], against which rounding counts; W is (rows, rows). `shares`: (n) the square of each
// contact's rows in the null space of all that are held, above `tolerance::shared` where its
// impulse is not determined; may be null.
ConeSolution solve_cones(const double* W, int rows, const double* b, double scale,
                         const Cones& cones, double* P, double* shares = nullptr);

// The residual of a given P, as `solve_cones` measures it.
double cone_residual(const double* W, int rows, const double* b, double scale, const Cones& cones,
                     const double* P);

// Newton's method from a given P, which is overwritten; for what is looked for near it.
void newton_on_cones(const double* W, int rows, const double* b, double scale, const Cones& cones,
                     double* P);

}  // namespace impulsekit
