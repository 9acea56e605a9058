#include "motion/dynamics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "contact/rest_law.hpp"
#include "contact/tolerances.hpp"
#include "linalg/arena.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// Accelerations [m/s² or rad/s²] that are rounding where no force acts: 1e-11 m in a day.
constexpr double kNoAcceleration = 1e-20;

// The direction in which something slides. Within a step that goes on beyond where it stops, what
// turns back has the direction that it came with: forces are smooth up to the stop and beyond.
void slip_direction(const double* speeds, double speed, double slow, const SlipState& slip_state,
                    double* direction) {
    const double ahead = speeds[0] * slip_state.direction[0] + speeds[1] * slip_state.direction[1];
    for (int j = 0; j < 2; ++j)
        direction[j] =
            speed > slow ? std::copysign(1.0, ahead) * speeds[j] / speed : slip_state.direction[j];
}

}  // namespace

Dynamics::Dynamics(const MotionScene& own)
    : scene(own),
      tree(*own.scene.model),
      constraints(own.scene, own.entries, own.driven_places, own.driven_speeds, own.constraints),
      contact_gaps(own.scene, own.law, own.contact_gaps, own.conditional),
      kinks(own.forces) {
    const int nv = own.scene.model->nv;
    M_.resize(nv * nv);
    load_.resize(nv);
    start_.resize(nv);
    target_.resize(constraints.rows());
    demand_.resize(constraints.rows());
    multipliers.resize(constraints.rows());
    unique.assign(constraints.rows(), 1);
    dry_torque.assign(own.dry.size(), 0.0);
    dry_rate.assign(own.dry.size(), 0.0);
}

double Dynamics::static_friction(int entry) const {
    if (contact_gaps.is_elliptic(entry)) return 1.0;
    return scene.law.contacts[entry].friction;
}

double Dynamics::sliding_friction(int entry, double speed) const {
    const Friction& model = scene.law.contacts[entry].model;
    if (model.kind == Friction::Kind::static_kinetic) return model.second;
    if (model.kind == Friction::Kind::by_speed)
        return model.at_speed(std::max(speed, tolerance::tiny));
    return static_friction(entry);
}

bool Dynamics::has_drop(int entry) const {
    const Friction::Kind kind = scene.law.contacts[entry].model.kind;
    return kind == Friction::Kind::static_kinetic || kind == Friction::Kind::by_speed;
}

void Dynamics::set_state(const double* q, const double* v, bool rates) {
    tree.place(q);
    tree.move(v);
    if (!rates) return;
    Arena::Scope scope(scratch());
    tree.bias(v, scene.gravity, scratch().allocate(scene.scene.model->nv));
}

const std::vector<double>& Dynamics::mass_matrix() {
    tree.weigh();
    tree.mass_matrix(M_.data());
    return M_;
}

bool Dynamics::correct(const Correction& correction, double* v) {
    const int nv = scene.scene.model->nv, count = static_cast<int>(correction.change.size());
    is_prepared_ = false;
    std::vector<int> vectors(count);
    std::iota(vectors.begin(), vectors.end(), 0);
    if (!mass_.factor(mass_matrix().data(), scene.scene.model->parent_v.data(), nv,
                      {count, correction.rows.data(), vectors.data(), nullptr}))
        return false;
    std::vector<double> demand = correction.change, impulses(count), dv(nv);
    mass_.apply_multipliers(demand.data(), dv.data(), impulses.data());
    mass_.mass().rest(dv.data());
    for (int i = 0; i < nv; ++i) v[i] += dv[i];
    return true;
}

