#include "derivatives.hpp"

#include <algorithm>

#include "rows.hpp"
#include "tree.hpp"

namespace impulsekit {
namespace {

// Directions that pass through the tree side by side.
constexpr int kWidth = 8;
using Number8 = Dual<kWidth>;

// q as numbers whose slopes are along some directions of its tangent, from `first` on.
class Seeds {
  public:
    Seeds(const Model& model, const double* q, int first) : q_(model.nq), first_(first) {
        for (int i = 0; i < model.nq; ++i) q_[i].value = q[i];
        for (std::size_t k = 1; k < model.bodies.size(); ++k)
            move(model.bodies[k], model.slots[model.bodies[k].slot].v);
    }

    const Number8* data() const { return q_.data(); }

  private:
    // Entry i of q changes by x with degree of freedom v.
    void set(int i, int v, double x) {
        if (v >= first_ && v < first_ + kWidth) q_[i].slope[v - first_] = x;
    }

    void move(const Body& body, int v) {
        const int i = body.q;
        switch (body.joint) {
            case Joint::circle:
                turn(i, v);
                break;
            case Joint::ball:
                roll(i, v);
                break;
            case Joint::free:
                roll(i + 3, v + 3);
                shift(i, v,
                      of_quaternion(q_[i + 3].value, q_[i + 4].value, q_[i + 5].value,
                                    q_[i + 6].value));
                break;
            case Joint::planar: {
                const double c = q_[i + 2].value, s = q_[i + 3].value;
                set(i, v, c);
                set(i + 1, v, s);
                set(i, v + 1, -s);
                set(i + 1, v + 1, c);
                turn(i + 2, v + 2);
                break;
            }
            default:
                for (int d = 0; d < body.freedoms; ++d) set(i + d, v + d, 1.0);
        }
    }

    // Cosine and sine of an angle.
    void turn(int i, int v) {
        set(i, v, -q_[i + 1].value);
        set(i + 1, v, q_[i].value);
    }

    // q ⊗ (ω/2, 0).
    void roll(int i, int v) {
        const double x = 0.5 * q_[i].value, y = 0.5 * q_[i + 1].value, z = 0.5 * q_[i + 2].value,
                     w = 0.5 * q_[i + 3].value;
        const double rates[3][4] = {{w, z, -y, -x}, {-z, w, x, -y}, {y, -x, w, -z}};
        for (int d = 0; d < 3; ++d)
            for (int j = 0; j < 4; ++j) set(i + j, v + d, rates[d][j]);
    }

    void shift(int i, int v, const Mat3<double>& turn) {
        const Vec3<double> columns[3] = {turn.x, turn.y, turn.z};
        for (int d = 0; d < 3; ++d) {
            set(i, v + d, columns[d].x);
            set(i + 1, v + d, columns[d].y);
            set(i + 2, v + d, columns[d].z);
        }
    }

    std::vector<Number8> q_;
    int first_;
};

// A blow as rows against the world.
Pair pair_of(const Blow& blow) {
    Pair pair;
    pair.first = blow.site;
    pair.carrier = blow.is_local ? Carrier::first : Carrier::world;
    return pair;
}

// Eight directions of all derivatives.
class Pass {
  public:
    Pass(const Scene& scene, const double* q, const GivenState& given, int first)
        : scene_(scene),
          nv_(scene.model->nv),
          first_(first),
          tree_(*scene.model),
          rows_(scene),
          seeds_(*scene.model, q, first),
          still_(nv_) {
        tree_.place(seeds_.data());
        rows_.fill(tree_, seeds_.data(), still_.data(), &given);
    }

    void write(DerivedRows& to) {
        if (first_ == 0) count(to);
        int row = 0;
        const auto add = [&](const Number8* rows, int count) {
            keep(rows, count * nv_, to.G, to.dG, row * nv_, to.rows * nv_);
            row += count;
        };
        for (const Blow& blow : scene_.blows) add(rows_.rows_of(tree_, pair_of(blow)).data(), 6);
        for (int v : scene_.kicks) {
            std::vector<Number8> unit(nv_);
            unit[v].value = 1.0;
            add(unit.data(), 1);
        }
        add(rows_.A.data(), scene_.rows());
        int point = 0;
        for (std::size_t i = 0; i < rows_.touches.size(); ++i) {
            if (!rows_.touches[i].touches[0]) continue;
            add(rows_.J.data() + 3 * i * nv_, 3);
            const Mat3<Number8>& r = rows_.touches[i].axes;
            const Number8 axes[9] = {r.x.x, r.y.x, r.z.x, r.x.y, r.y.y, r.z.y, r.x.z, r.y.z, r.z.z};
            keep(axes, 9, to.axes, to.daxes, 9 * point++, static_cast<int>(to.axes.size()));
        }
    }

