"""Bilateral rows of a system whose mass matrix is factored, in one compiled call.

With C = D^-½ U⁻¹ Aᵀ, W = Cᵀ C is the matrix of W λ = b − A v_free, and Δv = M⁻¹ (I + Aᵀλ). What
takes a closer look, rows that depend on each other or that rounding leaves unmet, is left.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled, entry
from .dense import cholesky, eliminate
from .half import factor_of, solve_mass
from .rank_tolerances import COMPARABLE, FAINT_AXIS_PIVOT
from .struck import posed
from .tolerances import CLEAR, ROUNDING

__all__ = ["BY_ALL", "BY_SOME", "UNSOLVED", "hold"]


# Not solved; solved, some rows moving nothing; solved, all rows moving something.
UNSOLVED, BY_SOME, BY_ALL = 0, 1, 2
# One of these; Δv (nv,); λ (m,); whether each row moves anything (m,).
Held = tuple[int, np.ndarray, np.ndarray, np.ndarray]


def _examples() -> tuple[object, ...]:
    return np.eye(3), np.ones(3), np.ones((2, 3)), np.ones(3), np.ones(3), np.ones(2), False


@entry(_examples, seconds=1.5)
def hold(
    lower: np.ndarray,
    pivots: np.ndarray,
    rows: np.ndarray,
    impulse: np.ndarray,
    v: np.ndarray,
    asked: np.ndarray,
    row_by_row: bool,
) -> Held:
    """Δv and λ with A Δv as asked; not solved where rows are not clearly independent or zeros.

    Args:
        lower, pivots: (nv, nv) Uᵀ and (nv,) D of M = U D Uᵀ.
        rows: (m, nv) A.
        impulse: (nv,) I.
        v: (nv,) v⁻.
        asked: (m,) b − A v⁻.
        row_by_row: whether each row is to be met to its own rounding, not all in norm.
    """
    m, nv = rows.shape
    given = np.empty((m + 1, nv))
    for k in range(nv):
        given[m, k] = impulse[k]
        for r in range(m):
            given[r, k] = rows[r, k]
    W, _ = posed(lower, pivots, given, v)
    multipliers, dv, moves = np.empty(m), impulse.copy(), np.ones(m, np.bool_)
    for r in range(m):
        multipliers[r] = asked[r] - W[m, r]
    live = _multiply(W, m, multipliers, moves)
    if live < 0:
        return UNSOLVED, dv, multipliers, moves
    for r in range(m):
        for k in range(nv):
            dv[k] += rows[r, k] * multipliers[r]
    solve_mass(factor_of(lower, pivots), dv)
    if not _is_met(rows, v, asked, dv, row_by_row):
        return UNSOLVED, dv, multipliers, moves
    return BY_ALL if live == m else BY_SOME, dv, multipliers, moves


@compiled
def _multiply(W: np.ndarray, m: int, x: np.ndarray, moves: np.ndarray) -> int:
    """x (m,) ← W⁻¹ x, 0 for rows of zeros; how many are not, −1 if not clearly independent."""
    least, largest, still = math.inf, 0.0, 0
    for r in range(m):
        largest = max(largest, W[r, r])
    for r in range(m):
        if W[r, r] != 0.0:
            least = min(least, W[r, r])
            continue
        # A row of no effect cannot change its velocity.
        if x[r] != 0.0:
            return -1
        moves[r] = False
        still += 1
        W[r, r] = largest
    if not 0.0 < largest < math.inf or (still > 0 and least < COMPARABLE * largest):
        return -1
    factor = np.empty((m, m))
    if not cholesky(W, m, factor) > CLEAR:
        return -1
    for r in range(m):
        if factor[r, r] * factor[r, r] < FAINT_AXIS_PIVOT * largest:
            return -1
    eliminate(factor, m, x)
    return m - still


@compiled
def _is_met(
    rows: np.ndarray, v: np.ndarray, asked: np.ndarray, dv: np.ndarray, row_by_row: bool
) -> bool:
    """Whether A Δv is as asked but for its own rounding."""
    m, nv = rows.shape
    left, entries, speeds, wanted = 0.0, 0.0, 0.0, 0.0
    for k in range(nv):
        speeds += dv[k] * dv[k] + v[k] * v[k]
    for r in range(m):
        missing, size = asked[r], abs(asked[r])
        for k in range(nv):
            missing -= rows[r, k] * dv[k]
            size += abs(rows[r, k]) * (abs(dv[k]) + abs(v[k]))
            entries += rows[r, k] * rows[r, k]
        if row_by_row and abs(missing) > ROUNDING * size:
            return False
        left += missing * missing
        wanted += asked[r] * asked[r]
    return left <= ROUNDING * ROUNDING * (entries * speeds + wanted)
