// Known impulses on a tree without rows: M Δv = I in O(n), for one state or eight side by side.
#pragma once

#include <algorithm>
#include <vector>

#include "scene/blows.hpp"
#include "spatial/articulated.hpp"

namespace impulsekit {

// Scratch of a scene whose blows and kicks in joints have these numbers, six of each blow and then
// those in joints. One per thread.
template <typename S>
class KnownImpulses {
  public:
    ArticulatedTree<S> tree;

    explicit KnownImpulses(const Scene& scene)
        : tree(*scene.model),
          scene_(scene),
          model_(*scene.model),
          struck_(model_.bodies.size(), 0),
          turned_(model_.bodies.size(), 0),
          rotation_(model_.bodies.size()),
          tau_(model_.nv) {
        for (const Blow& blow : scene.blows) {
            mark(struck_, blow.site.body);
            if (!blow.is_local) mark(turned_, blow.site.body);
        }
        for (const Slot& slot : model_.slots)
            if (std::find(scene.kicks.begin(), scene.kicks.end(), slot.v) != scene.kicks.end())
                mark(struck_, slot.body);
        const S one = S{} + 1.0, zero{};
        rotation_[0] = {{one, zero, zero}, {zero, one, zero}, {zero, zero, one}};
    }

    // Leave out the branches at the world that no impulse reaches.
    void leave_out_others() {
        std::vector<char> reached(model_.bodies.size(), 0);
        tree.bodies.clear();
        for (int k = 1; k < tree.count(); ++k) {
            const int parent = model_.bodies[k].parent;
            reached[k] = parent > 0 ? reached[parent] : struck_[k];
            if (reached[k]) tree.bodies.push_back(k);
        }
    }

    // Place bodies at q (nq), with their own inertias.
    void place(const S* q) {
        tree.place(q);
        for (int k : tree.bodies)
            if (turned_[k])
                rotation_[k] =
                    turned_on(rotation_[model_.bodies[k].parent], model_.bodies[k], tree.stance[k]);
    }

    // Δv (nv) of what is reached, after `tree.factor`.
    void respond(const S* numbers, S* dv) {
        take(numbers);
        tree.respond(struck_.data(), tau_.data(), dv);
    }

    // I = τ + Jᵀp (nv).
    void collect(const S* numbers, S* impulse) {
        take(numbers);
        tree.collect(struck_.data(), tau_.data(), impulse);
    }

  private:
    void mark(std::vector<char>& on_the_way, int body) const {
        for (int k = body; k > 0; k = model_.bodies[k].parent) on_the_way[k] = 1;
    }

    void take(const S* numbers) {
        std::fill(tree.wrench.begin(), tree.wrench.end(), Spatial<S>{});
        for (const Blow& blow : scene_.blows) {
            tree.wrench[blow.site.body] +=
                wrench_of(blow, numbers, rotation_[blow.site.body], true);
            numbers += 6;
        }
        std::fill(tau_.begin(), tau_.end(), S{});
        for (int v : scene_.kicks) tau_[v] += *numbers++;
    }

    const Scene& scene_;
    const Model& model_;
    std::vector<char> struck_, turned_;  // bodies that carry a blow on, in the world's axes
    std::vector<Mat3<S>> rotation_;      // in the world, of those
    std::vector<S> tau_;
};

// Δv (nv) at q (nq) of what the impulses reach; the rest is left as it is.
void solve_known(KnownImpulses<double>& known, const double* q, const double* numbers, double* dv);

}  // namespace impulsekit
