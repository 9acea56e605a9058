"""Newton on the modes of several contacts: parts, sticks or slides.

The natural map of 0 ≤ P_n − f ⊥ ξ_n ≥ 0 with Coulomb's friction (Alart & Curnier 1991) is
P_n − f = max(0, P_n − f − ρ ξ_n), P_t = proj(P_t − ρ ξ_t) onto |P_t| ≤ µ P_n; f is 0, or what an
expansion asks for at least. Its branches are the modes. A sticking contact has three unknowns,
a sliding one two, P_n and the direction s of slip: P_t = −µ P_n s, s⊥·ξ_t = 0. Newton on these,
modes seen anew at each step, until none changes.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .dense import gauss, gauss_of_rank
from .workspace import Sizes, Workspace

__all__ = [
    "BAR", "DEPENDENT", "FINE", "MOST_STEPS", "NULL", "RIDGE", "SLIDES", "polish", "residual_of",
    "sizes_of",
]  # fmt: skip

# Steps from nearby at most.
MOST_STEPS = 12
# Against singular W, relative: moves only what the velocities do not notice.
RIDGE = 1e-9
# Nearer than this the ridge is left out: what is redundant would drift by rounding over it, out
# of its cones and back. Pivots below this share are then none.
NEAR = 1e-3
DEPENDENT = 1e-10
# What the residual must come down to; and where it is rounding, so that further steps gain
# nothing.
BAR, FINE = 1e-10, 4e-15
# From here on one step more is for the last digits.
DEEP = 1e-13
# How often the residual may rise, where contacts on the edge of their cones change modes.
RISES = 3
# A row of W with this share of the largest on its diagonal moves nothing.
NULL = 1e-14
# Contacts whose masses differ by less than this are much alike.
ALIKE = 1e-2
# How many times the velocities W P may be before its rounding counts: beyond it an impulse that
# solves nothing could be so large that what it leaves drowns in its own rounding.
BALANCED = 1e3
# Parts; sticks; slides; the same two with P_n held at f.
PARTS, STICKS, SLIDES, STICKS_AT_FLOOR, SLIDES_AT_FLOOR = 0, 1, 2, 3, 4


@compiled
def sizes_of(work: Workspace, n: int, scale: float) -> Sizes:
    """What counts as nothing.

    Args:
        work: W and b.
        n: how many contacts.
        scale: the size of the velocities where they were larger before [m/s].
    """
    largest, heaviest = 0.0, math.inf
    for i in range(n):
        own = 0.0
        for k in range(3 * i, 3 * i + 3):
            scale = max(scale, abs(work.b[k]))
            own = max(own, work.W[k, k])
        largest, heaviest = max(largest, own), min(heaviest, own)
    return Sizes(scale, largest, NULL * largest, heaviest > ALIKE * largest)


@compiled
def polish(work: Workspace, n: int, sizes: Sizes, most: int, ridge: float) -> float:
    """Bring P (3n,) from nearby to rounding level; the residual.

    Args:
        work: the problem, with P to begin with.
        n: how many contacts.
        sizes: what counts as nothing.
        most: steps.
        ridge: relative; 0 where W is known to be regular and every row to move something.
    """
    P, best = work.P, work.best
    size = 3 * n
    for j in range(size):
        best[j] = P[j]
    bar = math.inf
    risen = 0
    for step in range(most + 1):
        residual = residual_of(work, n, sizes)
        if not residual < math.inf:
            break
        if residual < bar:
            last = bar < DEEP
            bar = residual
            if bar <= BAR:
                for j in range(size):
                    best[j] = P[j]
            # Deep enough; one step more is only for the last digits.
            if last and bar <= FINE:
                break
        elif bar < 1e-11:
            risen += 1
            if bar <= FINE or risen > RISES:
                break
        if step < most and not _stepped(work, n, sizes, ridge, ridge > 0.0 and residual < NEAR):
            break
    for j in range(size):
        P[j] = best[j]
    return bar


@compiled
def residual_of(work: Workspace, n: int, sizes: Sizes) -> float:
    """The natural map's distance from its fixed point, relative; writes ξ, modes and slips."""
    W, b, mu, floor, P, xi = work.W, work.b, work.mu, work.floor, work.P, work.xi
    mode, slip = work.mode, work.slip
    worst = 0.0
    size = sizes.scale
    largest_load = BALANCED * sizes.scale
    for k in range(3 * n):
        total = b[k]
        for j in range(3 * n):
            total += W[k, j] * P[j]
        if not abs(total) < math.inf:
            return math.inf
        xi[k] = total
    for i in range(n):
        k = 3 * i
        normal_rate = max(W[k + 2, k + 2], sizes.least)
        rate = max(W[k, k] + W[k + 1, k + 1], sizes.least)
        load = normal_rate * (P[k + 2] - floor[i])
        pushing = load > xi[k + 2]
        worst = max(worst, abs(xi[k + 2] if pushing else load))
        # Impulses in balance leave their own rounding where W P is formed.
        size = max(size, min(normal_rate * P[k + 2], largest_load))
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
    return worst / size if size > 0.0 else 0.0


@compiled
def _stepped(work: Workspace, n: int, sizes: Sizes, ridge: float, near: bool) -> bool:
    """One Newton step on the modes; False where the system is singular."""
    m = _system(work, n)
    if m == 0:
        return True
    matrix, x = work.matrix, work.x
    if not near and ridge > 0.0:
        for r in range(m):
            # Each unknown its own: beside a gram's contact a tonne's must not drown.
            size = abs(matrix[r, r])
            own = size if size > sizes.least and not sizes.alike else sizes.largest
            matrix[r, r] += ridge * own
    _add_stiffness(work, n)
    if near:
        gauss_of_rank(matrix, m, x, DEPENDENT, work.moved, work.xi)
    elif not gauss(matrix, m, x):
        return False
    _move(work, n, m)
    return True


@compiled
def _system(work: Workspace, n: int) -> int:
    """Write P onto its modes, and Aimᵀ W Way x = Aimᵀ ξ for its change; the number of unknowns."""
    W, b, mu, floor, P, xi = work.W, work.b, work.mu, work.floor, work.P, work.xi
    mode, slip, way, aim, matrix = work.mode, work.slip, work.way, work.aim, work.matrix
    x, moved = work.x, work.moved
    size = 3 * n
    m = int(np.int64(0))
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
        return m
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
    return m


@compiled
def _add_stiffness(work: Workspace, n: int) -> None:
    """As slip turns, so does what is across it."""
    mu, P, xi, mode, slip, matrix = work.mu, work.P, work.xi, work.mode, work.slip, work.matrix
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


@compiled
def _move(work: Workspace, n: int, m: int) -> None:
    """P by the step, slip back on the edge of its cone in the direction that it has turned to."""
    mu, floor, P, mode, slip = work.mu, work.floor, work.P, work.mode, work.slip
    way, x, bounds = work.way, work.x, work.moved
    size = 3 * n
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
