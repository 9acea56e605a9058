// Several contacts while their impulses grow: their springs, their forces, and the rates of both.
#pragma once

#include <cmath>
#include <vector>

#include "contact/problem.hpp"
#include "contact/rest_law.hpp"
#include "contact/tolerances.hpp"

namespace impulsekit {

// A short time, beside that of an impact, for first steps; a held contact is loaded again where its
// force rises in it.
inline constexpr double kAhead = 1e-6;

// Slip turns with its velocity or its spring, or keeps the direction that it had: where it begins,
// and of springs with hardly any depth.
enum class Slipping { none, straight, turning };
enum class Normal { open, loads, unloads, held };

struct LzbContact {
    // In the rows of the state: of two tangents, where it rubs, and of the normal; in its numbers:
    // of the tangential spring, where it has one, and of the work of friction.
    int tangents = -1, normal_row = 0, spring = -1, work = -1;
    // Stiffness and κ; µ; the shares e² and 1 − D of their work that the springs give back.
    double stiffness = 1.0, ratio = INFINITY, mu = 0.0, e2 = 0.0, kept = 1.0;
    Normal normal = Normal::open;
    Slipping slip = Slipping::none;
    bool releases = false;    // the tangential spring gives back
    bool slip_ended = false;  // with the last step
    double way[2] = {};       // of slip, or of the tangential spring; zeros where there is none
    double last[2] = {};      // of slip at the last step
    double from = 0.0;        // speed along `last` with which slip begins, but for rounding 0
    double stored = 0.0, normal_work = 0.0;  // by the normal spring, at the last step

    bool rubs() const { return tangents >= 0; }
    bool springs() const { return normal == Normal::loads || normal == Normal::unloads; }
    bool holds() const { return normal == Normal::held; }
    bool slips() const { return slip != Slipping::none; }
    // True if its tangents give way; else its friction is Coulomb's, as it is of all that is held.
    bool is_elastic() const { return spring >= 0 && springs(); }
    // Depth per approach: a contact that is restored gives e² of its work.
    double gives() const { return holds() ? 0.0 : normal == Normal::unloads ? 1.0 / e2 : 1.0; }
};

// In units in which the largest velocity, mobility and finite stiffness are 1. y: P of the rows,
// δ (n), χ = κ ζ of each tangential spring (2), the work of friction of each contact that rubs.
class LzbState {
  public:
    LzbState(const ContactProblem& problem, const Law& law);

    int size() const { return size_; }
    double& depth(double* y, int i) const { return y[rows_ + i]; }
    // F of the normal spring of a contact, its slope by the depth, and the work that it stores.
    double spring(const LzbContact& c, double depth, bool slope = false) const;
    double energy(const LzbContact& c, double depth) const {
        return spring(c, depth) * std::max(depth, 0.0) / (exponent_ + 1.0);
    }
    // The depth at which a normal spring has the force F.
    double depth_of(const LzbContact& c, double F) const {
        return std::pow(F / c.stiffness, 1.0 / exponent_);
    }

    // dy/dt at y; velocities, forces and ways are left.
    void rates(const double* y, double* dy);
    // ∂(dy/dt)/∂y (size, size); works follow from the rest, and nothing from them.
    void slopes(const double* y, double* J);

    double un(const LzbContact& c) const { return u[c.normal_row]; }
    double slip(const LzbContact& c) const {
        return c.rubs() ? std::hypot(u[c.tangents], u[c.tangents + 1]) : 0.0;
    }
    // Speed of slip along the way that it had when the step began.
    double ahead(const LzbContact& c) const {
        return u[c.tangents] * c.last[0] + u[c.tangents + 1] * c.last[1];
    }
    // Speed along the way of the tangential spring; what of it is slip where all friction is used:
    // the spring goes on only as the normal force does.
    double along(const LzbContact& c) const {
        return u[c.tangents] * c.way[0] + u[c.tangents + 1] * c.way[1];
    }
    double slip_of_spring(const LzbContact& c) const {
        const double rises = -c.gives() * un(c);
        return along(c) - (rises > 0.0 ? 1.0 : c.kept) * c.mu / c.ratio * rises;
    }
    // True if a tangential spring that slips turns much faster than normal forces change.
    bool turns_fast(const double* y) const;
    // du_n/dt of a contact under the forces that are there.
    double rises(const LzbContact& c) const;
    // By how much the forces of held contacts with finite stiffness rise in a short time from y on.
    const std::vector<double>& rises_of_held(const double* y);

    // The points that rest: those that are held, and rigid ones that are pressed and do not slip.
    struct Resting {
        std::vector<int> contact;
        std::vector<double> W, b, reach, direction, load, rate;
        std::vector<char> pressed;
        RestProblem problem;

        int rows() const { return 3 * static_cast<int>(contact.size()); }
    };
    // The row of the state for a row of `resting`; −1 where that is none.
    int row_of(int resting_row) const;

    std::vector<LzbContact> contacts;
    std::vector<double> W, free, u, force;  // of the rows
    Resting resting;
    double speed = 0.0, mobility = 0.0, approach = 0.0;  // [m/s, 1/kg, m/s]

  private:
    void find_resting(const double* y);
    void set_tangents(LzbContact& c, const double* y);
    void write_tangents(const LzbContact& c, const double* y, double* J) const;

    int rows_ = 0, size_ = 0;
    const double exponent_;
    std::vector<double> rise_;
};

}  // namespace impulsekit
