"""Several contacts of one state with friction, as ``impact.laws`` solves them, for kernels.

Newton on the modes of the contacts starts from what would hold them all still; where that
finds nothing, a few rounds of projection come near, and Newton goes on to rounding level. The
bars are those of the solver of single states, to which the code AGAIN leaves what fails here.
"""

from __future__ import annotations

import math

import numpy as np

from ...laws.coulomb import coulomb
from ...laws.status import Status
from ..codes import AGAIN
from .coulomb import block_at
from .dense import rank_by_pivots
from .jit import built_in
from .modes import BAR, MOST_STEPS, RIDGE, SLIDES, polish, residual_of
from .smooth import ALIKE, FINE
from .splitting import split
from .sticking import held_still

__all__ = ["frictional", "is_redundant"]

NULL = 1e-14
# As in ``impact.laws.frictional``: Newton's steps from a first guess, and what rounding leaves.
FEW = 8
ROUNDING = 2e-15
# Rounds of sweeps (above 0) and of splitting (below).
SWEEPS = (3, 10, 30, -100, -200, -400, -800, 200)
ROUNDS = len(SWEEPS)
# Share of the largest load, or of the velocities, that is none.
EDGE = 1e-9
_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)
_MANY, _NONE = int(Status.MANY_SOLUTIONS), int(Status.NO_SOLUTION)


@built_in
def _swept(W, b, mu, n, scale, P, sweeps, found, roots):
    """Contact after contact in closed form; one that needs a second look keeps what it has."""
    size = 3 * n
    for _ in range(sweeps):
        largest = 0.0
        for i in range(n):
            k = 3 * i
            u1, u2, un = b[k], b[k + 1], b[k + 2]
            for j in range(size):
                if j < k or j > k + 2:
                    u1 += W[k, j] * P[j]
                    u2 += W[k + 1, j] * P[j]
                    un += W[k + 2, j] * P[j]
            (p1, p2, pn), code = coulomb(block_at(W, k), u1, u2, un, mu[i], scale)
            if code in (_MANY, _NONE) and not pn > 0.0:
                continue
            largest = max(largest, W[k + 2, k + 2] * abs(pn - P[k + 2]))
            P[k], P[k + 1], P[k + 2] = p1, p2, pn
        if largest <= 1e-13 * scale:
            return


@built_in
def is_redundant(W, mu, n, dependent, largest, P, matrix, way, slips):
    """Whether load can be shifted between contacts without moving anything.

    Args:
        slips: whether an impulse on its cone is that of slip; False where none slips.
    """
    size = 3 * n
    most = 0.0
    for i in range(n):
        most = max(most, P[3 * i + 2])
    m = np.int64(0)
    for i in range(n):
        k = 3 * i
        if not P[k + 2] > 1e-13 * most:
            continue
        friction = math.sqrt(P[k] ** 2 + P[k + 1] ** 2)
        if slips and friction > mu[i] * P[k + 2] * (1.0 - 1e-9):
            for j in range(size):
                way[m, j] = 0.0
            for j in range(k, k + 3):
                way[m, j] = P[j] / P[k + 2]
            m += 1
        else:
            for row in range(k, k + 3):
                if W[row, row] > NULL * largest:
                    for j in range(size):
                        way[m, j] = 0.0
                    way[m, row] = 1.0
                    m += 1
    for r in range(m):
        for c in range(r + 1):
            total = 0.0
            for k in range(size):
                if way[r, k] != 0.0:
                    for j in range(size):
                        if way[c, j] != 0.0:
                            total += way[r, k] * W[k, j] * way[c, j]
            matrix[r, c] = total
            matrix[c, r] = total
    for r in range(m):
        way[0, r] = 1.0 / math.sqrt(max(matrix[r, r], NULL * largest))
    for r in range(m):
        for c in range(m):
            matrix[r, c] *= way[0, r] * way[0, c]
    return rank_by_pivots(matrix, m, dependent) < m


@built_in
def _slips(mode, n):
    """Whether any contact slides."""
    count = 0
    for i in range(n):
        count += mode[i] == SLIDES
    return count > 0