// τ − h without torques from outside: forces, weight, and what velocities ask for; the tree is left
// with rates.
void Dynamics::write_load(double t, const double* q, const double* v, const RestingState& rest) {
    const int nv = scene.scene.model->nv;
    std::fill(load_.begin(), load_.end(), 0.0);
    std::fill(tree.wrench.begin(), tree.wrench.end(), Spatial<double>{});
    add_torques(scene.forces, kinks, -1, t, q, v, load_.data());
    Arena::Scope scope(scratch());
    double* along = scratch().allocate(nv);
    if (scene.forces.on_bodies()) {
        add_wrenches(scene.forces, kinks, -1, t, q, v, tree,
                     [this](const Site& site, const Spatial<double>& own) {
                         tree.wrench[site.body] += own;
                     });
        tree.gather(along);
        for (int i = 0; i < nv; ++i) load_[i] += along[i];
    }
    tree.bias(v, scene.gravity, along);
    for (int i = 0; i < nv; ++i) load_[i] -= along[i];
    for (std::size_t j = 0; j < scene.dry.size(); ++j) {
        dry_torque[j] = -rest.dry[j] * scene.dry[j].bound;
        dry_rate[j] = 0.0;
        load_[scene.dry[j].v] += dry_torque[j];
    }
}

// Let the bilateral rows hold what `start`, half-solved, would make of them; false where they
// contradict each other.
bool Dynamics::hold(double* start) {
    const auto [apart, terms] = mass_.apply_multipliers(demand_.data(), start, multipliers.data());
    return !(apart > tolerance::contradiction * terms + tolerance::at_rest * squares_);
}

// J and its bias: points, turning, joints that keep still.
void Dynamics::write_rest_rows(const double* q, const double* v, const RestingState& rest) {
    const int nv = scene.scene.model->nv, n = static_cast<int>(rest.points.size());
    turning_points.clear();
    for (int i = 0; i < n; ++i)
        if (contact_gaps.gaps()[rest.points[i].gap].turns) turning_points.push_back(i);
    const int k = static_cast<int>(turning_points.size());
    int still = 0;
    for (signed char direction : rest.dry) still += direction == 0;
    rows_ = 3 * (n + k) + still;
    J_.assign(rows_ * nv, 0.0);
    bias_.assign(rows_, 0.0);
    int next = 0;
    for (int i = 0; i < n; ++i) {
        const bool turns = next < k && turning_points[next] == i;
        const int row = 3 * (n + next);
        contact_gaps.rows(tree, rest.points[i], q, v,
                          {J_.data() + 3 * i * nv, turns ? J_.data() + row * nv : nullptr,
                           bias_.data() + 3 * i, turns ? bias_.data() + row : nullptr});
        next += turns;
    }
    int row = 3 * (n + k);
    for (std::size_t j = 0; j < rest.dry.size(); ++j)
        if (rest.dry[j] == 0) J_[row++ * nv + scene.dry[j].v] = 1.0;
    condense(3 * (n + k));
}

// All that does not depend on torques from outside: loads, the factor of M, rows and W.
DynamicsFailure Dynamics::prepare(double t, const double* q, const double* v,
                                  const RestingState& rest) {
    ++evaluations;
    const int nv = scene.scene.model->nv, m = constraints.rows();
    is_prepared_ = false;
    set_state(q, v);
    write_load(t, q, v, rest);
    if (m > 0) {
        Arena::Scope scope(scratch());
        double* speed = scratch().allocate(m);
        constraints.fill(tree, q, v);
        constraints.speeds(t, speed, target_.data());
        for (int r = 0; r < m; ++r) target_[r] -= constraints.bias()[r];
        const double fastest = largest(v, nv);
        squares_ = largest(constraints.A(), m * nv) * fastest * fastest;
    }
    if (!mass_.factor(mass_matrix().data(), scene.scene.model->parent_v.data(), nv,
                      {m, constraints.A(), constraints.vectors(), constraints.wider()}))
        return DynamicsFailure::singular_mass;
    mass_.fill(target_.data(), load_.data());
    if (m > 0) unique = mass_.rows().unique();
    rows_ = 0;
    if (rest.acts()) write_rest_rows(q, v, rest);
    t_ = t;
    state_.assign(q, q + scene.scene.model->nq);
    state_.insert(state_.end(), v, v + nv);
    rest_ = rest;
    is_prepared_ = true;
    return DynamicsFailure::none;
}

