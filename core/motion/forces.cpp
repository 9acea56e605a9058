#include "motion/forces.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "linalg/arena.hpp"
#include "scene/blows.hpp"

namespace impulsekit {
namespace {

constexpr double kPi = 3.14159265358979323846;

// q − rest; where a joint turns without end, within half a turn of the middle of its side.
double strain_of(const JointForce& f, const double* q) {
    if (!f.is_circle) return q[f.q] - f.rest;
    const double middle = 0.5 * kPi * f.side;
    const double angle = std::atan2(q[f.q + 1], q[f.q]) - f.rest - middle;
    return angle - 2.0 * kPi * std::floor((angle + kPi) / (2.0 * kPi)) + middle;
}

double torque_of(const JointForce& f, const double* q, const double* v) {
    return f.torque - f.stiffness * strain_of(f, q) - f.damping * v[f.v];
}

// The strain of a one-sided spring; in a joint that turns without end the sine of that.
double zone_of(const JointForce& f, const double* q) {
    const double strain = strain_of(f, q);
    return f.side * (f.is_circle ? std::sin(strain) : strain);
}

struct Stretch {
    double length, rate;
    Vec3<double> along, place, other_place;  // along: from the other end to the first
};

Stretch stretch_of(const PointSpring& s, const Tree<double>& tree) {
    const Vec3<double> arm = tree.rotation[s.first.body] * vec3<double>(s.first.point),
                       other_arm = tree.rotation[s.other.body] * vec3<double>(s.other.point);
    Stretch found{};
    found.place = tree.origin[s.first.body] + arm;
    found.other_place = tree.origin[s.other.body] + other_arm;
    const Vec3<double> offset = found.place - found.other_place;
    found.length = std::sqrt(dot(offset, offset));
    if (found.length < tolerance::no_length) return found;
    found.along = offset * (1.0 / found.length);
    const Vec3<double> speed = twist_at(tree.twist[s.first.body], arm).linear -
                               twist_at(tree.twist[s.other.body], other_arm).linear;
    found.rate = dot(found.along, speed);
    return found;
}

double tension_of(const PointSpring& s, const Stretch& at) {
    return s.stiffness * (at.length - s.rest) + s.damping * at.rate;
}

void pull(const PointSpring& s, const Tree<double>& tree, const AddWrench& add) {
    const Stretch at = stretch_of(s, tree);
    if (at.length < tolerance::no_length) return;
    const Vec3<double> force = at.along * tension_of(s, at);
    add(s.first, {-force, cross(at.place - tree.origin[s.first.body], -force)});
    add(s.other, {force, cross(at.other_place - tree.origin[s.other.body], force)});
}

bool is_chosen(const Forces& forces, int entry, ForceEntry::Kind kind, std::size_t i) {
    return entry < 0 || (forces.entries[entry].kind == kind &&
                         forces.entries[entry].index == static_cast<int>(i));
}

double clamped(const JointForce& f, const Kinks& kinks, int i, const double* q, const double* v) {
    const Side side = kinks.of_joint(i);
    if (side == Side::out || side == Side::slack) return 0.0;
    const double torque = torque_of(f, q, v);
    if (side == Side::upper) return f.limit;
    return side == Side::lower ? -f.limit : torque;
}

}  // namespace

bool Forces::are_watched() const {
    bool any = !timed.empty() || !functions.empty();
    for (const AppliedForce& own : applied) any = any || own.function;
    return any;
}

Kinks::Kinks(const Forces& forces)
    : forces_(&forces),
      side_of_joint_(forces.joints.size(), Side::acts),
      side_of_spring_(forces.springs.size(), Side::acts) {
    for (std::size_t i = 0; i < forces.joints.size(); ++i)
        if (forces.joints[i].side != 0.0 || std::isfinite(forces.joints[i].limit))
            joints_.push_back(static_cast<int>(i));
    for (std::size_t i = 0; i < forces.springs.size(); ++i)
        if (forces.springs[i].side != 0.0) springs_.push_back(static_cast<int>(i));
}

Side& Kinks::side(int k) {
    const int joints = static_cast<int>(joints_.size());
    return k < joints ? side_of_joint_[joints_[k]] : side_of_spring_[springs_[k - joints]];
}

Kinks::Kinked Kinks::at(int k, const Tree<double>& tree, const double* q, const double* v) const {
    const int joints = static_cast<int>(joints_.size());
    if (k >= joints) {
        const PointSpring& s = forces_->springs[springs_[k - joints]];
        const Stretch at = stretch_of(s, tree);
        // (l² − l₀²)/2 l₀ is smooth where the ends meet.
        const double scale = s.side / (s.rest > 0.0 ? s.rest : 1.0);
        return {true,
                s.damping > 0.0,
                s.side * tension_of(s, at),
                INFINITY,
                tolerance::solved * (s.stiffness + s.damping),
                0.5 * scale * (at.length - s.rest) * (at.length + s.rest),
                scale * at.length * at.rate};
    }
    const JointForce& f = forces_->joints[joints_[k]];
    const double torque = torque_of(f, q, v);
    if (f.side == 0.0)
        return {false, false, torque, f.limit, tolerance::solved * f.limit, INFINITY, 0.0};
    const double turns = f.is_circle ? std::cos(strain_of(f, q)) : 1.0;
    return {true,
            f.damping > 0.0,
            -f.side * torque,
            INFINITY,
            tolerance::solved * (f.stiffness + f.damping),
            zone_of(f, q),
            f.side * v[f.v] * turns};
}

void Kinks::set_sides(const Tree<double>& tree, const double* q, const double* v) {
    for (int k = 0; k < count(); ++k) {
        const Kinked at = this->at(k, tree, q, v);
        if (at.is_one_sided)
            side(k) = at.zone > 0.0 ? at.inside() : Side::out;
        else
            side(k) = at.force > at.limit    ? Side::upper
                      : at.force < -at.limit ? Side::lower
                                             : Side::acts;
    }
}

void Kinks::change(const Tree<double>& tree, const double* q, const double* v) {
    for (int k = 0; k < count(); ++k) {
        const Kinked at = this->at(k, tree, q, v);
        const auto [zone, rate] = this->zone(k, tree, q, v);
        Side& own = side(k);
        if (zone <= 3.0 * tolerance::solved && rate < 0.0) {
            // The force tells of a damper that would pull at once.
            own = own == Side::out ? at.inside() : Side::out;
        } else if (margin(k, tree, q, v) <= 2.0 * at.beyond) {
            if (at.is_one_sided)
                own = own == Side::acts ? Side::slack : Side::acts;
            else
                own = own != Side::acts ? Side::acts : at.force > 0.0 ? Side::upper : Side::lower;
        }
    }
}

std::pair<double, double> Kinks::zone(int k, const Tree<double>& tree, const double* q,
                                      const double* v) const {
    const Kinked at = this->at(k, tree, q, v);
    const double sign = side(k) == Side::out ? -1.0 : 1.0;
    return {sign * at.zone + tolerance::solved, sign * at.rate};
}

double Kinks::margin(int k, const Tree<double>& tree, const double* q, const double* v) const {
    const Kinked at = this->at(k, tree, q, v);
    const Side own = side(k);
    if (!at.is_one_sided) {
        if (own == Side::upper) return at.force - at.limit + at.beyond;
        if (own == Side::lower) return -at.limit - at.force + at.beyond;
        return at.limit - std::abs(at.force) + at.beyond;
    }
    if (own == Side::out || !at.is_damped || at.force == 0.0) return INFINITY;
    return (own == Side::acts ? at.force : -at.force) + at.beyond;
}

void add_torques(const Forces& forces, const Kinks& kinks, int entry, double t, const double* q,
                 const double* v, double* torques) {
    for (std::size_t i = 0; i < forces.constants.size(); ++i)
        if (is_chosen(forces, entry, ForceEntry::constant, i))
            for (std::size_t j = 0; j < forces.constants[i].torque.size(); ++j)
                torques[forces.constants[i].v + j] += forces.constants[i].torque[j];
    for (std::size_t i = 0; i < forces.joints.size(); ++i)
        if (is_chosen(forces, entry, ForceEntry::joint, i))
            torques[forces.joints[i].v] +=
                clamped(forces.joints[i], kinks, static_cast<int>(i), q, v);
    for (std::size_t i = 0; i < forces.timed.size(); ++i)
        if (is_chosen(forces, entry, ForceEntry::timed, i))
            torques[forces.timed[i].v] += forces.timed[i].table.at(t);
    Arena::Scope scope(scratch());
    for (std::size_t i = 0; i < forces.functions.size(); ++i) {
        if (!is_chosen(forces, entry, ForceEntry::function, i)) continue;
        const TorqueFunction& own = forces.functions[i];
        double* given = scratch().allocate(own.count);
        own.function(t, q, v, given);
        for (int j = 0; j < own.count; ++j) torques[own.v + j] += given[j];
    }
}

void add_wrenches(const Forces& forces, const Kinks& kinks, int entry, double t, const double* q,
                  const double* v, const Tree<double>& tree, const AddWrench& add) {
    for (std::size_t i = 0; i < forces.springs.size(); ++i)
        if (is_chosen(forces, entry, ForceEntry::spring, i) &&
            kinks.of_spring(static_cast<int>(i)) == Side::acts)
            pull(forces.springs[i], tree, add);
    for (std::size_t i = 0; i < forces.applied.size(); ++i) {
        if (!is_chosen(forces, entry, ForceEntry::applied, i)) continue;
        const AppliedForce& own = forces.applied[i];
        double given[6];
        if (own.function) own.function(t, q, v, given);
        add(own.site, wrench_of(Blow{own.site, own.is_local}, own.function ? given : own.numbers,
                                tree.rotation[own.site.body], false));
    }
}

double spring_energy(const Forces& forces, const Tree<double>& tree, const double* q) {
    double total = 0.0;
    for (const JointForce& f : forces.joints) {
        const double strain = strain_of(f, q);
        if (f.stores && (f.side == 0.0 || zone_of(f, q) >= 0.0))
            total += 0.5 * f.stiffness * strain * strain;
    }
    for (const PointSpring& s : forces.springs) {
        const double strain = stretch_of(s, tree).length - s.rest;
        if (s.side * strain >= 0.0) total += 0.5 * s.stiffness * strain * strain;
    }
    return total;
}

}  // namespace impulsekit
