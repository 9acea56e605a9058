// The rows of a scene at a state: A, J, axes, places and gaps, for one state or eight side by side.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/shapes.hpp"
#include "linalg/tolerances.hpp"
#include "scene/contact_geometry.hpp"
#include "scene/scene.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {

// A point that may touch. Lanes that do not are left out of the law.
template <typename S>
struct ContactFrame {
    int entry = 0;
    int first = 0, other = 0;  // bodies; both 0 for a stop or functions
    bool of_bodies = false;    // whether it has a place, and axes in the world
    Mat3<S> axes = identity<S>();
    Vec3<S> place, other_place;  // of both ends, which differ for a rope
    S gap{};
    bool closed[Number<S>::lanes];
    int feature = -1;   // of bodies of any shapes: where the names of its points begin
    double sign = 1.0;  // of a stop: −1 at its upper limit
};

template <typename S>
class Rows {
  public:
    static constexpr int lanes = Number<S>::lanes;
    const Scene& scene;
    std::vector<S> A;       // (rows, nv)
    std::vector<S> target;  // (rows)
    std::vector<S> wider;   // (rows), see StateRows
    std::vector<ContactFrame<S>> contact_frames;
    std::vector<S> J;                 // (3 touches, nv)
    std::vector<S> turning;           // (3 touches, nv) of the relative angular velocity
    bool has_line[Number<S>::lanes];  // false where two points of a line coincide
    std::vector<Feature> features;    // of such touches, one of each lane

    explicit Rows(const Scene& s)
        : scene(s), A(s.rows() * s.model->nv), target(s.rows()), wider(s.rows()) {}

    // All rows at q, v; the tree with places and columns there. `given`: one of each lane.
    void fill(const Tree<S>& tree, const S* q, const S* v, const GivenState* given) {
        std::fill(has_line, has_line + lanes, true);
        add_contacts(tree, q, given);
        for (int k = 0; k < lanes; ++k)
            if (given[k].only) choose(given[k].only, k);
        add_constraints(tree, v, given);
    }

    // The points of one lane, without rows.
    void extract_points(const Tree<S>& tree, int k, StateRows& to) const {
        to.points.clear();
        to.turning_of.clear();
        to.contact_frame_of.clear();
        to.without_line = has_line[k] ? -1 : 0;
        to.without_ellipse = -1;
        for (std::size_t i = 0; i < contact_frames.size(); ++i) {
            if (!contact_frames[i].closed[k]) continue;
            if (scene.contacts[contact_frames[i].entry].turns)
                to.turning_of.push_back(static_cast<int>(to.points.size()));
            to.contact_frame_of.push_back(static_cast<int>(i));
            to.points.push_back(point_of(tree, contact_frames[i], k, to));
        }
    }

    // The rows of one lane.
    void extract(const Tree<S>& tree, int k, StateRows& to) const {
        extract_points(tree, k, to);
        to.A.resize(A.size());
        to.target.resize(target.size());
        to.wider.resize(wider.size());
        to.yielded.clear();
        for (std::size_t i = 0; i < A.size(); ++i) to.A[i] = get(A[i], k);
        for (std::size_t i = 0; i < target.size(); ++i) {
            to.target[i] = get(target[i], k);
            to.wider[i] = get(wider[i], k);
        }
        for (const Held& held : scene.held)
            if (held.stop >= 0 && to.A[held.row * nv() + held.terms[0].v] == 0.0)
                to.yielded.push_back(held.row);
        const std::size_t block = 3 * nv();
        to.J.resize((to.points.size() + to.turning_of.size()) * block);
        double* next = to.J.data();
        auto copy = [&](const std::vector<S>& rows, int frame) {
            for (std::size_t j = 0; j < block; ++j) *next++ = get(rows[frame * block + j], k);
        };
        for (int frame : to.contact_frame_of) copy(J, frame);
        for (int point : to.turning_of) copy(turning, to.contact_frame_of[point]);
    }

