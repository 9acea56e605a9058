#include "contact/islands.hpp"

#include <algorithm>

#include "linalg/arena.hpp"

namespace impulsekit {

int find_islands(const double* W, int rows, const int* owner, int* island) {
    Arena::Scope scope(scratch());
    int *queue = scratch().allocate_int(rows), count = 0;
    std::fill(island, island + rows, -1);
    for (int start = 0; start < rows; ++start) {
        if (island[start] >= 0 || owner[start] < 0) continue;
        int waiting = 1;
        queue[0] = start;
        island[start] = count;
        while (waiting > 0) {
            const int r = queue[--waiting];
            for (int c = 0; c < rows; ++c) {
                if (island[c] >= 0 || owner[c] < 0) continue;
                if (W[r * rows + c] == 0.0 && owner[c] != owner[r]) continue;
                island[c] = count;
                queue[waiting++] = c;
            }
        }
        ++count;
    }
    return count;
}

RestIsland::RestIsland(const RestProblem& p, const int* island, int number) {
    Arena& arena = scratch();
    const int n = p.points, whole = p.rows(), sliding = n + 2 * p.turning;
    int *of_reach = arena.allocate_int(sliding), *turning_of = arena.allocate_int(p.turning),
        *own = arena.allocate_int(n), count = 0, groups = 0;
    rows = arena.allocate_int(whole), points = arena.allocate_int(n);
    for (int r = 0; r < whole; ++r)
        if (island[r] == number) rows[count++] = r;
    for (int i = 0; i < n; ++i) {
        if (island[3 * i] != number) continue;
        own[i] = problem.points;
        points[problem.points++] = of_reach[groups++] = i;
    }
    for (int k = 0; k < p.turning; ++k) {
        if (island[3 * (n + k)] != number) continue;
        turning_of[problem.turning++] = own[p.turning_of[k]];
        for (int j = 0; j < 2; ++j) of_reach[groups++] = n + 2 * k + j;
    }
    problem.joints = count - 3 * (problem.points + problem.turning);
    problem.turning_of = turning_of;
    double *W = arena.allocate(count, count), *b = arena.allocate(count);
    for (int i = 0; i < count; ++i) {
        b[i] = p.b[rows[i]];
        for (int j = 0; j < count; ++j) W[i * count + j] = p.W[rows[i] * whole + rows[j]];
    }
    problem.W = W, problem.b = b;
    double *reach = arena.allocate(groups), *direction = arena.allocate(2 * groups);
    for (int i = 0; i < groups; ++i) {
        reach[i] = p.reach[of_reach[i]];
        std::copy_n(p.direction + 2 * of_reach[i], 2, direction + 2 * i);
    }
    problem.reach = reach, problem.direction = direction;
    double *load = arena.allocate(problem.points), *bound = arena.allocate(problem.joints);
    for (int i = 0; i < problem.points && p.load; ++i) load[i] = p.load[points[i]];
    for (int j = 0; j < problem.joints; ++j)
        bound[j] = p.bound[rows[count - problem.joints + j] - 3 * (n + p.turning)];
    problem.load = p.load ? load : nullptr, problem.bound = bound;
}

}  // namespace impulsekit
