// Slopes of the impulses of contacts that are followed in time, by differences.
#pragma once

#include <vector>

#include "contact/problem.hpp"

namespace impulsekit {

// Parameters of n contacts, in order: W_ij (i <= j) column by column, u_free (3n), u_n⁻ (n), e (n)
// and µ (n).
inline int law_parameters(int n) { return 3 * n * (3 * n + 1) / 2 + 6 * n; }

// ∂P (3n, parameters) of contacts with springs (lzb.hpp), by central differences of fourth order,
// from one side where a coefficient is at its end. They do not depend on u_n⁻. `edges`: (n) the
// contacts by whose numbers differences of two lengths disagree. False where an impulse is not
// found.
bool difference_law(const ContactProblem& problem, const Law& law, std::vector<double>& slopes,
                    std::vector<char>& edges);

}  // namespace impulsekit
