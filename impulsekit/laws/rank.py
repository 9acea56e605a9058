"""Small dense systems whose rank is found, in arrays that are made once."""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import entry
from .dense import cholesky, eliminate, take_off, upper_solve

__all__ = [
    "gauss_of_rank",
    "null_parts",
    "null_projector",
    "null_rows",
    "pivoted_cholesky",
    "range_rows",
]


def _examples() -> tuple[object, ...]:
    line = np.ones(2)
    return np.eye(2), 2, line, 0.0, line, line


@entry(_examples, seconds=1.0, apart=True)
def gauss_of_rank(
    a: np.ndarray, n: int, x: np.ndarray, tolerance: float, order: np.ndarray, y: np.ndarray
) -> int:
    """The shortest x with A x = r where r is in the range, A being used up; the rank.

    Args:
        x: (n,) r on entry.
        tolerance: pivots up to this share of the largest entry are none.
        order, y: room, (n,).
    """
    a, x, order, y = borrowed(a), borrowed(x), borrowed(order), borrowed(y)
    rank = n
    largest = 0.0
    for j in range(n):
        order[j] = j
        y[j] = 0.0
    # In y, the largest entry of each column: it is kept with what changes them, along rows.
    for i in range(n):
        for k in range(n):
            size = abs(a[i, k])
            y[k] = size if size > y[k] else y[k]
    for j in range(n):
        row, column = j, j
        for k in range(j + 1, n):
            if y[k] > y[column]:
                column = k
        for i in range(j + 1, n):
            if abs(a[i, column]) > abs(a[row, column]):
                row = i
        size = abs(a[row, column])
        if j == 0:
            largest = size
        if not size > tolerance * largest:
            rank = j
            break
        if row != j:
            for k in range(j, n):
                a[j, k], a[row, k] = a[row, k], a[j, k]
            x[j], x[row] = x[row], x[j]
        if column != j:
            for i in range(n):
                a[i, j], a[i, column] = a[i, column], a[i, j]
            order[j], order[column] = order[column], order[j]
        _eliminate_below(a, n, j, x, y[j + 1 : n])
    upper_solve(a, rank, x)
    if rank < n:
        m = min(rank, n - rank)
        _shorten(a, n, rank, x, np.empty((m, m)), y)
    for j in range(n):
        y[j] = x[j]
    for j in range(n):
        x[int(order[j])] = y[j]
    return rank


@borrowing
def _eliminate_below(a: np.ndarray, n: int, j: int, x: np.ndarray, largest: np.ndarray) -> None:
    """Take row j off those below it, the largest entry of each column behind it being kept."""
    pivot_row, pivot = a[j, j + 1 : n], a[j, j]
    for k in range(len(largest)):
        largest[k] = 0.0
    for i in range(j + 1, n):
        factor = a[i, j] / pivot
        row = a[i, j + 1 : n]
        for k in range(len(largest)):
            left = row[k] - factor * pivot_row[k]
            row[k] = left
            size = abs(left)
            largest[k] = size if size > largest[k] else largest[k]
        x[i] -= factor * x[j]


@borrowing
def _shorten(
    a: np.ndarray, n: int, rank: int, x: np.ndarray, matrix: np.ndarray, right: np.ndarray
) -> None:
    """x (n,) of [U V] x = c, U an upper triangle: the shortest, from U⁻¹ c in its first entries.

    With X = U⁻¹ V all solutions are (U⁻¹ c − X z, z), and the shortest has
    z = (1 + XᵀX)⁻¹ Xᵀ U⁻¹ c = Xᵀ (1 + X Xᵀ)⁻¹ U⁻¹ c, whichever is smaller to solve.

    Args:
        a: U and V in its first ``rank`` rows; X takes the place of V.
        n, rank: how many columns and rows.
        x: written.
        matrix: room, as large as what is solved.
        right: room, (n,).
    """
    for i in range(rank - 1, -1, -1):
        row, pivot = a[i, rank:n], a[i, i]
        for k in range(i + 1, rank):
            take_off(row, a[k, rank:n], a[i, k])
        for k in range(len(row)):
            row[k] /= pivot
    m = len(matrix)
    by_rows = m == rank
    for r in range(m):
        right[r] = x[r] if by_rows else 0.0
        for c in range(r + 1):
            matrix[r, c] = 1.0 if r == c else 0.0
    for i in range(rank):
        row = a[i, rank:n]
        if by_rows:
            for c in range(i + 1):
                matrix[i, c] += _along(row, a[c, rank:n])
        else:
            take_off(right[:m], row, -x[i])
            for r in range(m):
                take_off(matrix[r, : r + 1], row, -row[r])
    cholesky(matrix, m, matrix)
    eliminate(matrix, m, right)
    rest = x[rank:n]
    if by_rows:
        for k in range(len(rest)):
            rest[k] = 0.0
        for i in range(rank):
            take_off(rest, a[i, rank:n], -right[i])
    else:
        for k in range(m):
            rest[k] = right[k]
    for i in range(rank):
        x[i] -= _along(a[i, rank:n], rest)


