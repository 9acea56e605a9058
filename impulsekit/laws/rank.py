"""Small dense systems whose rank is found, in arrays that are made once."""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import entry

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
        for k in range(j + 1, n):
            y[k] = 0.0
        for i in range(j + 1, n):
            factor = a[i, j] / a[j, j]
            for k in range(j + 1, n):
                left = a[i, k] - factor * a[j, k]
                a[i, k] = left
                size = abs(left)
                y[k] = size if size > y[k] else y[k]
            x[i] -= factor * x[j]
    for i in range(rank - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, rank):
            total -= a[i, k] * y[k]
        y[i] = total / a[i, i]
    for j in range(rank, n):
        y[j] = 0.0
    if rank < n:
        _shorten(a, n, rank, y)
    for j in range(n):
        x[int(order[j])] = y[j]
    return rank


@borrowing
def _shorten(a: np.ndarray, n: int, rank: int, y: np.ndarray) -> None:
    """Take out of y what lies in the null space of an upper triangle of ``rank`` rows.

    By an orthonormal basis of these rows or of the null space, whichever has fewer vectors; it is
    written over them, or over the rows below, which are nothing.
    """
    if 2 * rank < n:
        for i in range(rank):
            for j in range(i):
                a[i, j] = 0.0
            _make_orthonormal(a, 0, i, n)
        rest = a[rank]
        for j in range(n):
            rest[j] = y[j]
        _take_out(a, 0, rank, n, rest)
        for j in range(n):
            y[j] -= rest[j]
        return
    for c in range(rank, n):
        for j in range(rank, n):
            a[c, j] = 1.0 if j == c else 0.0
        for i in range(rank - 1, -1, -1):
            total = -a[i, c]
            for k in range(i + 1, rank):
                total -= a[i, k] * a[c, k]
            a[c, i] = total / a[i, i]
        _make_orthonormal(a, rank, c, n)
    _take_out(a, rank, n, n, y)


@borrowing
def pivoted_cholesky(a: np.ndarray, n: int, tolerance: float, most: int, order: np.ndarray) -> int:
    """The rank of a positive semidefinite matrix: L Lᵀ of its rows and columns in a new order.

    Args:
        a: (n, n); L takes its place, in columns up to the rank. What is left of the other pivots
            stands on the diagonal.
        n: its size.
        tolerance: pivots up to here are none.
        most: columns of L are made at most.
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
        for i in range(j + 1, n):
            total = a[i, j]
            for k in range(j):
                total -= a[i, k] * a[j, k]
            total /= root
            a[i, j] = total
            a[i, i] -= total * total
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
            total = -a[rank + c, i]
            for k in range(i + 1, rank):
                total -= a[k, i] * null[c, order[k]]
            null[c, order[i]] = total / a[i, i]
        null[c, order[rank + c]] = 1.0
    _orthonormalize(null[: n - rank])


@borrowing
def range_rows(a: np.ndarray, n: int, rank: int, order: np.ndarray, rows: np.ndarray) -> None:
    """An orthonormal basis of the range, rank rows, of what ``pivoted_cholesky`` made."""
    for c in range(rank):
        for j in range(n):
            rows[c, order[j]] = a[j, c] if j >= c else 0.0
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
    count, n = rows.shape
    for r in range(count):
        _make_orthonormal(rows, 0, r, n)


@borrowing
def _make_orthonormal(a: np.ndarray, first: int, row: int, n: int) -> None:
    """Make a row of a orthonormal to those from ``first`` to before it, which are that."""
    # Twice, for what rounding leaves.
    _take_out(a, first, row, n, a[row])
    _take_out(a, first, row, n, a[row])
    size = 0.0
    for j in range(n):
        size += a[row, j] ** 2
    size = math.sqrt(size)
    for j in range(n):
        a[row, j] /= size


@borrowing
def _take_out(a: np.ndarray, first: int, last: int, n: int, x: np.ndarray) -> None:
    """Take the parts along rows ``first`` to ``last`` of a, which are orthonormal, out of x."""
    for r in range(first, last):
        # Four sums, which do not wait for each other.
        s0, s1, s2, s3 = 0.0, 0.0, 0.0, 0.0
        whole = n - n % 4
        for j in range(0, whole, 4):
            s0 += a[r, j] * x[j]
            s1 += a[r, j + 1] * x[j + 1]
            s2 += a[r, j + 2] * x[j + 2]
            s3 += a[r, j + 3] * x[j + 3]
        for j in range(whole, n):
            s0 += a[r, j] * x[j]
        along = (s0 + s1) + (s2 + s3)
        for j in range(n):
            x[j] -= along * a[r, j]
