// Bilateral constraints between impacts: rows, what accelerations they ask for, and their drift.
#pragma once

#include <functional>
#include <vector>

#include "scene/frame_pair.hpp"

namespace impulsekit {

// Users' functions of constraints; empty where a scene has none of the kind.
struct ConstraintFunctions {
    std::function<void(const double* q, double* rows)> rows;  // (function rows, nv)
    std::function<void(const double* q, const double* v, double* bias)> bias;
    std::function<void(const double* q, double* values)> values;
    // Velocities (rows) that are driven in time, and their rates, over what stands there.
    std::function<void(double t, double* velocity, double* rate)> speeds;
    // The prescribed coordinate of a driven joint at a time.
    std::function<double(int entry, double t)> place;
};

class BilateralConstraints {
  public:
    // `entries`: so many of the scene's first constraints hold between impacts, too. `driven`:
    // (entries) whether each is a joint's place as a function of time, or its rows' velocity.
    BilateralConstraints(const Scene& scene, int entries, std::vector<char> driven_places,
                         std::vector<char> driven_speeds, ConstraintFunctions functions);

    int rows() const { return rows_; }
    const int* vectors() const { return scene_->vectors.data(); }

    // A and Ȧ v; the tree with places, twists, and rates at no joint acceleration.
    void fill(const Tree<double>& tree, const double* q, const double* v);
    // A alone; the tree with places and twists.
    void fill_rows(const Tree<double>& tree, const double* q);
    const double* A() const { return A_.data(); }          // (rows, nv)
    const double* wider() const { return wider_.data(); }  // (rows) see StateRows
    const double* bias() const { return bias_.data(); }    // (rows)
    // (rows) what velocities have to be at a time, and their rates.
    void speeds(double t, double* velocity, double* rate) const;

    // Take what is kept, and where all stands, from the start of a motion.
    void start(const Tree<double>& tree, const double* q, const double* v);
    // The errors of coordinates at a time, and the rows they belong to.
    void drift(const Tree<double>& tree, const double* q, double t, std::vector<double>& off,
               std::vector<int>& rows) const;

  private:
    // The places at the start that one entry keeps.
    struct Kept {
        enum Kind { nothing, distance, met, apart } linear = nothing;
        enum Turn { none, all, hinge_of_first, hinge_of_world } angular = none;
        double length = 0.0;
        Vec point;               // of the other frame, or the way between both
        Mat relative, rotation;  // of the first frame in the other, and in the world
        std::vector<double> values;
    };

    void keep_pair(const Tree<double>& tree, const Held& held, Kept& kept) const;
    void drift_of_pair(const Tree<double>& tree, const Held& held, const Kept& kept, double t,
                       std::vector<double>& off, std::vector<int>& rows) const;
    void drift_of_speeds(const Held& held, int entry, const Kept& kept, const double* q, double t,
                         std::vector<double>& off, std::vector<int>& rows) const;
    bool is_plain(const Held& held) const;

    const Scene* scene_;
    int entries_, rows_ = 0;
    std::vector<char> driven_places_, driven_speeds_;
    ConstraintFunctions functions_;
    std::vector<double> A_, wider_, bias_, velocity_;
    std::vector<Kept> kept_;
};

}  // namespace impulsekit