    // Add what impulses of the rows (P of each touch in its axes and moments behind them, λ) give
    // the bodies, about their origins in world axes.
    void add_wrenches(Tree<S>& tree, const S* P, const S* moments, const S* lambda) const {
        for (std::size_t i = 0; i < contact_frames.size(); ++i) {
            const ContactFrame<S>& t = contact_frames[i];
            if (!t.of_bodies) continue;
            const Vec3<S> f = t.axes * Vec3<S>{P[3 * i], P[3 * i + 1], P[3 * i + 2]};
            add_wrench(tree, t.first, t.place, f, number<S>(1.0));
            add_wrench(tree, t.other, t.other_place, f, number<S>(-1.0));
            if (!scene.contacts[t.entry].turns) continue;
            const Vec3<S> m =
                t.axes * Vec3<S>{moments[3 * i], moments[3 * i + 1], moments[3 * i + 2]};
            tree.wrench[t.first].angular += m;
            tree.wrench[t.other].angular -= m;
        }
        for (const Held& held : scene.held) {
            if (held.kind != Held::pair) continue;
            const Ends ends = ends_of(tree, held.frames);
            S p[6] = {};
            for (int r = 0; r < held.count; ++r) p[held.select[r]] = lambda[held.row + r];
            const Vec3<S> f = ends.axes * Vec3<S>{p[0], p[1], p[2]};
            const Vec3<S> m = ends.axes * Vec3<S>{p[3], p[4], p[5]};
            add_wrench(tree, held.frames.first.body, ends.place, f, number<S>(1.0));
            add_wrench(tree, held.frames.other.body, ends.other_place, f, number<S>(-1.0));
            tree.wrench[held.frames.first.body].angular += m;
            tree.wrench[held.frames.other.body].angular -= m;
        }
    }

    // Both points of a pair in the world and from the origins of their bodies, and R.
    struct Ends {
        Vec3<S> place, other_place;
        Mat3<S> axes;
        Vec3<S> arm, other_arm;
    };

    static Ends ends_of(const Tree<S>& tree, const Pair& pair) {
        Ends ends;
        ends.axes = mat3<S>(pair.axes);
        ends.arm = tree.rotation[pair.first.body] * vec3<S>(pair.first.point);
        ends.place = tree.origin[pair.first.body] + ends.arm;
        ends.other_arm = tree.rotation[pair.other.body] * vec3<S>(pair.other.point);
        ends.other_place = tree.origin[pair.other.body] + ends.other_arm;
        if (pair.coincides) set_coincident(tree, pair.other.body, ends);
        if (pair.carrier == Carrier::first || pair.carrier == Carrier::other) {
            const Site& site = pair.carrier == Carrier::first ? pair.first : pair.other;
            ends.axes = tree.rotation[site.body] * (mat3<S>(site.axes) * ends.axes);
        } else if (pair.carrier == Carrier::line) {
            const Vec3<S> offset = ends.place - ends.other_place;
            const S length = root(dot(offset, offset));
            set_axes(ends.axes, offset * (pair.axes[8] / length));
        }
        return ends;
    }

    static Vec3<S> place_of(const Tree<S>& tree, const Site& site) {
        return tree.origin[site.body] + tree.rotation[site.body] * vec3<S>(site.point);
    }

  private:
    int nv() const { return scene.model->nv; }

