// Derivatives of the velocities and impulses of an impact by all that it starts from.
//
// With M Δv = I + Aᵀλ + JᵀP differentiated as it stands,
//     M d = −∂(M Δv)/∂q + ∂(I + Aᵀλ + JᵀP)/∂q + ∂I + Aᵀ dλ + Jᵀ dP,
// and beside it the rows that hold in the modes found (A v⁺ = b, ξ_n = 0, ξ_t = 0 where it sticks,
// P_t = −µ P_n ξ_t/|ξ_t| where it slips) it is one linear system at the answer (implicit function
// theorem). Poisson's law has two such stages, a sequence one or two for each hit. They are passed
// backwards, with weights of the results in, and slopes by all parameters out: no Jacobian is made
// on the way, and as many weights as there are results make one.
#pragma once

#include <cstdint>
#include <optional>
#include <vector>

#include "impact/coefficients.hpp"
#include "impact/constrained_mass.hpp"
#include "scene/tree_gradient.hpp"

namespace impulsekit {

// Offsets of the slopes by each kind of parameter: q on its tangent, v⁻, the numbers of known
// impulses, the points (3) of blows, e and µ of contacts, points and normals (3) of contacts,
// factors of masses.
struct Parameters {
    explicit Parameters(const Scene& scene);
    int q = 0, v, impulses, blow_points, restitution, friction, points, normals, masses, count;
    int states() const { return blow_points; }  // q, v and impulses
};

// Existence of derivatives.
enum class Existence : std::int8_t {
    exists,
    by_differences,
    mode_edge,
    rank_changes,
    not_available,
    no_impact,
};

// Reasons why an impact is not differentiated.
enum class Unavailable {
    none,
    drawn_in,
    too_many_hits,
    coupled,
    no_closed_form,
    no_compression,
    no_waves,
    functions,
    singular,
};

// Reasons why a small change may end a mode.
enum class Edge {
    hardly_presses,
    edge_of_cone,
    hardly_slips,
    out_of_proportion,
    at_table_point,
    at_capture,
    hardly_approaches,
    just_as_fast,
    hardly_parts,
    // Along a path of slip, as derive_path numbers them.
    stuck_at_edge,
    slip_ends_with_phase,
    hardly_slips_first,
    differences_disagree,
};

// A contact on the edge of its mode, and another one that it is compared with, or −1.
struct ModeEdge {
    Edge kind;
    int contact, other;
};

// What is known of an impact that was solved among eight, without bilateral rows: M factored, and
// M⁻¹ Jᵀ (…, nv) with the row there of each of its own.
struct FactoredLane {
    const MassFactorOf<Pack>* mass = nullptr;
    const Pack* response = nullptr;
    const int* rows = nullptr;
    int lane = 0;
};

// The impact that is differentiated.
struct Differentiated {
    const Tree<double>* tree = nullptr;  // placed
    const ImpactProblem* problem = nullptr;
    const ImpactSolution* solution = nullptr;
    const int* entries = nullptr;                    // of each point its contact
    const FramePairSlopes<double>* pairs = nullptr;  // of each point
    const FactoredLane* factored = nullptr;          // null where nothing is known
    const double* impulses = nullptr;                // the numbers of the known impulses
    const double* masses = nullptr;                  // factors; null for 1
    bool has_own_restitution = true;                 // whether e is that of the law
    bool is_closed = true;                           // whether all points move in closed form
    int inertia_of = -1;  // a body by whose inertia to differentiate as well, by ten numbers
};

class Derivation {
  public:
    Derivation(const Scene& scene, const ContactLaw& law);
    ~Derivation();

    // Make an impact linear in its modes; `check_rows` then finds where it has no slopes.
    void set(const Differentiated& given);
    void check_rows();

    const Parameters parameters;
    Existence existence = Existence::exists;
    Unavailable unavailable = Unavailable::none;
    int contact = -1;  // the contact that is not available
    std::vector<ModeEdge> edges;
    std::vector<char> determined;  // (rows of bilateral) whether each λ has derivatives

    int results() const;  // v⁺ (nv), λ (rows), the impulse (3) of each contact in the world
    int slopes() const { return parameters.count + (given_.inertia_of < 0 ? 0 : 10); }

    // (count, slopes) of Σ weight · result for sets of weights (count, results), eight side by
    // side; NaN by parameters for which there are none, and of shares of redundant loads.
    void pull_back(const double* weights, int count, double* slopes) const;

  private:
    struct Stage;
    struct Mode;
    struct Coefficients;
    template <typename S>
    struct Seed;
    template <typename S>
    class Pass;

    void find_coefficients();
    void find_stages();
    Mode mode_of(int point, const Stage& stage) const;
    void add_stage(Stage stage, int acting);
    void solve_system(Stage& stage);
    void share_evenly(Stage& stage, std::vector<double>& W);
    void drop_rows(Stage& stage);
    void compress();
    void follow_hits(bool along_path);
    void find_responses();
    void find_inertias();
    bool find_hits(std::vector<int>& order, std::vector<double>& shares);
    bool find_hits_in_turn(const ContactProblem& contact, std::vector<int>& order,
                           std::vector<double>& shares);
    bool has_springs() const;
    bool find_hits_at_once(const ContactProblem& contact, std::vector<int>& order,
                           std::vector<double>& shares);
    Stage stage_of_hits(const std::vector<int>& points, const double* impulses, int& now);
    void keep_units(Stage& stage);
    void follow_waves(const std::vector<int>& points, const double* impulses, int& now);
    void follow_hit(int point, const double* share, int& now, bool along_path);
    void check_stage(int number);
    template <typename S>
    void pull_set_back(Pass<S>& pass, const S* weights, S* slopes) const;
    bool is_determined(const double* weights) const;
    void find_wrenches(Stage& stage) const;
    std::vector<double> unit_impulses(int point, int row) const;
    bool is_split_open() const;
    int keep(std::vector<double> velocity);
    void add_edge(Edge kind, int point, int other = -1);
    const double* row(int r) const;
    bool is_stop(int point) const;

    const Scene& scene_;
    const ContactLaw& law_;
    Differentiated given_;
    int nv_ = 0, m_ = 0, n_ = 0;
    double scale_ = 0.0;
    bool is_shared_ = false;
    ConstrainedMass mass_;
    std::vector<double> response_, W_, filling_;  // M⁻¹ Gᵀ of all rows, G M⁻¹ Gᵀ
    std::vector<double> free_response_, free_multipliers_,
        free_W_;  // the same of contacts, bilateral rows held
    std::vector<Coefficients> own_;
    std::vector<std::vector<double>> velocities_;
    std::vector<std::vector<Spatial<double>>> twists_;  // of these
    std::vector<Stage> stages_;
    std::vector<Inertia<double>> inertias_;
    std::vector<FramePairSlopes<double>> held_pairs_, blow_pairs_;
    std::vector<char> consistent_;
};

// The same of known impulses on a tree that nothing holds or touches, for states side by side; x:
// M⁻¹ of the weights of v⁺, which are what the slopes by v⁻ are.
template <typename S>
void pull_back_blows(const Scene& scene, const Tree<S>& tree, const Inertia<S>* inertias,
                     const S* impulses, const S* weights, const S* x, const S* change, S* slopes);

}  // namespace impulsekit
