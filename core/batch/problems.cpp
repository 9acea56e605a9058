#include "batch/problems.hpp"

#include <algorithm>
#include <stdexcept>

#include "linalg/parallel.hpp"

namespace impulsekit {
namespace {

void solve(const ContactProblems& given, const Law& law, std::size_t i,
           ContactProblemSolutions& found) {
    ContactProblem p;
    p.contacts = given.contacts;
    const std::size_t r = p.rows();
    p.W = given.W + i * r * r;
    p.before = given.before + i * r;
    p.free = given.free + i * r;
    p.restitution = given.restitution.row(i);
    p.friction = given.friction.row(i);
    p.tangential = given.tangential.row(i);
    const ContactSolution s = solve_contacts(p, law);
    if (!s.refused.empty()) throw std::invalid_argument(s.refused);
    std::copy(s.impulse.begin(), s.impulse.end(), found.impulse.begin() + i * r);
    std::copy(s.after.begin(), s.after.end(), found.after.begin() + i * r);
    found.status[i] = static_cast<std::int8_t>(s.status);
    found.residual[i] = s.residual;
}

}  // namespace

ContactProblemSolutions solve_problems(const ContactProblems& given, const Law& law, int threads) {
    const std::size_t rows = 3 * given.count * given.contacts;
    ContactProblemSolutions found{std::vector<double>(rows), std::vector<double>(rows),
                                  std::vector<double>(given.count),
                                  std::vector<std::int8_t>(given.count)};
    run_parallel(given.count, threads,
                 [&] { return [&](std::size_t i) { solve(given, law, i, found); }; });
    return found;
}

}  // namespace impulsekit
