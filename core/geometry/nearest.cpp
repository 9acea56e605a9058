// Distance of two convex shapes, and its direction.
//
// The separation s(n) = −h_a(−n) − h_b(n) along unit normals n, from b to a, is largest where two
// shapes are nearest: there it is their distance, or minus the depth of their overlap. All is
// worked out in the frame of b's joint, on the cores; the radii around them are taken off.
#include <algorithm>
#include <array>
#include <cmath>

#include "geometry/patch.hpp"
#include "linalg/tolerances.hpp"

namespace impulsekit {
namespace {

using V = Vec3<double>;

// First guesses need no more digits than Newton's method takes to converge.
constexpr double kGuess = 1e-7;
constexpr int kMostSupports = 60, kMostSteps = 30, kMostRounds = 24;
// If shapes overlap, so many of the best guesses are followed to their ends.
constexpr int kMostStarts = 8;
// Guesses this near each other lead to the same end (cosine).
constexpr double kSameWay = 0.9;

double length(const V& a) { return std::sqrt(dot(a, a)); }

// A part of a core that reaches furthest: a corner, a rim or the whole ellipsoid.
struct Part {
    int number = 0;  // among points, then circles; the ellipsoid is 0
    V point;
};

// A core somewhere: directions and points go through its placement.
struct Core {
    const Shape& shape;
    Placement at;

    double reach(const V& direction, Part& part) const {
        const V d = back(at.rotation, direction);
        const int count = static_cast<int>(shape.points.size());
        double best = -std::numeric_limits<double>::infinity();
        for (int i = 0; i < count; ++i) {
            const double height = dot(shape.points[i], d);
            if (height > best) best = height, part.number = i;
        }
        if (!shape.circles.empty()) {
            const V out = d - shape.axis * dot(d, shape.axis);
            const double sine = length(out);
            for (int i = 0; i < static_cast<int>(shape.circles.size()); ++i) {
                const auto& c = shape.circles[i];
                const double height = dot(c.centre, d) + c.radius * sine;
                if (height > best) best = height, part.number = count + i;
            }
        }
        if (shape.kind == Shape::ellipsoid) part.number = 0;
        part.point = point_of(part.number, direction);
        return dot(part.point, direction);
    }

    // Count the points that reach furthest along a direction, within `level`; the first and the
    // last.
    int count_furthest(const V& direction, double level, V* ends) const {
        if (shape.kind == Shape::ellipsoid) return 1;
        const V d = back(at.rotation, direction);
        const V out = d - shape.axis * dot(d, shape.axis);
        const double sine = length(out);
        const V along = sine > 0.0 ? out * (1.0 / sine) : shape.across;
        double best = -std::numeric_limits<double>::infinity();
        int count = 0;
        const auto each = [&](const auto& use_point) {
            for (const V& p : shape.points) use_point(p);
            for (const auto& c : shape.circles)
                for (double sign : {1.0, -1.0}) use_point(c.centre + along * (sign * c.radius));
        };
        each([&](const V& p) { best = std::max(best, dot(p, d)); });
        each([&](const V& p) {
            if (dot(p, d) >= best - level) ends[count++ > 0] = at.act(p);
        });
        return count;
    }

    // The point of one part that reaches furthest.
    V point_of(int number, const V& direction) const {
        const int count = static_cast<int>(shape.points.size());
        if (shape.kind != Shape::ellipsoid && number < count) return at.act(shape.points[number]);
        const V d = back(at.rotation, direction);
        if (shape.kind == Shape::ellipsoid) {
            const V across = back(shape.axes, d);
            return at.act(shape.centre + shape.axes * (across * (1.0 / length(across))));
        }
        const auto& c = shape.circles[number - count];
        const V out = d - shape.axis * dot(d, shape.axis);
        const double sine = length(out);
        return at.act(c.centre + (sine > 0.0 ? out * (c.radius / sine) : shape.across * c.radius));
    }

