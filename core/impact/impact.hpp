// One impact in generalized coordinates: M Δv = I + Aᵀλ + JᵀP, A v⁺ = b, P by the law of contact.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "contact/problem.hpp"

namespace impulsekit {

// A state's numbers. All arrays are row-major and outlive the call.
struct ImpactProblem {
    int nv = 0;
    const double* M = nullptr;        // (nv, nv), its lower triangle
    const int* parent = nullptr;      // (nv) degree of freedom that each hangs on, −1 for none
    const double* v = nullptr;        // (nv) v⁻
    const double* impulse = nullptr;  // (nv) I of the known impulses; null for none

    int bilateral = 0;
    const double* A = nullptr;       // (bilateral, nv)
    const double* target = nullptr;  // (bilateral) b, the rows' velocities after the impact
    const int* vectors = nullptr;  // (bilateral) a number for each, the same for axes of one vector
    const double* wider = nullptr;  // (bilateral) see StateRows; null where all are 1
    const char* passive =
        nullptr;                 // (bilateral) whether a row is brought to rest: nothing drives it
    const int* locks = nullptr;  // (bilateral) the one degree of freedom a row prescribes, or −1

    const double* J = nullptr;  // (3 (contacts + turning), nv), see ContactProblem
    // Counts and coefficients; W, before and free are filled in by `solve_impact`.
    ContactProblem contact;
    Law law;
};

struct ImpactSolution {
    enum class Failure { none, singular_mass, contradiction, refused };

    std::vector<double> dv;           // (nv)
    std::vector<double> multipliers;  // (bilateral) λ
    std::vector<char> unique;         // (bilateral) whether each is determined
    bool nearly_dependent = false;    // rows were taken for dependent that are so only nearly
    std::vector<double> before;       // (3 (contacts + turning)) J v⁻
    ContactSolution contact;
    Failure failure = Failure::none;
    std::vector<int> failed;  // degrees of freedom without mass, or rows that contradict
    double apart = 0.0;       // by how much those rows disagree
    double momentum_residual = 0.0, constraint_residual = 0.0, contact_residual = 0.0;
};

void solve_impact(const ImpactProblem& problem, ImpactSolution& solution);

// The status of an impact: of its contacts (solved without any), unless one of its residuals is too
// large, or rows are nearly dependent.
Status judge(Status contacts, const std::array<double, 3>& residuals, bool nearly_dependent);
// The status of a solution, and whether its velocities may be used.
Status status_of(const ImpactSolution& solution);
bool is_valid(Status status);

}  // namespace impulsekit
