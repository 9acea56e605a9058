// The stages of an impact: known impulses, compression and expansion, or hit after hit.
#include <algorithm>
#include <cmath>

#include "contact/law_slopes.hpp"
#include "contact/path.hpp"
#include "contact/sequence.hpp"
#include "contact/tolerances.hpp"
#include "derivatives/derivation.hpp"
#include "linalg/dense.hpp"

namespace impulsekit {
namespace {

// So many hits are differentiated one by one; longer series are known by their limit.
constexpr int kMostHits = 2000;

}  // namespace

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

}  // namespace impulsekit
