#include "batch/batch.hpp"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <exception>
#include <limits>
#include <mutex>
#include <thread>

#include "batch/contact_lanes.hpp"
#include "batch/contact_outputs.hpp"
#include "contact/tolerances.hpp"
#include "derivatives/derivatives.hpp"
#include "impact/known_impulses.hpp"
#include "impact/scene_impact.hpp"
#include "scene/frame_pair_states.hpp"
#include "scene/wrenches.hpp"
#include "spatial/joints.hpp"
#include "spatial/tree.hpp"

namespace impulsekit {
namespace {

// A quaternion, or a cosine and sine, may be off unit length by this.
constexpr double kUnit = 1e-6;
// Blocks of eight rows that a thread takes at once.
constexpr int kPiece = 32;

std::int8_t code_of(Status status) { return static_cast<std::int8_t>(status); }

double get(const Pack& x, int lane) { return x[lane]; }

// NaN in the lanes that hold a NaN or an infinity, else 0.
Pack flaw(const std::vector<Pack>& x) {
    Pack sum{};
    for (const Pack& entry : x) sum += entry * 0.0;
    return sum;
}

// One thread's room for eight states.
class Block {
  public:
    explicit Block(const Batch& batch)
        : b_(batch),
          scene_(*batch.scene),
          model_(*batch.scene->model),
          tree_(model_),
          known_(scene_),
          rows_(scene_),
          q_(model_.nq),
          v_(model_.nv),
          given_(6 * scene_.blows.size() + scene_.kicks.size()),
          impulse_(model_.nv),
          dv_(model_.nv),
          M_(model_.nv * model_.nv),
          units_(units_of(model_)),
          found_(scene_),
          lane_tree_(model_),
          derivation_(scene_, *batch.law),
          contact_lanes_(scene_, *batch.law) {
        by_articulated_ = scene_.held.empty() && scene_.contacts.empty() && !model_.has_followers &&
                          !model_.has_ellipsoids && batch.is_regular;
        needs_loads_ = batch.out.reactions || batch.out.bodies;
        const BatchInput& in = batch.in;
        places_vary_ = in.masses.varies || in.points.varies || in.function_rows.varies ||
                       in.function_contacts.varies;
    }

    void solve(int block) {
        first_ = block * kLanes;
        count_ = std::min(kLanes, b_.in.size - first_);
        read();
        if (by_articulated_)
            respond_freely();
        else
            respond_by_rows();
        write();
        if (needs_loads_) load();
        if (b_.out.existence && by_articulated_) differentiate_freely();
    }

  private:
    static Pack largest_of(const std::vector<Pack>& numbers) {
        Pack most{};
        for (const Pack& x : numbers) {
            const Pack size = x < 0.0 ? -x : x;
            most = size > most ? size : most;
        }
        return most;
    }

    // This block's first row of an output; null where it is not asked for.
    double* row(double* out, std::size_t width) const { return out ? out + first_ * width : out; }

    int row_of(int lane) const { return first_ + std::min(lane, count_ - 1); }

    void gather(const Column& column, std::vector<Pack>& to) {
        for (int k = 0; k < kLanes; ++k) {
            const double* from = column.row(row_of(k));
            for (std::size_t i = 0; i < to.size(); ++i) to[i][k] = from[i];
        }
    }

    void read() {
        const bool is_first = q_before_.empty();
        q_before_ = q_;
        gather(b_.in.q, q_);
        stays_ = !is_first && !places_vary_ &&
                 std::memcmp(q_before_.data(), q_.data(), q_.size() * sizeof(Pack)) == 0;
        gather(b_.in.v, v_);
        if (!given_.empty()) gather(b_.in.impulses, given_);
        const Pack flaws = flaw(q_) + flaw(v_) + flaw(given_);
        Pack off{};
        for (const auto& [first, count] : units_) {
            Pack square{};
            for (int i = first; i < first + count; ++i) square += q_[i] * q_[i];
            const Pack one = root(square) - 1.0;
            off = one * one > off ? one * one : off;
        }
        for (int k = 0; k < count_; ++k) {
            std::int8_t& code = b_.out.codes[first_ + k];
            code = b_.in.codes[first_ + k];
            if (code != 0) continue;
            if (flaws[k] != 0.0)
                code = code_of(Status::not_finite);
            else if (off[k] > kUnit * kUnit)
                code = code_of(Status::off_manifold);
        }
    }

