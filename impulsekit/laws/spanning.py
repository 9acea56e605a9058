"""What half-solved bilateral rows span, in one compiled call, where their rank is clear."""

from __future__ import annotations

import math

import numpy as np

from .bilateral import find_span
from .compiled import entry

__all__ = ["span_rows"]

# Live rows and rank; order of the rows; basis, L and shares as ``find_span`` writes them; 1/|L⁻¹|.
Spanned = tuple[int, int, np.ndarray, np.ndarray, np.ndarray, np.ndarray, float]


@entry(lambda: (np.ones((2, 3)), np.zeros(2, np.int64)), seconds=1.5)
def span_rows(half: np.ndarray, vectors: np.ndarray) -> Spanned:
    """``find_span`` of rows (m, nv), and a bound from below on their least singular value."""
    m, nv = half.shape
    squares, order = np.zeros(m), np.empty(m, np.int64)
    basis, lower, shares = np.empty((m, nv)), np.zeros((m, m)), np.empty((m, m))
    for r in range(m):
        for k in range(nv):
            squares[r] += half[r, k] * half[r, k]
    live, rank = find_span(half, squares, vectors, order, basis, lower, shares)
    total, column = 0.0, np.empty(m)
    for c in range(rank):
        for r in range(c, rank):
            left = 1.0 if r == c else 0.0
            for k in range(c, r):
                left -= lower[r, k] * column[k]
            column[r] = left / lower[r, r]
            total += column[r] * column[r]
    return live, rank, order, basis, lower, shares, 1.0 / math.sqrt(total) if total > 0.0 else 1.0
