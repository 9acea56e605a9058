// Contacts along a motion: how far they are from touching, and the points that rest.
#pragma once

#include <functional>
#include <limits>
#include <vector>

#include "impact/coefficients.hpp"
#include "motion/free_times.hpp"
#include "motion/state.hpp"
#include "scene/contact_frame.hpp"

namespace impulsekit {

// One way in which a contact of the scene may touch: a joint stop has two.
struct Gap {
    int entry = 0;
    Contact::Kind kind = Contact::point;
    double limit = 0.0, sign = 1.0;  // of a stop
    int function = -1;
    double capture = 0.0;  // slower approaches are met without restitution [m/s]
    double rests = 0.0;    // points that part more slowly rest [m/s]
    double deepest = 0.0;  // an overlap above this is no motion that is right [m]
    bool turns = false, has_condition = false;
    // Radius, for bodies, of a ball around the smaller one [m]; which of them consists of points
    // alone, with a radius around them: 0, 1 or neither (−1); how far that reaches [m].
    double smaller = 0.0;
    int pointed = -1;
    double reach = 0.0;

    bool of_bodies() const { return Contact::of_bodies(kind); }
    bool of_frames() const { return Contact::of_frames(kind); }
};

struct GapFunctions {
    // Gap and (3, nv) rows of the i-th contact by functions, and the rates of its rows.
    std::function<void(int i, const double* q, double* found)> rows;
    std::function<void(int i, const double* q, const double* v, double* bias)> bias;
    // True if a contact of the scene counts as one at a state.
    std::function<bool(int entry, const double* q, const double* v)> counts;
};

// One gap at a state.
struct GapState {
    double gap = 0.0, rate = 0.0;  // [m, m/s]; of joints [rad, rad/s]
    double bound = 0.0;            // no gap of this contact closes faster, at this state [m/s]
    double rounding = 0.0;         // of the gap [m]
    double turning = 0.0;          // the fastest angular velocity of its bodies [rad/s]
    bool is_rough = false;         // bodies are far: they are further apart than it says
    double free = 0.0;             // no gap closes sooner, see ``Ahead`` [s]
    RelativeMotion motion;         // of a body of points in the frame of the other

    // Gaps that differ by less are alike [m]: they are differences of places.
    double noise() const { return 4.0 * std::max(tolerance::rounding, rounding); }
};

// A gap at a state.
struct GapAt {
    int gap = 0, entry = 0;
    double value = 0.0, rate = 0.0;
};

// For which time a gap surely stays open: what it counts from [m], and the largest acceleration of
// points of one body in the frame of the other [m/s²].
struct Ahead {
    double base = 0.0, acceleration = 0.0;
};

// The places at which rows (3, nv) of a resting point are written, and where they are not null
// those of its turning, and the rates (3) of both.
struct RestRows {
    double* J;
    double *turning = nullptr, *bias = nullptr, *turning_bias = nullptr;
};

class ContactGaps {
  public:
    ContactGaps(const Scene& scene, const ContactLaw& law, GapFunctions functions,
                const std::vector<char>& conditional);

    const std::vector<Gap>& gaps() const { return gaps_; }
    bool counts(const Gap& gap, const double* q, const double* v) const;

    // A gap; the tree with places and twists.
    GapState measure(const Tree<double>& tree, const Gap& gap, const double* q, const double* v,
                     const Ahead* ahead = nullptr) const;
    // The gap of one resting point, and how far inside its face or edges it is.
    double gap_of(const Tree<double>& tree, const RestingContact& point, const double* q,
                  double* inside) const;
    // The points at which a gap's bodies touch now within a margin; of another kind its one point.
    void find_points(const Tree<double>& tree, int gap, double margin,
                     std::vector<RestingContact>& found) const;

    // The point and axes of a resting point of two bodies, and how these move where asked for; the
    // tree with places and twists. For an ellipse of friction tangents have its semi-axes as units.
    FramePairMotion spot(const Tree<double>& tree, const RestingContact& point, bool moves) const;
    // The velocity of a resting point and its angular velocity, in its axes.
    Spatial<double> velocity(const Tree<double>& tree, const RestingContact& point, const double* q,
                             const double* v) const;
    // (3, nv) rows of both, and their rates at no joint acceleration, where asked for; for rates
    // the tree with those of bodies as well.
    void rows(const Tree<double>& tree, const RestingContact& point, const double* q,
              const double* v, const RestRows& to) const;
    // True if friction goes by an ellipse, whose semi-axes are units of the tangents.
    bool is_elliptic(int entry) const;

  private:
    void measure_bodies(const Tree<double>& tree, const Gap& gap, const Ahead* ahead,
                        GapState& found) const;
    FramePairMotion spot_of_bodies(const Tree<double>& tree, const RestingContact& point,
                                   bool moves) const;
    void scale_to_ellipse(const Tree<double>& tree, int entry, Mat& axes) const;
    const Contact& contact_of(const Gap& gap) const { return scene_->contacts[gap.entry]; }

    const Scene* scene_;
    const ContactLaw* law_;
    GapFunctions functions_;
    std::vector<Gap> gaps_;
};

}  // namespace impulsekit
