// Distance of two convex shapes, and its direction.
//
// The separation s(n) = −h_a(−n) − h_b(n) along unit normals n, from b to a, is largest where two
// shapes are nearest: there it is their distance, or minus the depth of their overlap. All is
// worked out in the frame of b's joint, on the cores; the radii around them are taken off.
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/candidates.hpp"
#include "geometry/patch.hpp"
#include "geometry/simplex.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit {
namespace {

using namespace convex;

constexpr int kMostSteps = 30, kMostRounds = 24;
// If shapes overlap, so many of the best guesses are followed to their ends.
constexpr int kMostStarts = 8;
// Guesses this near each other lead to the same end (cosine).
constexpr double kSameWay = 0.9;

// Corners of the same two parts become one, that moves along them.
void merge(Simplex& simplex) {
    Simplex found;
    for (int k = 0; k < simplex.count; ++k) {
        const Corner& corner = simplex.corners[k];
        int i = 0;
        while (i < found.count && (found.corners[i].one.number != corner.one.number ||
                                   found.corners[i].two.number != corner.two.number))
            ++i;
        if (i == found.count)
            found.corners[found.count++] = corner;
        else
            found.corners[i].weight += corner.weight;
    }
    simplex = found;
}

void tangents_of(const V& n, V& t, V& s) {
    const double x = std::abs(n.x), y = std::abs(n.y), z = std::abs(n.z);
    const V axis = x <= y && x <= z ? V{1, 0, 0} : y <= z ? V{0, 1, 0} : V{0, 0, 1};
    t = cross(n, axis);
    t = t * (1.0 / length(t));
    s = cross(n, t);
}

// One step of Newton's method on the conditions of the largest separation g: with corners
// y_k = x_k − x'_k of the parts that reach furthest and weights λ,
//     n·y_k = g,   t·Σ λ_k y_k = 0 for t across n,   Σ λ_k = 1.
// Gives what was left of them, and infinity where there is no step.
double newton_step(const Pair& pair, Simplex& simplex, V& n, double& g) {
    const int count = simplex.count, size = count + 3;
    V t[2];
    tangents_of(n, t[0], t[1]);
    double m[7][7] = {}, x[7] = {};
    V sum;
    for (int k = 0; k < count; ++k) {
        Corner& c = simplex.corners[k];
        c.one.point = pair.a.point_of(c.one.number, -n);
        c.two.point = pair.b.point_of(c.two.number, n);
        c.at = c.one.point - c.two.point;
        sum += c.at * c.weight;
        for (int i = 0; i < 2; ++i) {
            m[k][i] = m[count + i][3 + k] = dot(t[i], c.at);
            const V rate =
                pair.a.rate_of(c.one.number, -n, t[i]) + pair.b.rate_of(c.two.number, n, t[i]);
            for (int j = 0; j < 2; ++j) m[count + j][i] -= c.weight * dot(t[j], rate);
        }
        m[k][2] = -1.0;
        m[size - 1][3 + k] = pair.size;
        x[k] = g - dot(n, c.at);
        x[size - 1] -= pair.size * c.weight;
    }
    x[size - 1] += pair.size;
    for (int i = 0; i < 2; ++i) {
        m[count + i][i] -= dot(n, sum);
        x[count + i] = -dot(t[i], sum);
    }
    double left = 0.0;
    for (int i = 0; i < size; ++i) left = std::max(left, std::abs(x[i]));
    for (int i = 0; i < size; ++i) {
        for (int j = 0; j < size; ++j) m[i][j] /= pair.size;
        x[i] /= pair.size;
    }
    // Angles and weights are numbers; g is taken relative to the size.
    for (int i = 0; i < size; ++i) m[i][2] *= pair.size;
    if (!solve(m, x, size)) return std::numeric_limits<double>::infinity();
    n += t[0] * x[0] + t[1] * x[1];
    n = n * (1.0 / length(n));
    g += x[2] * pair.size;
    for (int k = 0; k < count; ++k) simplex.corners[k].weight += x[3 + k];
    return left;
}

// Digits of a guess to the end; false where the parts are others, or nothing converges.
bool sharpen(const Pair& pair, Simplex simplex, V n, V& normal, Simplex& found) {
    merge(simplex);
    while (simplex.count > 0) {
        Simplex own = simplex;
        V along = n;
        double g = dot(n, own.sum()), left = std::numeric_limits<double>::infinity();
        for (int k = 0; k < kMostSteps; ++k) {
            left = newton_step(pair, own, along, g);
            if (!(left > tolerance::sums * pair.size) || !std::isfinite(left)) break;
        }
        int least = 0;
        for (int k = 1; k < own.count; ++k)
            if (own.corners[k].weight < own.corners[least].weight) least = k;
        if (left <= 100.0 * tolerance::sums * pair.size &&
            own.corners[least].weight >= -tolerance::alike) {
            if (std::abs(pair.separation(along) - g) > tolerance::at_rest * (1.0 + pair.size))
                return false;
            normal = along, found = own;
            return true;
        }
        // A corner that pulls has no part in it.
        if (!std::isfinite(left)) {
            least = 0;
            for (int k = 1; k < simplex.count; ++k)
                if (simplex.corners[k].weight < simplex.corners[least].weight) least = k;
        }
        simplex.corners[least] = simplex.corners[--simplex.count];
    }
    return false;
}

struct Found {
    double separation = -std::numeric_limits<double>::infinity();
    V normal{0, 0, 1};
    Simplex simplex;
};

// From a guess to the largest separation around it: the shapes are moved apart along the normal
// found last, where their nearest points are well told, until it stays.
Found climb(const Pair& pair, const V& start) {
    Found best;
    best.normal = start, best.separation = pair.separation(start);
    for (int round = 0; round < kMostRounds; ++round) {
        const double apart = std::max(0.0, 0.1 * pair.size - best.separation);
        const V shift = best.normal * apart;
        const Simplex guess = nearest_simplex(pair, best.normal, shift);
        const V point = guess.sum() + shift;
        const double away = length(point);
        if (round == 0) best.simplex = guess;
        if (!(away > 0.0)) break;
        const V along = point * (1.0 / away);
        V sharp;
        Simplex own;
        if (sharpen(pair, guess, along, sharp, own)) {
            const double further = pair.separation(sharp);
            if (further >= best.separation - tolerance::at_rest) {
                if (further > best.separation) best.separation = further, best.normal = sharp;
                best.simplex = own;
                break;
            }
        }
        const double further = pair.separation(along);
        if (!(further > best.separation + tolerance::sums * pair.size)) {
            best.simplex = guess;
            break;
        }
        best.separation = further, best.normal = along, best.simplex = guess;
    }
    return best;
}

Pair pair_of(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb) {
    const Mat3<double>& r = pb.rotation;
    const Placement relative{
        {back(r, pa.rotation.x), back(r, pa.rotation.y), back(r, pa.rotation.z)},
        pb.back(pa.origin)};
    const double size = std::max(a.reach < b.reach ? a.reach : b.reach, tolerance::alike);
    return {{a, relative}, {b, {}}, a.radius + b.radius, size};
}

// Directions all around, in the axes of both joints: where shapes overlap there may be several
// ways out, of which the shortest counts.
void add_all_around(const Pair& pair, std::vector<Guess>& guesses) {
    for (int x = -1; x <= 1; ++x) {
        for (int y = -1; y <= 1; ++y) {
            for (int z = -1; z <= 1; ++z) {
                if (!(x || y || z)) continue;
                const V along =
                    V{1.0 * x, 1.0 * y, 1.0 * z} * (1.0 / std::sqrt(x * x + y * y + z * z));
                for (const V& n : {along, pair.a.at.rotation * along})
                    guesses.push_back({pair.separation(n), n});
            }
        }
    }
}

// Use what a climb found, if it is better; of as good ones the normal of the face before.
bool use(Found& found, const Found& own) {
    const bool better = own.separation > found.separation + tolerance::at_rest;
    if (better)
        found = own;
    else if (own.separation >= found.separation - tolerance::at_rest && found.simplex.count == 0)
        found.simplex = own.simplex;
    return better;
}

Found largest_separation(const Pair& pair, bool only_faces_and_edges) {
    std::vector<Guess> guesses;
    const bool polytopes =
        pair.a.shape.kind == Shape::polytope && pair.b.shape.kind == Shape::polytope;
    const Guess best = best_candidate(pair, polytopes, guesses);
    Found found;
    found.separation = best.separation, found.normal = best.normal;
    if (polytopes && only_faces_and_edges) return found;
    const V between = pair.a.at.act(pair.a.shape.centre) - pair.b.at.act(pair.b.shape.centre);
    const double away = length(between);
    Guess start{best.separation, best.normal};
    if (away > 0.0) {
        const Guess middle{pair.separation(between * (1.0 / away)), between * (1.0 / away)};
        guesses.push_back(middle);
        if (middle.separation > start.separation) start = middle;
    }
    use(found, climb(pair, start.normal));
    // Apart there is one largest separation alone, and of polytopes all are known.
    if (polytopes || found.separation > 0.0) return found;
    add_all_around(pair, guesses);
    std::sort(guesses.begin(), guesses.end(),
              [](const Guess& x, const Guess& y) { return x.separation > y.separation; });
    std::vector<V> started{start.normal};
    for (const Guess& guess : guesses) {
        if (static_cast<int>(started.size()) == kMostStarts) break;
        bool known = false;
        for (const V& n : started) known = known || dot(n, guess.normal) > kSameWay;
        if (known) continue;
        started.push_back(guess.normal);
        use(found, climb(pair, guess.normal));
    }
    return found;
}

}  // namespace

