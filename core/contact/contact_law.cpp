// From a problem and a law to the program of that law: what all laws have in common.
#include <algorithm>
#include <cmath>

#include "contact/compliant.hpp"
#include "contact/friction.hpp"
#include "contact/islands.hpp"
#include "contact/lzb.hpp"
#include "contact/path.hpp"
#include "contact/problem.hpp"
#include "contact/sequence.hpp"
#include "contact/simultaneous.hpp"
#include "contact/tolerances.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

ContactSolution solve_plain(const ContactProblem& problem, const Law& law);

ContactSolution empty_solution(const ContactProblem& problem) {
    const int rows = problem.rows(), count = problem.contacts + problem.turning;
    ContactSolution solution;
    solution.impulse.assign(rows, 0.0);
    solution.after.assign(problem.free, problem.free + rows);
    solution.start = solution.after;
    solution.normal_work.assign(count, 0.0);
    solution.friction_work.assign(count, 0.0);
    solution.unique.assign(count, 1);
    return solution;
}

// The worse of two statuses, those of no answer last.
Status worse(Status a, Status b) { return static_cast<int>(a) > static_cast<int>(b) ? a : b; }

// Contacts that do not act on each other, each island as if the others were not there.
ContactSolution solve_islands(const ContactProblem& problem, const Law& law,
                              const std::vector<int>& island, int count) {
    const int n = problem.contacts, rows = problem.rows();
    ContactSolution all = empty_solution(problem);
    for (int number = 0; number < count; ++number) {
        std::vector<int> members;
        for (int i = 0; i < n; ++i)
            if (island[3 * i + 2] == number) members.push_back(i);
        const int own = static_cast<int>(members.size());
        std::vector<double> W(9 * own * own), before(3 * own), free(3 * own), numbers(7 * own);
        for (int a = 0; a < own; ++a) {
            for (int k = 0; k < 3; ++k) {
                int r = 3 * members[a] + k;
                before[3 * a + k] = problem.before[r];
                free[3 * a + k] = problem.free[r];
                for (int c = 0; c < own; ++c)
                    for (int l = 0; l < 3; ++l)
                        W[(3 * a + k) * 3 * own + 3 * c + l] =
                            problem.W[r * rows + 3 * members[c] + l];
            }
            numbers[a] = problem.restitution[members[a]];
            numbers[own + a] = problem.friction[members[a]];
            numbers[2 * own + a] = problem.tangential[members[a]];
            numbers[3 * own + a] = problem.stiffness ? problem.stiffness[members[a]] : 0.0;
            numbers[5 * own + a] =
                problem.stiffness_ratio ? problem.stiffness_ratio[members[a]] : 0.0;
            numbers[6 * own + a] = problem.damping ? problem.damping[members[a]] : 0.0;
            numbers[4 * own + a] = problem.adhesion ? problem.adhesion[members[a]] : 0.0;
        }
        ContactProblem part;
        part.contacts = own;
        part.W = W.data();
        part.before = before.data();
        part.free = free.data();
        part.restitution = numbers.data();
        part.friction = numbers.data() + own;
        part.tangential = numbers.data() + 2 * own;
        part.stiffness = problem.stiffness ? numbers.data() + 3 * own : nullptr;
        part.stiffness_ratio = problem.stiffness_ratio ? numbers.data() + 5 * own : nullptr;
        part.damping = problem.damping ? numbers.data() + 6 * own : nullptr;
        part.adhesion = problem.adhesion ? numbers.data() + 4 * own : nullptr;
        ContactSolution found = solve_plain(part, law);
        if (!found.refused.empty()) return found;
        for (int a = 0; a < own; ++a) {
            int i = members[a];
            for (int k = 0; k < 3; ++k) {
                all.impulse[3 * i + k] = found.impulse[3 * a + k];
                all.after[3 * i + k] = found.after[3 * a + k];
                all.start[3 * i + k] = found.start[3 * a + k];
            }
            all.normal_work[i] = found.normal_work[a];
            all.friction_work[i] = found.friction_work[a];
            all.unique[i] = found.unique[a];
        }
        all.status = worse(all.status, found.status);
        all.residual = std::max(all.residual, found.residual);
        all.iterations += found.iterations;
        all.tied = all.tied || found.tied;
    }
    // Along tangents without friction contacts of other islands may move them.
    multiply(problem.W, rows, all.impulse.data(), problem.free, all.after.data());
    return all;
}

