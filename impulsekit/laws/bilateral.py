"""Bilateral rows of one state: which of them count, what they want, and what each bears.

C = L⁻¹ Aᵀ has the half-solved rows, scaled to unit length, and W = Cᵀ C. Rows that depend on
others are set aside by pivoted QR of C, as ``impact.elimination`` does by singular values; what
rows bear is then the λ of least scaled norm. Where rounding could have a say in which rows these
are, the state is in doubt, and left to singular values.

``solve`` and batches decide alike: they differ in where a state's numbers stand, no more.
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .compiled import compiled
from .dense import cholesky, lower_solve, upper_solve
from .rank_tolerances import (
    COMPARABLE,
    DETERMINED,
    EXACT_RANK,
    FAINT_AXIS_PIVOT,
    IDLE,
    UNEVEN_AXES,
)
from .tolerances import CLEAR

__all__ = ["are_shared", "find_rank", "find_span", "is_implied", "spread"]


@compiled
def find_span(
    half: np.ndarray,
    squares: np.ndarray,
    vectors: np.ndarray,
    order: np.ndarray,
    basis: np.ndarray,
    lower: np.ndarray,
    shares: np.ndarray,
) -> tuple[int, int]:
    """How many rows move something, and the rank of these; rank -1 in doubt.

    Args:
        half: (m, nv) Cᵀ. squares: (m,) of the lengths of its rows; 0 for rows of no effect.
        vectors: (m,) a number for each row, the same for rows along axes of one vector.
        order: (m,) written: rows that count, then those that depend on them, then the others.
        basis: (m, nv) written: an orthonormal basis of the span in its first rows.
        lower, shares: (m, m) written as by ``find_rank``, of rows scaled to unit length.
    """
    m, nv = half.shape
    live, still, least, largest = 0, m, math.inf, 0.0
    for r in range(m):
        if squares[r] == 0.0:
            still -= 1
            order[still] = r
            continue
        order[live] = r
        least, largest = min(least, squares[r]), max(largest, squares[r])
        scale = 1.0 / math.sqrt(squares[r])
        for k in range(nv):
            basis[live, k] = scale * half[r, k]
        live += 1
    comparable = least >= COMPARABLE * largest
    if not largest < math.inf or not (comparable or live == m):
        return live, -1
    rank = find_rank(basis[:live], order[:live], lower, shares)
    if rank < live:
        uneven = not comparable or _are_uneven(squares, vectors, order[:live])
        return live, -1 if uneven else rank
    for k in range(rank):
        # Short axes of a vector are judged beside its long ones.
        if lower[k, k] * lower[k, k] * squares[order[k]] < FAINT_AXIS_PIVOT * largest:
            return live, -1
    return live, rank


@borrowing
def _are_uneven(squares: np.ndarray, vectors: np.ndarray, rows: np.ndarray) -> bool:
    """Whether one of some rows is far shorter than another axis of its vector."""
    for i in range(len(rows)):
        for j in range(len(rows)):
            r, c = rows[i], rows[j]
            if vectors[c] == vectors[r] and squares[r] < UNEVEN_AXES * UNEVEN_AXES * squares[c]:
                return True
    return False


@borrowing
def find_rank(half: np.ndarray, order: np.ndarray, lower: np.ndarray, shares: np.ndarray) -> int:
    """The rank of rows of unit length; ``order`` with those that count first; -1 in doubt.

    C P = Q R by Gram and Schmidt, each column once more; L = Rᵀ. A row that is set aside is
    R₁⁻¹ R₂ of the others.

    Args:
        half: (count, nv) Cᵀ, used up.
        order: (count,) numbers of the rows, brought into a new order.
        lower: (count, count) or more; L of the rows that count is written into its first rows
            and columns, Lᵀ above.
        shares: row by row, what each row that is set aside is of those that count; written.
    """
    live, nv = half.shape
    # R, above the diagonal.
    upper = lower
    rank: int = live
    for k in range(live):
        best, longest = k, -1.0
        for i in range(k, live):
            size = 0.0
            for dof in range(nv):
                size += half[i, dof] * half[i, dof]
            if size > longest:
                best, longest = i, size
        length = math.sqrt(longest)
        if length <= EXACT_RANK:
            rank = k
            break
        if not length * length > CLEAR:
            return -1
        if best != k:
            order[k], order[best] = order[best], order[k]
            for dof in range(nv):
                half[k, dof], half[best, dof] = half[best, dof], half[k, dof]
            for j in range(k):
                upper[j, k], upper[j, best] = upper[j, best], upper[j, k]
        # Once more against those before, for what subtracting left of them.
        for j in range(k):
            upper[j, k] += _take_out(half, j, k)
        size = 0.0
        for dof in range(nv):
            size += half[k, dof] * half[k, dof]
        length = math.sqrt(size)
        upper[k, k] = length
        for dof in range(nv):
            half[k, dof] /= length
        for i in range(k + 1, live):
            upper[k, i] = _take_out(half, k, i)
    for k in range(rank):
        for j in range(k):
            lower[k, j] = upper[j, k]
    for i in range(rank, live):
        own = shares[i - rank]
        for k in range(rank):
            own[k] = upper[k, i]
        upper_solve(lower, rank, own)
    return rank


@borrowing
def _take_out(half: np.ndarray, of: int, row: int) -> float:
    """Take the part along row ``of``, a unit vector, out of another; how much that was."""
    along = 0.0
    for dof in range(half.shape[1]):
        along += half[of, dof] * half[row, dof]
    for dof in range(half.shape[1]):
        half[row, dof] -= along * half[of, dof]
    return along


@borrowing
def is_implied(
    wanted: float, share: np.ndarray, known: np.ndarray, rank: int, speed: float
) -> bool:
    """Whether a row that is set aside wants what those that count imply.

    Args:
        wanted: what it wants. known: (rank,) what those want, all in units of the scaled rows.
        share: (rank,) of each of them in it.
        speed: the size of the velocities, in these units.
    """
    left = wanted
    for j in range(rank):
        left -= share[j] * known[j]
    return abs(left) <= IDLE * speed


@borrowing
def spread(
    rank: int, shares: np.ndarray, x: np.ndarray, others: np.ndarray, factor: np.ndarray
) -> None:
    """x (rank,) of the rows that count, and of the others, of least norm.

    (x, 0) less what lies in the null space, whose columns are (−Sᵀ, 1): with G = 1 + S Sᵀ
    the others get z = G⁻¹ S x, and x loses Sᵀ z.

    Args:
        shares: (len(others), rank or more) S. others: written.
        factor: L of G is written into its first len(others) rows and columns, Lᵀ above.
    """
    count = len(others)
    for i in range(count):
        for j in range(i + 1):
            total = 1.0 if i == j else 0.0
            for k in range(rank):
                total += shares[i, k] * shares[j, k]
            factor[i, j] = total
        others[i] = 0.0
        for k in range(rank):
            others[i] += shares[i, k] * x[k]
    cholesky(factor, count, factor)
    lower_solve(factor, count, others)
    upper_solve(factor, count, others)
    for k in range(rank):
        for i in range(count):
            x[k] -= shares[i, k] * others[i]


@borrowing
def are_shared(
    rank: int, shares: np.ndarray, factor: np.ndarray, column: np.ndarray, shared: np.ndarray
) -> None:
    """Write (rank,) whether rows that count share their impulse with others.

    The part of a row in the null space is sᵀ G⁻¹ s.

    Args:
        shares, factor: as ``spread`` takes and writes them.
        column: buffer, a number for each of the others. shared: written.
    """
    count = len(column)
    for k in range(rank):
        for i in range(count):
            column[i] = shares[i, k]
        lower_solve(factor, count, column)
        part = 0.0
        for i in range(count):
            part += column[i] * column[i]
        shared[k] = not 1.0 - part > DETERMINED
