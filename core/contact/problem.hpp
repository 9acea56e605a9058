// Problem and solution of the laws of contact.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "linalg/table.hpp"

namespace impulsekit {

enum class Restitution { newton, poisson, stronge, lzb };
enum class Slip { end, path, compliant };
enum class Order { simultaneous, sequential };

struct Law {
    Restitution restitution = Restitution::newton;
    Slip slip = Slip::end;
    Order order = Order::simultaneous;
    double exponent = 1.5;  // of "lzb": F = k δ^exponent
};

// The status of a result. A law itself gives the first, and the three that speak of laws.
enum class Status {
    solved = 0,
    inaccurate = 1,
    energy_gain = 4,
    no_solution = 6,
    not_converged = 7,
    not_finite = 9,
    off_manifold = 10,
    out_of_range = 11,
    singular_mass = 12,
    contradiction = 13,
    refused = 14,
    nearly_dependent = 15,
};

// Friction that is more than one number.
struct Friction {
    enum class Kind { number, static_kinetic, by_speed, elliptic };
    Kind kind = Kind::number;
    double first = 0.0, second = 0.0;          // µ; static, kinetic; µ along and across an axis
    double axis[2] = {1.0, 0.0};               // of an ellipse, in the contact's tangents
    Table table{};                             // µ by slip speed [m/s], unless
    std::function<double(double)> function{};  // this gives it

    double at_speed(double slip) const { return function ? function(slip) : table.at(slip); }
};

// n contacts of three rows each, two tangents and then the normal, which points from what is
// touched to what touches: approaching is u_n < 0. u⁺ = u_free + W P. After them come three rows
// for each of the contacts that resist rolling and spin, of the relative angular velocity [rad/s].
// Of one state, or eight side by side.
template <typename S>
struct ContactProblemOf {
    int contacts = 0, turning = 0;
    const S* W = nullptr;                // (r, r), r = 3 (contacts + turning) [1/kg]
    const S* before = nullptr;           // (r) u⁻ [m/s]
    const S* free = nullptr;             // (r) u⁻ and what known impulses add to it [m/s]
    const S* restitution = nullptr;      // (contacts) e
    const S* friction = nullptr;         // (contacts) µ
    const S* tangential = nullptr;       // (contacts) e_t
    const S* stiffness = nullptr;        // (contacts) k, for "lzb"; else null
    const S* stiffness_ratio = nullptr;  // (contacts) tangential over normal; else null
    const S* damping = nullptr;        // (contacts) of tangential springs; null where none has any
    const S* adhesion = nullptr;       // (contacts) largest pull [N s]; null where none holds
    const int* turning_of = nullptr;   // (turning) the contact
    const S* rolling = nullptr;        // (turning) [m]
    const S* torsion = nullptr;        // (turning) [m]
    const Friction* models = nullptr;  // (contacts); null where all are numbers

    int rows() const { return 3 * (contacts + turning); }
};

using ContactProblem = ContactProblemOf<double>;

struct ContactSolution {
    std::vector<double> impulse, after, start;       // (r) P [N s], u⁺, and where works begin [m/s]
    std::vector<double> normal_work, friction_work;  // (contacts + turning) [J]
    std::vector<double> friction;                    // (contacts) µ in the end, of `models`
    std::vector<char> unique;                        // (contacts + turning)
    Status status = Status::solved;
    double residual = 0.0;
    int iterations = 0;   // of Newton's method; hits of a sequence; steps of a motion
    bool tied = false;    // the order of entries decided which contact is hit first
    std::string refused;  // what the law does not accept, with {i} the number of a contact
};

// Why a problem of so many rows is not accepted; "" where it is. Below the limit products of two
// sizes are integers, and a matrix of them is memory that machines have.
std::string refusal_of_size(int rows);

// The impulses of all contacts of one instant under a law.
ContactSolution solve_contacts(const ContactProblem& problem, const Law& law);

}  // namespace impulsekit
