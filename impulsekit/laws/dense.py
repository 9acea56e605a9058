"""Small dense systems of one state, in arrays that are made once."""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing

__all__ = [
    "cholesky",
    "eliminate",
    "factorize",
    "gauss",
    "gauss_of_rank",
    "invert",
    "lower_solve",
    "null_rows",
    "orthonormalize",
    "pivoted_cholesky",
    "put",
    "put_rows",
    "solve_factorized",
]


@borrowing
def put(values: np.ndarray, into: np.ndarray) -> None:
    """Write numbers (n,) into an array: numba would ask whether they overlap, and copy them."""
    for k in range(len(values)):
        into[k] = values[k]


@borrowing
def put_rows(values: np.ndarray, into: np.ndarray) -> None:
    """Write rows (m, n) into an array; see ``put``."""
    for i in range(len(values)):
        for k in range(values.shape[1]):
            into[i, k] = values[i, k]


@borrowing
def cholesky(a: np.ndarray, n: int, lower: np.ndarray) -> float:
    """L of the leading n rows of a symmetric matrix; the least pivot over its diagonal."""
    least = math.inf
    for i in range(n):
        for j in range(i + 1):
            total = a[i, j]
            for k in range(j):
                total -= lower[i, k] * lower[j, k]
            if j < i:
                lower[i, j] = total / lower[j, j]
            else:
                if not total > 0.0:
                    return 0.0
                least = min(least, total / a[i, i])
                lower[i, i] = math.sqrt(total)
    return least


@borrowing
def lower_solve(lower: np.ndarray, n: int, x: np.ndarray) -> None:
    """x ← L⁻¹ x."""
    for i in range(n):
        total = x[i]
        for k in range(i):
            total -= lower[i, k] * x[k]
        x[i] = total / lower[i, i]


@borrowing
def eliminate(lower: np.ndarray, n: int, x: np.ndarray) -> None:
    """x ← (L Lᵀ)⁻¹ x."""
    lower_solve(lower, n, x)
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= lower[k, i] * x[k]
        x[i] = total / lower[i, i]


@borrowing
def invert(a: np.ndarray, n: int, row: np.ndarray) -> bool:
    """A symmetric positive definite matrix becomes its inverse; False where it is none.

    The sweep operator, on the lower triangle (Goodnight 1979). ``row``: buffer (n,).
    """
    for k in range(n):
        pivot = a[k, k]
        if not pivot > 0.0:
            return False
        part = 1.0 / pivot
        for j in range(k):
            row[j] = a[k, j]
        for i in range(k, n):
            row[i] = a[i, k]
        for i in range(n):
            if i != k:
                factor = row[i] * part
                for j in range(i + 1):
                    a[i, j] -= factor * row[j]
        for j in range(k):
            a[k, j] = row[j] * part
        for i in range(k + 1, n):
            a[i, k] = row[i] * part
        a[k, k] = -part
    for i in range(n):
        for j in range(i + 1):
            a[i, j] = -a[i, j]
            a[j, i] = a[i, j]
    return True


@borrowing
def gauss(a: np.ndarray, n: int, x: np.ndarray) -> bool:
    """x ← A⁻¹ x with row pivoting, A being used up; False where it is singular."""
    for j in range(n):
        best = j
        for i in range(j + 1, n):
            if abs(a[i, j]) > abs(a[best, j]):
                best = i
        pivot = a[best, j]
        if not abs(pivot) > 0.0:
            return False
        if best != j:
            for k in range(j, n):
                a[j, k], a[best, k] = a[best, k], a[j, k]
            x[j], x[best] = x[best], x[j]
        for i in range(j + 1, n):
            factor = a[i, j] / pivot
            if factor != 0.0:
                for k in range(j + 1, n):
                    a[i, k] -= factor * a[j, k]
                x[i] -= factor * x[j]
    _substitute_back(a, n, x)
    return True


