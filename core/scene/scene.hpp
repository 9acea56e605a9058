// Constraints, contacts and known impulses of a robot, as plain tables.
//
// Conventions of all rows. The first frame receives the impulse, the other one the opposite; linear
// comes before angular; vectors are in world axes. With c, c' two points, v, v' their velocities
// and R = [t₁ t₂ n] the axes, n from the other to the first, the rows are
//     u = Rᵀ (v − v', ω − ω').
// c' is a point of the other frame, or the point of it that coincides with c. An impulse p of the
// rows is the force R p at c on the first body and −R p at c' on the other.
#pragma once

#include <limits>
#include <vector>

#include "geometry/shapes.hpp"
#include "linalg/tolerances.hpp"
#include "spatial/model.hpp"

namespace impulsekit {

// A point of a frame on a body, and the frame's axes, both in the body's axes (rows first).
struct Site {
    int body = 0;
    int frame = -1;  // by its number in the robot's model; −1: of none
    double point[3] = {};
    double axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};
};

// The carrier of the axes R of a pair; "line" leads from the other point to the first.
enum class Carrier { world, first, other, line };

// Rows between two frames.
struct Pair {
    Site first, other;
    bool coincides = true;
    Carrier carrier = Carrier::world;
    double axes[9] = {1, 0, 0, 0, 1, 0, 0, 0, 1};  // R in the carrier's; of a line its last sign
};

// Bilateral rows: of a pair, of speeds, or given state by state by functions.
struct Held {
    enum Kind { pair, speeds, functions };
    struct Term {
        int row, v;
        double factor;
    };
    Kind kind = pair;
    int row = 0, count = 0;
    Pair frames;
    int select[6] = {};       // which of the six rows of the pair
    std::vector<Term> terms;  // row counted within the entry
    int stop = -1;            // contact that a controlled joint yields to
};

// A ball and what may touch it (the other of its pair, whose axes are those of the shape).
struct Ball {
    enum Kind { ball, box, cylinder, capsule, plane };
    Kind kind = ball;
    double radius = 0.0;
    double size[3] =
        {};  // of the shape: half sides; or radius, half length [m]; none of a plane, z = 0
    double sign = 1.0;  // −1 where the shape is the first of the entry
};

struct Contact {
    enum Kind {
        point,      // on a plane
        rope,       // two points, taut
        stop,       // a joint at its limits
        functions,  // gap and rows given state by state
        ball,       // a ball and a shape
        shapes,     // two bodies of any shapes
    };
    Kind kind = point;
    Pair frames;
    Ball shape;
    std::vector<Shape> first, other;  // pieces of both bodies
    double limit = 0.0;               // length of a rope, margin of bodies
    int q = 0, v = 0;                 // of a stop
    double lower = 0.0, upper = 0.0;  // its limits
    bool turns = false;               // whether it resists turning
    int ellipse_body = -1;  // body that is touched, where friction is elliptic, and the direction
    double along[3] = {};   // of its first axis in that body

    // Kinds of the surfaces of two bodies, and of two frames, whose gap is that of `gap_of`.
    static bool of_bodies(Kind kind) { return kind == shapes || kind == ball; }
    static bool of_frames(Kind kind) {
        return !of_bodies(kind) && kind != stop && kind != functions;
    }
    // The bodies in the order of the entry: of a ball's pair the shape may come first.
    const Site& first_site() const { return shape.sign < 0.0 ? frames.other : frames.first; }
    const Site& other_site() const { return shape.sign < 0.0 ? frames.first : frames.other; }
    int first_body() const { return first_site().body; }
    int other_body() const { return other_site().body; }
};

// A known impulse on a body, six numbers: in the world's axes, or in those of its frame.
struct Blow {
    Site site;
    bool is_local = false;
};

struct Scene {
    const Model* model = nullptr;
    std::vector<Held> held;
    std::vector<double> velocity;  // (rows) after the impact
    std::vector<char> kept;        // (rows) whether it stays what it was instead
    std::vector<int> vectors;      // (rows) the same number for axes of one velocity
    std::vector<char> passive;     // (rows) whether it is brought to rest
    std::vector<int> locks;        // (rows) the one degree of freedom that it prescribes, or −1
    std::vector<Contact> contacts;
    std::vector<Blow> blows;
    std::vector<int> kicks;   // degrees of freedom of known impulses in joints, after all blows'
    std::vector<Load> loads;  // links whose masses vary
    std::vector<int> points;  // contacts whose points vary
    int function_rows = 0, function_contacts = 0;

    int rows() const { return static_cast<int>(velocity.size()); }
};

// Inputs of one state beside q and v; null where the scene needs none.
struct GivenState {
    const double* function_rows = nullptr;      // (function_rows, nv)
    const double* function_contacts = nullptr;  // (function_contacts, 1 + 3 nv): gap, then rows
    const double* points = nullptr;             // (points, 3) in the axes of the joint
    // (contacts) which take part, whatever their gaps, stops at the nearer limit; null for those
    // that touch.
    const char* only = nullptr;
    // By contact of bodies the points that take part, where they are known by name; null for all
    // within the margin.
    const std::vector<std::pair<int, Feature>>* features = nullptr;
};

// An axis of friction whose part in the plane is shorter has none.
inline constexpr double kAlongNormal = 1e-6;

}  // namespace impulsekit
