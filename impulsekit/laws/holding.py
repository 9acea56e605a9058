"""Bilateral rows of a system whose mass matrix is factored, in one compiled call.

With C = D^-½ U⁻¹ Aᵀ, W = Cᵀ C is the matrix of W λ = b − A v_free, and Δv = M⁻¹ (I + Aᵀλ). What
takes a closer look, rows that nearly depend on each other or that rounding leaves unmet, is left.
"""

from __future__ import annotations

import math

import numpy as np

from .bilateral import are_shared, find_span, is_implied, spread
from .compiled import compiled, entry
from .dense import cholesky, eliminate, lower_solve, upper_solve
from .half import delassus_of, factor_of, halve, solve_mass
from .rank_tolerances import COMPARABLE, FAINT_AXIS_PIVOT
from .tolerances import CLEAR, ROUNDING

__all__ = ["BY_ALL", "BY_SOME", "UNSOLVED", "hold"]


# Not solved; solved, the impulses of some rows not determined; solved, all of them determined.
UNSOLVED, BY_SOME, BY_ALL = 0, 1, 2
# One of these; Δv (nv,); λ (m,); whether that of each row is determined (m,).
Held = tuple[int, np.ndarray, np.ndarray, np.ndarray]


def _examples() -> tuple[object, ...]:
    line, two = np.ones(3), np.ones(2)
    return np.eye(3), line, np.ones((2, 3)), line, line, two, np.zeros(2, np.int64), False


@entry(_examples, seconds=2.5)
def hold(
    lower: np.ndarray,
    pivots: np.ndarray,
    rows: np.ndarray,
    impulse: np.ndarray,
    v: np.ndarray,
    asked: np.ndarray,
    vectors: np.ndarray,
    row_by_row: bool,
) -> Held:
    """Δv and λ with A Δv as asked; not solved where the rank of the rows is not clear.

    Args:
        lower, pivots: (nv, nv) Uᵀ and (nv,) D of M = U D Uᵀ.
        rows: (m, nv) A.
        impulse: (nv,) I.
        v: (nv,) v⁻.
        asked: (m,) b − A v⁻.
        vectors: (m,) a number for each row, the same for rows along axes of one vector.
        row_by_row: whether each row is to be met to its own rounding, not all in norm.
    """
    m, nv = rows.shape
    factor, half = factor_of(lower, pivots), np.empty((m + 1, nv))
    for k in range(nv):
        half[m, k] = impulse[k]
        for r in range(m):
            half[r, k] = rows[r, k]
    for r in range(m + 1):
        halve(factor, half[r])
    W = delassus_of(half)
    multipliers, dv, unique, speed = np.empty(m), impulse.copy(), np.ones(m, np.bool_), 0.0
    for r in range(m):
        before = 0.0
        for k in range(nv):
            before += rows[r, k] * v[k]
        speed = max(speed, abs(before), abs(before + asked[r]), abs(before + W[m, r]))
        multipliers[r] = asked[r] - W[m, r]
    if not _multiply(W, half, vectors, speed, multipliers, unique):
        return UNSOLVED, dv, multipliers, unique
    for r in range(m):
        for k in range(nv):
            dv[k] += rows[r, k] * multipliers[r]
    solve_mass(factor, dv)
    if not _is_met(rows, v, asked, dv, row_by_row):
        return UNSOLVED, dv, multipliers, unique
    return BY_ALL if unique.all() else BY_SOME, dv, multipliers, unique


@compiled
def _multiply(
    W: np.ndarray,
    half: np.ndarray,
    vectors: np.ndarray,
    speed: float,
    x: np.ndarray,
    unique: np.ndarray,
) -> bool:
    """x (m,) ← λ with W λ = x, of least scaled norm; False where the rank is not clear.

    Args:
        W: (m, m) or more, used up. half: (m, nv) Cᵀ, or more.
        vectors: (m,) as for ``hold``. speed: the size of the rows' velocities.
        unique: (m,) True; cleared for rows whose impulse is not determined.
    """
    m = len(x)
    squares = np.empty(m)
    least, largest, still = math.inf, 0.0, 0
    for r in range(m):
        squares[r] = W[r, r]
        largest = max(largest, squares[r])
    for r in range(m):
        if squares[r] != 0.0:
            least = min(least, squares[r])
            continue
        # A row of no effect cannot change its velocity.
        if x[r] != 0.0:
            return False
        unique[r] = False
        still += 1
        W[r, r] = largest
    if not 0.0 < largest < math.inf or (still > 0 and least < COMPARABLE * largest):
        return False
    factor = np.empty((m, m))
    if not cholesky(W, m, factor) > CLEAR:
        return _share(half[:m], squares, vectors, speed, x, unique)
    for r in range(m):
        if factor[r, r] * factor[r, r] < FAINT_AXIS_PIVOT * largest:
            return False
    eliminate(factor, m, x)
    return True


@compiled
def _share(
    half: np.ndarray,
    squares: np.ndarray,
    vectors: np.ndarray,
    speed: float,
    x: np.ndarray,
    unique: np.ndarray,
) -> bool:
    """As ``_multiply``, of rows some of which depend on others. ``squares``: as ``find_span``."""
    m = len(x)
    order, basis = np.empty(m, np.int64), np.empty(half.shape)
    lower, shares, known, others = np.empty((m, m)), np.empty((m, m)), np.empty(m), np.empty(m)
    live, rank = find_span(half, squares, vectors, order, basis, lower, shares)
    if rank < 0 or rank == live:
        return False
    for i in range(live):
        scale = 1.0 / math.sqrt(squares[order[i]])
        known[i] = scale * x[order[i]]
        if i >= rank and not is_implied(known[i], shares[i - rank], known, rank, scale * speed):
            return False
    lower_solve(lower, rank, known)
    upper_solve(lower, rank, known)
    shared, factor = np.zeros(live, np.bool_), np.empty((live, live))
    spread(rank, shares, known, others[: live - rank], factor)
    are_shared(rank, shares, factor, np.empty(live - rank), shared)
    for i in range(live):
        value = known[i] if i < rank else others[i - rank]
        x[order[i]] = value / math.sqrt(squares[order[i]])
        unique[order[i]] = i < rank and not shared[i]
    return True


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