    // The inertia of a body, with links whose masses vary.
    Inertia<Pack> inertia_at(int body) const {
        Inertia<Pack> own = inertia_of<Pack>(model_.bodies[body]), more;
        for (std::size_t i = 0; i < scene_.loads.size(); ++i) {
            if (scene_.loads[i].body != body) continue;
            Pack share{};
            for (int k = 0; k < kLanes; ++k) share[k] = b_.in.masses.row(row_of(k))[i] - 1.0;
            more += share_of(inertia_of<Pack>(scene_.loads[i]), share);
        }
        return own += more;
    }

    // Known impulses on a tree without rows.
    void respond_freely() {
        if (!stays_) {
            known_.place(q_.data());
            for (int k = 1; k < tree_.count() && !scene_.loads.empty(); ++k)
                known_.tree.set_inertia(k, inertia_at(k));
            known_.tree.factor();
        }
        known_.respond(given_.data(), dv_.data());
        if (b_.out.generalized_impulse || b_.out.energy_change)
            known_.collect(given_.data(), impulse_.data());
        const Pack flaws = flaw(dv_), blows = largest_of(given_), jumps = largest_of(dv_);
        for (int k = 0; k < count_; ++k) {
            std::int8_t& code = b_.out.codes[first_ + k];
            if (code != 0) continue;
            if (flaws[k] != 0.0)
                code = code_of(Status::singular_mass);
            else if (std::fpclassify(blows[k]) == FP_SUBNORMAL ||
                     std::fpclassify(jumps[k]) == FP_SUBNORMAL)
                code = code_of(Status::inaccurate);  // such numbers have lost digits
        }
        if (needs_loads_ || b_.out.existence) {
            if (!stays_) tree_.place(q_.data());
            multipliers_.assign(1, Pack{});
        }
    }

    void respond_by_rows() {
        if (!stays_) {
            tree_.place(q_.data());
            for (int k = 1; k < tree_.count(); ++k)
                tree_.gathered[k] = tree_.in_world(k, inertia_at(k));
            tree_.mass_matrix(M_.data());
        }
        add_blow_wrenches(scene_, given_.data(), tree_);
        tree_.gather(impulse_.data());
        for (std::size_t i = 0; i < scene_.kicks.size(); ++i)
            impulse_[scene_.kicks[i]] += given_[6 * scene_.blows.size() + i];
        for (int k = 0; k < kLanes; ++k) state_[k] = given_of(row_of(k));
        // Targets of bilateral rows may follow v.
        if (!stays_ || scene_.rows() > 0) rows_.fill(tree_, q_.data(), v_.data(), state_);
        impulses_.assign(3 * rows_.contact_frames.size(), Pack{});
        moments_.assign(3 * rows_.contact_frames.size(), Pack{});
        multipliers_.assign(scene_.rows() + 1, Pack{});
        found_.before.assign(rows_.contact_frames.size(), Pack{});
        found_.after = found_.before;
        std::fill(dv_.begin(), dv_.end(), Pack{});
        kept_ = has_directions_ = PackBits{};
        for (int k = 0; k < count_ && b_.out.existence; ++k) leave_slopes(first_ + k);
        if (!solve_side_by_side())
            for (int k = 0; k < count_; ++k)
                if (b_.out.codes[first_ + k] == 0) solve_lane(k);
        const std::size_t n = scene_.contacts.size();
        found_.write_gaps(rows_.contact_frames, has_directions_, count_, row(b_.out.gaps, n));
        found_.write(rows_.contact_frames, impulses_.data(), kept_, count_,
                     row(b_.out.contact_impulses, 3 * n), row(b_.out.normal_components, 3 * n));
        const int nv = model_.nv;
        for (int i = 0; i < nv && (b_.out.generalized_impulse || b_.out.energy_change); ++i) {
            impulse_[i] = Pack{};
            for (int j = 0; j < nv; ++j) impulse_[i] += M_[i * nv + j] * dv_[j];
        }
    }

