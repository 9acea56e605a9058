#include "derivatives/derivatives.hpp"

#include <algorithm>
#include <cmath>

#include "contact/tolerances.hpp"
#include "derivatives/derivation.hpp"
#include "linalg/dense.hpp"
#include "scene/frame_pair_states.hpp"

namespace impulsekit {
namespace {

// The step of differences in the slope of a function, beside the velocities.
constexpr double kStep = 1e-3;

// de/d(approach speed), and whether it was found by differences; edges are told by their kind.
double slope_of(const BySpeed& e, double speed, double scale, bool& by_differences,
                std::optional<Edge>& edge) {
    const double small = tolerance::edge * scale;
    if (e.slope) return e.slope(speed);
    if (e.function) {
        by_differences = true;
        // Richardson's extrapolation of central differences: of fourth order.
        const double step = std::min(kStep * std::max(speed, scale), 0.5 * speed);
        if (step <= 0.0) return 0.0;
        const auto over = [&](double h) { return (e.at(speed + h) - e.at(speed - h)) / (2.0 * h); };
        return (4.0 * over(0.5 * step) - over(step)) / 3.0;
    }
    if (e.capture > 0.0 && std::abs(speed - e.capture) < small) edge = Edge::at_capture;
    const std::vector<double>& speeds = e.table.points;
    const std::size_t count = speeds.size();
    for (double at : speeds)
        if (count > 1 && std::abs(at - speed) < small) edge = Edge::at_table_point;
    if (count == 0 || !(speeds.front() <= speed && speed < speeds.back())) return 0.0;
    return e.table.slope_before(std::upper_bound(speeds.begin(), speeds.end(), speed) -
                                speeds.begin());
}

}  // namespace

Parameters::Parameters(const Scene& scene) {
    const int nv = scene.model->nv, contacts = static_cast<int>(scene.contacts.size()),
              blows = static_cast<int>(scene.blows.size());
    v = nv;
    impulses = v + nv;
    blow_points = impulses + 6 * blows + static_cast<int>(scene.kicks.size());
    restitution = blow_points + 3 * blows;
    friction = restitution + contacts;
    points = friction + contacts;
    normals = points + 3 * contacts;
    masses = normals + 3 * contacts;
    count = masses + static_cast<int>(scene.loads.size());
}

Derivation::Derivation(const Scene& scene, const ContactLaw& law)
    : parameters(scene), scene_(scene), law_(law) {}

Derivation::~Derivation() = default;

int Derivation::results() const {
    return scene_.model->nv + scene_.rows() + 3 * static_cast<int>(scene_.contacts.size());
}

const double* Derivation::row(int r) const {
    const ImpactProblem& p = *given_.problem;
    return r < m_ ? p.A + r * nv_ : p.J + (r - m_) * nv_;
}

void Derivation::add_edge(Edge kind, int point, int other) {
    edges.push_back({kind, given_.entries[point], other < 0 ? -1 : given_.entries[other]});
    if (existence <= Existence::by_differences) existence = Existence::mode_edge;
}

int Derivation::keep(std::vector<double> velocity) {
    velocities_.push_back(std::move(velocity));
    return static_cast<int>(velocities_.size()) - 1;
}

void Derivation::set(const Differentiated& given) {
    given_ = given;
    const ImpactProblem& p = *given.problem;
    const ImpactSolution& s = *given.solution;
    nv_ = p.nv;
    m_ = p.bilateral;
    n_ = p.contact.contacts;
    existence = Existence::exists;
    unavailable = Unavailable::none;
    edges.clear();
    velocities_.clear();
    stages_.clear();
    consistent_.assign(slopes(), 1);
    const auto refuse = [&](Unavailable why) { unavailable = why; };
    for (const Held& held : scene_.held)
        if (held.kind == Held::functions) refuse(Unavailable::functions);
    for (int i = 0; i < n_; ++i)
        if (scene_.contacts[given.entries[i]].kind == Contact::functions)
            refuse(Unavailable::functions);
    if (!given.is_closed) refuse(Unavailable::no_closed_form);
    if (unavailable == Unavailable::none) {
        if (given.factored)
            mass_.take(*given.factored->mass, given.factored->lane, nv_);
        else if (!mass_.factor(p.M, p.parent, nv_, {m_, p.A, p.vectors, p.wider}))
            refuse(Unavailable::singular);
    }
    if (unavailable != Unavailable::none) {
        existence = Existence::not_available;
        return;
    }
    const auto all = [](const std::vector<char>& unique) {
        return std::find(unique.begin(), unique.end(), 0) == unique.end();
    };
    is_shared_ = !all(s.unique) || !all(s.contact.unique);
    find_responses();
    find_inertias();
    held_pairs_.clear();
    for (const Held& held : scene_.held)
        if (held.kind == Held::pair)
            held_pairs_.emplace_back(frame_pair_state(*given.tree, held.frames));
    blow_pairs_.clear();
    for (const Blow& blow : scene_.blows)
        blow_pairs_.emplace_back(frame_pair_state(*given.tree, pair_of(blow)));
    find_coefficients();
    find_stages();
    if (unavailable != Unavailable::none) {
        existence = Existence::not_available;
        return;
    }
    const TreeGradient<double, double> tree(*given.tree);
    twists_.resize(velocities_.size());
    for (std::size_t t = 0; t < velocities_.size(); ++t)
        tree.move(velocities_[t].data(), twists_[t]);
    for (Stage& stage : stages_) find_wrenches(stage);
}

// M⁻¹ Gᵀ and W of all rows, and what fills up a singular M.
void Derivation::find_responses() {
    const int rows = m_ + 3 * n_;
    response_.resize(rows * nv_);
    W_.resize(rows * rows);
    for (int r = 0; r < rows; ++r) {
        double* own = response_.data() + r * nv_;
        if (const FactoredLane* given = given_.factored) {
            const Pack* from = given->response + given->rows[r] * nv_;
            for (int i = 0; i < nv_; ++i) own[i] = from[i][given->lane];
        } else {
            std::copy(row(r), row(r) + nv_, own);
            mass_.mass().solve(own);
        }
        for (int j = 0; j <= r; ++j) W_[r * rows + j] = W_[j * rows + r] = dot(row(j), own, nv_);
    }
    filling_.assign(mass_.is_filled() ? m_ * nv_ : 0, 0.0);
    for (std::size_t r = 0; r * nv_ < filling_.size(); ++r) {
        std::vector<double> unit(m_, 0.0);
        unit[r] = 1.0;
        mass_.fill(unit.data(), filling_.data() + r * nv_);
    }
}

// The inertias of all bodies in the world, with the factors of masses.
void Derivation::find_inertias() {
    const Differentiated& given = given_;
    inertias_.resize(scene_.model->bodies.size());
    for (int k = 1; k < static_cast<int>(inertias_.size()); ++k)
        inertias_[k] = given.tree->in_world(k, inertia_of<double>(scene_.model->bodies[k]));
    for (std::size_t i = 0; i < scene_.loads.size() && given.masses; ++i) {
        const Load& load = scene_.loads[i];
        inertias_[load.body] += share_of(given.tree->in_world(load.body, inertia_of<double>(load)),
                                         given.masses[i] - 1.0);
    }
}

bool Derivation::is_stop(int i) const {
    return scene_.contacts[given_.entries[i]].kind == Contact::stop;
}

void Derivation::find_coefficients() {
    const ImpactProblem& p = *given_.problem;
    std::vector<double> after(p.v, p.v + nv_), blown;
    for (int i = 0; i < nv_; ++i) after[i] += given_.solution->dv[i];
    if (p.impulse) {
        blown.assign(p.impulse, p.impulse + nv_);
        mass_.mass().solve(blown.data());
    }
    const double* speeds[] = {p.v, after.data(), blown.data()};
    scale_ = 0.0;
    for (int r = 0; r < 3 * n_; ++r)
        for (int k = 0; k < (p.impulse ? 3 : 2); ++k)
            scale_ = std::max(scale_, std::abs(dot(p.J + r * nv_, speeds[k], nv_)));
    own_.assign(n_, {});
    for (int i = 0; i < n_; ++i) {
        Coefficients& own = own_[i];
        own.e = p.contact.restitution[i];
        own.mu = p.contact.friction[i];
        own.tangential = p.contact.tangential[i];
        const double normal = dot(p.J + (3 * i + 2) * nv_, p.v, nv_),
                     small = tolerance::edge * scale_;
        std::optional<Edge> found;
        bool by_differences = false;
        // A parting contact has an approach speed of zero, here and nearby.
        if (given_.has_own_restitution && !(normal > small))
            own.slope = slope_of(law_.contacts[given_.entries[i]].restitution,
                                 std::max(-normal, 0.0), scale_, by_differences, found);
        if ((own.e > 0.0 || own.slope != 0.0) && std::abs(normal) <= small && !found)
            found = Edge::hardly_approaches;
        if (!(normal < 0.0)) own.slope = 0.0;
        if (by_differences && existence == Existence::exists) existence = Existence::by_differences;
        if (found && given_.solution->contact.impulse[3 * i + 2] > 0.0) add_edge(*found, i);
    }
    keep(std::vector<double>(p.v, p.v + nv_));
    keep(std::move(after));
}

// True if what weights sum up is determined: not a share of redundant loads.
bool Derivation::is_determined(const double* weights) const {
    const double *multipliers = weights + nv_, *impulses = multipliers + m_;
    for (int r = 0; r < m_; ++r)
        if (multipliers[r] != 0.0 && !determined[r]) return false;
    for (int i = 0; i < n_; ++i)
        if (!given_.solution->contact.unique[i])
            for (int k = 0; k < 3; ++k)
                if (impulses[3 * given_.entries[i] + k] != 0.0) return false;
    return true;
}

}  // namespace impulsekit
