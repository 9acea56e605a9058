// The rows of a scene at a state: A, J, axes, places and gaps, for one state or eight side by side.
#pragma once

#include <algorithm>
#include <cmath>
#include <vector>

#include "geometry/shapes.hpp"
#include "linalg/dense.hpp"
#include "scene/constraint_rows.hpp"
#include "scene/contact_frame.hpp"

namespace impulsekit {

template <typename S>
class Rows {
  public:
    static constexpr int lanes = Number<S>::lanes;
    const Scene& scene;
    std::vector<S> A;       // (rows, nv)
    std::vector<S> target;  // (rows)
    std::vector<S> wider;   // (rows), see StateRows
    std::vector<ContactFrame<S>> contact_frames;
    std::vector<S> J;        // (3 touches, nv)
    std::vector<S> turning;  // (3 touches, nv) of the relative angular velocity; empty if none turn
    bool has_line[Number<S>::lanes];  // false where two points of a line coincide

    explicit Rows(const Scene& s)
        : scene(s), A(s.rows() * s.model->nv), target(s.rows()), wider(s.rows()) {
        for (const Contact& contact : s.contacts) turns_ = turns_ || contact.turns;
    }

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
        to.origin = lane_of(tree.origin[0], k);
        to.without_line = has_line[k] ? -1 : 0;
        to.without_ellipse = -1;
        for (std::size_t i = 0; i < contact_frames.size(); ++i) {
            if (!contact_frames[i].closed[k]) continue;
            const Contact& contact = scene.contacts[contact_frames[i].entry];
            if (contact.turns) to.turning_of.push_back(static_cast<int>(to.points.size()));
            to.contact_frame_of.push_back(static_cast<int>(i));
            to.points.push_back(point_of(contact_frames[i], k));
            ContactFrame<double>& point = to.points.back();
            if (contact.ellipse_body >= 0 &&
                !ellipse_axis(contact, lane_of(tree.rotation[contact.ellipse_body], k), point.axes,
                              point.ellipse))
                to.without_ellipse = point.entry;
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

  private:
    int nv() const { return scene.model->nv; }

    static ContactFrame<double> point_of(const ContactFrame<S>& t, int k) {
        ContactFrame<double> p;
        static_cast<FramePairState<double>&>(p) = lane_of<S>(t, k);
        p.entry = t.entry;
        p.of_bodies = t.of_bodies;
        p.gap = get(t.gap, k);
        p.feature[0] = t.feature[k];
        p.sign = t.sign;
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
        return {lane_of(axes_of(tree, site), k), lane_of(place_of(tree, site), k)};
    }

    // The contact of a ball and a shape, lane by lane.
    static void ball_contact(const Ball& ball, const Vec3<S>& centre, Vec3<S>& point,
                             Vec3<S>& normal, S& gap) {
        if constexpr (lanes == 1) {
            gap = impulsekit::ball_contact(ball, centre, point, normal);
        } else {
            for (int k = 0; k < lanes; ++k) {
                Vec3<double> own, along;
                Number<S>::set(gap, k,
                               impulsekit::ball_contact(ball, lane_of(centre, k), own, along));
                set_lane(point, k, own);
                set_lane(normal, k, along);
            }
        }
    }

    static double get(const S& x, int lane) { return Number<S>::get(x, lane); }

    void add_constraints(const Tree<S>& tree, const S* v, const GivenState* given) {
        write_constraint_rows(scene, static_cast<int>(scene.held.size()), tree, given, A.data(),
                              wider.data(), has_line);
        for (int r = 0; r < scene.rows(); ++r) {
            target[r] = number<S>(scene.velocity[r]);
            // Summed up as where it is demanded: what is kept demands nothing, to the last bit.
            if (scene.kept[r]) target[r] = dot(A.data() + r * nv(), v, nv());
        }
        for (const Held& held : scene.held)
            if (held.stop >= 0) yield_to_stop(held, v);
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
        J.clear();
        turning.clear();
        int function = 0, point = 0;
        for (std::size_t i = 0; i < scene.contacts.size(); ++i) {
            const Contact& contact = scene.contacts[i];
            const int entry = static_cast<int>(i);
            switch (contact.kind) {
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
                case Contact::shapes:
                    add_shape_contacts(tree, contact, entry, given);
                    break;
                default: {
                    const bool varies = point < static_cast<int>(scene.points.size()) &&
                                        scene.points[point] == entry;
                    add_frame_contact(tree, contact, entry, varies ? point : -1, given);
                    point += varies;
                }
            }
        }
    }

    ContactFrame<S>& new_contact_frame(int entry) {
        ContactFrame<S>& t = contact_frames.emplace_back();
        t.entry = entry;
        std::fill(t.closed, t.closed + lanes, true);
        J.resize(3 * contact_frames.size() * nv(), S{});
        if (turns_) turning.resize(J.size(), S{});
        return t;
    }

    S* last_rows(std::vector<S>& rows) {
        return rows.data() + 3 * (contact_frames.size() - 1) * nv();
    }

    void add_frame_contact(const Tree<S>& tree, const Contact& contact, int entry, int point,
                           const GivenState* given) {
        ContactFrame<S>& t = new_contact_frame(entry);
        static_cast<FramePairState<S>&>(t) = frame_pair_state(tree, contact.frames);
        if (point >= 0) {
            Vec3<S> own;
            for (int k = 0; k < lanes; ++k)
                set_lane(own, k, vec3<double>(given[k].points + 3 * point));
            const Mat3<S> turn = mat3<S>(scene.model->bodies[t.first].turn);
            const Vec3<S> arm = tree.rotation[t.first] * back(turn, own);
            set_coincident(tree, tree.origin[t.first] + arm, arm, t);
        }
        t.gap = gap_of(tree, contact, t);
        write_rows(tree, contact);
        if (t.carrier != Carrier::line) return;
        find_line(t, has_line);
        close(t, contact.limit);
        // Nothing acts across a line.
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

    // A joint this near its limit, relative to its size, is at it; a rope of its length is taut.
    void close(ContactFrame<S>& t, double size) const {
        const double bar = tolerance::alike * std::max(1.0, std::abs(size));
        for (int k = 0; k < lanes; ++k) t.closed[k] = get(t.gap, k) <= bar;
    }

    void add_function_contact(int entry, int function, const GivenState* given) {
        ContactFrame<S>& t = new_contact_frame(entry);
        S* rows = last_rows(J);
        for (int k = 0; k < lanes; ++k) {
            const double* own = given[k].function_contacts + function * (1 + 3 * nv());
            Number<S>::set(t.gap, k, own[0]);
            for (int i = 0; i < 3 * nv(); ++i) Number<S>::set(rows[i], k, own[1 + i]);
            t.closed[k] = own[0] <= tolerance::alike;
        }
    }

    void add_ball_contact(const Tree<S>& tree, const Contact& contact, int entry) {
        const Site& shape = contact.frames.other;
        const Mat3<S> axes = axes_of(tree, shape);
        const Vec3<S> at = place_of(tree, shape);
        const Vec3<S> centre = back(axes, place_of(tree, contact.frames.first) - at);
        Vec3<S> point, normal;
        ContactFrame<S>& t = new_contact_frame(entry);
        ball_contact(contact.shape, centre, point, normal, t.gap);
        for (int k = 0; k < lanes; ++k) t.closed[k] = get(t.gap, k) <= contact.limit;
        t.axes = contact_axes_of_lanes(axes * (normal * number<S>(contact.shape.sign)));
        write_at_contact(tree, contact, at + axes * point);
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
            Vec3<S> place, normal;
            for (int k = 0; k < lanes; ++k) {
                t.closed[k] = i < found_[k].size();
                if (!t.closed[k]) set_lane(normal, k, {0.0, 0.0, 1.0});
                if (!t.closed[k]) continue;
                t.feature[k] = found_[k][i].feature;
                set_lane(place, k, found_[k][i].point);
                set_lane(normal, k, found_[k][i].normal);
                Number<S>::set(t.gap, k, found_[k][i].gap);
            }
            t.axes = contact_axes_of_lanes(normal);
            write_at_contact(tree, contact, place);
        }
    }

    // Rows of the last contact frame, where two bodies meet at a place.
    void write_at_contact(const Tree<S>& tree, const Contact& contact, const Vec3<S>& place) {
        ContactFrame<S>& t = contact_frames.back();
        t.first = contact.first_body();
        t.other = contact.other_body();
        set_coincident(tree, place, place - tree.origin[t.first], t);
        write_rows(tree, contact);
    }

    void write_rows(const Tree<S>& tree, const Contact& contact) {
        ContactFrame<S>& t = contact_frames.back();
        t.of_bodies = true;
        S* rows = last_rows(J);
        add_rows(tree, t, rows, contact.turns ? last_rows(turning) : nullptr);
        const S least = rounding_of(t.place);
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

    std::vector<ContactPoint> found_[Number<S>::lanes];
    bool turns_ = false;  // whether some contact does
};

}  // namespace impulsekit
