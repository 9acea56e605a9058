// The law of contact of states side by side that touch at the same points and act alike there.
#pragma once

#include <vector>

#include "contact/simultaneous.hpp"
#include "impact/coefficients.hpp"

namespace impulsekit {

class AlikeContacts {
  public:
    AlikeContacts(const Scene& scene, const ContactLaw& law) : scene_(scene), law_(law) {
        const Law& own = law.law;
        is_simultaneous_ = own.order == Order::simultaneous && own.slip == Slip::end &&
                           own.restitution <= Restitution::poisson && !law.has_adhesion;
    }

    // Coefficients of points of some contacts (count), of each state its own or those of the law.
    // False where the law goes state by state.
    bool set(const std::vector<int>& entries, const double* const* restitution,
             const double* const* friction) {
        const std::size_t n = entries.size();
        if (!is_simultaneous_ || n == 0) return false;
        e_.resize(n);
        mu_.resize(n);
        tangential_.resize(n);
        for (std::size_t i = 0; i < n; ++i) {
            const int entry = entries[i];
            const ContactCoefficients& own = law_.contacts[entry];
            const bool is_newton = law_.law.restitution == Restitution::newton;
            if (scene_.contacts[entry].turns || scene_.contacts[entry].ellipse_body >= 0 ||
                (!restitution[0] && !own.restitution.is_constant()) ||
                (!friction[0] && law_.has_models) || (own.tangential != 0.0 && !is_newton))
                return false;
            tangential_[i] = number<Pack>(own.tangential);
            for (int k = 0; k < kLanes; ++k) {
                e_[i][k] = restitution[k] ? restitution[k][entry] : own.restitution.value;
                mu_[i][k] = friction[k] ? friction[k][entry] : own.friction;
            }
        }
        return true;
    }

    // P, u⁺ (3 count), residuals and shares (count, see solve_cones) in the states of `todo` that
    // are found here, which are returned, and where they gain energy; others are left as they are.
    PackBits solve(const Pack* W, const Pack* before, const Pack* free, PackBits todo, Pack* P,
                   Pack* after, Pack* shares, Pack& residual, PackBits& gains) {
        const int n = static_cast<int>(e_.size());
        ContactProblemOf<Pack> p;
        p.contacts = n;
        p.W = W;
        p.before = before;
        p.free = free;
        p.restitution = e_.data();
        p.friction = mu_.data();
        p.tangential = tangential_.data();
        PackBits solved{};
        const PackBits coupled = are_coupled(p);
        // Those that differ from the most are tried among each other.
        while (Alike<Pack>::count(todo) > 1) {
            const Arena::Scope scope(scratch());
            const auto take = [](int count) { return scratch().allocate_of<Pack>(count); };
            Alike<Pack> alike(todo);
            SimultaneousOf<Pack> found{take(3 * n), take(3 * n), take(n), take(n), take(n)};
            solve_simultaneous(p, law_.law, found, alike);
            alike.keep(coupled);
            const PackBits in = found.has_none ? PackBits{} : alike.in();
            const auto write = [&](const Pack* from, int count, Pack* to) {
                for (int i = 0; i < count; ++i) to[i] = in ? from[i] : to[i];
            };
            write(found.impulse, 3 * n, P);
            write(found.after, 3 * n, after);
            write(found.shares, n, shares);
            write(&found.residual, 1, &residual);
            gains = in ? gains_energy(p, law_.law, found) : gains;
            solved |= in;
            todo = alike.differing();
        }
        return solved;
    }

  private:
    // Where W couples all contacts with each other, as far as a walk from the first to the last
    // finds: what it does not couple is solved apart.
    static PackBits are_coupled(const ContactProblemOf<Pack>& p) {
        const Arena::Scope scope(scratch());
        const int n = p.contacts, rows = p.rows();
        PackBits *reached = scratch().allocate_of<PackBits>(n), all = ~PackBits{};
        reached[0] = all;
        for (int i = 0; i < n; ++i) {
            all = ~PackBits{};
            for (int j = 0; j < n; ++j) {
                for (int a = first_row(p, i); a < 3 && !all_of(reached[j]); ++a)
                    for (int b = first_row(p, j); b < 3; ++b)
                        reached[j] |= reached[i] & (p.W[(3 * i + a) * rows + 3 * j + b] != 0.0);
                all &= reached[j];
            }
            if (all_of(all)) break;
        }
        return all;
    }
    // Tangents count where some state has friction; that all have is asked elsewhere.
    static int first_row(const ContactProblemOf<Pack>& p, int i) {
        return any(p.friction[i] > tolerance::negligible) ? 0 : 2;
    }
    static bool all_of(const PackBits& x) { return !any(~x); }

    const Scene& scene_;
    const ContactLaw& law_;
    bool is_simultaneous_ = false;
    std::vector<Pack> e_, mu_, tangential_;
};

}  // namespace impulsekit
