#include "scene/frame_pair_states.hpp"

namespace impulsekit {
namespace {

// A ball of which the centre stands where `m.centre` says, at a shape with these axes and place.
void set_ball_contact(const Ball& ball, const Mat3<double>& axes, const Vec3<double>& at,
                      bool is_first, FramePairSlopes<double>& m) {
    using Number4 = Dual<4>;
    const Vec3<double> local = back(axes, m.centre - at);
    Vec3<Number4> centre{{local.x, {1.0}}, {local.y, {0.0, 1.0}}, {local.z, {0.0, 0.0, 1.0}}};
    Vec3<Number4> point, normal;
    ball_contact(ball, centre, point, normal);
    m.ball = is_first ? 1 : -1;
    const double sign = is_first ? 1.0 : -1.0;
    const auto in_world = [&](const Vec3<Number4>& a, double factor) {
        Vec3<double> columns[3];
        for (int d = 0; d < 3; ++d)
            columns[d] = axes * Vec3<double>{a.x.slope[d], a.y.slope[d], a.z.slope[d]} * factor;
        const Mat3<double> by_local{columns[0], columns[1], columns[2]};
        return by_local * transposed(axes);
    };
    m.point_by_centre = in_world(point, 1.0);
    m.normal_by_centre = in_world(normal, sign);
}

// Bodies of any shapes: known in closed form are a ball's, corner's or capsule's end on a flat
// face, and two balls.
bool set_feature_contact(const Contact& contact, const Feature& feature, const Placement& first,
                         const Placement& other, FramePairSlopes<double>& m) {
    const Shape* shapes[2] = {&contact.first[feature.piece[0]], &contact.other[feature.piece[1]]};
    const Placement* places[2] = {&first, &other};
    const bool on_face =
        feature.kind == Feature::corner_on_face || feature.kind == Feature::tip_on_face;
    const int side = on_face ? feature.index[0] : 0, tip = on_face ? feature.index[1] : 0;
    const Shape &own = *shapes[side], &ground = *shapes[1 - side];
    if (tip < 0 || tip >= static_cast<int>(own.points.size())) return false;
    if (!on_face && (own.kind != Shape::ball || ground.kind != Shape::ball)) return false;
    m.centre = places[side]->act(own.points[tip]);
    const Placement& under = *places[1 - side];
    Ball ball;
    ball.radius = own.radius;
    if (!on_face) {
        ball.size[0] = ground.radius;
        set_ball_contact(ball, under.rotation, under.act(ground.points[0]), side == 0, m);
        return true;
    }
    const Face& face = ground.faces[feature.index[2]];
    ball.kind = Ball::plane;
    const Mat3<double> axes = contact_axes(face.normal);
    set_ball_contact(ball, under.rotation * axes,
                     under.act(face.normal * (face.offset + ground.radius)), side == 0, m);
    return true;
}

}  // namespace

bool find_frame_pair_states(const Scene& scene, const Tree<double>& tree, const StateRows& rows,
                            std::vector<FramePairSlopes<double>>& found, int& entry) {
    const auto placement = [&](const Site& site) {
        return Placement{axes_of(tree, site), place_of(tree, site)};
    };
    found.clear();
    bool is_closed = true;
    for (const ContactFrame<double>& point : rows.points) {
        const Contact& contact = scene.contacts[point.entry];
        FramePairSlopes<double> m(point);
        if (contact.kind == Contact::ball) {
            const Placement shape = placement(contact.frames.other);
            m.centre = place_of(tree, contact.frames.first);
            set_ball_contact(contact.shape, shape.rotation, shape.origin, contact.shape.sign > 0.0,
                             m);
        } else if (contact.kind == Contact::shapes) {
            const bool own =
                set_feature_contact(contact, point.feature[0], placement(contact.frames.first),
                                    placement(contact.frames.other), m);
            if (!own && is_closed) entry = point.entry;
            is_closed = is_closed && own;
        }
        found.push_back(m);
    }
    return is_closed;
}

}  // namespace impulsekit