// The refusal of several contacts along the path of one.
ContactSolution refuse_several(const Law& law, int n) {
    ContactSolution refusal;
    std::string what =
        law.restitution == Restitution::stronge ? "restitution=\"stronge\"" : "slip=\"path\"";
    refusal.refused = "contacts: more than one of the " + std::to_string(n) +
                      " contacts would take part at once; " + what +
                      " follows one contact along its impact, and how several share it is not "
                      "defined. Use Law(order=\"sequential\"), or slip=\"end\" with Newton's or "
                      "Poisson's restitution";
    return refusal;
}

// Slip along the path of the one contact that acts, the others parting or at rest.
ContactSolution solve_along_path(const ContactProblem& problem, const Law& law) {
    const int n = problem.contacts, rows = problem.rows();
    auto approach = [&](int i) {
        double target = law.restitution == Restitution::newton
                            ? problem.restitution[i] * std::min(problem.before[3 * i + 2], 0.0)
                            : 0.0;
        return problem.free[3 * i + 2] + target;
    };
    double scale = 0.0;
    for (int i = 0; i < n; ++i) scale = std::max(scale, std::abs(approach(i)));
    int acting = 0, last = 0;
    bool rubs = false;
    for (int i = 0; i < n; ++i) {
        rubs = rubs || problem.friction[i] > 0.0;
        if (approach(i) < -tolerance::at_rest * scale) {
            ++acting;
            last = i;
        }
    }
    // With one contact alone rounding cannot hide an approach.
    if (n == 1) acting = 1;
    if (acting == 1) {
        double W[9];
        for (int k = 0; k < 3; ++k)
            for (int l = 0; l < 3; ++l)
                W[3 * k + l] = problem.W[(3 * last + k) * rows + 3 * last + l];
        const Restitution own =
            law.restitution == Restitution::lzb ? Restitution::stronge : law.restitution;
        const double e = problem.restitution[last], mu = problem.friction[last];
        const PathImpact impact =
            law.slip == Slip::compliant
                ? follow_compliant(W, problem.free + 3 * last, e, mu, problem.stiffness_ratio[last])
                : follow_path(W, problem.before[3 * last + 2], problem.free + 3 * last, e, mu, own);
        ContactSolution solution = empty_solution(problem);
        std::copy(impact.impulse, impact.impulse + 3, solution.impulse.begin() + 3 * last);
        multiply(problem.W, rows, solution.impulse.data(), problem.free, solution.after.data());
        bool alone = true;
        for (int i = 0; i < n; ++i)
            alone =
                alone && (i == last || solution.after[3 * i + 2] >= -tolerance::at_rest * scale);
        if (alone || impact.status > Status::energy_gain) {
            solution.normal_work[last] = impact.normal_work;
            solution.friction_work[last] = impact.friction_work;
            solution.status = impact.status;
            solution.residual = impact.residual;
            return solution;
        }
    }
    if (acting == 0 || (!rubs && law.restitution != Restitution::stronge)) {
        // Nothing acts or nothing rubs: both slips are the same.
        std::vector<double> smooth(n, 0.0);
        ContactProblem plain = problem;
        plain.friction = smooth.data();
        Law end = law;
        end.slip = Slip::end;
        if (law.restitution == Restitution::stronge) end.restitution = Restitution::poisson;
        return solve_simultaneous(plain, end);
    }
    return refuse_several(law, n);
}

// True if contacts that act at once share the impact by their stiffnesses.
bool has_springs(const Law& law) {
    return law.restitution == Restitution::lzb || law.slip == Slip::compliant;
}

// A law whose coefficients are numbers.
ContactSolution solve_plain(const ContactProblem& problem, const Law& law) {
    if (law.order == Order::sequential) return solve_sequence(problem, law);
    // One contact has closed forms, unless its spring is damped.
    const bool is_damped = law.slip == Slip::compliant && problem.contacts == 1 &&
                           problem.damping && problem.damping[0] > 0.0 &&
                           problem.friction[0] > tolerance::negligible &&
                           !std::isinf(problem.stiffness_ratio[0]);
    if (has_springs(law) && (problem.contacts > 1 || is_damped)) return solve_lzb(problem, law);
    if (law.slip != Slip::end) return solve_along_path(problem, law);
    return solve_simultaneous(problem, law);
}

