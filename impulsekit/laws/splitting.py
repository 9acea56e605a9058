"""Several contacts with friction by operator splitting (ADMM), which knows no order of contacts.

½ xᵀW x + (b + s)ᵀx over the friction cones, above their floors, s_n = µ|ξ_t| being De Saxcé's
correction, which makes a convex problem of Coulomb's law at every step (Acary, Cadoux, Lemaréchal
& Malick 2011); x and its copy y in the cones are brought together by z (Carpentier et al. 2024).
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .dense import invert
from .rank import pivoted_cholesky
from .workspace import Workspace

__all__ = ["split"]

# Steps between looks at the rate; the ratio of what x and y are apart to what y moves by, above
# which (or below its inverse) the rate follows it; by this factor at most at once.
LOOK, UNBALANCED, MOST_CHANGE = 10, 5.0, 10.0
# One contact in so many moves by itself at most where W is taken by its factor; pivots of rounding.
SMALL, SPLIT_ROUNDING = 3, 1e-15


@borrowing
def split(work: Workspace, n: int, steps: int, rate: float, relaxed: float) -> float:
    """Improve y (3n,) in the cones by some steps, z (3n,) being kept; the rate to go on with.

    y and z are in units of ``work.unit`` (n,): P = unit y, of one size for a contact's three rows.
    x is moved past where a step leads by the factor ``relaxed`` (Eckstein & Bertsekas 1992).
    """
    b, mu, y, z, unit = work.b, work.mu, work.y, work.z, work.unit
    x, last, right = work.x, work.moved, work.best
    size = 3 * n
    rank = _factor(work, n)
    fresh = True
    for step in range(steps):
        if fresh:
            if not _invert(work, n, rank, rate):
                return rate
            fresh = False
        for i in range(n):
            k = 3 * i
            slip = math.sqrt(z[k] * z[k] + z[k + 1] * z[k + 1])
            for j in range(k, k + 3):
                right[j] = rate * y[j] - unit[i] * b[j] - z[j]
            right[k + 2] -= mu[i] * slip
        _solve(work, size, rank, rate)
        apart = 0.0
        moved = 0.0
        for i in range(n):
            k = 3 * i
            for j in range(k, k + 3):
                last[j] = y[j]
                x[j] += (relaxed - 1.0) * (x[j] - y[j])
                y[j] = x[j] + z[j] / rate
            _project(y, k, mu[i], work.floor[i] / unit[i])
            off, change = 0.0, 0.0
            for j in range(k, k + 3):
                z[j] += rate * (x[j] - y[j])
                off += (x[j] - y[j]) ** 2
                change += (y[j] - last[j]) ** 2
            # By contact, the same whichever way its tangents point.
            apart = max(apart, math.sqrt(off))
            moved = max(moved, math.sqrt(change))
        if (step + 1) % LOOK == 0:
            if apart > UNBALANCED * moved:
                rate *= min(apart / moved, MOST_CHANGE) if moved > 0.0 else MOST_CHANGE
                fresh = True
            elif moved > UNBALANCED * apart:
                rate *= max(apart / moved, 1.0 / MOST_CHANGE)
                fresh = True
    return rate


@borrowing
def _factor(work: Workspace, n: int) -> int:
    """Write F (rank, 3n) into ``way``, FᵀF being W in units; -1 where its rank is not small."""
    W, unit, matrix, way, order = work.W, work.unit, work.matrix, work.way, work.owner
    size = 3 * n
    largest = 0.0
    for i in range(size):
        for j in range(size):
            matrix[i, j] = unit[i // 3] * W[i, j] * unit[j // 3]
        largest = max(largest, matrix[i, i])
    rank = pivoted_cholesky(matrix, size, SPLIT_ROUNDING * largest, size // SMALL + 1, order)
    if rank > size // SMALL:
        return -1
    for c in range(rank):
        for k in range(size):
            way[c, order[k]] = matrix[c, k] if k >= c else 0.0
    return rank


@borrowing
def _invert(work: Workspace, n: int, rank: int, rate: float) -> bool:
    """Write what ``_solve`` needs, A being W in units; False where A + ρ is not definite.

    (A + ρ)⁻¹ into ``matrix``; or G into ``aim``, with (A + ρ)⁻¹ = (1 − GᵀG)/ρ (Woodbury): the
    rows of F made orthonormal in the metric of F Fᵀ + ρ.
    """
    W, unit, matrix, way, aim = work.W, work.unit, work.matrix, work.way, work.aim
    size = 3 * n
    if rank < 0:
        for i in range(size):
            for j in range(size):
                matrix[i, j] = unit[i // 3] * W[i, j] * unit[j // 3]
            matrix[i, i] += rate
        return invert(matrix, size, work.moved)
    for r in range(rank):
        for c in range(r + 1):
            total = rate if r == c else 0.0
            for k in range(size):
                total += way[r, k] * way[c, k]
            matrix[r, c] = total
    lower = work.matrix
    for r in range(rank):
        for c in range(r):
            for k in range(c):
                lower[r, c] -= lower[r, k] * lower[c, k]
            lower[r, c] /= lower[c, c]
        for k in range(r):
            lower[r, r] -= lower[r, k] ** 2
        if not lower[r, r] > 0.0:
            return False
        lower[r, r] = math.sqrt(lower[r, r])
        for k in range(size):
            aim[r, k] = way[r, k]
        for c in range(r):
            for k in range(size):
                aim[r, k] -= lower[r, c] * aim[c, k]
        for k in range(size):
            aim[r, k] /= lower[r, r]
    return True


@borrowing
def _solve(work: Workspace, size: int, rank: int, rate: float) -> None:
    """x = (A + ρ)⁻¹ r of the right sides in ``best``, by what ``_invert`` wrote."""
    x, right, matrix, aim = work.x, work.best, work.matrix, work.aim
    if rank < 0:
        for i in range(size):
            x[i] = 0.0
        # By columns, which lie as the rows do: many entries at once.
        for j in range(size):
            share = right[j]
            for i in range(size):
                x[i] += share * matrix[j, i]
        return
    for i in range(size):
        x[i] = right[i]
    for c in range(rank):
        share = 0.0
        for i in range(size):
            share += aim[c, i] * right[i]
        for i in range(size):
            x[i] -= share * aim[c, i]
    for i in range(size):
        x[i] /= rate


@borrowing
def _project(y: np.ndarray, k: int, mu: float, floor: float) -> None:
    """The nearest point of |y_t| ≤ µ y_n, y_n ≥ floor."""
    size = math.sqrt(y[k] * y[k] + y[k + 1] * y[k + 1])
    inside = size <= mu * y[k + 2]
    normal = y[k + 2] if inside else (y[k + 2] + mu * size) / (1.0 + mu * mu)
    if normal < floor:
        normal = floor
        inside = size <= mu * floor
    if not inside:
        factor = mu * normal / size
        y[k], y[k + 1] = factor * y[k], factor * y[k + 1]
    y[k + 2] = normal