    StateRows::Point point_of(const Tree<S>& tree, const ContactFrame<S>& t, int k,
                              StateRows& to) const {
        StateRows::Point p;
        p.entry = t.entry;
        p.first = t.first;
        p.other = t.other;
        p.of_bodies = t.of_bodies;
        p.sign = t.sign;
        p.end = get(t.place, k);
        p.other_end = get(t.other_place, k);
        if (t.feature >= 0) p.feature = features[t.feature + k];
        p.gap = get(t.gap, k);
        const Vec3<double> x = get(t.axes.x, k), y = get(t.axes.y, k), n = get(t.axes.z, k);
        const Vec3<double> place = get(tree.world_place(t.place), k);
        const double axes[9] = {x.x, y.x, n.x, x.y, y.y, n.y, x.z, y.z, n.z};
        std::copy(axes, axes + 9, p.axes);
        p.place[0] = place.x;
        p.place[1] = place.y;
        p.place[2] = place.z;
        const Contact& contact = scene.contacts[t.entry];
        if (contact.ellipse_body < 0) return p;
        const Mat3<S>& r = tree.rotation[contact.ellipse_body];
        const Mat3<double> turn{get(r.x, k), get(r.y, k), get(r.z, k)};
        const Vec3<double> along = turn * vec3<double>(contact.along);
        const double a = dot(x, along), b = dot(y, along), length = std::hypot(a, b);
        if (!(length > kAlongNormal)) to.without_ellipse = t.entry;
        p.ellipse[0] = a / length;
        p.ellipse[1] = b / length;
        return p;
    }

    // Those that take part touch, whatever their gap; of a stop the nearer limit.
    void choose(const char* only, int k) {
        for (std::size_t i = 0; i < contact_frames.size(); ++i) {
            ContactFrame<S>& t = contact_frames[i];
            t.closed[k] =
                only[t.entry] && (scene.contacts[t.entry].kind != Contact::shapes || t.closed[k]);
            if (i == 0 || scene.contacts[t.entry].kind != Contact::stop) continue;
            ContactFrame<S>& last = contact_frames[i - 1];
            if (last.entry != t.entry) continue;
            const bool nearer = get(t.gap, k) < get(last.gap, k);
            last.closed[k] = last.closed[k] && !nearer;
            t.closed[k] = t.closed[k] && nearer;
        }
    }

    // The placement of a frame in one lane.
    static Placement placement_of(const Tree<S>& tree, const Site& site, int k) {
        const Mat3<S> axes = tree.rotation[site.body] * mat3<S>(site.axes);
        return {{get(axes.x, k), get(axes.y, k), get(axes.z, k)}, get(place_of(tree, site), k)};
    }

    // Let the other point be that which coincides with the first.
    static void set_coincident(const Tree<S>& tree, int other, Ends& ends) {
        ends.other_place = ends.place;
        ends.other_arm = ends.place - tree.origin[other];
    }

    // Contact axes on the normals of all lanes.
    static void set_axes(Mat3<S>& axes, const Vec3<S>& normal) {
        if constexpr (lanes == 1) {
            axes = contact_axes(normal);
        } else {
            for (int k = 0; k < lanes; ++k) {
                const Mat3<double> own = contact_axes(get(normal, k));
                put(axes.x, k, own.x);
                put(axes.y, k, own.y);
                put(axes.z, k, own.z);
            }
        }
    }

    // The contact of a ball and a shape, lane by lane.
    static void ball_contact(const Ball& ball, const Vec3<S>& centre, Vec3<S>& point,
                             Vec3<S>& normal, S& gap) {
        if constexpr (lanes == 1) {
            gap = impulsekit::ball_contact(ball, centre, point, normal);
        } else {
            for (int k = 0; k < lanes; ++k) {
                Vec3<double> own, along;
                Number<S>::set(gap, k, impulsekit::ball_contact(ball, get(centre, k), own, along));
                put(point, k, own);
                put(normal, k, along);
            }
        }
    }

    static double get(const S& x, int lane) { return Number<S>::get(x, lane); }
    static Vec3<double> get(const Vec3<S>& a, int k) {
        return {get(a.x, k), get(a.y, k), get(a.z, k)};
    }
    static void put(Vec3<S>& to, int k, const Vec3<double>& a) {
        Number<S>::set(to.x, k, a.x);
        Number<S>::set(to.y, k, a.y);
        Number<S>::set(to.z, k, a.z);
    }

    static void add_wrench(Tree<S>& tree, int body, const Vec3<S>& place, const Vec3<S>& f,
                           const S& sign) {
        const Vec3<S> own = f * sign;
        tree.wrench[body] += Spatial<S>{own, cross(place - tree.origin[body], own)};
    }

