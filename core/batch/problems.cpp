#include "batch/problems.hpp"

#include <algorithm>
#include <atomic>
#include <exception>
#include <mutex>
#include <stdexcept>
#include <thread>

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
    std::atomic<std::size_t> next{0};
    std::mutex lock;
    std::exception_ptr error;
    const auto work = [&] {
        try {
            for (std::size_t i; (i = next++) < given.count;) solve(given, law, i, found);
        } catch (...) {
            const std::lock_guard<std::mutex> guard(lock);
            if (!error) error = std::current_exception();
            next = given.count;
        }
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back(work);
    work();
    for (std::thread& other : others) other.join();
    if (error) std::rethrow_exception(error);
    return found;
}

}  // namespace impulsekit