    // H t, how fast that point moves as the direction turns by t.
    V rate_of(int number, const V& direction, const V& t) const {
        const int count = static_cast<int>(shape.points.size());
        if (shape.kind != Shape::ellipsoid && number < count) return {};
        const V d = back(at.rotation, direction), turn = back(at.rotation, t);
        if (shape.kind == Shape::ellipsoid) {
            const V across = back(shape.axes, d), rate = back(shape.axes, turn);
            const double size = length(across);
            const V along = across * (dot(across, rate) / (size * size));
            return at.rotation * (shape.axes * ((rate - along) * (1.0 / size)));
        }
        const V out = d - shape.axis * dot(d, shape.axis);
        const double sine = length(out);
        if (!(sine > 0.0)) return {};
        const V side = cross(shape.axis, out * (1.0 / sine));
        const double share = shape.circles[number - count].radius * dot(side, turn) / sine;
        return at.rotation * (side * share);
    }
};

struct Pair {
    Core a, b;
    double around, size;

    double separation(const V& n) const {
        Part one, two;
        return -a.reach(-n, one) - b.reach(n, two);
    }
};

// A point of the difference of two cores, and its weight.
struct Corner {
    Part one, two;
    V at;
    double weight = 0.0;
};

struct Simplex {
    std::array<Corner, 4> corners;
    int count = 0;

