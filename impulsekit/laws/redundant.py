"""Which contacts carry what no other contact could carry for them."""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled, entry
from .rank import null_parts, pivoted_cholesky
from .tolerances import CLEAR, EDGE, PART
from .workspace import Sizes, Workspace, workspace

__all__ = ["NO_LOAD", "find_shared", "is_redundant"]

# Of the largest load: none.
NO_LOAD = 1e-13


@compiled
def is_redundant(W: np.ndarray, size: int, dependent: float, null: float) -> bool:
    """Whether rows of W that move anything depend on each other, or none moves anything.

    Args:
        W: Delassus matrix [1/kg], of which the first ``size`` rows count.
        size: how many rows.
        dependent: pivots, the diagonal being 1, below which rows depend on each other.
        null: the share of the largest W_ii below which a row moves nothing.
    """
    most = 0.0
    for r in range(size):
        most = max(most, W[r, r])
    unit, scaled, order = np.zeros(size), np.empty((size, size)), np.empty(size, np.int64)
    kept = 0
    for r in range(size):
        if W[r, r] > null * most:
            unit[r] = 1.0 / math.sqrt(W[r, r])
            kept += 1
    for r in range(size):
        for c in range(size):
            scaled[r, c] = W[r, c] * unit[r] * unit[c]
    return kept == 0 or pivoted_cholesky(scaled, size, dependent, size, order) < kept


def _examples() -> tuple[object, ...]:
    return workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), 0.0, False


@entry(_examples, seconds=2.0, apart=True)
def find_shared(work: Workspace, n: int, sizes: Sizes, dependent: float, slips: bool) -> bool:
    """Whether load can be shifted between contacts without moving anything.

    Sticking leaves three entries of P free, sliding the normal one; what moves no velocity among
    these can be added or taken away. ``work.unique`` tells which contacts have no part in that.

    Args:
        work: the problem and P.
        n: how many contacts.
        sizes: what counts as nothing.
        dependent: pivots, the diagonal being 1, below which rows depend on each other.
        slips: whether an impulse on its cone is that of slip; False where none slips.
    """
    W, mu, P, matrix, way = work.W, work.mu, work.P, work.matrix, work.way
    size = 3 * n
    owner, order = np.empty(size, np.int64), np.empty(size, np.int64)
    most = 0.0
    for i in range(n):
        work.unique[i] = True
        most = max(most, P[3 * i + 2])
    m = int(np.int64(0))
    for i in range(n):
        k = 3 * i
        if not P[k + 2] > NO_LOAD * most:
            continue
        friction = math.sqrt(P[k] ** 2 + P[k + 1] ** 2)
        if slips and friction > mu[i] * P[k + 2] * (1.0 - EDGE):
            for j in range(size):
                way[m, j] = 0.0
            for j in range(k, k + 3):
                way[m, j] = P[j] / P[k + 2]
            owner[m] = i
            m += 1
        else:
            for row in range(k, k + 3):
                if W[row, row] > sizes.least:
                    for j in range(size):
                        way[m, j] = 0.0
                    way[m, row] = 1.0
                    owner[m] = i
                    m += 1
    for r in range(m):
        for c in range(r + 1):
            total = 0.0
            for k in range(3 * owner[r], 3 * owner[r] + 3):
                if way[r, k] != 0.0:
                    for j in range(3 * owner[c], 3 * owner[c] + 3):
                        total += way[r, k] * W[k, j] * way[c, j]
            matrix[r, c] = total
            matrix[c, r] = total
    for r in range(m):
        work.x[r] = 1.0 / math.sqrt(max(matrix[r, r], sizes.least))
    for r in range(m):
        for c in range(m):
            matrix[r, c] *= work.x[r] * work.x[c]
    scaled = work.aim
    for r in range(m):
        for c in range(m):
            scaled[r, c] = matrix[r, c]
    rank = pivoted_cholesky(matrix, m, dependent, m, order)
    return rank < m and _tell_shared(work, m, rank, dependent, owner, order)


def _shared_examples() -> tuple[object, ...]:
    return workspace(1), 1, 1, 0.0, np.ones(3, np.int64), np.ones(3, np.int64)


@entry(_shared_examples, seconds=1.0, apart=True)
def _tell_shared(
    work: Workspace, m: int, rank: int, dependent: float, owner: np.ndarray, order: np.ndarray
) -> bool:
    """Write ``work.unique``, and whether any is not.

    Args:
        work: the scaled matrix of m entries of P in ``aim``, and its factor in ``matrix``.
        m, rank: its size, and its rank by pivots.
        dependent: as in ``find_shared``.
        owner: (m,) the contact of each entry.
        order: (m,) of the pivots.
    """
    matrix, part = work.matrix, work.moved
    if rank > 0 and matrix[rank - 1, rank - 1] ** 2 < CLEAR:
        values, vectors = np.linalg.eigh(work.aim[:m, :m].copy())
        for j in range(m):
            part[j] = 0.0
        free = 0
        while free < m and values[free] <= dependent * values[m - 1]:
            for j in range(m):
                part[j] += vectors[j, free] ** 2
            free += 1
    else:
        null_parts(matrix, m, rank, order, work.way, part)
    shared = False
    for j in range(m):
        if part[j] > PART:
            work.unique[owner[j]] = False
            shared = True
    return shared
