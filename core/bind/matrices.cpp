// Impacts of systems that are given by their matrices, as Python calls them.
#include <nanobind/nanobind.h>
#include <nanobind/stl/vector.h>

#include <atomic>
#include <exception>
#include <mutex>
#include <numeric>
#include <thread>

#include "bind/laws.hpp"
#include "impact/impact.hpp"

namespace nb = nanobind;

namespace impulsekit {
namespace {

// M Δv = Aᵀλ + JᵀP with A v⁺ = target and P by the law.
ImpactSolution solve_matrices(const Array& M, const Integers& parent, const Array& v,
                              const Array& A, const Array& target, const Array& J,
                              const nb::tuple& contacts, const std::vector<nb::tuple>& models,
                              int restitution, int slip, int order, double exponent) {
    const GivenContacts given = contacts_of(contacts, models);
    ImpactProblem p;
    const std::size_t nv = v.size(), bilateral = target.size();
    p.nv = static_cast<int>(nv);
    p.M = data_of(M, nv * nv, "M");
    p.parent = data_of(parent, nv, "parent");
    for (std::size_t i = 0; i < nv; ++i)
        if (p.parent[i] < -1 || p.parent[i] >= static_cast<int>(i))
            throw nb::value_error("parent: each must be -1 or smaller than its own number");
    p.v = v.data();
    p.bilateral = static_cast<int>(bilateral);
    p.A = data_of(A, bilateral * nv, "A");
    p.target = target.data();
    std::vector<int> vectors(bilateral);
    std::iota(vectors.begin(), vectors.end(), 0);
    const std::vector<char> passive(bilateral, 1);
    p.vectors = vectors.data();
    p.passive = passive.data();
    p.contact = given.coefficients();
    p.J = data_of(J, p.contact.rows() * nv, "J");
    p.law = law_of(restitution, slip, order, exponent);
    ImpactSolution solution;
    const nb::gil_scoped_release release;
    solve_impact(p, solution);
    return solution;
}

// Numbers of all problems, or one set that they share.
const double* row_of(const Array& given, std::size_t count, std::size_t width, std::size_t i) {
    return given.data() + (given.size() == count * width ? i * width : 0);
}

void check_rows(const Array& given, std::size_t count, std::size_t width, const char* name) {
    if (given.size() != count * width && given.size() != width)
        throw nb::value_error((std::string(name) + ": expected one row, or one each").c_str());
}

using Output = nb::ndarray<double, nb::c_contig, nb::device::cpu>;
using Codes = nb::ndarray<std::int8_t, nb::c_contig, nb::device::cpu>;

// Many contact problems of one size: W (N, r, r), u⁻ and u_free (N, r) in; P and u⁺ (N, r) out.
void solve_problems(const Array& W, const Array& before, const Array& free,
                    const Array& restitution, const Array& friction, const Array& tangential,
                    const Output& impulse, const Output& after, const Codes& codes,
                    const Output& residuals, int restitution_law, int slip, int order,
                    double exponent, int threads) {
    const std::size_t count = codes.size();
    if (count == 0) return;
    const std::size_t r = free.size() / count, n = r / 3;
    if (r % 3 != 0) throw nb::value_error("free: expected three rows a contact");
    data_of(W, count * r * r, "W");
    data_of(before, count * r, "before");
    data_of(free, count * r, "free");
    check_rows(restitution, count, n, "restitution");
    check_rows(friction, count, n, "friction");
    check_rows(tangential, count, n, "tangential");
    if (impulse.size() != count * r || after.size() != count * r || residuals.size() != count)
        throw nb::value_error("results: expected the sizes of the problems");
    const Law law = law_of(restitution_law, slip, order, exponent);
    const nb::gil_scoped_release release;
    std::atomic<std::size_t> next{0};
    std::mutex lock;
    std::exception_ptr error;
    const auto work = [&] {
        try {
            for (std::size_t i; (i = next++) < count;) {
                ContactProblem p;
                p.contacts = static_cast<int>(n);
                p.W = W.data() + i * r * r;
                p.before = before.data() + i * r;
                p.free = free.data() + i * r;
                p.restitution = row_of(restitution, count, n, i);
                p.friction = row_of(friction, count, n, i);
                p.tangential = row_of(tangential, count, n, i);
                const ContactSolution s = solve_contacts(p, law);
                if (!s.refused.empty()) throw nb::value_error(s.refused.c_str());
                std::copy(s.impulse.begin(), s.impulse.end(), impulse.data() + i * r);
                std::copy(s.after.begin(), s.after.end(), after.data() + i * r);
                codes.data()[i] = static_cast<std::int8_t>(s.status);
                residuals.data()[i] = s.residual;
            }
        } catch (...) {
            const std::lock_guard<std::mutex> guard(lock);
            if (!error) error = std::current_exception();
            next = count;
        }
    };
    std::vector<std::thread> others;
    for (int i = 1; i < threads; ++i) others.emplace_back(work);
    work();
    for (std::thread& other : others) other.join();
    if (error) std::rethrow_exception(error);
}

}  // namespace
}  // namespace impulsekit

void bind_matrices(nb::module_& module) {
    using namespace impulsekit;
    module.def("solve_matrices", &solve_matrices, nb::arg("M"), nb::arg("parent"), nb::arg("v"),
               nb::arg("A"), nb::arg("target"), nb::arg("J"), nb::arg("contacts"),
               nb::arg("models"), nb::arg("restitution"), nb::arg("slip"), nb::arg("order"),
               nb::arg("exponent"), "Return the impact of a system given by its matrices.");
    module.def("solve_problems", &solve_problems, nb::arg("W"), nb::arg("before"), nb::arg("free"),
               nb::arg("restitution"), nb::arg("friction"), nb::arg("tangential"),
               nb::arg("impulse"), nb::arg("after"), nb::arg("codes"), nb::arg("residuals"),
               nb::arg("restitution_law"), nb::arg("slip"), nb::arg("order"), nb::arg("exponent"),
               nb::arg("threads"), "Solve many contact problems of one size; results are written.");
}