@borrowing
def pivoted_cholesky(a: np.ndarray, n: int, tolerance: float, most: int, order: np.ndarray) -> int:
    """The rank of a positive semidefinite matrix: L Lᵀ of its rows and columns in a new order.

    Args:
        a: (n, n); Lᵀ takes its place, in rows up to the rank. What is left of the other pivots
            stands on the diagonal.
        n: its size.
        tolerance: pivots up to here are none.
        most: rows of Lᵀ are made at most.
        order: (n,) written: where each row stood.
    """
    for j in range(n):
        order[j] = j
    for j in range(most):
        best = j
        for i in range(j + 1, n):
            if a[i, i] > a[best, best]:
                best = i
        if not a[best, best] > tolerance:
            return j
        if best != j:
            order[j], order[best] = order[best], order[j]
            _swap_both(a, n, j, best)
        root = math.sqrt(a[j, j])
        a[j, j] = root
        row = a[j, j + 1 : n]
        for k in range(j):
            take_off(row, a[k, j + 1 : n], a[k, j])
        for i in range(j + 1, n):
            a[j, i] /= root
            a[i, i] -= a[j, i] ** 2
    return most


@borrowing
def _swap_both(a: np.ndarray, n: int, j: int, other: int) -> None:
    """Swap two rows and columns."""
    for k in range(n):
        a[j, k], a[other, k] = a[other, k], a[j, k]
    for k in range(n):
        a[k, j], a[k, other] = a[k, other], a[k, j]


@borrowing
def null_rows(a: np.ndarray, n: int, rank: int, order: np.ndarray, null: np.ndarray) -> None:
    """An orthonormal basis of the null space, n − rank rows, of what ``pivoted_cholesky`` made."""
    for c in range(n - rank):
        for j in range(n):
            null[c, j] = 0.0
        # L₁₁ᵀ x = −L₂₁ᵀ, and 1 for the column itself.
        for i in range(rank - 1, -1, -1):
            total = -a[i, rank + c]
            for k in range(i + 1, rank):
                total -= a[i, k] * null[c, order[k]]
            null[c, order[i]] = total / a[i, i]
        null[c, order[rank + c]] = 1.0
    _orthonormalize(null[: n - rank])


@borrowing
def range_rows(a: np.ndarray, n: int, rank: int, order: np.ndarray, rows: np.ndarray) -> None:
    """An orthonormal basis of the range, rank rows, of what ``pivoted_cholesky`` made."""
    for c in range(rank):
        for j in range(n):
            rows[c, order[j]] = a[c, j] if j >= c else 0.0
    _orthonormalize(rows[:rank])


@borrowing
def null_projector(
    a: np.ndarray, n: int, rank: int, order: np.ndarray, room: np.ndarray, onto: np.ndarray
) -> None:
    """Write the projector (n, n) onto the null space of what ``pivoted_cholesky`` made.

    By an orthonormal basis of it or of the range, whichever has fewer vectors.

    Args:
        room: (n, n).
    """
    by_range = 2 * rank < n
    count = rank if by_range else n - rank
    if by_range:
        range_rows(a, n, rank, order, room)
    else:
        null_rows(a, n, rank, order, room)
    for r in range(n):
        for c in range(n):
            onto[r, c] = 1.0 if by_range and r == c else 0.0
        for k in range(count):
            part = -room[k, r] if by_range else room[k, r]
            for c in range(n):
                onto[r, c] += part * room[k, c]


@borrowing
def null_parts(
    a: np.ndarray, n: int, rank: int, order: np.ndarray, room: np.ndarray, part: np.ndarray
) -> None:
    """(n,) the squares of the parts in the null space, of what ``pivoted_cholesky`` made.

    Args:
        room: (n, n).
        part: written; of each unit vector.
    """
    by_range = 2 * rank < n
    count = rank if by_range else n - rank
    if by_range:
        range_rows(a, n, rank, order, room)
    else:
        null_rows(a, n, rank, order, room)
    for j in range(n):
        total = 0.0
        for c in range(count):
            total += room[c, j] ** 2
        part[j] = 1.0 - total if by_range else total


@borrowing
def _orthonormalize(rows: np.ndarray) -> None:
    """Make linearly independent rows orthonormal, one after the other (Gram & Schmidt)."""
    for r in range(len(rows)):
        row = rows[r]
        # Twice, for what rounding leaves.
        for _ in range(2):
            for k in range(r):
                take_off(row, rows[k], _along(row, rows[k]))
        size = math.sqrt(_along(row, row))
        for j in range(len(row)):
            row[j] /= size


@borrowing
def _along(x: np.ndarray, y: np.ndarray) -> float:
    """x · y, by four sums, which do not wait for each other."""
    s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
    whole = len(x) - len(x) % 4
    for j in range(0, whole, 4):
        s0 += x[j] * y[j]
        s1 += x[j + 1] * y[j + 1]
        s2 += x[j + 2] * y[j + 2]
        s3 += x[j + 3] * y[j + 3]
    for j in range(whole, len(x)):
        s0 += x[j] * y[j]
    return (s0 + s1) + (s2 + s3)