    // Call add(slot, velocity, spin) for the share of every slot in w = v − v' and ω − ω'. Of a
    // body that carries both points only their distance tells. Arms are summed up joint by joint:
    // however far away a robot stands, its places cost no digits.
    template <typename Add>
    void for_slots(const Tree<S>& tree, int first, int other, Ends ends, bool coincides,
                   Add add) const {
        const std::vector<Body>& bodies = scene.model->bodies;
        while (first > 0 || other > 0) {
            if (first == other) {
                if (coincides) return;
                const Vec3<S> between = ends.place - ends.other_place;
                each_slot(tree, first, [&](int a, const Spatial<S>& c) {
                    add(a, cross(c.angular, between), Vec3<S>{});
                });
                first = other = bodies[first].parent;
            } else if (first > other) {
                each_slot(tree, first, [&](int a, const Spatial<S>& c) {
                    add(a, c.linear + cross(c.angular, ends.arm), c.angular);
                });
                ends.arm += tree.arm[first];
                first = bodies[first].parent;
            } else {
                each_slot(tree, other, [&](int a, const Spatial<S>& c) {
                    add(a, -(c.linear + cross(c.angular, ends.other_arm)), -c.angular);
                });
                ends.other_arm += tree.arm[other];
                other = bodies[other].parent;
            }
        }
    }

    template <typename Use>
    void each_slot(const Tree<S>& tree, int body, Use use) const {
        const Body& own = scene.model->bodies[body];
        for (int a = own.slot; a < own.slot + own.freedoms; ++a) use(a, tree.column[a]);
    }

    void add_constraints(const Tree<S>& tree, const S* v, const GivenState* given) {
        std::fill(A.begin(), A.end(), S{});
        std::fill(wider.begin(), wider.end(), number<S>(1.0));
        int function = 0;
        for (const Held& held : scene.held) {
            S* rows = A.data() + held.row * nv();
            if (held.kind == Held::pair) add_pair(tree, held, rows);
            for (const Held::Term& term : held.terms)
                rows[term.row * nv() + term.v] += number<S>(term.factor);
            if (held.kind == Held::functions) {
                for (int i = 0; i < held.count * nv(); ++i)
                    for (int k = 0; k < lanes; ++k)
                        Number<S>::set(rows[i], k, given[k].function_rows[function * nv() + i]);
                function += held.count;
            }
        }
        for (int r = 0; r < scene.rows(); ++r) {
            target[r] = number<S>(scene.velocity[r]);
            if (!scene.kept[r]) continue;
            target[r] = S{};
            for (int i = 0; i < nv(); ++i) target[r] += A[r * nv() + i] * v[i];
        }
        for (const Held& held : scene.held)
            if (held.stop >= 0) yield_to_stop(held, v);
    }

    void add_pair(const Tree<S>& tree, const Held& held, S* rows) {
        const Ends ends = ends_of(tree, held.frames);
        if (held.frames.carrier == Carrier::line) check_line(ends);
        write_six(tree, held.frames, ends);
        S squares[6] = {};
        for (int r = 0; r < 6; ++r)
            for (int i = 0; i < nv(); ++i) squares[r] += six_[r * nv() + i] * six_[r * nv() + i];
        for (int r = 0; r < held.count; ++r)
            std::copy_n(six_.begin() + held.select[r] * nv(), nv(), rows + r * nv());
        set_widening(held, squares,
                     tolerance::sums * (number<S>(1.0) + root(dot(ends.place, ends.place))));
    }

    // All six rows of a pair.
    void write_six(const Tree<S>& tree, const Pair& pair, const Ends& ends) {
        six_.assign(6 * nv(), S{});
        for_slots(tree, pair.first.body, pair.other.body, ends, pair.coincides,
                  [&](int a, const Vec3<S>& w, const Vec3<S>& spin) {
                      const Vec3<S> u = back(ends.axes, w), turns = back(ends.axes, spin);
                      const S all[6] = {u.x, u.y, u.z, turns.x, turns.y, turns.z};
                      const int at = scene.model->slots[a].v;
                      for (int r = 0; r < 6; ++r) six_[r * nv() + at] += all[r];
                  });
    }

