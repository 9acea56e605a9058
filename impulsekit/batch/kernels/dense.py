"""Small dense systems of one state, in arrays that are made once."""

from __future__ import annotations

import math

from .jit import built_in

__all__ = ["cholesky", "eliminate", "gauss", "lower_solve", "rank_by_pivots"]


@built_in
def cholesky(a, n, lower):
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


@built_in
def lower_solve(lower, n, x):
    """x ← L⁻¹ x."""
    for i in range(n):
        total = x[i]
        for k in range(i):
            total -= lower[i, k] * x[k]
        x[i] = total / lower[i, i]


@built_in
def eliminate(lower, n, x):
    """x ← (L Lᵀ)⁻¹ x."""
    lower_solve(lower, n, x)
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= lower[k, i] * x[k]
        x[i] = total / lower[i, i]


@built_in
def gauss(a, n, x):
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
    for i in range(n - 1, -1, -1):
        total = x[i]
        for k in range(i + 1, n):
            total -= a[i, k] * x[k]
        x[i] = total / a[i, i]
    return True


@built_in
def rank_by_pivots(a, n, tolerance):
    """The rank of a positive semidefinite matrix, which is used up (pivoted Cholesky)."""
    for j in range(n):
        best = j
        for i in range(j + 1, n):
            if a[i, i] > a[best, best]:
                best = i
        if not a[best, best] > tolerance:
            return j
        if best != j:
            for k in range(n):
                a[j, k], a[best, k] = a[best, k], a[j, k]
            for k in range(n):
                a[k, j], a[k, best] = a[k, best], a[k, j]
        for i in range(j + 1, n):
            factor = a[i, j] / a[j, j]
            for k in range(j + 1, i + 1):
                a[i, k] -= factor * a[k, j]
        for i in range(j + 1, n):
            for k in range(j + 1, i):
                a[k, i] = a[i, k]
            a[j, i] = a[i, j]
    return n
