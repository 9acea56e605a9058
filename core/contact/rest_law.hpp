// Coulomb's law for forces at points that rest, and for joints with dry friction.
#pragma once

#include <vector>

namespace impulsekit {

// a = b + W F over three rows for each point (two tangents, the normal), then three for each of the
// points that resist turning, then one for each joint that stands still. A point pushes, F_n >= 0
// and a_n >= 0, one of them zero; what keeps still has |F_t| <= µ F_n against its acceleration, and
// what slides F_t = −µ F_n s. A point with a load has that for F_n, of which b knows already, as
// it knows of its sliding.
struct RestProblem {
    int points = 0, turning = 0, joints = 0;
    const double* W = nullptr;      // (rows, rows)
    const double* b = nullptr;      // (rows)
    const double* reach = nullptr;  // (points + 2 turning) µ; then rolling [m], torsion [m]
    // (points + 2 turning, 2) s where it moves, zeros where it keeps still
    const double* direction = nullptr;
    const double* load = nullptr;     // (points) a known F_n, NAN where there is none; may be null
    const int* turning_of = nullptr;  // (turning) the point
    const double* bound = nullptr;    // (joints) the largest friction

    int rows() const { return 3 * (points + turning) + joints; }
};

// Forces F (rows) and accelerations a (rows); false where none obey the law. `pressed`: (points)
// which points push, as a guess, and as found.
bool solve_rest(const RestProblem& problem, char* pressed, double* F, double* a);

// (rows, rows) ∂F/∂b while what is pressed keeps still and what holds holds.
void rest_slopes(const RestProblem& problem, char* pressed, double* slopes);

}  // namespace impulsekit
