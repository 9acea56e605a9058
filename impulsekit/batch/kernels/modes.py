"""Newton on the modes of several contacts: parts, sticks or slides (``impact.laws.modes``).

0 ≤ P_n − f ⊥ ξ_n ≥ 0 with Coulomb's friction; f is 0, or what an expansion asks for at least.
"""

from __future__ import annotations

import math

import numpy as np

from .dense import gauss, gauss_of_rank
from .jit import built_in

__all__ = ["BAR", "MOST_STEPS", "RIDGE", "SLIDES", "polish", "residual_of"]

# As in ``impact.laws.modes``.
MOST_STEPS = 12
RIDGE = 1e-9
# Nearer than this the ridge is left out: what is redundant would drift by rounding over it, out
# of its cones and back. Pivots below this share are then none.
NEAR = 1e-3
DEPENDENT = 1e-10
BAR = 1e-10
DEEP = 1e-13
RISES = 3
# Parts; sticks; slides; the same two with P_n held at f.
PARTS, STICKS, SLIDES, STICKS_AT_FLOOR, SLIDES_AT_FLOOR = 0, 1, 2, 3, 4


@built_in
def polish(
    W, b, mu, floor, n, scale, largest, least, fine, most, ridge, P, best, xi, mode, slip, way,
    aim, matrix, x, moved,
):  # fmt: skip
    """Bring P (3n,) from nearby to rounding level; the residual.

    Args:
        floor: (n,) f [N s].
        scale: the size of the velocities.
        largest: the largest entry on the diagonal of W.
        least: what counts as a diagonal of nothing.
        fine: the residual below which nothing is to be gained.
        most: steps.
        ridge: relative; 0 where W is known to be regular and every row to move something.
    """
    size = 3 * n
    for j in range(size):
        best[j] = P[j]
    bar = math.inf
    risen = 0
    for step in range(most + 1):
        residual = residual_of(W, b, mu, floor, n, scale, least, P, xi, mode, slip)
        if not residual < math.inf:
            break
        if residual < bar:
            last = bar < DEEP
            bar = residual
            if bar <= BAR:
                for j in range(size):
                    best[j] = P[j]
            # Deep enough; one step more is only for the last digits.
            if last and bar <= fine:
                break
        elif bar < 1e-11:
            # It may rise for a step, where contacts on the edge of their cones change modes.
            risen += 1
            if bar <= fine or risen > RISES:
                break
        if step < most and not _stepped(
            W, b, mu, floor, n, ridge * largest, P, xi, mode, slip, way, aim, matrix, x, moved,
            ridge > 0.0 and residual < NEAR,
        ):  # fmt: skip
            break
    for j in range(size):
        P[j] = best[j]
    return bar


@built_in
def residual_of(W, b, mu, floor, n, scale, least, P, xi, mode, slip):
    """The residual of the natural map; mode and slip of each contact."""
    worst = 0.0
    size = scale
    for k in range(3 * n):
        total = b[k]
        for j in range(3 * n):
            total += W[k, j] * P[j]
        xi[k] = total
    for i in range(n):
        k = 3 * i
        normal_rate = max(W[k + 2, k + 2], least)
        rate = max(W[k, k] + W[k + 1, k + 1], least)
        load = normal_rate * (P[k + 2] - floor[i])
        pushing = load > xi[k + 2]
        worst = max(worst, abs(xi[k + 2] if pushing else load))
        size = max(size, normal_rate * P[k + 2])
        if not pushing and floor[i] == 0.0:
            mode[i] = PARTS
            worst = max(worst, rate * (abs(P[k]) + abs(P[k + 1])))
            continue
        q1, q2 = P[k] - xi[k] / rate, P[k + 1] - xi[k + 1] / rate
        length = math.sqrt(q1 * q1 + q2 * q2)
        bound = mu[i] * P[k + 2] if P[k + 2] > 0.0 else 0.0
        if length > bound:
            q1, q2 = q1 / length, q2 / length
            mode[i] = SLIDES if pushing else SLIDES_AT_FLOOR
            slip[i, 0], slip[i, 1] = -q1, -q2
            d1, d2 = P[k] - bound * q1, P[k + 1] - bound * q2
            worst = max(worst, rate * math.sqrt(d1 * d1 + d2 * d2))
        else:
            mode[i] = STICKS if pushing else STICKS_AT_FLOOR
            worst = max(worst, math.sqrt(xi[k] * xi[k] + xi[k + 1] * xi[k + 1]))
        if worst != worst:
            return math.inf
    return worst / size if size > 0.0 else 0.0