    // A vector is as long as its longest axis, held or not; of one shorter than `least` [m] only
    // rounding is left.
    void set_widening(const Held& held, const S* squares, const S& least) {
        for (int k = 0; k < lanes; ++k) {
            const double bars[2] = {get(least, k), tolerance::sums};
            double longest[2] = {}, own[2] = {};
            for (int r = 0; r < 6; ++r)
                longest[r / 3] = std::max(longest[r / 3], get(squares[r], k));
            for (int r = 0; r < held.count; ++r) {
                const int axis = held.select[r];
                own[axis / 3] = std::max(own[axis / 3], get(squares[axis], k));
            }
            for (int r = 0; r < held.count; ++r) {
                const int vector = held.select[r] / 3;
                const double ratio = own[vector] > 0.0 ? longest[vector] / own[vector] : 1.0;
                Number<S>::set(wider[held.row + r], k, std::sqrt(ratio));
                if (longest[vector] > bars[vector] * bars[vector]) continue;
                for (int i = 0; i < nv(); ++i) Number<S>::set(A[(held.row + r) * nv() + i], k, 0.0);
            }
        }
    }

    void check_line(const Ends& ends) {
        const Vec3<S> offset = ends.place - ends.other_place;
        const S square = dot(offset, offset);
        for (int k = 0; k < lanes; ++k)
            if (!(get(square, k) > tolerance::no_length * tolerance::no_length))
                has_line[k] = false;
    }

    // A stop that turns a controlled joint back is stiffer than its control.
    void yield_to_stop(const Held& held, const S* v) {
        for (const ContactFrame<S>& t : contact_frames) {
            if (t.entry != held.stop) continue;
            const int at = scene.contacts[t.entry].v;
            const S* own = J.data() + 3 * (&t - contact_frames.data()) * nv();
            for (int k = 0; k < lanes; ++k) {
                if (!t.closed[k] || !(get(own[2 * nv() + at], k) * get(v[at], k) < 0.0)) continue;
                Number<S>::set(target[held.row], k, 0.0);
                for (int i = 0; i < nv(); ++i) Number<S>::set(A[held.row * nv() + i], k, 0.0);
            }
        }
    }

