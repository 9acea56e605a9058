"""Answers of one problem, each kept once."""

from __future__ import annotations

import numpy as np

from .borrowed import borrowing
from .dense import put

__all__ = ["SAME", "keep_if_new"]

# Velocities that differ by less than this share of the largest are the same.
SAME = 1e-6


@borrowing
def keep_if_new(W: np.ndarray, P: np.ndarray, scale: float, found: np.ndarray, count: int) -> int:
    """How many answers there are with P, which is written if there is none like it.

    Args:
        W: (m, m) Delassus matrix [1/kg].
        P: (m,) impulses [N s].
        scale: the size of the velocities [m/s].
        found: (most, m) impulses of the answers so far; with room for no more, P is left out.
        count: how many these are.
    """
    size = len(P)
    for s in range(count):
        apart = 0.0
        for r in range(size):
            apart = max(apart, W[r, r] * abs(P[r] - found[s, r]))
        if apart <= SAME * scale:
            return count
    if count < len(found):
        put(P, found[count])
        return count + 1
    return count
