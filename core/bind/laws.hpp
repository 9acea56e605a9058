// Contacts and laws as Python gives them.
#pragma once

#include <nanobind/nanobind.h>

#include <functional>
#include <optional>
#include <vector>

#include "bind/arrays.hpp"
#include "contact/problem.hpp"

namespace impulsekit {

// Coefficients of contacts, kept alive for the call: restitution, friction, tangential restitution,
// stiffness, adhesion, turning_of, rolling and torsion, each of the last five None where unused.
struct GivenContacts {
    Array restitution, friction, tangential;
    std::optional<Array> stiffness, adhesion;
    std::optional<Integers> turning_of;
    std::optional<Array> rolling, torsion;
    std::vector<Friction> models;

    // A problem without W and velocities.
    ContactProblem coefficients() const;
};

// A function of Python's, which any thread may call.
std::function<double(double)> function_of(const nb::object& function);

// Friction of one contact: (kind, first, second, axis, axis, function of the slip speed or None).
Friction friction_of(const nb::tuple& given);

GivenContacts contacts_of(const nb::tuple& given, const std::vector<nb::tuple>& models);
Law law_of(int restitution, int slip, int order, double exponent);

}  // namespace impulsekit