    V sum() const {
        V found;
        for (int k = 0; k < count; ++k) found += corners[k].at * corners[k].weight;
        return found;
    }
};

// Solve a small system with row exchanges; false where it is singular.
template <int N>
bool solve(double (&m)[N][N], double (&x)[N], int n) {
    for (int k = 0; k < n; ++k) {
        int best = k;
        for (int i = k + 1; i < n; ++i)
            if (std::abs(m[i][k]) > std::abs(m[best][k])) best = i;
        if (!(std::abs(m[best][k]) > tolerance::rounding)) return false;
        for (int j = 0; j < n; ++j) std::swap(m[k][j], m[best][j]);
        std::swap(x[k], x[best]);
        for (int i = k + 1; i < n; ++i) {
            const double f = m[i][k] / m[k][k];
            for (int j = k; j < n; ++j) m[i][j] -= f * m[k][j];
            x[i] -= f * x[k];
        }
    }
    for (int k = n - 1; k >= 0; --k) {
        for (int j = k + 1; j < n; ++j) x[k] -= m[k][j] * x[j];
        x[k] /= m[k][k];
    }
    return true;
}

// Weights of the point nearest to −shift among the hull of some corners; corners without go.
void reduce(Simplex& simplex, const V& shift) {
    double best = std::numeric_limits<double>::infinity();
    Simplex found = simplex;
    for (int set = 1; set < 1 << simplex.count; ++set) {
        Simplex own;
        for (int k = 0; k < simplex.count; ++k)
            if (set >> k & 1) own.corners[own.count++] = simplex.corners[k];
        double m[3][3], x[3];
        const V base = own.corners[0].at + shift;
        double scale = 0.0;
        for (int i = 1; i < own.count; ++i) {
            const V e = own.corners[i].at - own.corners[0].at;
            scale = std::max(scale, dot(e, e));
        }
        for (int i = 1; i < own.count; ++i) {
            const V e = own.corners[i].at - own.corners[0].at;
            for (int j = 1; j < own.count; ++j)
                m[i - 1][j - 1] = dot(e, own.corners[j].at - own.corners[0].at) / scale;
            x[i - 1] = -dot(e, base) / scale;
        }
        if (!solve(m, x, own.count - 1)) continue;
        double rest = 1.0;
        bool inside = true;
        for (int i = 1; i < own.count; ++i) {
            own.corners[i].weight = x[i - 1];
            rest -= x[i - 1];
            inside = inside && x[i - 1] >= 0.0;
        }
        own.corners[0].weight = rest;
        if (!inside || rest < 0.0) continue;
        const V point = own.sum() + shift;
        // Among equally near ones that with fewer corners.
        if (dot(point, point) < best * (1.0 - tolerance::sums))
            best = dot(point, point), found = own;
    }
    simplex = found;
}

Corner corner_along(const Pair& pair, const V& n) {
    Corner found;
    pair.a.reach(-n, found.one);
    pair.b.reach(n, found.two);
    found.at = found.one.point - found.two.point;
    return found;
}

// The point of the difference of the cores nearest to −shift, up to a guess's digits
// (Gilbert, Johnson & Keerthi 1988); sooner where the distance is known to be above or below one
// that is given.
Simplex nearest_simplex(const Pair& pair, const V& n, const V& shift,
                        double enough = std::numeric_limits<double>::quiet_NaN()) {
    Simplex simplex;
    simplex.corners[0] = corner_along(pair, n);
    simplex.corners[0].weight = 1.0;
    simplex.count = 1;
    for (int k = 0; k < kMostSupports; ++k) {
        const V point = simplex.sum() + shift;
        const double away = length(point);
        if (!(away > tolerance::sums * pair.size) || away <= enough) break;
        const V along = point * (1.0 / away);
        const Corner next = corner_along(pair, along);
        const double least = dot(next.at + shift, along);
        if (away - least <= kGuess * away || least > enough) break;
        bool known = false;
        for (int i = 0; i < simplex.count; ++i) {
            const V same = simplex.corners[i].at - next.at;
            known = known || dot(same, same) == 0.0;
        }
        if (known || simplex.count == 4) break;
        simplex.corners[simplex.count++] = next;
        const Simplex before = simplex;
        reduce(simplex, shift);
        if (simplex.count == 0) return before;
    }
    return simplex;
}

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

// True if two numbers are on either side of zero, or one is zero but for rounding.
bool opposite(double x, double y) {
    return !(x > tolerance::parallel && y > tolerance::parallel) &&
           !(x < -tolerance::parallel && y < -tolerance::parallel);
}

// The edges of a polytope: along each, and the normals of the faces to its left and right.
struct Ridge {
    V along, left, right;
};
std::vector<Ridge> ridges_of(const Core& core) {
    std::vector<Ridge> found;
    for (const Shape::Edge& e : core.shape.edges) {
        const V along = core.shape.points[e.end] - core.shape.points[e.start];
        const V left = core.shape.faces[e.left].normal;
        const V right = e.right < 0 ? -left : core.shape.faces[e.right].normal;
        const Mat3<double>& turn = core.at.rotation;
        found.push_back({turn * (along * (1.0 / length(along))), turn * left, turn * right});
    }
    return found;
}

// Every normal of a face of either, and those on which two edges cross. Of two polytopes these are
// the edges that make a face of the difference of both: the arcs from the left to the right normal
// of one and, turned round, of the other cross (Gregorius 2013).
template <typename Use>
void for_candidates(const Pair& pair, const Use& use) {
    for (const V& axis : pair.b.shape.face_axes) use(axis, true);
    for (const V& axis : pair.a.shape.face_axes) use(pair.a.at.rotation * axis, true);
    const auto cross_edges = [&](const V& e, const V& f) {
        const V turn = cross(e, f);
        const double sine = length(turn);
        if (sine > tolerance::parallel) use(turn * (1.0 / sine), false);
    };
    if (pair.a.shape.kind == Shape::polytope && pair.b.shape.kind == Shape::polytope) {
        const std::vector<Ridge> others = ridges_of(pair.b);
        for (const Ridge& e : ridges_of(pair.a)) {
            for (const Ridge& f : others) {
                const double left = dot(f.left, e.along), right = dot(e.right, f.along);
                if (opposite(left, dot(f.right, e.along)) &&
                    opposite(dot(e.left, f.along), right) && opposite(left, right))
                    cross_edges(e.along, f.along);
            }
        }
        return;
    }
    for (const V& e : pair.a.shape.edge_axes)
        for (const V& f : pair.b.shape.edge_axes) cross_edges(pair.a.at.rotation * e, f);
}

struct Guess {
    double separation;
    V normal;
};

// The best of all candidates; of faces as good as edges the face. All are kept in `guesses`.
Guess best_candidate(const Pair& pair, std::vector<Guess>* guesses) {
    Guess best{-std::numeric_limits<double>::infinity(), {0, 0, 1}};
    const auto use = [&](const V& axis, bool of_face) {
        for (double sign : {1.0, -1.0}) {
            const Guess own{pair.separation(axis * sign), axis * sign};
            if (guesses) guesses->push_back(own);
            if (own.separation > best.separation + (of_face ? 0.0 : tolerance::at_rest)) best = own;
        }
    };
    for_candidates(pair, use);
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
    const Guess best = best_candidate(pair, polytopes ? nullptr : &guesses);
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
