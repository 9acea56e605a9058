"""Zeros in time of what falls within a step."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

__all__ = ["PIECES", "States", "falling_root", "quadratic_roots"]

# Between nodes a solution bends little: a step is about one radian of its fastest motion.
PIECES = 4

States = Callable[[float], tuple[np.ndarray, np.ndarray]]


def falling_root(function: Callable[[float], float], start: float, end: float) -> float:
    """Where a function that is positive at the start, and not at the end, comes to zero."""
    from scipy.optimize import brentq

    if function(start) <= 0.0:
        return start
    if function(end) > 0.0:
        return end
    return float(brentq(function, start, end, xtol=1e-15, rtol=1e-15))


def quadratic_roots(a: float, b: float, c: float) -> list[float]:
    """The real zeros of a s² + b s + c, rising."""
    if abs(a) <= 1e-14 * (abs(b) + abs(c)):
        return [-c / b] if b else []
    root = b * b - 4.0 * a * c
    if root < 0.0:
        return []
    half = -0.5 * (b + np.copysign(np.sqrt(root), b))
    zeros = [half / a] + ([c / half] if half else [])
    return sorted(zeros)
