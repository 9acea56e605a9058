// A tree of rigid bodies with joints, as plain tables: what does not change with the state.
//
// Conventions are Pinocchio's: spatial vectors linear before angular, quaternions x, y, z, w, the
// velocity of a free-flyer, ball or planar joint in the axes of its body. Bodies are numbered from
// 1, parents first; 0 is the world. A joint of Pinocchio that is several in a row (composite,
// universal, ball by three angles) is several bodies here, all but the last without mass.
#pragma once

#include <vector>

namespace impulsekit {

// Kinds of joints, the entries of q they take, and their motion; single axes are z of the body.
enum class Joint {
    angle,        // 1: turns about z
    circle,       // 2: the same by cosine and sine
    slide,        // 1: along z
    helix,        // 1: turns about z and goes along it by the pitch
    ball,         // 4: a quaternion
    free,         // 7: place and quaternion
    planar,       // 4: x, y, cosine, sine
    translation,  // 3
    ellipsoid,    // 3: turns about x, y, z in turn while its origin runs over an ellipsoid
};

struct Body {
    int parent = 0;
    Joint joint = Joint::angle;
    int q = 0;                   // first entry of q
    int slot = 0, freedoms = 0;  // first of its slots, and how many
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
    double pitch = 0.0;                // of a helix [m/rad]
    double ratio = 1.0, offset = 0.0;  // of one that follows another: q = ratio q' + offset
    double radius[3] = {};             // of an ellipsoid [m]
    double turn[9] = {};               // from these axes of the body to those of its joint

    bool turns_about_z() const { return joint == Joint::angle || joint == Joint::circle; }
    // True if the joint has one number, which a joint that follows it can multiply.
    bool is_scalar() const {
        return joint == Joint::angle || joint == Joint::slide || joint == Joint::helix;
    }
};

// One way in which one body moves: an entry of v, or of several that follow it.
struct Slot {
    int body = 0;
    int direction = 0;  // 0 to 5: x, y, z linear, then angular, in the body's axes
    int v = 0;
    double ratio = 1.0, armature = 0.0;
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
    int parent = 0, joint = 0, q = 0, v = 0;
    double axis[3];  // radii of an ellipsoid
    double rotation[9], shift[3], mass, moment[3], inertia[6], pitch, ratio, offset;
};

// The tables of a tree. `armature`: (nv) [kg m², kg]. Bodies that follow others have the v of
// these.
Model model_of(const std::vector<GivenBody>& bodies, int nq, int nv, const double* armature);

int freedoms_of(Joint joint);
int coordinates_of(Joint joint);

}  // namespace impulsekit