    // A row without slopes, until some are found.
    void leave_slopes(std::size_t row) {
        const std::size_t size = sets() * b_.in.parameters.size();
        std::fill_n(b_.out.slopes + row * size, size, std::numeric_limits<double>::quiet_NaN());
        b_.out.existence[row] = static_cast<std::int8_t>(Existence::no_impact);
    }

    std::size_t sets() const { return b_.in.weights.data ? 1 : b_.in.results.size(); }

    // Weights of all results, set by set.
    void weigh(int row) {
        const std::size_t results = derivation_.results();
        weights_.assign(sets() * results, 0.0);
        if (const double* given = b_.in.weights.row(row))
            std::copy(given, given + results, weights_.begin());
        else
            for (std::size_t i = 0; i < sets(); ++i) weights_[i * results + b_.in.results[i]] = 1.0;
    }

    void differentiate(int k, int row, const ImpactProblem& p, const FactoredLane* factored) {
        const Status status = solution_.contact.status;
        if (solution_.failure != ImpactSolution::Failure::none ||
            (status != Status::solved && status != Status::energy_gain))
            return;
        extract_lane(tree_, k, lane_tree_);
        Differentiated d;
        d.is_closed =
            find_frame_pair_states(scene_, lane_tree_, lane_, pairs_, derivation_.contact);
        entries_.clear();
        for (const ContactFrame<double>& point : lane_.points) entries_.push_back(point.entry);
        d.tree = &lane_tree_;
        d.problem = &p;
        d.solution = &solution_;
        d.factored = factored;
        d.entries = entries_.data();
        d.pairs = pairs_.data();
        d.impulses = b_.in.impulses.row(row);
        d.masses = b_.in.masses.row(row);
        d.has_own_restitution = !b_.in.restitution.data;
        derivation_.set(d);
        derivation_.check_rows();
        b_.out.existence[row] = static_cast<std::int8_t>(derivation_.existence);
        if (derivation_.unavailable != Unavailable::none) return;
        weigh(row);
        const std::size_t width = derivation_.slopes(), count = b_.in.parameters.size();
        slopes_.resize(sets() * width);
        derivation_.pull_back(weights_.data(), static_cast<int>(sets()), slopes_.data());
        double* to = b_.out.slopes + row * sets() * count;
        for (std::size_t i = 0; i < sets(); ++i)
            for (std::size_t j = 0; j < count; ++j)
                to[i * count + j] = slopes_[i * width + b_.in.parameters[j]];
    }

    // Slopes under known impulses alone, eight rows side by side.
    void differentiate_freely() {
        const std::size_t results = derivation_.results(), count = b_.in.parameters.size();
        std::vector<Inertia<Pack>> inertias(tree_.count());
        for (int k = 1; k < tree_.count(); ++k) inertias[k] = tree_.in_world(k, inertia_at(k));
        const std::vector<char> all(tree_.count(), 1);
        std::vector<Pack> w(model_.nv), x(model_.nv), slopes(derivation_.slopes());
        for (int k = 0; k < count_; ++k) {
            leave_slopes(first_ + k);
            if (b_.out.codes[first_ + k] == 0)
                b_.out.existence[first_ + k] = static_cast<std::int8_t>(Existence::exists);
        }
        for (std::size_t i = 0; i < sets(); ++i) {
            for (int k = 0; k < kLanes; ++k) {
                weigh(row_of(k));
                for (int j = 0; j < model_.nv; ++j) w[j][k] = weights_[i * results + j];
            }
            std::fill(known_.tree.wrench.begin(), known_.tree.wrench.end(), Spatial<Pack>{});
            known_.tree.respond(all.data(), w.data(), x.data());
            pull_back_blows(scene_, tree_, inertias.data(), given_.data(), w.data(), x.data(),
                            dv_.data(), slopes.data());
            for (int k = 0; k < count_; ++k) {
                const std::size_t row = first_ + k;
                if (b_.out.codes[row] != 0) continue;
                for (std::size_t j = 0; j < count; ++j)
                    b_.out.slopes[(row * sets() + i) * count + j] = slopes[b_.in.parameters[j]][k];
            }
        }
    }

