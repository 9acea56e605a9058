// What a batch says of the contacts of eight states, by entry of the scene.
#pragma once

#include <limits>
#include <vector>

#include "impact/scene_impact.hpp"

namespace impulsekit {

// Write the rows of some of the first `count` lanes, where they are asked for.
inline void write_rows(const std::vector<Pack>& x, const PackBits& lanes, int count, double* out) {
    const std::size_t width = x.size();
    for (int k = 0; k < count && out; ++k, out += width)
        for (std::size_t i = 0; i < width && lanes[k]; ++i) out[i] = x[i][k];
}

class ContactOutputs {
  public:
    std::vector<Pack> before, after;  // u_n of each contact frame

    explicit ContactOutputs(const Scene& scene) : scene_(scene) {}

    // The gap of the lowest of its points; NaN where none touches.
    void write_gaps(const std::vector<ContactFrame<Pack>>& frames, const PackBits& lanes, int count,
                    double* out) {
        if (!out) return;
        gaps_.assign(scene_.contacts.size(),
                     number<Pack>(std::numeric_limits<double>::quiet_NaN()));
        for (const ContactFrame<Pack>& frame : frames) {
            Pack& least = gaps_[frame.entry];
            least = closed(frame) & ~(least <= frame.gap) ? frame.gap : least;
        }
        write_rows(gaps_, lanes, count, out);
    }

    // The impulse in world axes (of a stop along its coordinate), from those of the frames; and of
    // the points that carry one the mean u_n before and after, and the sum of P_n.
    void write(const std::vector<ContactFrame<Pack>>& frames, const Pack* impulses,
               const PackBits& lanes, int count, double* sums, double* normals) {
        if (!sums && !normals) return;
        const std::size_t n = scene_.contacts.size();
        sums_.assign(3 * n, Pack{});
        normals_.assign(3 * n, Pack{});
        loaded_.assign(n, Pack{});
        for (std::size_t i = 0; i < frames.size(); ++i) add(frames[i], impulses + 3 * i, i, lanes);
        for (std::size_t e = 0; e < n; ++e) {
            const Pack share = loaded_[e] > 0.0 ? 1.0 / loaded_[e] : Pack{};
            normals_[3 * e] *= share;
            normals_[3 * e + 1] *= share;
        }
        write_rows(sums_, lanes, count, sums);
        write_rows(normals_, lanes, count, normals);
    }

  private:
    static PackBits closed(const ContactFrame<Pack>& frame) {
        PackBits lanes;
        for (int k = 0; k < kLanes; ++k) lanes[k] = -frame.closed[k];
        return lanes;
    }

    void add(const ContactFrame<Pack>& frame, const Pack* P, std::size_t i, const PackBits& lanes) {
        const PackBits touches = lanes & closed(frame);
        const PackBits bears = touches & ((P[0] != 0.0) | (P[1] != 0.0) | (P[2] != 0.0));
        const auto add_in = [](const PackBits& in, Pack& to, const Pack& more) {
            to = in ? to + more : to;
        };
        const Vec3<Pack> world = world_impulse(scene_, frame, Vec3<Pack>{P[0], P[1], P[2]});
        Pack *sum = sums_.data() + 3 * frame.entry, *normal = normals_.data() + 3 * frame.entry;
        add_in(touches, sum[0], world.x);
        add_in(touches, sum[1], world.y);
        add_in(touches, sum[2], world.z);
        add_in(bears, normal[0], before[i]);
        add_in(bears, normal[1], after[i]);
        add_in(bears, normal[2], P[2]);
        add_in(bears, loaded_[frame.entry], number<Pack>(1.0));
    }

    const Scene& scene_;
    std::vector<Pack> gaps_, sums_, normals_, loaded_;
};

}  // namespace impulsekit