@built_in
def _on_an_edge(W, b, mu, n, scale, P):
    """Whether a contact touches and bears nothing, or is on its cone and does not slip."""
    most = 0.0
    for i in range(n):
        most = max(most, P[3 * i + 2])
    for i in range(n):
        k = 3 * i
        u1, u2, un = b[k], b[k + 1], b[k + 2]
        for j in range(3 * n):
            u1 += W[k, j] * P[j]
            u2 += W[k + 1, j] * P[j]
            un += W[k + 2, j] * P[j]
        if P[k + 2] <= EDGE * most:
            if un <= EDGE * scale:
                return True
        elif mu[i] > 0.0 and math.sqrt(u1 * u1 + u2 * u2) <= EDGE * scale:
            friction = math.sqrt(P[k] ** 2 + P[k + 1] ** 2)
            if friction >= mu[i] * P[k + 2] * (1.0 - EDGE):
                return True
    return False


@built_in
def frictional(
    W, b, mu, floor, n, dependent, P, best, xi, mode, slip, way, aim, matrix, x, moved,
    split_y, split_z, found, roots,
):  # fmt: skip
    """P (3n,) of n contacts with friction; the code. W and b of smooth tangents are cleared.

    ``floor`` (n,) is 0 here.
    """
    size = 3 * n
    for i in range(n):
        if mu[i] == 0.0:
            for k in (3 * i, 3 * i + 1):
                b[k] = 0.0
                for j in range(size):
                    W[k, j] = 0.0
                    W[j, k] = 0.0
    scale = 0.0
    largest = 0.0
    slowest = math.inf
    for k in range(size):
        scale = max(scale, abs(b[k]))
        largest = max(largest, W[k, k])
        P[k] = 0.0
        if k % 3 == 2:
            slowest = min(slowest, b[k])
    if slowest >= -1e-15 * scale:
        return _SOLVED
    for i in range(n):
        if max(W[3 * i, 3 * i], W[3 * i + 1, 3 * i + 1], W[3 * i + 2, 3 * i + 2]) < ALIKE * largest:
            return AGAIN
    least = NULL * largest
    # First what ``solve`` tries first: of several answers both then find the same.
    ridge = held_still(W, b, size, largest, least, P, matrix, way, x)
    if ridge >= 0.0:
        bar = polish(
            W, b, mu, floor, n, scale, largest, least, FINE, FEW, ridge, P, best, xi, mode, slip,
            way, aim, matrix, x, moved,
        )  # fmt: skip
        if bar <= BAR:
            return _SOLVED if bar <= 10.0 * FINE else AGAIN
    else:
        bar = residual_of(W, b, mu, floor, n, scale, least, P, xi, mode, slip)
        if bar > ROUNDING and not _slips(mode, n):
            polish(
                W, b, mu, floor, n, scale, largest, least, FINE, FEW, RIDGE, P, best, xi, mode,
                slip, way, aim, matrix, x, moved,
            )  # fmt: skip
            bar = residual_of(W, b, mu, floor, n, scale, least, P, xi, mode, slip)
        if bar <= ROUNDING and not _slips(mode, n):
            redundant = is_redundant(W, mu, n, dependent, largest, P, matrix, way, False)
            return _NOT_UNIQUE if redundant else _SOLVED
    for k in range(size):
        P[k] = 0.0
    rate = 0.05 * largest
    for j in range(size):
        split_y[j], split_z[j] = 0.0, 0.0
    for k in range(ROUNDS):
        if SWEEPS[k] > 0:
            _swept(W, b, mu, n, scale, P, SWEEPS[k], found, roots)
        else:
            rate = split(W, b, mu, n, split_y, split_z, -SWEEPS[k], rate, way, aim, x, moved)
            for j in range(size):
                P[j] = split_y[j]
        bar = polish(
            W, b, mu, floor, n, scale, largest, least, FINE, MOST_STEPS, RIDGE, P, best, xi, mode,
            slip, way, aim, matrix, x, moved,
        )  # fmt: skip
        if bar <= BAR:
            if bar > 10.0 * FINE:
                return AGAIN
            if ridge >= 0.0:
                return _SOLVED
            # Load that can be shifted, now or once a contact leaves an edge: which share of it
            # ``solve`` finds tells what it calls determined.
            if _on_an_edge(W, b, mu, n, scale, P) or is_redundant(
                W, mu, n, dependent, largest, P, matrix, way, True
            ):
                return AGAIN
            return _SOLVED
    return AGAIN