@built_in
def _stepped(
    W, b, mu, floor, n, ridge, P, xi, mode, slip, way, aim, matrix, x, moved, near
):  # fmt: skip
    """One Newton step on the modes; False where the system is singular."""
    size = 3 * n
    m = np.int64(0)
    for k in range(size):
        for j in range(size):
            way[k, j] = 0.0
            aim[k, j] = 0.0
    for i in range(n):
        k = 3 * i
        if mode[i] == PARTS:
            P[k], P[k + 1], P[k + 2] = 0.0, 0.0, 0.0
            continue
        pushing = mode[i] <= SLIDES
        pn = max(P[k + 2], floor[i]) if pushing else floor[i]
        P[k + 2] = pn
        if mu[i] == 0.0:
            P[k], P[k + 1] = 0.0, 0.0
            if pushing:
                way[m, k + 2] = 1.0
                aim[m, k + 2] = 1.0
                m += 1
        elif mode[i] == SLIDES or mode[i] == SLIDES_AT_FLOOR:
            s1, s2 = slip[i, 0], slip[i, 1]
            P[k], P[k + 1] = -mu[i] * pn * s1, -mu[i] * pn * s2
            if pushing:
                way[m, k], way[m, k + 1], way[m, k + 2] = -mu[i] * s1, -mu[i] * s2, 1.0
                aim[m, k + 2] = 1.0
                m += 1
            way[m, k], way[m, k + 1] = s2, -s1
            aim[m, k], aim[m, k + 1] = s2, -s1
            m += 1
        else:
            for j in range(3 if pushing else 2):
                way[m, k + j] = 1.0
                aim[m, k + j] = 1.0
                m += 1
    if m == 0:
        return True
    for k in range(size):
        total = b[k]
        for j in range(size):
            total += W[k, j] * P[j]
        xi[k] = total
    for c in range(m):
        # W times the way, whose few entries belong to one contact.
        for k in range(size):
            moved[k] = 0.0
        for j in range(size):
            if way[c, j] != 0.0:
                for k in range(size):
                    moved[k] += W[k, j] * way[c, j]
        for r in range(m):
            total = 0.0
            for k in range(size):
                if aim[r, k] != 0.0:
                    total += aim[r, k] * moved[k]
            matrix[r, c] = total
    for r in range(m):
        total = 0.0
        for k in range(size):
            if aim[r, k] != 0.0:
                total += aim[r, k] * xi[k]
        x[r] = total
        if not near:
            matrix[r, r] += ridge
    c = 0
    for i in range(n):
        if mode[i] == PARTS:
            continue
        pushing = mode[i] <= SLIDES
        if mu[i] == 0.0:
            c += pushing
        elif mode[i] == SLIDES or mode[i] == SLIDES_AT_FLOOR:
            c += pushing
            bound = mu[i] * P[3 * i + 2]
            along = slip[i, 0] * xi[3 * i] + slip[i, 1] * xi[3 * i + 1]
            if bound > 0.0 and along > 0.0:
                matrix[c, c] += along / bound
            c += 1
        else:
            c += 3 if pushing else 2
    if near:
        gauss_of_rank(matrix, m, x, DEPENDENT, moved, xi)
    elif not gauss(matrix, m, x):
        return False
    bounds = moved
    for i in range(n):
        bounds[i] = mu[i] * P[3 * i + 2]
    for c in range(m):
        for k in range(size):
            if way[c, k] != 0.0:
                P[k] -= way[c, k] * x[c]
    for i in range(n):
        if (mode[i] == SLIDES or mode[i] == SLIDES_AT_FLOOR) and mu[i] > 0.0:
            k = 3 * i
            s1, s2 = slip[i, 0], slip[i, 1]
            across = s2 * P[k] - s1 * P[k + 1]
            turn = math.atan(across / bounds[i]) if bounds[i] > 0.0 else 0.0
            cosine, sine = mu[i] * math.cos(turn), mu[i] * math.sin(turn)
            pn = max(floor[i], P[k + 2])
            P[k] = pn * (sine * s2 - cosine * s1)
            P[k + 1] = -pn * (cosine * s2 + sine * s1)
    return True