    GivenState given_of(int row) const {
        GivenState given;
        given.function_rows = b_.in.function_rows.row(row);
        given.function_contacts = b_.in.function_contacts.row(row);
        given.points = b_.in.points.row(row);
        return given;
    }

    // Solve all lanes at once. False where bilateral rows or a mass matrix that may be singular are
    // decided on one by one, or where matrices are large.
    bool solve_side_by_side() {
        if (!scene_.held.empty() || !b_.is_regular) return false;
        for (int k = 0; k < kLanes; ++k) {
            lanes_[k].is_given = k < count_ && b_.out.codes[first_ + k] == 0;
            lanes_[k].restitution = b_.in.restitution.row(row_of(k));
            lanes_[k].friction = b_.in.friction.row(row_of(k));
        }
        if (!contact_lanes_.choose(tree_, rows_, lanes_, stays_)) return false;
        jumps_.resize(model_.nv);
        contact_lanes_.solve(M_.data(), v_.data(), given_.empty() ? nullptr : impulse_.data(),
                             lanes_, jumps_.data());
        for (int k = 0; k < count_; ++k) {
            if (!lanes_[k].is_given) continue;
            const Status status = lanes_[k].status;
            b_.out.codes[first_ + k] = code_of(status);
            has_directions_[k] = -rows_.has_line[k];
            kept_[k] = -(status != Status::refused && status != Status::singular_mass);
        }
        keep_lanes();
        for (int k = 0; k < count_ && b_.out.existence; ++k)
            if (kept_[k]) differentiate_lane(k);
        return true;
    }

    // Bring what was found in all lanes out.
    void keep_lanes() {
        for (int i = 0; i < model_.nv; ++i) dv_[i] = kept_ ? jumps_[i] : Pack{};
        const std::vector<int>&frames = contact_lanes_.frames(),
              &turning = contact_lanes_.turning();
        const Pack *P = contact_lanes_.P().data(), *moments = P + 3 * frames.size();
        for (std::size_t i = 0; i < frames.size(); ++i) {
            std::copy(P + 3 * i, P + 3 * i + 3, impulses_.data() + 3 * frames[i]);
            found_.before[frames[i]] = contact_lanes_.before()[3 * i + 2];
            found_.after[frames[i]] = contact_lanes_.after()[3 * i + 2];
        }
        for (std::size_t i = 0; i < turning.size(); ++i)
            std::copy(moments + 3 * i, moments + 3 * i + 3,
                      moments_.data() + 3 * frames[turning[i]]);
    }

    void differentiate_lane(int k) {
        rows_.extract(tree_, k, lane_);
        solution_ = ImpactSolution();
        solution_.contact = contact_lanes_.solution(lane_, lanes_[k], k);
        solution_.dv.resize(model_.nv);
        for (int i = 0; i < model_.nv; ++i) solution_.dv[i] = jumps_[i][k];
        differentiate(k, first_ + k, problem_of_lane(k), contact_lanes_.factored(lane_, k));
    }