@borrowing
def _substitute_back(a: np.ndarray, n: int, x: np.ndarray) -> None:
    """x ← U⁻¹ x, U being the upper triangle."""
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= a[i, k] * x[k]
        x[i] = total / a[i, i]


@borrowing
def _swap_both(a: np.ndarray, n: int, j: int, other: int) -> None:
    """Swap two rows and columns."""
    for k in range(n):
        a[j, k], a[other, k] = a[other, k], a[j, k]
    for k in range(n):
        a[k, j], a[k, other] = a[k, other], a[k, j]


@borrowing
def gauss_of_rank(
    a: np.ndarray, n: int, x: np.ndarray, tolerance: float, order: np.ndarray, y: np.ndarray
) -> None:
    """The shortest x with A x = r where r is in the range, A being used up.

    Args:
        x: (n,) r on entry.
        tolerance: pivots up to this share of the largest entry are none.
        order, y: room, (n,).
    """
    rank = n
    largest = 0.0
    for j in range(n):
        order[j] = j
    for j in range(n):
        row, column, size = j, j, 0.0
        for i in range(j, n):
            for k in range(j, n):
                if abs(a[i, k]) > size:
                    row, column, size = i, k, abs(a[i, k])
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
        for i in range(j + 1, n):
            factor = a[i, j] / a[j, j]
            if factor != 0.0:
                for k in range(j + 1, n):
                    a[i, k] -= factor * a[j, k]
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


@borrowing
def _shorten(a: np.ndarray, n: int, rank: int, y: np.ndarray) -> None:
    """Take out of y what lies in the null space of an upper triangle of ``rank`` rows.

    The rows below it, which are nothing, are written: a basis of the null space.
    """
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
def factorize(a: np.ndarray, n: int, order: np.ndarray) -> bool:
    """L U of the leading n rows with row pivoting, in their place; False where it is singular.

    Args:
        a: the matrix.
        order: (n,) which row comes to stand where.
    """
    for j in range(n):
        best = j
        for i in range(j + 1, n):
            if abs(a[i, j]) > abs(a[best, j]):
                best = i
        order[j] = best
        pivot = a[best, j]
        if not abs(pivot) > 0.0:
            return False
        if best != j:
            for k in range(n):
                a[j, k], a[best, k] = a[best, k], a[j, k]
        for i in range(j + 1, n):
            if a[i, j] != 0.0:
                a[i, j] /= pivot
                for k in range(j + 1, n):
                    a[i, k] -= a[i, j] * a[j, k]
    return True


@borrowing
def solve_factorized(a: np.ndarray, n: int, order: np.ndarray, x: np.ndarray) -> None:
    """x ← A⁻¹ x by what ``factorize`` made of A."""
    for j in range(n):
        x[j], x[order[j]] = x[order[j]], x[j]
    for i in range(n):
        total = x[i]
        for k in range(i):
            total -= a[i, k] * x[k]
        x[i] = total
    _substitute_back(a, n, x)


@borrowing
def pivoted_cholesky(a: np.ndarray, n: int, tolerance: float, order: np.ndarray) -> int:
    """The rank of a positive semidefinite matrix: L Lᵀ of its rows and columns in a new order.

    Args:
        a: (n, n); L takes its place, in columns up to the rank.
        n: its size.
        tolerance: pivots up to here are none.
        order: (n,) written: where each row stood.
    """
    for j in range(n):
        order[j] = j
    for j in range(n):
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
            a[i, j] /= root
        for i in range(j + 1, n):
            for k in range(j + 1, i + 1):
                a[i, k] -= a[i, j] * a[k, j]
                a[k, i] = a[i, k]
    return n


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
    orthonormalize(null[: n - rank])


@borrowing
def orthonormalize(rows: np.ndarray) -> None:
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
        along = 0.0
        for j in range(n):
            along += a[r, j] * x[j]
        for j in range(n):
            x[j] -= along * a[r, j]
