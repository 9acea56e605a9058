// Friction that is more than one number: static and kinetic, by slip speed, by direction.
#pragma once

#include <functional>

#include "contact/problem.hpp"

namespace impulsekit {

// Each is brought to Coulomb's law with one µ by contact. An ellipse is a circle in other units:
// with P_t = A y, |y| <= P_n, and rows Aᵀ u_t the law for y has µ = 1. All contacts begin with
// their static µ; those that slip are solved again with the kinetic one, which they keep. µ by slip
// speed is the µ for which µ = f(|u_t⁺|), by Broyden's method. `solve`: the law for one µ by
// contact.
ContactSolution solve_with_friction_models(
    const ContactProblem& problem, const Law& law,
    const std::function<ContactSolution(const ContactProblem&)>& solve);

}  // namespace impulsekit