    // The problem of one lane, whose rows have been extracted.
    ImpactProblem problem_of_lane(int k) {
        const int nv = model_.nv, row = first_ + k;
        numbers_.resize(nv * nv + 2 * nv);
        double *M = numbers_.data(), *v = M + nv * nv, *blow = v + nv;
        for (int i = 0; i < nv * nv; ++i) M[i] = get(M_[i], k);
        for (int i = 0; i < nv; ++i) v[i] = get(v_[i], k), blow[i] = get(impulse_[i], k);
        ImpactProblem p = problem_of(scene_, lane_, b_.law->law);
        p.M = M;
        p.v = v;
        if (!given_.empty()) p.impulse = blow;
        coefficients_.set(*b_.law, lane_, b_.in.restitution.row(row), b_.in.friction.row(row), v,
                          p.contact);
        return p;
    }

    void solve_lane(int k) {
        const int row = first_ + k;
        std::int8_t& code = b_.out.codes[row];
        rows_.extract(tree_, k, lane_);
        if (lane_.without_line >= 0 || lane_.without_ellipse >= 0) {
            code = code_of(Status::refused);
            return;
        }
        has_directions_[k] = -1;
        const ImpactProblem p = problem_of_lane(k);
        solve_impact(p, solution_);
        code = code_of(status_of(solution_));
        if (b_.out.existence) differentiate(k, row, p, nullptr);
        if (solution_.failure != ImpactSolution::Failure::none) return;
        keep(k);
    }

    // Bring what was found in one lane back into it, and out.
    void keep(int k) {
        const ImpactSolution& s = solution_;
        kept_[k] = -1;
        for (int i = 0; i < model_.nv; ++i) dv_[i][k] = s.dv[i];
        for (std::size_t i = 0; i < s.multipliers.size(); ++i)
            multipliers_[i][k] = s.multipliers[i];
        const std::size_t points = lane_.points.size();
        for (std::size_t i = 0; i < points; ++i) {
            const int frame = lane_.contact_frame_of[i];
            for (int j = 0; j < 3; ++j) impulses_[3 * frame + j][k] = s.contact.impulse[3 * i + j];
            found_.before[frame][k] = s.before[3 * i + 2];
            found_.after[frame][k] = s.contact.after[3 * i + 2];
        }
        for (std::size_t i = 0; i < lane_.turning_of.size(); ++i)
            for (int j = 0; j < 3; ++j)
                moments_[3 * lane_.contact_frame_of[lane_.turning_of[i]] + j][k] =
                    s.contact.impulse[3 * (points + i) + j];
        if (b_.out.constraint_impulses)
            std::copy(s.multipliers.begin(), s.multipliers.end(),
                      b_.out.constraint_impulses + (first_ + k) * s.multipliers.size());
    }

    void write() {
        const PackBits all = ~PackBits{};
        const std::size_t nv = model_.nv;
        write_rows(dv_, all, count_, row(b_.out.dv, nv));
        write_rows(impulse_, all, count_, row(b_.out.generalized_impulse, nv));
        if (b_.out.energy_change) {
            Pack energy{};
            for (int i = 0; i < model_.nv; ++i) energy += impulse_[i] * (v_[i] + 0.5 * dv_[i]);
            for (int k = 0; k < count_; ++k) b_.out.energy_change[first_ + k] = energy[k];
        }
        if (b_.out.v_after) {
            for (int i = 0; i < model_.nv; ++i) v_[i] += dv_[i];
            write_rows(v_, all, count_, row(b_.out.v_after, nv));
        }
    }

    // Compute the load of each joint, and the velocity changes of links.
    void load() {
        std::fill(tree_.wrench.begin(), tree_.wrench.end(), Spatial<Pack>{});
        for_wrenches<Pack>(scene_, tree_, rows_.contact_frames,
                           {given_.data(), multipliers_.data(), impulses_.data(), moments_.data()},
                           [&](int, const Site& site, const Spatial<Pack>& own) {
                               tree_.wrench[site.body] += own;
                           });
        tree_.move(dv_.data());
        tree_.load(tree_.twist, [&](int k) { return inertia_at(k); }, false);
        tree_.gather(impulse_.data());
        for (std::size_t j = 0; j < b_.joints.size() && b_.out.reactions; ++j)
            put(tree_.wrench[b_.joints[j]], b_.out.reactions, j, b_.joints.size());
        for (std::size_t j = 0; j < b_.links.size() && b_.out.bodies; ++j) {
            const Link& link = b_.links[j];
            put(at_centre(tree_, link, tree_.twist[link.body]), b_.out.bodies, j, b_.links.size());
        }
    }

