// A tree of rigid bodies with joints, as plain tables: what does not change with the state.
//
// Conventions are Pinocchio's: spatial vectors linear before angular, quaternions x, y, z, w, the
// velocity of a free-flyer, ball or planar joint in the axes of its body. Bodies are numbered from
// 1, parents first; 0 is the world. A joint of Pinocchio that is several in a row (composite,
// universal, ball by three angles) is several bodies here, all but the last without mass.
#pragma once

#include <vector>

namespace impulsekit {

// Rotations of a joint, by the last of its entries of q.
enum class Turn {
    none,
    angle,       // 1: about z
    circle,      // 2: about z, by cosine and sine
    quaternion,  // 4
    ellipsoid,   // 3: about x, y, z in turn, while the origin runs over an ellipsoid
};

// A type of joint: places along some axes of its frame, and then a rotation. Its velocities are in
// the axes of its body. `joint_types` has all; a new one is an entry there.
struct JointType {
    const char* name;
    int places;    // entries of q that are lengths
    int along[3];  // the axis of each: 0 to 2
    Turn turn;

    int coordinates() const;
    int freedoms() const;
    // Its i-th entry of v: see Slot.
    int direction(int i) const;
    // True if it moves along z and about z alone, which is then the axis that is given.
    bool has_axis() const;
};

// Joint types in the order of their numbers.
const std::vector<JointType>& joint_types();

struct Body {
    int parent = 0;
    JointType type{};
    int q = 0;                   // first entry of q
    int slot = 0, freedoms = 0;  // first of its slots, and how many
    bool turns_about_z = false;  // and does nothing else
    bool about_x = false;        // whether α, β are not nothing
    bool about_z = false;
    double rotation[9] = {};  // of the joint in its parent's axes, row by row
    double shift[3] = {};     // likewise its origin [m]
    // The rotation of a joint about z: Rz(β) Rx(α) Rz(γ), cosine and sine of each (after Denavit &
    // Hartenberg 1955). Axes of bodies are chosen such that most β are nothing.
    double beta[2] = {1.0, 0.0}, alpha[2] = {1.0, 0.0}, gamma[2] = {1.0, 0.0};
    double mass = 0.0;                 // [kg]
    double moment[3] = {};             // mass times centre [kg m]
    double inertia[6] = {};            // about the joint: xx, xy, xz, yy, yz, zz [kg m²]
    double pitch = 0.0;                // along z with a turn about it [m/rad]
    double ratio = 1.0, offset = 0.0;  // of one that follows another: q = ratio q' + offset
    double radius[3] = {};             // of an ellipsoid [m]
    double turn[9] = {};               // from these axes of the body to those of its joint
};

// One way in which one body moves: an entry of v, or of several that follow it.
struct Slot {
    int body = 0;
    int direction = 0;  // 0 to 5: x, y, z linear, then angular, in the body's axes
    int v = 0;
    double ratio = 1.0, armature = 0.0;
};

// Mass that a body carries: ten numbers as those of the body.
struct Load {
    int body = 0;
    double mass = 0.0, moment[3] = {}, inertia[6] = {};
};

struct Model {
    int nq = 0, nv = 0;
    bool has_followers = false, has_ellipsoids = false;
    std::vector<Body> bodies;   // the world first
    std::vector<Slot> slots;    // in the order of the bodies
    std::vector<int> parent_v;  // (nv) degree of freedom that each hangs on, for factors of M
};

// A body as it is given: in the axes of its joint, which are those of Pinocchio.
struct GivenBody {
    int parent = 0, joint = 0, q = 0, v = 0;  // joint: number of its type
    double axis[3];                           // radii of an ellipsoid
    double rotation[9], shift[3], mass, moment[3], inertia[6], pitch, ratio, offset;
};

// The tables of a tree. `armature`: (nv) [kg m², kg]. Bodies that follow others have the v of
// these.
Model model_of(const std::vector<GivenBody>& bodies, int nq, int nv, const double* armature);

}  // namespace impulsekit
