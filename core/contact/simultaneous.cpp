#include "contact/simultaneous.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "contact/uniqueness.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Add the work P·(u + u⁺)/2 of each contact.
void add_works(const ContactProblem& problem, const double* impulse, const double* start,
               const double* after, ContactSolution& solution) {
    const int n = problem.contacts;
    for (int i = 0; i < n + problem.turning; ++i) {
        double own[3];
        for (int k = 0; k < 3; ++k) {
            int r = 3 * i + k;
            own[k] = 0.5 * impulse[r] * (start[r] + after[r]);
        }
        // About the normal a moment acts, not the normal impulse.
        solution.normal_work[i] += i < n ? own[2] : 0.0;
        solution.friction_work[i] += own[0] + own[1] + (i < n ? 0.0 : own[2]);
    }
}

// Velocities that are rounding of what they are sums of are zero.
void clear_rounding(double* velocity, int rows, double scale) {
    for (int r = 0; r < rows; ++r)
        if (std::abs(velocity[r]) <= tolerance::sums * scale) velocity[r] = 0.0;
}

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

// The answer of all modes of few contacts that slips least, where Newton's method found none; true
// if it is proven that there is none.
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

void mark_shared(const ContactProblem& problem, const ConeSolution& found,
                 ContactSolution& solution) {
    for (int i = 0; i < problem.contacts; ++i) solution.unique[i] &= found.unique[i];
    for (int k = 0; k < problem.turning; ++k)
        solution.unique[problem.contacts + k] &= found.unique[problem.turning_of[k]];
}

}  // namespace

Cones cones_of(const ContactProblem& problem) {
    const int n = problem.contacts;
    Cones cones(n, n + 2 * problem.turning, scratch());
    for (int i = 0; i < n; ++i) {
        const double pull = problem.adhesion ? problem.adhesion[i] : 0.0;
        cones.add_contact(3 * i + 2, pull > 0.0 ? -pull : 0.0, pull);
    }
    auto add = [&](int first, int size, int contact, double friction) {
        if (friction > tolerance::negligible) cones.add_group(first, size, contact, friction);
    };
    for (int i = 0; i < n; ++i) add(3 * i, 2, i, problem.friction[i]);
    for (int k = 0; k < problem.turning; ++k) {
        add(3 * (n + k), 2, problem.turning_of[k], problem.rolling[k]);
        add(3 * (n + k) + 2, 1, problem.turning_of[k], problem.torsion[k]);
    }
    return cones;
}

void add_newtons_shift(const ContactProblem& problem, double* xi) {
    for (int i = 0; i < problem.contacts; ++i) {
        const double* u = problem.before + 3 * i;
        xi[3 * i + 2] += problem.restitution[i] * std::min(u[2], 0.0);
        for (int k = 0; k < 2; ++k) xi[3 * i + k] += problem.tangential[i] * u[k];
    }
}

double velocity_scale(const ContactProblem& problem) {
    double scale = 0.0;
    for (int i = 0; i < problem.contacts; ++i)
        for (int k = problem.friction[i] > tolerance::negligible ? 0 : 2; k < 3; ++k)
            scale = std::max(
                {scale, std::abs(problem.before[3 * i + k]), std::abs(problem.free[3 * i + k])});
    return scale;
}

bool gains_energy(const double* impulse, const double* start, const double* free, int rows,
                  double work, double work_size) {
    double by_blows = 0.0, size = work_size;
    for (int r = 0; r < rows; ++r) {
        by_blows += 0.5 * impulse[r] * (free[r] - start[r]);
        size += std::abs(impulse[r]) * (std::abs(start[r]) + std::abs(free[r]));
    }
    return std::min(work, work + by_blows) > tolerance::gain * size;
}

ContactSolution solve_simultaneous(const ContactProblem& problem, const Law& law) {
    const Arena::Scope scope(scratch());
    const int rows = problem.rows(), count = problem.contacts + problem.turning;
    const bool newton = law.restitution == Restitution::newton;
    const double* start = newton ? problem.before : problem.free;
    ContactSolution solution;
    solution.impulse.assign(rows, 0.0);
    solution.after.assign(problem.free, problem.free + rows);
    solution.start.assign(start, start + rows);
    solution.normal_work.assign(count, 0.0);
    solution.friction_work.assign(count, 0.0);
    solution.unique.assign(count, 1);
    Cones cones = cones_of(problem);
    double scale = velocity_scale(problem);
    double* xi = scratch().allocate(rows);
    std::copy(problem.free, problem.free + rows, xi);
    if (newton) add_newtons_shift(problem, xi);
    ConeSolution found = solve_cones(problem.W, rows, xi, scale, cones, solution.impulse.data());
    const bool has_none =
        newton && !found.infeasible && !(found.residual <= tolerance::residual) &&
        try_all_modes(problem, law, xi, scale, cones, solution.impulse.data(), found);
    multiply(problem.W, rows, solution.impulse.data(), problem.free, solution.after.data());
    add_works(problem, solution.impulse.data(), start, solution.after.data(), solution);
    mark_shared(problem, found, solution);
    solution.residual = found.residual;
    solution.iterations = found.steps;
    bool releases = false;
    for (int i = 0; !newton && i < problem.contacts; ++i) {
        cones.floor[i] = problem.restitution[i] * solution.impulse[3 * i + 2];
        releases = releases || cones.floor[i] > 0.0;
    }
    if (releases && found.residual <= tolerance::residual) {
        std::vector<double> middle = solution.after, release(rows, 0.0);
        clear_rounding(middle.data(), rows, scale);
        found = solve_cones(problem.W, rows, middle.data(), scale, cones, release.data());
        multiply(problem.W, rows, release.data(), middle.data(), solution.after.data());
        add_works(problem, release.data(), middle.data(), solution.after.data(), solution);
        for (int r = 0; r < rows; ++r) solution.impulse[r] += release[r];
        multiply(problem.W, rows, solution.impulse.data(), problem.free, solution.after.data());
        mark_shared(problem, found, solution);
        solution.residual = std::max(solution.residual, found.residual);
        solution.iterations += found.steps;
    }
    double work = 0.0, size = 0.0;
    for (int i = 0; i < count; ++i) {
        work += solution.normal_work[i] + solution.friction_work[i];
        size += std::abs(solution.normal_work[i]) + std::abs(solution.friction_work[i]);
    }
    if (found.immovable || found.infeasible || has_none)
        solution.status = Status::no_solution;
    else if (!(solution.residual <= tolerance::residual))
        solution.status = Status::not_converged;
    else if (gains_energy(solution.impulse.data(), start, problem.free, rows, work, size))
        solution.status = Status::energy_gain;
    return solution;
}

}  // namespace impulsekit
