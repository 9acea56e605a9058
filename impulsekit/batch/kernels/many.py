"""Several contacts of one state with friction, as ``impact.laws`` solves them, for kernels.

A few rounds of projection come near, and Newton on the modes of the contacts goes to rounding
level. The bars are those of the solver of single states, to which the code AGAIN leaves what
fails here.
"""

from __future__ import annotations

import math

import numpy as np

from ..codes import AGAIN, RowStatus
from .coulomb import coulomb
from .dense import rank_by_pivots
from .jit import built_in
from .modes import BAR, polish
from .smooth import ALIKE, FINE
from .splitting import split

__all__ = ["frictional", "is_redundant"]

NULL = 1e-14
# Rounds of sweeps (above 0) and of splitting (below).
SWEEPS = (3, 10, 30, -100, -200, -400, -800, 200)
ROUNDS = len(SWEEPS)
_SOLVED, _NOT_UNIQUE = int(RowStatus.SOLVED), int(RowStatus.NOT_UNIQUE)


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
            p1, p2, pn, code = coulomb(
                W[k, k], W[k, k + 1], W[k + 1, k + 1], W[k, k + 2], W[k + 1, k + 2],
                W[k + 2, k + 2], u1, u2, un, mu[i], scale, found, roots,
            )  # fmt: skip
            if code == AGAIN and not pn > 0.0:
                continue
            largest = max(largest, W[k + 2, k + 2] * abs(pn - P[k + 2]))
            P[k], P[k + 1], P[k + 2] = p1, p2, pn
        if largest <= 1e-13 * scale:
            return


@built_in
def is_redundant(W, mu, n, dependent, largest, P, matrix, way):
    """Whether load can be shifted between contacts without moving anything."""
    size = 3 * n
    most = 0.0
    for i in range(n):
        most = max(most, P[3 * i + 2])
    m = np.int64(0)
    for i in range(n):
        k = 3 * i
        if not P[k + 2] > 1e-13 * most:
            continue
        if math.sqrt(P[k] ** 2 + P[k + 1] ** 2) > mu[i] * P[k + 2] * (1.0 - 1e-9):
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
            W, b, mu, floor, n, scale, largest, least, FINE, P, best, xi, mode, slip, way, aim,
            matrix, x, moved,
        )  # fmt: skip
        if bar <= BAR:
            if bar > 10.0 * FINE:
                return AGAIN
            if not is_redundant(W, mu, n, dependent, largest, P, matrix, way):
                return _SOLVED
            # What is left over may be what sets nearly redundant contacts apart.
            return _NOT_UNIQUE if bar <= FINE else AGAIN
    return AGAIN