// One µ by contact.
ContactSolution solve_numbers(const ContactProblem& problem, const Law& law) {
    if (problem.turning == 0 && problem.contacts > 1) {
        const int rows = problem.rows();
        std::vector<int> owner(rows), island(rows);
        for (int r = 0; r < rows; ++r)
            owner[r] = r % 3 == 2 || problem.friction[r / 3] > tolerance::negligible ? r / 3 : -1;
        const int count = find_islands(problem.W, rows, owner.data(), island.data());
        if (count > 1) return solve_islands(problem, law, island, count);
    }
    return solve_plain(problem, law);
}

// The refusal of stiffnesses that are missing, or of one that cannot be: contacts that act at once
// under slip="compliant" may all go without, and are then equally stiff.
std::string refusal_of_springs(const ContactProblem& problem, const Law& law) {
    const int n = problem.contacts;
    const double *k = problem.stiffness, speed = largest(problem.free, problem.rows());
    const bool any = k && std::any_of(k, k + n, [](double one) { return one > 0.0; });
    if (!any && law.slip == Slip::compliant) return "";
    for (int i = 0; i < n; ++i) {
        const double un = problem.free[3 * i + 2];
        if (!any || !(k[i] > 0.0))
            return law.slip == Slip::compliant
                       ? "contacts: slip=\"compliant\" needs the stiffness of every contact that "
                         "acts with others, or of none, which makes them equally stiff"
                       : "contacts: restitution=\"lzb\" needs a stiffness above 0 of every contact";
        if (std::isinf(k[i]) && un < -tolerance::solved * speed)
            return "contacts: contact " + std::to_string(i) + " is approached at " +
                   std::to_string(-un) +
                   " m/s and has an infinite stiffness, which is for supports at rest; give it a "
                   "finite one";
    }
    return "";
}

std::string refusal_of(const ContactProblem& problem, const Law& law) {
    const std::string size = refusal_of_size(problem.rows());
    if (!size.empty()) return size;
    for (int i = 0; problem.adhesion && i < problem.contacts; ++i)
        if (problem.adhesion[i] > 0.0 &&
            !(law.restitution == Restitution::newton && law.slip == Slip::end &&
              law.order == Order::simultaneous))
            return "contacts: adhesion belongs to Law(), without words of its own; under other "
                   "laws it is 0";
    if (law.slip == Slip::end && law.restitution == Restitution::newton) return "";
    const char* names[] = {"newton", "poisson", "stronge", "lzb"};
    const char* slips[] = {"end", "path", "compliant"};
    for (int i = 0; i < problem.contacts; ++i)
        if (problem.tangential[i] != 0.0 && problem.friction[i] > tolerance::negligible)
            return std::string(
                       "contacts: tangential restitution has no meaning with "
                       "restitution=\"") +
                   names[static_cast<int>(law.restitution)] + "\", slip=\"" +
                   slips[static_cast<int>(law.slip)] +
                   "\"; it belongs to Law(restitution=\"newton\", slip=\"end\"), or is 0";
    if (has_springs(law) && problem.contacts > 1) {
        const std::string springs = refusal_of_springs(problem, law);
        if (!springs.empty()) return springs;
    }
    if (law.slip == Slip::compliant)
        for (int i = 0; i < problem.contacts; ++i)
            if (problem.friction[i] > tolerance::negligible &&
                !(problem.stiffness_ratio && problem.stiffness_ratio[i] > 0.0))
                return "contacts: slip=\"compliant\" needs a stiffness_ratio above 0 of each "
                       "contact";
    if (problem.turning > 0 && (law.slip != Slip::end || law.order == Order::sequential))
        return "contacts: rolling and torsion need slip=\"end\" and order=\"simultaneous\"; they "
               "are not defined along the path of an impact";
    return "";
}

}  // namespace

std::string refusal_of_size(int rows) {
    constexpr int kMost = 20000;
    if (rows <= kMost) return "";
    return "contacts and constraints: " + std::to_string(rows) +
           " rows act at once (three of each contact), the limit is " + std::to_string(kMost) +
           "; leave out redundant contacts, or solve the parts of the scene that do not act on "
           "each other one by one";
}

ContactSolution solve_contacts(const ContactProblem& problem, const Law& law) {
    ContactSolution refusal;
    refusal.refused = refusal_of(problem, law);
    if (!refusal.refused.empty()) return refusal;
    auto plain = [&](const ContactProblem& own) { return solve_numbers(own, law); };
    if (problem.models) return solve_with_friction_models(problem, law, plain);
    return plain(problem);
}

}  // namespace impulsekit