  private:
    void count(DerivedRows& to) const {
        for (const auto& touch : rows_.touches)
            if (touch.touches[0]) to.entries.push_back(touch.entry);
        const int points = static_cast<int>(to.entries.size());
        to.rows = static_cast<int>(6 * scene_.blows.size() + scene_.kicks.size()) + scene_.rows() +
                  3 * points;
        to.G.resize(to.rows * nv_);
        to.dG.resize(nv_ * to.rows * nv_);
        to.axes.resize(9 * points);
        to.daxes.resize(nv_ * 9 * points);
    }

    // Values and slopes of an array that begins at an entry of one of a size.
    void keep(const Number8* from, int count, std::vector<double>& value,
              std::vector<double>& slope, int at, int size) const {
        const int width = std::min(kWidth, nv_ - first_);
        for (int i = 0; i < count; ++i) {
            value[at + i] = from[i].value;
            for (int d = 0; d < width; ++d) slope[(first_ + d) * size + at + i] = from[i].slope[d];
        }
    }

    const Scene& scene_;
    const int nv_, first_;
    Tree<Number8> tree_;
    Rows<Number8> rows_;
    Seeds seeds_;
    std::vector<Number8> still_;
};

}  // namespace

DerivedRows derive_rows(const Scene& scene, const double* q, const GivenState& given) {
    DerivedRows found;
    Tree<double> tree(*scene.model);
    tree.place(q);
    tree.weigh();
    found.M.resize(scene.model->nv * scene.model->nv);
    tree.mass_matrix(found.M.data());
    for (int first = 0; first < std::max(scene.model->nv, 1); first += kWidth)
        Pass(scene, q, given, first).write(found);
    return found;
}

std::vector<double> momentum_by_q(const Model& model, const double* q, const double* x) {
    const int nv = model.nv;
    std::vector<double> found(nv * nv);
    std::vector<Number8> speeds(nv), along(nv);
    for (int i = 0; i < nv; ++i) speeds[i].value = x[i];
    Tree<Number8> tree(model);
    for (int first = 0; first < nv; first += kWidth) {
        tree.place(Seeds(model, q, first).data());
        tree.move(speeds.data());
        for (int k = 1; k < tree.count(); ++k)
            tree.wrench[k] = tree.in_world(k, inertia_of<Number8>(model.bodies[k])) * tree.twist[k];
        tree.gather(along.data());
        for (int d = 0; d < std::min(kWidth, nv - first); ++d)
            for (int i = 0; i < nv; ++i) found[(first + d) * nv + i] = along[i].slope[d];
    }
    return found;
}

std::vector<double> inertia_regressor(const Model& model, const double* q, const double* x,
                                      int body) {
    Tree<double> tree(model);
    tree.place(q);
    tree.move(x);
    const Mat3<double> own = mat3<double>(model.bodies[body].turn);
    const Vec3<double> across[3] = {
        {own.x.x, own.y.x, own.z.x}, {own.x.y, own.y.y, own.z.y}, {own.x.z, own.y.z, own.z.z}};
    const Mat3<double>& r = tree.rotation[body];
    const Mat3<double> joint{r * across[0], r * across[1], r * across[2]};
    const Vec3<double> a = back(joint, tree.twist[body].linear),
                       w = back(joint, tree.twist[body].angular);
    const Vec3<double> unit[3] = {{1.0, 0.0, 0.0}, {0.0, 1.0, 0.0}, {0.0, 0.0, 1.0}};
    // I = Σ of these: xx, xy, yy, xz, yz, zz.
    const Sym3<double> shapes[6] = {{1, 0, 0, 0, 0, 0}, {0, 1, 0, 0, 0, 0}, {0, 0, 0, 1, 0, 0},
                                    {0, 0, 1, 0, 0, 0}, {0, 0, 0, 0, 1, 0}, {0, 0, 0, 0, 0, 1}};
    std::vector<double> found(10 * model.nv), along(model.nv);
    for (int k = 0; k < 10; ++k) {
        Spatial<double> momentum;
        if (k == 0)
            momentum.linear = a;
        else if (k < 4)
            momentum = {cross(w, unit[k - 1]), cross(unit[k - 1], a)};
        else
            momentum.angular = shapes[k - 4] * w;
        std::fill(tree.wrench.begin(), tree.wrench.end(), Spatial<double>{});
        tree.wrench[body] = {joint * momentum.linear, joint * momentum.angular};
        tree.gather(along.data());
        for (int i = 0; i < model.nv; ++i) found[10 * i + k] = along[i];
    }
    return found;
}

}  // namespace impulsekit
