"""Small dense systems of one state, in arrays that are made once."""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing

__all__ = [
    "cholesky",
    "factorize",
    "gauss",
    "invert",
    "lower_solve",
    "put",
    "put_rows",
    "solve_factorized",
    "take_off",
    "upper_solve",
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
def take_off(row: np.ndarray, other: np.ndarray, factor: float) -> None:
    """row (n,) −= factor · other: of rows that lie in one piece many entries at once."""
    for k in range(len(row)):
        row[k] -= factor * other[k]


@borrowing
def cholesky(a: np.ndarray, n: int, lower: np.ndarray) -> float:
    """L of the leading n rows of a symmetric matrix; the least pivot over its diagonal.

    Lᵀ is written above it, so that what is taken off goes along rows: many entries at once.
    """
    least = math.inf
    for i in range(n):
        for j in range(i + 1):
            lower[i, j] = a[i, j]
    for j in range(n):
        pivot = lower[j, j]
        if not pivot > 0.0:
            return 0.0
        least = min(least, pivot / a[j, j])
        root = math.sqrt(pivot)
        lower[j, j] = root
        for i in range(j + 1, n):
            lower[i, j] /= root
            lower[j, i] = lower[i, j]
        for i in range(j + 1, n):
            take_off(lower[i, j + 1 : i + 1], lower[j, j + 1 : i + 1], lower[i, j])
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
def upper_solve(lower: np.ndarray, n: int, x: np.ndarray) -> None:
    """x ← L⁻ᵀ x, by Lᵀ above the diagonal."""
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= lower[i, k] * x[k]
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
                take_off(a[i, j + 1 : n], a[j, j + 1 : n], factor)
                x[i] -= factor * x[j]
    upper_solve(a, n, x)
    return True


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
                take_off(a[i, j + 1 : n], a[j, j + 1 : n], a[i, j])
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
    upper_solve(a, n, x)
