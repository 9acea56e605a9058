#include "contact/simultaneous.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "contact/uniqueness.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// The largest slip of P.
double slip_of(const ContactProblem& problem, const double* P) {
    double slip = 0.0;
    for (int i = 0; i < problem.contacts; ++i)
        for (int k = 0; k < 2 && P[3 * i + 2] > 0.0; ++k) {
            const int r = 3 * i + k;
            const double own =
                problem.free[r] + dot(problem.W + r * problem.rows(), P, problem.rows());
            slip = std::max(slip, std::abs(own));
        }
    return slip;
}

}  // namespace

bool try_all_modes(const ContactProblem& problem, const Law& law, double* xi, double scale,
                   const Cones& cones, double* P, ConeSolution& found) {
    if (problem.turning > 0 || problem.adhesion) return false;
    const Uniqueness all = find_others(problem, law, P);
    double least = INFINITY;
    for (const std::vector<double>& other : all.impulses) {
        const double slip = slip_of(problem, other.data());
        if (!(slip < least)) continue;
        least = slip;
        std::copy(other.begin(), other.end(), P);
    }
    if (all.impulses.empty()) return all.verdict == Verdict::all_tried && !all.gains;
    found.residual = cone_residual(problem.W, problem.rows(), xi, scale, cones, P);
    found.infeasible = found.immovable = false;
    return false;
}

ContactSolution solve_simultaneous(const ContactProblem& problem, const Law& law) {
    const Arena::Scope scope(scratch());
    const int rows = problem.rows(), count = problem.contacts + problem.turning;
    const double* start = law.restitution == Restitution::newton ? problem.before : problem.free;
    ContactSolution solution;
    solution.impulse.assign(rows, 0.0);
    solution.after.assign(problem.free, problem.free + rows);
    solution.start.assign(start, start + rows);
    solution.normal_work.assign(count, 0.0);
    solution.friction_work.assign(count, 0.0);
    solution.unique.assign(count, 1);
    SimultaneousOf<double> found{solution.impulse.data(), solution.after.data(),
                                 solution.normal_work.data(), solution.friction_work.data(),
                                 scratch().allocate(problem.contacts)};
    Alike<double> alike;
    solve_simultaneous(problem, law, found, alike);
    solution.residual = found.residual;
    solution.iterations = found.iterations;
    for (int i = 0; i < count; ++i) {
        const int of = i < problem.contacts ? i : problem.turning_of[i - problem.contacts];
        solution.unique[i] = found.shares[of] <= tolerance::shared;
    }
    if (found.has_none)
        solution.status = Status::no_solution;
    else if (!(solution.residual <= tolerance::residual))
        solution.status = Status::not_converged;
    else if (gains_energy(problem, law, found))
        solution.status = Status::energy_gain;
    return solution;
}

}  // namespace impulsekit
