"""Gauss-Jordan elimination with full exchanges, in any numbers, of any rank."""

from __future__ import annotations

import numpy as np

from impulsekit.reference import Arithmetic
from impulsekit.reference.arithmetic import Array


def generalized_inverse(numbers: Arithmetic, matrix: Array) -> tuple[Array, int]:
    """G with A G A = A, and the rank of A: the inverse where there is one.

    Where A has lost rank, unknowns without a pivot are left at zero, so that G b is one of
    the solutions of A x = b if there are any. Rows and columns are best scaled before.

    Args:
        numbers: what the entries are.
        matrix: (n, n) A.

    Returns:
        G (n, n) and the rank, judged by pivots above epsilon^(3/4) of the largest entry.
    """
    size = len(matrix)
    largest_of_row = np.abs(matrix).max(axis=1, initial=numbers.number(0))
    units = np.where(largest_of_row > 0, largest_of_row, numbers.number(1))
    work = np.concatenate([matrix / units[:, None], numbers.eye(size)], axis=1)
    rows, columns = list(range(size)), list(range(size))
    first: float = 0.0
    tolerance = float(numbers.epsilon) ** 0.75
    rank = 0
    pivots: list[tuple[int, int]] = []
    for _ in range(size):
        left = np.abs(work[np.ix_(rows, columns)].astype(float))
        at = int(left.argmax())
        row, column = rows[at // len(columns)], columns[at % len(columns)]
        largest = float(left.flat[at])
        first = first or largest
        if not largest > tolerance * first:
            break
        rank += 1
        pivots.append((row, column))
        work[row] = work[row] / work[row, column]
        factors = work[:, column].copy()
        factors[row] = numbers.number(0)
        touched = np.flatnonzero(factors != 0)
        # Eliminated columns and most of the identity are zero.
        across = np.flatnonzero(work[row] != 0)
        if len(touched):
            work[np.ix_(touched, across)] -= np.outer(factors[touched], work[row, across])
        rows.remove(row)
        columns.remove(column)
    inverse = numbers.zeros(size, size)
    for row, column in pivots:
        inverse[column] = work[row, size:] / units
    return inverse, rank


def solved_pair(matrix: Array, right: Array) -> Array:
    """x (2,) with A x = b, for a regular A (2, 2)."""
    (a, b), (c, d) = matrix
    det = a * d - b * c
    return np.array([d * right[0] - b * right[1], a * right[1] - c * right[0]]) / det