    void add_contacts(const Tree<S>& tree, const S* q, const GivenState* given) {
        contact_frames.clear();
        features.clear();
        J.clear();
        turning.clear();
        int function = 0, point = 0;
        for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
            const Contact& contact = scene.contacts[i];
            const int entry = static_cast<int>(i);
            switch (contact.kind) {
                case Contact::point: {
                    const bool varies = point < static_cast<int>(scene.points.size()) &&
                                        scene.points[point] == entry;
                    add_point_contact(tree, contact, entry, varies ? point : -1, given);
                    point += varies;
                    break;
                }
                case Contact::rope:
                    add_rope(tree, contact, entry);
                    break;
                case Contact::stop:
                    add_stop(contact, entry, q, contact.lower, 1.0);
                    add_stop(contact, entry, q, contact.upper, -1.0);
                    break;
                case Contact::functions:
                    add_function_contact(entry, function++, given);
                    break;
                case Contact::ball:
                    add_ball_contact(tree, contact, entry);
                    break;
                default:
                    add_shape_contacts(tree, contact, entry, given);
            }
        }
    }

    ContactFrame<S>& new_contact_frame(int entry) {
        ContactFrame<S> t;
        t.entry = entry;
        std::fill(t.closed, t.closed + lanes, true);
        contact_frames.push_back(t);
        J.resize(3 * contact_frames.size() * nv(), S{});
        turning.resize(J.size(), S{});
        return contact_frames.back();
    }

    S* last_rows(std::vector<S>& rows) {
        return rows.data() + 3 * (contact_frames.size() - 1) * nv();
    }

    void add_point_contact(const Tree<S>& tree, const Contact& contact, int entry, int point,
                           const GivenState* given) {
        Ends ends = ends_of(tree, contact.frames);
        const Site& site = contact.frames.first;
        if (point >= 0) {
            Vec3<S> own;
            for (int k = 0; k < lanes; ++k) put(own, k, vec3<double>(given[k].points + 3 * point));
            const Mat3<S> turn = mat3<S>(scene.model->bodies[site.body].turn);
            ends.arm = tree.rotation[site.body] * back(turn, own);
            ends.place = tree.origin[site.body] + ends.arm;
            set_coincident(tree, contact.frames.other.body, ends);
        }
        ContactFrame<S>& t = new_contact_frame(entry);
        t.axes = ends.axes;
        t.place = t.other_place = ends.place;
        t.gap = dot(ends.axes.z, ends.place - place_of(tree, contact.frames.other));
        write_pair(tree, contact, ends, true);
    }

    void add_rope(const Tree<S>& tree, const Contact& contact, int entry) {
        const Ends ends = ends_of(tree, contact.frames);
        check_line(ends);
        ContactFrame<S>& t = new_contact_frame(entry);
        const Vec3<S> offset = ends.place - ends.other_place;
        t.axes = ends.axes;
        t.place = ends.place;
        t.other_place = ends.other_place;
        t.gap = contact.limit - root(dot(offset, offset));
        close(t, contact.limit);
        write_pair(tree, contact, ends, false);
        // Nothing acts across a rope.
        S* rows = last_rows(J);
        std::fill(rows, rows + 2 * nv(), S{});
    }

    void add_stop(const Contact& contact, int entry, const S* q, double limit, double sign) {
        if (std::isinf(limit)) return;
        ContactFrame<S>& t = new_contact_frame(entry);
        t.gap = (q[contact.q] - limit) * sign;
        t.sign = sign;
        close(t, limit);
        last_rows(J)[2 * nv() + contact.v] = number<S>(sign);
    }

    void close(ContactFrame<S>& t, double size) const {
        const double bar = kAtStop * std::max(1.0, std::abs(size));
        for (int k = 0; k < lanes; ++k) t.closed[k] = get(t.gap, k) <= bar;
    }

    void add_function_contact(int entry, int function, const GivenState* given) {
        ContactFrame<S>& t = new_contact_frame(entry);
        S* rows = last_rows(J);
        for (int k = 0; k < lanes; ++k) {
            const double* own = given[k].function_contacts + function * (1 + 3 * nv());
            Number<S>::set(t.gap, k, own[0]);
            for (int i = 0; i < 3 * nv(); ++i) Number<S>::set(rows[i], k, own[1 + i]);
            t.closed[k] = own[0] <= kAtStop;
        }
    }

    void add_ball_contact(const Tree<S>& tree, const Contact& contact, int entry) {
        const Site &site = contact.frames.first, &shape = contact.frames.other;
        const Mat3<S> axes = tree.rotation[shape.body] * mat3<S>(shape.axes);
        const Vec3<S> at = place_of(tree, shape);
        const Vec3<S> centre = back(axes, place_of(tree, site) - at);
        Vec3<S> point, normal;
        ContactFrame<S>& t = new_contact_frame(entry);
        ball_contact(contact.shape, centre, point, normal, t.gap);
        for (int k = 0; k < lanes; ++k) t.closed[k] = get(t.gap, k) <= contact.limit;
        t.place = t.other_place = at + axes * point;
        set_axes(t.axes, axes * (normal * number<S>(contact.shape.sign)));
        write_at_contact(tree, contact, contact.shape.sign < 0.0);
    }

    // As many points as the lane with the most of them has.
    void add_shape_contacts(const Tree<S>& tree, const Contact& contact, int entry,
                            const GivenState* given) {
        std::size_t most = 0;
        for (int k = 0; k < lanes; ++k) {
            found_[k].clear();
            const Placement first = placement_of(tree, contact.frames.first, k),
                            other = placement_of(tree, contact.frames.other, k);
            // A body without a finite place touches nothing.
            const Vec3<double> away = first.origin - other.origin + first.rotation.x +
                                      first.rotation.y + other.rotation.x + other.rotation.y;
            if (!std::isfinite(dot(away, away))) continue;
            if (given[k].features) {
                for (const auto& [of, feature] : *given[k].features)
                    if (of == entry)
                        found_[k].push_back(
                            follow(feature, contact.first, first, contact.other, other));
            } else {
                contact_points(contact.first, first, contact.other, other, contact.limit,
                               found_[k]);
            }
            most = std::max(most, found_[k].size());
        }
        for (std::size_t i = 0; i < most; ++i) {
            ContactFrame<S>& t = new_contact_frame(entry);
            Vec3<S> normal;
            t.feature = static_cast<int>(features.size());
            features.resize(features.size() + lanes);
            for (int k = 0; k < lanes; ++k) {
                t.closed[k] = i < found_[k].size();
                if (t.closed[k]) features[t.feature + k] = found_[k][i].feature;
                if (!t.closed[k]) put(normal, k, {0.0, 0.0, 1.0});
                if (!t.closed[k]) continue;
                put(t.place, k, found_[k][i].point);
                put(normal, k, found_[k][i].normal);
                Number<S>::set(t.gap, k, found_[k][i].gap);
            }
            t.other_place = t.place;
            set_axes(t.axes, normal);
            write_at_contact(tree, contact, false);
        }
    }

    // Rows of the last touch, where two bodies meet at its place. `swapped`: the other receives.
    void write_at_contact(const Tree<S>& tree, const Contact& contact, bool swapped) {
        int first = contact.frames.first.body, other = contact.frames.other.body;
        if (swapped) std::swap(first, other);
        Ends ends;
        ends.place = contact_frames.back().place;
        ends.arm = ends.place - tree.origin[first];
        set_coincident(tree, other, ends);
        write_rows(tree, contact, first, other, ends, true);
    }

    void write_pair(const Tree<S>& tree, const Contact& contact, const Ends& ends, bool coincides) {
        write_rows(tree, contact, contact.frames.first.body, contact.frames.other.body, ends,
                   coincides);
    }

    void write_rows(const Tree<S>& tree, const Contact& contact, int first, int other,
                    const Ends& ends, bool coincides) {
        ContactFrame<S>& t = contact_frames.back();
        t.of_bodies = true;
        t.first = first;
        t.other = other;
        S *rows = last_rows(J), *turns = last_rows(turning);
        for_slots(tree, first, other, ends, coincides,
                  [&](int a, const Vec3<S>& w, const Vec3<S>& spin) {
                      const int at = scene.model->slots[a].v;
                      const Vec3<S> u = back(t.axes, w);
                      rows[at] += u.x;
                      rows[nv() + at] += u.y;
                      rows[2 * nv() + at] += u.z;
                      if (!contact.turns) return;
                      const Vec3<S> omega = back(t.axes, spin);
                      turns[at] += omega.x;
                      turns[nv() + at] += omega.y;
                      turns[2 * nv() + at] += omega.z;
                  });
        const S least = number<S>(tolerance::sums) * (number<S>(1.0) + root(dot(t.place, t.place)));
        for (int k = 0; k < lanes; ++k) clear_faint(rows, k, get(least, k));
    }

    // The normal's row, or both tangents', is zero where only the rounding of places is left of it.
    void clear_faint(S* rows, int k, double least) {
        const auto largest = [&](int begin, int end) {
            double most = 0.0;
            for (int i = begin; i < end; ++i) most = std::max(most, std::abs(get(rows[i], k)));
            return most;
        };
        const auto clear = [&](int begin, int end) {
            for (int i = begin; i < end; ++i) Number<S>::set(rows[i], k, 0.0);
        };
        if (largest(2 * nv(), 3 * nv()) <= least) clear(2 * nv(), 3 * nv());
        if (largest(0, 2 * nv()) <= least) clear(0, 2 * nv());
    }

    std::vector<S> six_;
    std::vector<ContactPoint> found_[Number<S>::lanes];
};

}  // namespace impulsekit
