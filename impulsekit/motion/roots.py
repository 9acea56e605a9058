"""Zeros in time of what falls within a step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

__all__ = ["PIECES", "States", "falling_root"]

# Absolute [s] and relative tolerance for a root.
FOUND = 1e-15
# Between nodes a solution bends little: a window is at most one radian of its fastest motion.
PIECES = 4

States = Callable[[float], tuple[np.ndarray, np.ndarray]]


def falling_root(function: Callable[[float], float], start: float, end: float) -> float:
    """Where a function that is positive at the start, and not at the end, comes to zero."""
    from scipy.optimize import brentq

    if function(start) <= 0.0:
        return start
    if function(end) > 0.0:
        return end
    return float(brentq(function, start, end, xtol=FOUND, rtol=FOUND))
