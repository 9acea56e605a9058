#include "derivatives/derivatives.hpp"

#include <algorithm>
#include <cmath>

#include "contact/law_slopes.hpp"
#include "contact/path.hpp"
#include "contact/sequence.hpp"
#include "contact/tolerances.hpp"
#include "derivatives/derivation.hpp"
#include "linalg/dense.hpp"
#include "scene/frame_pair_states.hpp"

namespace impulsekit {
namespace {

// A contact that slips has its impulse on the cone, to this share of its bound.
constexpr double kOnCone = 1e-6;
// An impulse that could move this much faster than anything moves is held up by nothing.
constexpr double kProportion = 1e7;
// The step of differences in the slope of a function, beside the velocities.
constexpr double kStep = 1e-3;
// So many hits are differentiated one by one; longer series are known by their limit.
constexpr int kMostHits = 2000;

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
        if (!mass_.factor(p.M, p.parent, nv_, {m_, p.A, p.vectors, p.wider}))
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
        std::copy(row(r), row(r) + nv_, response_.data() + r * nv_);
        mass_.mass().solve(response_.data() + r * nv_);
        for (int j = 0; j <= r; ++j)
            W_[r * rows + j] = W_[j * rows + r] = dot(row(j), response_.data() + r * nv_, nv_);
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

void Derivation::find_stages() {
    const Law& law = law_.law;
    const bool sequential = law.order == Order::sequential;
    const bool struck = scene_.blows.size() + scene_.kicks.size() > 0;
    // Something may change the velocity before the first hit: then even one contact has two laws.
    const bool in_turn = n_ > 1 || (sequential && struck) || m_ > 0;
    bool rubs = law.restitution == Restitution::stronge;
    for (const Coefficients& own : own_) rubs = rubs || own.mu != 0.0;
    const bool along = law.slip == Slip::compliant || law.restitution == Restitution::lzb ||
                       (law.slip == Slip::path && rubs);
    if (n_ > 0 && (along || (sequential && in_turn))) return follow_hits(along);
    if (n_ > 0 && law.restitution != Restitution::newton) return compress();
    Stage whole;
    whole.end = 1;
    whole.first = true;
    whole.impulses = given_.solution->multipliers;
    const std::vector<double>& P = given_.solution->contact.impulse;
    whole.impulses.insert(whole.impulses.end(), P.begin(), P.begin() + 3 * n_);
    add_stage(std::move(whole), n_);
}

// Compression and expansion of Poisson's law.
void Derivation::compress() {
    const std::vector<double> zeros(n_, 0.0);
    ImpactProblem pressed = *given_.problem;
    pressed.contact.restitution = pressed.contact.tangential = zeros.data();
    pressed.law = Law();
    ImpactSolution found;
    solve_impact(pressed, found);
    if (found.failure != ImpactSolution::Failure::none ||
        (found.contact.status != Status::solved && found.contact.status != Status::energy_gain)) {
        unavailable = Unavailable::no_compression;
        return;
    }
    std::vector<double> middle = velocities_[0];
    for (int i = 0; i < nv_; ++i) middle[i] += found.dv[i];
    Stage first, rest;
    first.first = true;
    first.end = rest.start = keep(std::move(middle));
    rest.end = 1;
    const ImpactSolution& s = *given_.solution;
    for (int r = 0; r < m_; ++r) {
        first.impulses.push_back(found.multipliers[r]);
        rest.impulses.push_back(s.multipliers[r] - found.multipliers[r]);
    }
    for (int r = 0; r < 3 * n_; ++r) {
        first.impulses.push_back(found.contact.impulse[r]);
        rest.impulses.push_back(s.contact.impulse[r] - found.contact.impulse[r]);
        if (r % 3 == 2) rest.compressed.push_back(found.contact.impulse[r]);
    }
    add_stage(std::move(first), n_);
    add_stage(std::move(rest), n_);
}

// First the known impulses, then one contact after the other.
void Derivation::follow_hits(bool along_path) {
    const ImpactSolution& s = *given_.solution;
    const int rows = 3 * n_;
    mass_.respond(given_.problem->J, rows, free_response_, free_multipliers_, free_W_);
    std::vector<double> free = velocities_[1];
    for (int r = 0; r < rows; ++r)
        for (int i = 0; i < nv_; ++i) free[i] -= s.contact.impulse[r] * free_response_[r * nv_ + i];
    Stage bare;
    bare.first = true;
    int now = bare.end = keep(std::move(free));
    std::vector<int> order;
    std::vector<double> shares;
    if (!find_hits(order, shares)) return;
    bare.impulses = s.multipliers;
    bare.impulses.resize(m_ + rows, 0.0);
    for (std::size_t h = 0; h < order.size(); ++h)
        for (int k = 0; k < 3; ++k)
            for (int r = 0; r < m_; ++r)
                bare.impulses[r] -=
                    free_multipliers_[(3 * order[h] + k) * m_ + r] * shares[3 * h + k];
    add_stage(std::move(bare), -1);
    if (has_springs()) return follow_waves(order, shares.data(), now);
    for (std::size_t h = 0; h < order.size() && unavailable == Unavailable::none; ++h)
        follow_hit(order[h], shares.data() + 3 * h, now, along_path);
}

// The hits in order and their impulses, and where the order is on an edge.
bool Derivation::find_hits(std::vector<int>& order, std::vector<double>& shares) {
    const ImpactProblem& p = *given_.problem;
    const int rows = 3 * n_;
    ContactProblem contact = p.contact;
    contact.models = nullptr;
    std::vector<double> before(rows), free(rows);
    for (int r = 0; r < rows; ++r) {
        before[r] = dot(p.J + r * nv_, p.v, nv_);
        free[r] = dot(p.J + r * nv_, velocities_.back().data(), nv_);
    }
    contact.W = free_W_.data();
    contact.before = before.data();
    contact.free = free.data();
    return law_.law.order == Order::sequential ? find_hits_in_turn(contact, order, shares)
                                               : find_hits_at_once(contact, order, shares);
}

bool Derivation::find_hits_in_turn(const ContactProblem& contact, std::vector<int>& order,
                                   std::vector<double>& shares) {
    const Law& law = law_.law;
    const int rows = 3 * n_;
    const double small = tolerance::edge * scale_;
    const auto weight = [&](int i) { return free_W_[(3 * i + 2) * (rows + 1)]; };
    std::vector<Hit> hits;
    solve_sequence(contact, law, &hits);
    if (hits.size() > kMostHits) {
        unavailable = Unavailable::too_many_hits;
        return false;
    }
    std::vector<double> now(contact.free, contact.free + rows);
    std::vector<char> at_rest(n_, 0);
    for (const Hit& hit : hits) {
        const int i = hit.contact;
        const double own = now[3 * i + 2];
        std::vector<double> next = now;
        for (int r = 0; r < rows; ++r)
            next[r] += dot(free_W_.data() + r * rows + 3 * i, hit.impulse, 3);
        for (int j = 0; j < n_; ++j) {
            const double normal = now[3 * j + 2];
            // The order is that of |u_n|/√W_nn; what no impulse moves comes first.
            const double as_fast =
                own * std::sqrt(weight(j) / (weight(i) != 0.0 ? weight(i) : 1.0));
            if (j != i && std::abs(normal - as_fast) <= small) add_edge(Edge::just_as_fast, i, j);
            at_rest[j] =
                at_rest[j] && std::abs(next[3 * j + 2] - normal) <= tolerance::at_rest * scale_;
        }
        at_rest[i] = own_[i].e == 0.0;
        now = next;
        order.push_back(i);
        shares.insert(shares.end(), hit.impulse, hit.impulse + 3);
    }
    // The rest of a series without end was summed up, not followed: then more is left than
    // rounding.
    const std::vector<double>& P = given_.solution->contact.impulse;
    std::vector<double> left(P.begin(), P.begin() + rows);
    for (std::size_t h = 0; h < order.size(); ++h)
        for (int k = 0; k < 3; ++k) left[3 * order[h] + k] -= shares[3 * h + k];
    if (largest(left.data(), rows) > 10.0 * tolerance::handed_on * largest(P.data(), rows)) {
        unavailable = Unavailable::too_many_hits;
        return false;
    }
    for (int j = 0; j < n_; ++j)
        if (std::abs(now[3 * j + 2]) <= small && !at_rest[j]) add_edge(Edge::hardly_parts, j);
    return true;
}

// The contacts that act, which do not act on each other, and others that nearly do.
bool Derivation::find_hits_at_once(const ContactProblem& contact, std::vector<int>& order,
                                   std::vector<double>& shares) {
    const Law& law = law_.law;
    const int rows = 3 * n_;
    const double small = tolerance::edge * scale_, *before = contact.before, *free = contact.free;
    const std::vector<double>& P = given_.solution->contact.impulse;
    for (int j = 0; j < n_; ++j) {
        const double shift = law.restitution == Restitution::newton
                                 ? own_[j].e * std::min(before[3 * j + 2], 0.0)
                                 : 0.0;
        if (std::abs(free[3 * j + 2] + shift) <= small) add_edge(Edge::hardly_parts, j);
        if (!(P[3 * j + 2] > 0.0)) continue;
        for (int i : order)
            for (int k = own_[i].mu != 0.0 ? 0 : 2; k < 3; ++k)
                for (int l = own_[j].mu != 0.0 ? 0 : 2; l < 3; ++l)
                    if (!has_springs() && free_W_[(3 * i + k) * rows + 3 * j + l] != 0.0)
                        unavailable = Unavailable::coupled;
        order.push_back(j);
        shares.insert(shares.end(), P.begin() + 3 * j, P.begin() + 3 * j + 3);
    }
    for (int j = 0; j < n_ && !order.empty(); ++j) {
        const double after =
            free[3 * j + 2] + dot(free_W_.data() + (3 * j + 2) * rows, P.data(), rows);
        if (!(P[3 * j + 2] > 0.0) && std::abs(after) <= small) add_edge(Edge::hardly_parts, j);
    }
    return unavailable == Unavailable::none;
}

// True if contacts share the impact by their stiffnesses, followed in time.
bool Derivation::has_springs() const {
    return law_.law.slip == Slip::compliant || law_.law.restitution == Restitution::lzb;
}

// The stage of impulses of contacts from the velocity `now`, which becomes that after them:
// bilateral rows bear and bodies move in proportion to the impulses.
Derivation::Stage Derivation::stage_of_hits(const std::vector<int>& points, const double* impulses,
                                            int& now) {
    Stage stage;
    stage.start = now;
    stage.impulses.assign(m_ + 3 * n_, 0.0);
    std::vector<double> end = velocities_[now];
    for (std::size_t h = 0; h < 3 * points.size(); ++h) {
        const int row = 3 * points[h / 3] + static_cast<int>(h % 3);
        stage.impulses[m_ + row] = impulses[h];
        for (int r = 0; r < m_; ++r)
            stage.impulses[r] += free_multipliers_[row * m_ + r] * impulses[h];
        for (int j = 0; j < nv_; ++j) end[j] += free_response_[row * nv_ + j] * impulses[h];
    }
    now = stage.end = keep(std::move(end));
    return stage;
}

// Keep the velocities by unit impulses along the rows of the points that a stage follows.
void Derivation::keep_units(Stage& stage) {
    stage.units = static_cast<int>(velocities_.size());
    for (int i : stage.along)
        for (int k = 0; k < 3; ++k) {
            const double* response = free_response_.data() + (3 * i + k) * nv_;
            keep(std::vector<double>(response, response + nv_));
        }
}

// All contacts that act, under a law that follows them in time: by differences of that.
void Derivation::follow_waves(const std::vector<int>& points, const double* impulses, int& now) {
    const int own = static_cast<int>(points.size()), rows = 3 * n_;
    if (own == 0) return;
    const ContactProblem& all = given_.problem->contact;
    std::vector<double> W(9 * own * own), free(3 * own), numbers(6 * own);
    for (int r = 0; r < 3 * own; ++r) {
        const int row = 3 * points[r / 3] + r % 3;
        free[r] = dot(given_.problem->J + row * nv_, velocities_[now].data(), nv_);
        for (int c = 0; c < 3 * own; ++c)
            W[r * 3 * own + c] = free_W_[row * rows + 3 * points[c / 3] + c % 3];
    }
    ContactProblem part;
    part.contacts = own;
    part.W = W.data();
    part.free = part.before = free.data();
    const double* given[6] = {all.restitution, all.friction,        all.tangential,
                              all.stiffness,   all.stiffness_ratio, all.damping};
    const double** to[6] = {&part.restitution, &part.friction,        &part.tangential,
                            &part.stiffness,   &part.stiffness_ratio, &part.damping};
    for (int k = 0; k < 6; ++k) {
        if (!given[k]) continue;
        for (int a = 0; a < own; ++a) numbers[k * own + a] = given[k][points[a]];
        *to[k] = numbers.data() + k * own;
    }
    Stage stage = stage_of_hits(points, impulses, now);
    stage.along = points;
    stage.from_start = true;
    std::vector<char> at_edge;
    if (!difference_law(part, law_.law, stage.law, at_edge)) unavailable = Unavailable::no_waves;
    if (existence == Existence::exists) existence = Existence::by_differences;
    for (int a = 0; a < own; ++a)
        if (at_edge[a]) add_edge(Edge::differences_disagree, points[a]);
    keep_units(stage);
    add_stage(std::move(stage), -1);
}

// One hit, from the velocity `now`, which becomes that after it.
void Derivation::follow_hit(int i, const double* share, int& now, bool along_path) {
    const Law& law = law_.law;
    const int rows = 3 * n_;
    double block[9], u[3];
    for (int k = 0; k < 3; ++k) {
        u[k] = dot(given_.problem->J + (3 * i + k) * nv_, velocities_[now].data(), nv_);
        for (int l = 0; l < 3; ++l) block[3 * k + l] = free_W_[(3 * i + k) * rows + 3 * i + l];
    }
    const auto part = [&](const double* impulse) { return stage_of_hits({i}, impulse, now); };
    if (along_path) {
        for (int k = 0; k < 3; ++k)
            // Along what bilateral rows hold, slip is rounding, and no friction ends it.
            if (block[4 * k] == 0.0 && std::abs(u[k]) <= tolerance::at_rest * scale_) u[k] = 0.0;
        const bool from_start = law.order == Order::sequential;
        const double before =
            from_start ? u[2] : dot(given_.problem->J + (3 * i + 2) * nv_, given_.problem->v, nv_);
        const PathDerivative found =
            derive_path(block, before, u, own_[i].e, own_[i].mu, law.restitution);
        if (found.is_drawn_in) unavailable = Unavailable::drawn_in;
        for (int k = 0; k < 3; ++k)
            if (found.edges >> k & 1)
                add_edge(static_cast<Edge>(static_cast<int>(Edge::stuck_at_edge) + k), i);
        Stage stage = part(share);
        stage.along = {i};
        stage.from_start = from_start;
        stage.law.assign(found.by, found.by + 3 * kPathParameters);
        keep_units(stage);
        return add_stage(std::move(stage), -1);
    }
    if (law.restitution == Restitution::newton) return add_stage(part(share), i);
    const double zero = 0.0;
    ContactProblem one;
    one.contacts = 1;
    one.W = block;
    one.before = one.free = u;
    one.restitution = one.tangential = &zero;
    one.friction = &own_[i].mu;
    const ContactSolution pressed = solve_contacts(one, Law());
    double rest[3];
    for (int k = 0; k < 3; ++k) rest[k] = share[k] - pressed.impulse[k];
    add_stage(part(pressed.impulse.data()), i);
    Stage expansion = part(rest);
    expansion.compressed.assign(n_, 0.0);
    expansion.compressed[i] = pressed.impulse[2];
    add_stage(std::move(expansion), i);
}

// The mode of a point in a stage; tells edges.
Derivation::Mode Derivation::mode_of(int i, const Stage& stage) const {
    auto& self = const_cast<Derivation&>(*this);
    const Coefficients& own = own_[i];
    const bool newton = law_.law.restitution == Restitution::newton;
    const double small = tolerance::edge * scale_;
    const double *start = velocities_[stage.start].data(), *end = velocities_[stage.end].data();
    const double* P = stage.impulses.data() + m_ + 3 * i;
    double xi[3], mobility[3] = {};
    for (int k = 0; k < 3; ++k) {
        const double* J = row(m_ + 3 * i + k);
        const double before = dot(J, start, nv_);
        xi[k] = dot(J, end, nv_);
        if (newton && k < 2 && own.mu > 0.0) xi[k] += own.tangential * before;
        if (newton && k == 2) xi[k] += own.e * std::min(before, 0.0);
        // Without the coupling of joints: of the size of W, from below.
        for (int j = 0; j < nv_; ++j)
            if (J[j] != 0.0) mobility[k] += J[j] * J[j] / given_.problem->M[j * (nv_ + 1)];
    }
    Mode mode;
    const double tangential = std::hypot(P[0], P[1]), speed = std::hypot(xi[0], xi[1]);
    const double compressed = stage.compressed.empty() ? 0.0 : stage.compressed[i];
    const double e = stage.compressed.empty() ? 0.0 : own.e;
    if (mobility[2] * (P[2] - e * compressed) <= small) {
        mode.held = compressed > 0.0;
        // Without restitution nothing expands, and the velocity stays at zero.
        const bool clear = xi[2] > small || (mode.held && e == 0.0);
        if (!clear) self.add_edge(Edge::hardly_presses, i);
        if (!mode.held && (clear || P[2] <= 0.0)) return mode;
    }
    mode.parted = false;
    mode.normal = P[2];
    mode.compressed = compressed;
    mode.sticking = own.mu > 0.0 && speed <= small;
    // Without restitution an expansion has neither impulse nor cone.
    if (mode.sticking && !(mode.held && e == 0.0) &&
        std::max(mobility[0], mobility[1]) * (own.mu * P[2] - tangential) <= small)
        self.add_edge(Edge::edge_of_cone, i);
    if (own.mu > 0.0 && !mode.sticking && own.mu * P[2] - tangential > kOnCone * own.mu * P[2])
        self.add_edge(Edge::hardly_slips, i);
    if (mobility[2] * P[2] > kProportion * scale_) self.add_edge(Edge::out_of_proportion, i);
    if (speed <= small) return mode;
    mode.slip[0] = xi[0] / speed;
    mode.slip[1] = xi[1] / speed;
    mode.resistance = own.mu * P[2] / speed;
    return mode;
}

// Keep a stage in which one point takes part; `acting`: n for all of them, −1 for none.
void Derivation::add_stage(Stage stage, int acting) {
    const double* start = velocities_[stage.start].data();
    for (int r = 0; r < m_; ++r) {
        stage.rows.push_back(r);
        stage.kappa.push_back(!stage.first || scene_.kept[r] ? 1.0 : 0.0);
    }
    for (int i = 0; i < n_; ++i) {
        if (acting != n_ && acting != i) continue;
        const Mode mode = mode_of(i, stage);
        if (mode.parted) continue;
        stage.carrying.push_back(i);
        stage.modes.push_back(mode);
        const bool newton = law_.law.restitution == Restitution::newton;
        const double shift = newton && own_[i].mu > 0.0 ? own_[i].tangential : 0.0;
        const bool approaches = dot(row(m_ + 3 * i + 2), start, nv_) < 0.0;
        for (int k = 0; k < 3; ++k) {
            stage.rows.push_back(m_ + 3 * i + k);
            stage.kappa.push_back(k < 2 ? -shift : newton && approaches ? -own_[i].e : 0.0);
        }
    }
    std::vector<double> change = velocities_[stage.end];
    for (int i = 0; i < nv_; ++i) change[i] -= start[i];
    stage.change = keep(std::move(change));
    solve_system(stage);
    stages_.push_back(std::move(stage));
}

void Derivation::solve_system(Stage& stage) {
    const int count = static_cast<int>(stage.rows.size()), all = m_ + 3 * n_;
    std::vector<double> W(count * count);
    for (int i = 0; i < count; ++i)
        for (int j = 0; j < count; ++j) W[i * count + j] = W_[stage.rows[i] * all + stage.rows[j]];
    if (is_shared_ && !mass_.is_filled()) share_evenly(stage, W);
    double most = tolerance::tiny;
    for (int i = 0; i < count; ++i) most = std::max(most, W[i * (count + 1)]);
    stage.null.assign(count, 0);
    stage.scale.assign(count, 1.0);
    for (int i = 0; i < count; ++i) {
        stage.null[i] = W[i * (count + 1)] <= tolerance::immovable * most;
        if (!stage.null[i]) stage.scale[i] = 1.0 / std::sqrt(W[i * (count + 1)]);
    }
    const int m = stage.bilateral();
    stage.mix.assign(m, 1.0);
    stage.own.assign(m, 0.0);
    for (std::size_t c = 0; c < stage.carrying.size(); ++c) {
        const Mode& mode = stage.modes[c];
        const double normal = mode.held ? 0.0 : 1.0, k = mode.resistance, a = mode.slip[0],
                     b = mode.slip[1], mu = own_[stage.carrying[c]].mu;
        double mix[9] = {k * b * b, -k * a * b, 0, -k * a * b, k * a * a, 0, 0, 0, normal};
        double own[9] = {1, 0, mu * a, 0, 1, mu * b, 0, 0, 1.0 - normal};
        if (mode.sticking) {
            mix[0] = mix[4] = 1.0;
            mix[1] = mix[3] = own[0] = own[2] = own[4] = own[5] = 0.0;
        }
        stage.mix.insert(stage.mix.end(), mix, mix + 9);
        stage.own.insert(stage.own.end(), own, own + 9);
    }
    stage.kept.assign(count, 0);
    drop_rows(stage);
    // (Φ W + E)ᵀ, its rows and columns of one size.
    stage.factors.assign(count * count, 0.0);
    const auto put = [&](int r, int k, double mix, double own) {
        if (own != 0.0) stage.factors[k * count + r] += own * stage.scale[r] * stage.scale[k];
        for (int j = 0; j < count && mix != 0.0; ++j)
            stage.factors[j * count + r] +=
                mix * W[k * count + j] * stage.scale[r] * stage.scale[j];
    };
    for (int r = 0; r < m; ++r) put(r, r, stage.mix[r], stage.own[r]);
    for (int r = m; r < count; ++r)
        for (int k = 0; k < 3; ++k) {
            const int at = m + 3 * (r - m) + k;
            put(r, m + (r - m) / 3 * 3 + k, stage.mix[at], stage.own[at]);
        }
    stage.pivots.resize(count);
    stage.is_open = !factor_lu(stage.factors.data(), count, stage.pivots.data());
}

// Springs that keep shares of load even where contacts slip: of redundant loads the rule is theirs.
void Derivation::share_evenly(Stage& stage, std::vector<double>& W) {
    const int count = static_cast<int>(stage.rows.size()), m = stage.bilateral();
    bool slips = false;
    std::vector<double> points;
    for (std::size_t c = 0; c < stage.carrying.size(); ++c) {
        if (stage.modes[c].held) continue;
        slips = slips || !stage.modes[c].sticking;
        stage.even.push_back(m + 3 * static_cast<int>(c) + 2);
        const double* normal = row(stage.rows[stage.even.back()]);
        points.insert(points.end(), normal, normal + nv_);
    }
    const int k = static_cast<int>(stage.even.size());
    std::vector<double> velocity_changes, unit_multipliers, own, projector(k * k);
    std::vector<int> order(k);
    int rank = k;
    if (k > 1 && slips) {
        // Row by row: a normal by itself is a vector.
        own.resize(k * k);
        std::vector<double> half = points;
        for (int i = 0; i < k; ++i) {
            mass_.mass().half(half.data() + i * nv_);
            if (m_ > 0) mass_.rows().project_out(half.data() + i * nv_);
        }
        for (int i = 0; i < k; ++i)
            for (int j = 0; j < k; ++j)
                own[i * k + j] = dot(half.data() + i * nv_, half.data() + j * nv_, nv_);
        bool moves = true;
        for (int i = 0; i < k; ++i) moves = moves && own[i * (k + 1)] > 0.0;
        std::vector<double> roots(k);
        for (int i = 0; i < k && moves; ++i) roots[i] = std::sqrt(own[i * (k + 1)]);
        for (int i = 0; i < k * k && moves; ++i) own[i] /= roots[i / k] * roots[i % k];
        if (moves) rank = factor_pivoted(own.data(), k, order.data(), tolerance::dependent);
        if (rank < k) {
            null_projector(own.data(), order.data(), k, rank, projector.data(), scratch());
            stage.springs.assign(count * k, 0.0);
            for (int i = 0; i < k; ++i)
                for (int j = 0; j < k; ++j) {
                    const double spring = projector[i * k + j] * roots[j];
                    stage.springs[stage.even[j] * k + i] = spring;
                    W[stage.even[i] * count + stage.even[j]] += roots[i] * spring;
                }
        }
    }
    if (rank == k) stage.even.clear();
}

// Leave out demands of rows that move nothing, or that others already make.
void Derivation::drop_rows(Stage& stage) {
    const int count = static_cast<int>(stage.rows.size()), m = stage.bilateral();
    const int springs = static_cast<int>(stage.even.size()), width = nv_ + springs;
    std::vector<int> chosen, vectors;
    std::vector<char> dropped(count, 0);
    std::vector<double> half;
    for (int r = 0; r < count; ++r) {
        if (r >= m) {
            const Mode& mode = stage.modes[(r - m) / 3];
            if ((r - m) % 3 == 2 ? mode.held : !mode.sticking) continue;
        }
        if (stage.null[r]) {
            dropped[r] = 1;
        } else if (is_shared_) {
            chosen.push_back(r);
            vectors.push_back(r < m ? given_.problem->vectors[r] : -1 - r);
            const double* own = row(stage.rows[r]);
            half.insert(half.end(), own, own + nv_);
            mass_.mass().half(half.data() + half.size() - nv_);
            half.insert(half.end(), stage.springs.data() + r * springs,
                        stage.springs.data() + (r + 1) * springs);
        }
    }
    if (!chosen.empty()) {
        const BilateralRows ranked(half.data(), static_cast<int>(chosen.size()), width,
                                   vectors.data());
        for (std::size_t k = ranked.rank(); k < chosen.size(); ++k)
            dropped[chosen[ranked.order()[k]]] = 1;
    }
    for (int r = 0; r < count; ++r) {
        if (!dropped[r]) continue;
        stage.kept[r] = 1;
        const int size = r < m ? 1 : 3, at = r < m ? r : m + 3 * (r - m);
        for (int k = 0; k < size; ++k)
            stage.mix[at + k] = 0.0, stage.own[at + k] = k == (r < m ? 0 : (r - m) % 3) ? 1.0 : 0.0;
    }
    // Springs would take up what redundant rows contradict each other by.
    for (int r : stage.even) stage.kept[r] = 1;
}

// True if v⁺ may depend on how redundant contacts share their load: under Poisson's law e times
// each share comes back, which is e times the resultant without friction and with one e for all.
bool Derivation::is_split_open() const {
    if (law_.law.restitution != Restitution::poisson) return false;
    bool any = false, rubs = false, differ = false;
    double first = -1.0;
    for (int i = 0; i < n_; ++i) {
        if (given_.solution->contact.unique[i]) continue;
        any = any || own_[i].e != 0.0;
        rubs = rubs || own_[i].mu != 0.0;
        if (first < 0.0) first = own_[i].e;
        differ = differ || own_[i].e != first;
    }
    return any && (rubs || differ);
}

}  // namespace impulsekit
