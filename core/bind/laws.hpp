// Contacts as Python gives them.
#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "bind/arrays.hpp"
#include "contact/problem.hpp"

namespace impulsekit {

// Coefficients of contacts, kept alive for the call; None where unused.
struct GivenContacts {
    Array restitution, friction, tangential;
    std::optional<Array> stiffness, stiffness_ratio, tangential_damping, adhesion;
    std::optional<Integers> turning_of;
    std::optional<Array> rolling, torsion;
    std::vector<Friction> models;

    // A problem without W and velocities.
    ContactProblem coefficients() const;
};

}  // namespace impulsekit
