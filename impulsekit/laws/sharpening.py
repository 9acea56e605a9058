"""Newton on the modes of several contacts, with the velocities that an answer makes.

W = J M⁻¹ Jᵀ has rounding of its own, and so have sums over many contacts: P is known from
W P + b to fewer digits than from u⁻ + J Δv, a plain sum. With these velocities a step or two give
P the digits that it lacks.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import entry
from .half import factor_of, solve_mass
from .modes import (
    DEPENDENT,
    NULL,
    add_stiffness,
    assemble,
    map_naturally,
    sizes_of,
    write_onto_modes,
)
from .rank import gauss_of_rank
from .single import newtons_shift
from .tolerances import ROUNDING
from .words import NO
from .workspace import workspace

__all__ = ["MOST_STEPS", "lead", "sharpen"]

# What rounding leaves of an impulse, relative to itself: to move Δv by that would be noise.
ROUNDING_OF_ONE = 1e-15
MOST_STEPS = 6

# Residual; the change of P; the part of it that brings P onto its modes (3n,); Way and Aim,
# (m, 3n), a row for each unknown; the stiffness of slip that turns, (m,) on the diagonal;
# Aimᵀ ξ (m,), of P on its modes.
Lead = tuple[float, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


@entry(lambda: (np.eye(6), np.ones(2), np.ones(6), np.ones(6), 1.0), seconds=2.0)
def lead(W: np.ndarray, mu: np.ndarray, P: np.ndarray, xi: np.ndarray, scale: float) -> Lead:
    """The residual with ξ known better than W P + b, and the next step of Newton.

    With P + o on its modes, (Aimᵀ W Way + stiffness) x = Aimᵀ ξ, and the change is o − Way x, x
    being the least: what is shared among redundant contacts stays as it is. Residual ∞ where a
    number is not finite.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        mu: (n,) friction.
        P: (3n,) a solution but for rounding [N s].
        xi: (3n,) ξ that it makes [m/s].
        scale: the size of the velocities [m/s].
    """
    n = len(mu)
    size = 3 * n
    work = workspace(n)
    matrix, x, unit = work.matrix, work.x, work.total
    finite = 0.0
    for r in range(size):
        work.P[r], work.xi[r] = P[r], xi[r]
        finite += abs(P[r]) + abs(xi[r])
        for c in range(size):
            work.W[r, c] = W[r, c]
    for i in range(n):
        work.mu[i] = mu[i]
    sizes = sizes_of(work, n, scale)
    residual = map_naturally(work, n, sizes, NO)
    m = write_onto_modes(work, n)
    offset, off = np.zeros(size), False
    for i in range(n):
        load, apart = 0.0, 0.0
        for k in range(3 * i, 3 * i + 3):
            load, apart = max(load, abs(P[k])), max(apart, abs(work.P[k] - P[k]))
        if apart > ROUNDING_OF_ONE * load:
            off = True
            for k in range(3 * i, 3 * i + 3):
                offset[k] = work.P[k] - P[k]
                for r in range(size):
                    work.xi[r] += W[r, k] * offset[k]
    assemble(work, m)
    right, stiffness, change = x[:m].copy(), np.empty(m), offset.copy()
    if not off:
        # Then what is left is what the velocities leave.
        residual = np.abs(right).max() / scale if m > 0 and scale > 0.0 else 0.0
    for r in range(m):
        unit[r] = matrix[r, r]
        matrix[r, r] = 0.0
    add_stiffness(work, n)
    for r in range(m):
        stiffness[r] = matrix[r, r]
        matrix[r, r] += unit[r]
        own = abs(matrix[r, r])
        unit[r] = 1.0 / math.sqrt(own if own > NULL * sizes.largest else sizes.largest)
    for r in range(m):
        x[r] *= unit[r]
        for c in range(m):
            matrix[r, c] *= unit[r] * unit[c]
    gauss_of_rank(matrix, m, x, DEPENDENT, work.moved, work.y)
    for c in range(m):
        for k in range(3 * work.owner[c], 3 * work.owner[c] + 3):
            change[k] -= work.way[c, k] * unit[c] * x[c]
    if not finite < math.inf:
        residual = math.inf
    return residual, change, offset, work.way[:m].copy(), work.aim[:m].copy(), stiffness, right


def _examples() -> tuple[object, ...]:
    line = np.ones(6)
    return np.eye(3), np.ones(3), np.ones((6, 3)), np.eye(6), np.ones((3, 2)), np.ones((3, 6)), line


@entry(_examples, seconds=2.0, apart=True)
def sharpen(
    lower: np.ndarray,
    pivots: np.ndarray,
    rows: np.ndarray,
    W: np.ndarray,
    coefficients: np.ndarray,
    points: np.ndarray,
    jump: np.ndarray,
) -> float:
    """Bring an answer of Newton's law nearer to it; its residual with J (v⁻ + Δv).

    Args:
        lower, pivots, rows, coefficients: as for ``struck.strike_at_once``.
        W: (3n, 3n) Delassus matrix [1/kg].
        points: (3, 3n) P [N s], u⁺ and u⁻ [m/s]; the first two are written.
        jump: (nv,) Δv, written.
    """
    mu, e, e_t = coefficients[0], coefficients[1], coefficients[2]
    impulse, dv, before = points[0].copy(), jump.copy(), points[2]
    size, nv = rows.shape
    after, xi, change_of_dv = np.empty(size), np.empty(size), np.empty(nv)
    scale, least = 0.0, math.inf
    aim = np.empty(size)
    for k in range(size):
        i = k // 3
        aim[k] = newtons_shift(e[i], before[k]) if k % 3 == 2 else e_t[i] * before[k]
        scale = max(scale, abs(before[k]), abs(before[k] + aim[k]))
    for step in range(MOST_STEPS + 1):
        for k in range(size):
            after[k] = before[k]
            for j in range(nv):
                after[k] += rows[k, j] * dv[j]
            xi[k] = after[k] + aim[k]
        found = lead(W, mu, impulse, xi, scale)
        residual, change = found[0], found[1]
        if residual < least:
            least = residual
            for k in range(size):
                points[0, k], points[1, k] = impulse[k], after[k]
            for j in range(nv):
                jump[j] = dv[j]
        if not residual < math.inf or residual <= ROUNDING or step == MOST_STEPS:
            break
        for j in range(nv):
            change_of_dv[j] = 0.0
        for k in range(size):
            impulse[k] += change[k]
            for j in range(nv):
                change_of_dv[j] += rows[k, j] * change[k]
        solve_mass(factor_of(lower, pivots), change_of_dv)
        for j in range(nv):
            dv[j] += change_of_dv[j]
    return least