    void put(const Spatial<Pack>& x, double* out, std::size_t j, std::size_t count) const {
        for (int k = 0; k < count_; ++k) {
            const double entries[6] = {get(x.linear.x, k),  get(x.linear.y, k),
                                       get(x.linear.z, k),  get(x.angular.x, k),
                                       get(x.angular.y, k), get(x.angular.z, k)};
            std::copy(entries, entries + 6, out + 6 * ((first_ + k) * count + j));
        }
    }

    const Batch& b_;
    const Scene& scene_;
    const Model& model_;
    Tree<Pack> tree_;
    KnownImpulses<Pack> known_;
    Rows<Pack> rows_;
    std::vector<Pack> q_, v_, given_, impulse_, dv_, M_;
    std::vector<Pack> impulses_, moments_, multipliers_;
    std::vector<std::pair<int, int>> units_;
    std::vector<Pack> q_before_;
    // Columns other than q change M and rows; q is that of the block before, and all made of it.
    bool places_vary_ = false, stays_ = false;
    bool by_articulated_ = false, needs_loads_ = false;
    int first_ = 0, count_ = 0;
    GivenState state_[kLanes];
    StateRows lane_;
    ImpactSolution solution_;
    std::vector<double> numbers_;
    PointCoefficients coefficients_;
    PackBits kept_{}, has_directions_{};  // lanes that are written
    ContactOutputs found_;
    Tree<double> lane_tree_;
    Derivation derivation_;
    ContactLanes contact_lanes_;
    ContactLanes::Lane lanes_[kLanes];
    std::vector<Pack> jumps_;
    std::vector<FramePairSlopes<double>> pairs_;
    std::vector<int> entries_;
    std::vector<double> weights_, slopes_;
};

// Pieces of a batch, handed to whoever asks; the first exception ends it.
struct Work {
    const Batch& batch;
    int blocks, piece;
    std::atomic<int> next{0}, done{0};
    std::mutex lock;
    std::exception_ptr error;

    void stop() {
        const std::lock_guard<std::mutex> guard(lock);
        if (!error) error = std::current_exception();
        next = blocks;
    }

    // Solve pieces until none is left. `look` of the calling thread, else null.
    void run(const std::function<void(int)>* on_progress) {
        try {
            Block block(batch);
            for (int begin; (begin = next.fetch_add(piece)) < blocks;) {
                const int end = std::min(begin + piece, blocks);
                for (int i = begin; i < end; ++i) block.solve(i);
                done += std::min(end * kLanes, batch.in.size) - begin * kLanes;
                if (on_progress) (*on_progress)(done);
            }
        } catch (...) {
            stop();
        }
    }
};

}  // namespace

void solve_rows(const Batch& batch, int threads, const std::function<void(int)>& on_progress) {
    const int blocks = (batch.in.size + kLanes - 1) / kLanes;
    threads = std::max(1, std::min(threads, blocks));
    Work work{batch, blocks, std::max(1, std::min(kPiece, blocks / threads)), {}, {}, {}, {}};
    std::vector<std::thread> others;
    try {
        for (int i = 1; i < threads; ++i) others.emplace_back([&] { work.run(nullptr); });
    } catch (...) {
        work.stop();
    }
    work.run(&on_progress);
    for (std::thread& other : others) other.join();
    if (work.error) std::rethrow_exception(work.error);
    on_progress(work.done);
}

}  // namespace impulsekit
