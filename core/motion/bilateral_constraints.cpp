#include "motion/bilateral_constraints.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "scene/constraint_rows.hpp"
#include "spatial/joints.hpp"

namespace impulsekit {
namespace {

// Points so near at the start [m] are closed for good: loops closed by hand are off by as much.
constexpr double kClosed = 1e-6;

// The rotation vector of a small turn.
Vec turn_of(const Mat& r) {
    return {0.5 * (r.y.z - r.z.y), 0.5 * (r.z.x - r.x.z), 0.5 * (r.x.y - r.y.x)};
}

bool moves(const Scene& scene, const Held& held, bool angular) {
    for (int r = 0; r < held.count; ++r)
        if ((held.select[r] > 2) == angular && scene.velocity[held.row + r] != 0.0) return true;
    return false;
}

int count_of(const Held& held, bool angular) {
    int count = 0;
    for (int r = 0; r < held.count; ++r) count += (held.select[r] > 2) == angular;
    return count;
}

}  // namespace

BilateralConstraints::BilateralConstraints(const Scene& scene, int entries,
                                           std::vector<char> driven_places,
                                           std::vector<char> driven_speeds,
                                           ConstraintFunctions functions)
    : scene_(&scene),
      entries_(entries),
      driven_places_(std::move(driven_places)),
      driven_speeds_(std::move(driven_speeds)),
      functions_(std::move(functions)),
      kept_(entries) {
    for (int e = 0; e < entries; ++e) rows_ += scene.held[e].count;
    A_.assign(rows_ * scene.model->nv, 0.0);
    wider_.assign(rows_, 1.0);
    bias_.assign(rows_, 0.0);
    velocity_.assign(scene.velocity.begin(), scene.velocity.begin() + rows_);
}

void BilateralConstraints::fill_rows(const Tree<double>& tree, const double* q) {
    const Arena::Scope scope(scratch());
    double* rows = scratch().allocate(scene_->function_rows * scene_->model->nv);
    if (scene_->function_rows > 0) functions_.rows(q, rows);
    GivenState given;
    given.function_rows = rows;
    bool has_line = true;
    write_constraint_rows(*scene_, entries_, tree, &given, A_.data(), wider_.data(), &has_line);
}

void BilateralConstraints::fill(const Tree<double>& tree, const double* q, const double* v) {
    fill_rows(tree, q);
    Arena::Scope scope(scratch());
    double* given = scratch().allocate(scene_->function_rows);
    if (scene_->function_rows > 0) functions_.bias(q, v, given);
    for (int e = 0; e < entries_; ++e) {
        const Held& held = scene_->held[e];
        double* to = bias_.data() + held.row;
        std::fill(to, to + held.count, 0.0);
        if (held.kind == Held::pair) {
            const Spatial<double> rate = relative_rate(tree, frame_pair_motion(tree, held.frames));
            for (int r = 0; r < held.count; ++r)
                to[r] = held.select[r] < 3 ? entry(rate.linear, held.select[r])
                                           : entry(rate.angular, held.select[r] - 3);
        } else if (held.kind == Held::functions) {
            std::copy(given, given + held.count, to);
            given += held.count;
        }
    }
}

void BilateralConstraints::speeds(double t, double* velocity, double* rate) const {
    std::copy(velocity_.begin(), velocity_.end(), velocity);
    std::fill(rate, rate + rows_, 0.0);
    if (functions_.speeds) functions_.speeds(t, velocity, rate);
}

void BilateralConstraints::start(const Tree<double>& tree, const double* q, const double* v) {
    fill_rows(tree, q);
    const int nv = scene_->model->nv;
    for (int r = 0; r < rows_; ++r) {
        if (!scene_->kept[r]) continue;
        velocity_[r] = 0.0;
        for (int i = 0; i < nv; ++i) velocity_[r] += A_[r * nv + i] * v[i];
    }
    int function = 0;
    std::vector<double> values(scene_->function_rows);
    if (functions_.values && !values.empty()) functions_.values(q, values.data());
    for (int e = 0; e < entries_; ++e) {
        const Held& held = scene_->held[e];
        kept_[e] = Kept();
        if (held.kind == Held::pair && !driven_speeds_[e]) keep_pair(tree, held, kept_[e]);
        if (held.kind == Held::speeds) kept_[e].values.assign(q, q + scene_->model->nq);
        if (held.kind != Held::functions) continue;
        auto& own = kept_[e].values;
        own.assign(values.begin() + function, values.begin() + function + held.count);
        double most = 0.0;
        for (double x : own) most = std::max(most, std::abs(x));
        if (most < kClosed) std::fill(own.begin(), own.end(), 0.0);
        function += held.count;
    }
}

// Find what the rows of two frames determine of their places: all of a point, or all of its
// coordinates in axes that stay; all of a turn, or the tilt of an axis.
void BilateralConstraints::keep_pair(const Tree<double>& tree, const Held& held, Kept& kept) const {
    const Pair& pair = held.frames;
    const Vec first = place_of(tree, pair.first), other = place_of(tree, pair.other);
    const Mat rotation = axes_of(tree, pair.first), other_rotation = axes_of(tree, pair.other);
    const Vec offset = first - other;
    if (pair.carrier == Carrier::line) {
        kept.linear = Kept::distance;
        kept.length = std::sqrt(dot(offset, offset));
        return;
    }
    const int linear = count_of(held, false), angular = count_of(held, true);
    const bool drives = moves(*scene_, held, false), whole = linear == 3 && !drives;
    if (linear > 0 && pair.coincides && (whole || angular == 3)) {
        kept.linear = drives ? Kept::nothing : Kept::met;
        kept.point = back(other_rotation, offset);
    } else if (linear > 0 && (pair.carrier == Carrier::world || whole) &&
               !(pair.coincides && pair.other.body > 0)) {
        kept.linear = Kept::apart;
        kept.point = offset;
        const double most = std::max({std::abs(offset.x), std::abs(offset.y), std::abs(offset.z)});
        if (!pair.coincides && most < kClosed) kept.point = {};
    }
    kept.rotation = rotation;
    kept.relative = transposed(other_rotation) * rotation;
    if (angular == 0 || moves(*scene_, held, true)) return;
    const bool local = pair.carrier != Carrier::world;
    if (angular == 3)
        kept.angular = Kept::all;
    else if (angular == 2 && (local || pair.other.body == 0))
        kept.angular = local ? Kept::hinge_of_first : Kept::hinge_of_world;
}

void BilateralConstraints::drift_of_pair(const Tree<double>& tree, const Held& held,
                                         const Kept& kept, double t, std::vector<double>& off,
                                         std::vector<int>& rows) const {
    const Pair& pair = held.frames;
    const Vec first = place_of(tree, pair.first), other = place_of(tree, pair.other);
    const Mat rotation = axes_of(tree, pair.first), other_rotation = axes_of(tree, pair.other);
    const Mat axes = frame_pair_state(tree, pair).axes;
    Vec linear, angular;
    if (kept.linear == Kept::distance) {
        const Vec offset = first - other;
        off.push_back(std::sqrt(dot(offset, offset)) - kept.length - velocity_[held.row] * t);
        rows.push_back(held.row);
        return;
    }
    if (kept.linear == Kept::met) linear = back(axes, first - other - other_rotation * kept.point);
    if (kept.linear == Kept::apart) {
        Vec speed;
        for (int r = 0; r < held.count; ++r) {
            if (held.select[r] == 0) speed.x = velocity_[held.row + r];
            if (held.select[r] == 1) speed.y = velocity_[held.row + r];
            if (held.select[r] == 2) speed.z = velocity_[held.row + r];
        }
        linear = back(axes, first - other - kept.point - speed * t);
    }
    if (kept.angular == Kept::all) {
        const Mat was = other_rotation * kept.relative;
        angular = back(axes, turn_of(rotation * transposed(was)));
    } else if (kept.angular != Kept::none) {
        bool turns[3] = {};
        for (int r = 0; r < held.count; ++r)
            if (held.select[r] > 2) turns[held.select[r] - 3] = true;
        const int free = !turns[0] ? 0 : !turns[1] ? 1 : 2;
        const Mat m = kept.angular == Kept::hinge_of_first
                          ? transposed(rotation) * (other_rotation * kept.relative)
                          : rotation * transposed(kept.rotation);
        const double sign = kept.angular == Kept::hinge_of_first ? -1.0 : 1.0;
        const Vec axis = entry(m, free) * sign;
        const Vec unit{free == 0 ? 1.0 : 0.0, free == 1 ? 1.0 : 0.0, free == 2 ? 1.0 : 0.0};
        angular = cross(unit, axis);
    }
    for (int r = 0; r < held.count; ++r) {
        const bool turns = held.select[r] > 2;
        if (turns ? kept.angular == Kept::none : kept.linear == Kept::nothing) continue;
        off.push_back(turns ? entry(angular, held.select[r] - 3) : entry(linear, held.select[r]));
        rows.push_back(held.row + r);
    }
}

// True if all its coordinates are numbers that velocities are the rates of.
bool BilateralConstraints::is_plain(const Held& held) const {
    const Model& model = *scene_->model;
    for (const Held::Term& term : held.terms)
        for (const Slot& slot : model.slots)
            if (slot.v == term.v && model.bodies[slot.body].type.coordinates() != 1) return false;
    return true;
}

void BilateralConstraints::drift_of_speeds(const Held& held, int e, const Kept& kept,
                                           const double* q, double t, std::vector<double>& off,
                                           std::vector<int>& rows) const {
    if (driven_places_[e]) {
        const int v = held.terms[0].v;
        std::vector<double> there(kept.values);
        set_coordinate(*scene_->model, v, functions_.place(e, t), there.data());
        off.push_back(coordinate_difference(*scene_->model, v, there.data(), q));
        rows.push_back(held.row);
        return;
    }
    const bool locks = scene_->locks[held.row] >= 0;
    if (driven_speeds_[e] || !(locks || is_plain(held))) return;
    for (int r = 0; r < held.count; ++r) {
        const double speed = velocity_[held.row + r];
        if (speed != 0.0 && !is_plain(held)) continue;
        double own = -speed * t;
        for (const Held::Term& term : held.terms)
            if (term.row == r)
                own += term.factor *
                       coordinate_difference(*scene_->model, term.v, kept.values.data(), q);
        off.push_back(own);
        rows.push_back(held.row + r);
    }
}

void BilateralConstraints::drift(const Tree<double>& tree, const double* q, double t,
                                 std::vector<double>& off, std::vector<int>& rows) const {
    off.clear();
    rows.clear();
    int function = 0;
    std::vector<double> values(scene_->function_rows);
    if (functions_.values && !values.empty()) functions_.values(q, values.data());
    for (int e = 0; e < entries_; ++e) {
        const Held& held = scene_->held[e];
        const Kept& kept = kept_[e];
        if (held.kind == Held::pair && !driven_speeds_[e])
            drift_of_pair(tree, held, kept, t, off, rows);
        if (held.kind == Held::speeds) drift_of_speeds(held, e, kept, q, t, off, rows);
        if (held.kind != Held::functions) continue;
        for (int r = 0; r < held.count && !driven_speeds_[e]; ++r) {
            off.push_back(values[function + r] - kept.values[r] - velocity_[held.row + r] * t);
            rows.push_back(held.row + r);
        }
        function += held.count;
    }
}

}  // namespace impulsekit