bool Dynamics::is_known(double t, const double* q, const double* v,
                        const RestingState& rest) const {
    const auto same = [](const RestingContact& x, const RestingContact& y) {
        return x.is_same_point(y);
    };
    return is_prepared_ && t == t_ && rest.dry == rest_.dry &&
           std::equal(rest.points.begin(), rest.points.end(), rest_.points.begin(),
                      rest_.points.end(), same) &&
           std::equal(q, q + scene.scene.model->nq, state_.begin()) &&
           std::equal(v, v + scene.scene.model->nv, state_.end() - scene.scene.model->nv);
}

DynamicsFailure Dynamics::accelerate(double t, const double* q, const double* v, RestingState& rest,
                                     double* a) {
    const DynamicsFailure failure = prepare(t, q, v, rest);
    return failure == DynamicsFailure::none ? accelerate_again(rest, a) : failure;
}

DynamicsFailure Dynamics::accelerate_again(RestingState& rest, double* a) {
    const int nv = scene.scene.model->nv;
    double* start = start_.data();
    std::copy(load_.begin(), load_.end(), start);
    for (std::size_t i = 0; i < rest.controls.size(); ++i) start[i] += rest.controls[i];
    mass_.mass().half(start);
    std::fill(multipliers.begin(), multipliers.end(), 0.0);
    demand_ = target_;
    if (!hold(start)) return DynamicsFailure::contradiction;
    if (rest.acts()) {
        const DynamicsFailure failure = rest_forces(rest, start);
        if (failure != DynamicsFailure::none) return failure;
    } else {
        F.clear(), rate.clear(), slip.clear(), moment.clear(), turn_rate.clear(), turning.clear();
    }
    std::copy(start, start + nv, a);
    mass_.mass().rest(a);
    return DynamicsFailure::none;
}

// W of the rows of what rests, under the bilateral rows.
void Dynamics::condense(int threes) {
    const int nv = scene.scene.model->nv;
    Arena::Scope scope(scratch());
    half_contacts_ = J_;
    for (int r = 0; r < threes; r += 3) mass_.mass().half<3>(half_contacts_.data() + r * nv);
    for (int r = threes; r < rows_; ++r) mass_.mass().half(half_contacts_.data() + r * nv);
    left_ = half_contacts_;
    W_.resize(rows_ * rows_);
    // Points have three rows each, a joint one.
    mass_.project_out_constraints(half_contacts_.data(), threes, left_.data());
    for (int r = threes; r < rows_; ++r)
        mass_.project_out_constraints(half_contacts_.data() + r * nv, 1, left_.data() + r * nv);
    // Rows of bodies that have nothing to do with each other share no columns.
    int *first = scratch().allocate_int(rows_), *last = scratch().allocate_int(rows_);
    for (int i = 0; i < rows_; ++i) {
        const double* row = left_.data() + i * nv;
        first[i] = 0, last[i] = nv;
        while (first[i] < nv && row[first[i]] == 0.0) ++first[i];
        while (last[i] > first[i] && row[last[i] - 1] == 0.0) --last[i];
        for (int j = 0; j <= i; ++j) {
            const int from = std::max(first[i], first[j]), to = std::min(last[i], last[j]);
            W_[i * rows_ + j] = W_[j * rows_ + i] =
                from < to ? dot(row + from, left_.data() + j * nv + from, to - from) : 0.0;
        }
    }
}