Nearest nearest(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb,
                bool by_faces_and_edges) {
    if (a.kind == Shape::half_space && b.kind != Shape::half_space) {
        const Nearest other = nearest(b, pb, a, pa);
        return {other.gap, -other.normal, other.on_other, other.on_first};
    }
    const Pair pair = pair_of(a, pa, b, pb);
    Nearest found;
    if (b.kind == Shape::half_space) {
        const V n = b.faces[0].normal;
        if (a.kind == Shape::half_space) {
            found.gap = -std::numeric_limits<double>::infinity();
            found.normal = pb.rotation * n;
            return found;
        }
        Part low;
        found.gap = -pair.a.reach(-n, low) - b.faces[0].offset - pair.around;
        found.normal = pb.rotation * n;
        found.on_first = pb.act(low.point - n * a.radius);
        found.on_other = found.on_first - found.normal * found.gap;
        return found;
    }
    const Found own = largest_separation(pair, by_faces_and_edges);
    found.gap = own.separation - pair.around;
    V one, two;
    for (int k = 0; k < own.simplex.count; ++k) {
        const Corner& c = own.simplex.corners[k];
        one += c.one.point * c.weight;
        two += c.two.point * c.weight;
    }
    // A point alone that reaches furthest is told by the normal, beside a face to all digits; where
    // nothing else is known, of several one of the body that has fewer.
    const double level = tolerance::alike * pair.size;
    V own_ends[2], other_ends[2];
    const int count = pair.a.count_furthest(-own.normal, level, own_ends),
              other_count = pair.b.count_furthest(own.normal, level, other_ends);
    const bool unknown = own.simplex.count == 0;
    Part part;
    if (unknown && count == 2 && other_count == 2) {
        // Two edges, where they cross as seen along the normal.
        const V along = own_ends[1] - own_ends[0], across = other_ends[1] - other_ends[0];
        const V turn = cross(along, across);
        const double square = dot(turn, turn);
        const double s =
            square > 0.0 ? dot(cross(other_ends[0] - own_ends[0], across), turn) / square : 0.0;
        one = own_ends[0] + along * std::min(std::max(s, 0.0), 1.0);
        two = one - own.normal * own.separation;
    } else if (count == 1 || (unknown && count <= other_count)) {
        pair.a.reach(-own.normal, part);
        one = part.point, two = one - own.normal * own.separation;
    } else if (other_count == 1 || unknown) {
        pair.b.reach(own.normal, part);
        two = part.point, one = two + own.normal * own.separation;
    }
    const V middle = (one - own.normal * a.radius + two + own.normal * b.radius) * 0.5;
    found.normal = pb.rotation * own.normal;
    found.on_first = pb.act(middle) + found.normal * (0.5 * found.gap);
    found.on_other = pb.act(middle) - found.normal * (0.5 * found.gap);
    return found;
}

double least_distance(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb,
                      double enough) {
    const V away = pa.act(a.centre) - pb.act(b.centre);
    const double bound = length(away) - a.reach - b.reach;
    if (bound > enough || a.kind == Shape::half_space || b.kind == Shape::half_space) return bound;
    const Pair pair = pair_of(a, pa, b, pb);
    const V start = length(away) > 0.0 ? back(pb.rotation, away) : V{0, 0, 1};
    const V point = nearest_simplex(pair, start, {}, enough + pair.around).sum();
    const double further = length(point);
    return further > 0.0 ? pair.separation(point * (1.0 / further)) - pair.around : bound;
}

double distance(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb,
                double enough) {
    if (std::isfinite(enough)) {
        const double bound = least_distance(a, pa, b, pb, enough);
        if (bound > enough) return bound;
    }
    return nearest(a, pa, b, pb).gap;
}

void separate(const Shape& a, const Placement& pa, const Shape& b, const Placement& pb, double& gap,
              V& normal) {
    const Pair pair = pair_of(a, pa, b, pb);
    const Found own = largest_separation(pair, true);
    gap = own.separation - pair.around, normal = own.normal;
}

}  // namespace impulsekit