// Bounds of friction, directions of slip and pulls of what rests; pulls act on the bias.
void Dynamics::write_bounds(const RestingState& rest, const RestBounds& bounds, double* free) {
    const int nv = scene.scene.model->nv;
    const double *v = state_.data() + scene.scene.model->nq, *W = W_.data();
    const int n = static_cast<int>(rest.points.size()), k = static_cast<int>(turning_points.size());
    const auto [reach, direction, bound, pull, pressed] = bounds;
    slip.assign(3 * n, 0.0);
    turning.assign(3 * k, 0.0);
    size = 0.0;
    for (int i = 0; i < n; ++i) {
        const RestingContact& point = rest.points[i];
        const int entry = contact_gaps.gaps()[point.gap].entry;
        for (int j = 0; j < 3; ++j) slip[3 * i + j] = dot(J_.data() + (3 * i + j) * nv, v, nv);
        pressed[i] = point.pressed;
        reach[i] = static_friction(entry);
        if (point.slip.moves) {
            const double speed = std::hypot(slip[3 * i], slip[3 * i + 1]);
            reach[i] = sliding_friction(entry, speed);
            if (!point.slip.begins())
                slip_direction(&slip[3 * i], speed, slow, point.slip, direction + 2 * i);
        }
        if (!scene.pulls.empty()) pull[i] = scene.pulls[entry];
    }
    for (int r = 0; r < rows_; ++r) {
        if (std::abs(free[r]) <= kNoAcceleration) free[r] = 0.0;
        size = std::max(size, std::abs(free[r]));
    }
    for (int i = 0; i < n; ++i)
        if (pull[i] > 0.0) {
            for (int r = 0; r < rows_; ++r) free[r] -= W[r * rows_ + 3 * i + 2] * pull[i];
            size = std::max(size, W[(3 * i + 2) * (rows_ + 1)] * pull[i]);
        }
    for (int c = 0; c < k; ++c) {
        const RestingContact& point = rest.points[turning_points[c]];
        const ContactCoefficients& own = scene.law.contacts[contact_gaps.gaps()[point.gap].entry];
        const int row = 3 * (n + c), roll = n + 2 * c;
        for (int j = 0; j < 3; ++j) turning[3 * c + j] = dot(J_.data() + (row + j) * nv, v, nv);
        reach[roll] = own.rolling;
        reach[roll + 1] = own.torsion;
        const double speed = std::hypot(turning[3 * c], turning[3 * c + 1]);
        if (point.roll.moves)
            slip_direction(&turning[3 * c], speed, slow, point.roll, direction + 2 * roll);
        if (point.spin.moves) direction[2 * (roll + 1)] = point.spin.direction[0];
    }
    int joint = 0;
    for (std::size_t j = 0; j < rest.dry.size(); ++j)
        if (rest.dry[j] == 0) bound[joint++] = scene.dry[j].bound;
}

DynamicsFailure Dynamics::rest_forces(RestingState& rest, double* start) {
    const int nv = scene.scene.model->nv;
    const int n = static_cast<int>(rest.points.size()), k = static_cast<int>(turning_points.size());
    Arena::Scope scope(scratch());
    double* free = scratch().allocate(rows_);
    for (int r = 0; r < rows_; ++r)
        free[r] = bias_[r] + dot(half_contacts_.data() + r * nv, start, nv);
    RestProblem p;
    p.points = n;
    p.turning = k;
    p.joints = rows_ - 3 * (n + k);
    double *reach = scratch().allocate(n + 2 * k), *direction = scratch().allocate(2 * (n + 2 * k)),
           *bound = scratch().allocate(p.joints), *pull = scratch().allocate(n);
    char* pressed = reinterpret_cast<char*>(scratch().allocate(n));
    write_bounds(rest, {reach, direction, bound, pull, pressed}, free);
    p.W = W_.data();
    p.b = free;
    p.reach = reach;
    p.direction = direction;
    p.turning_of = turning_points.data();
    p.bound = bound;
    double *force = scratch().allocate(rows_), *rates = scratch().allocate(rows_);
    if (!solve_rest(p, pressed, force, rates)) return DynamicsFailure::rest_not_solved;
    for (int i = 0; i < n; ++i) {
        rest.points[i].pressed = pressed[i];
        has_opened = has_opened || !pressed[i];
        force[3 * i + 2] -= pull[i];
    }
    F.assign(force, force + 3 * n);
    rate.assign(rates, rates + 3 * n);
    moment.assign(force + 3 * n, force + 3 * (n + k));
    turn_rate.assign(rates + 3 * n, rates + 3 * (n + k));
    int joint = 3 * (n + k);
    for (std::size_t j = 0; j < rest.dry.size(); ++j)
        if (rest.dry[j] == 0) {
            dry_torque[j] = force[joint];
            dry_rate[j] = rates[joint++];
        }
    add_transposed(half_contacts_.data(), rows_, nv, force, start);
    return hold(start) ? DynamicsFailure::none : DynamicsFailure::contradiction;
}

}  // namespace impulsekit
