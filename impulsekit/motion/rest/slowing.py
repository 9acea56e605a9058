"""How soon the slip of resting points stops, if accelerations stay as they are.

A step that goes far past such a stop has stages near it, where rounding of the slip across is
divided by what slip is left: it ends soon after the stop instead.
"""

from __future__ import annotations

import math

import numpy as np

from ...laws.borrowed import borrowed, borrowing
from ..tree.pressed import SLIDES

__all__ = ["FURTHER", "until_stopping"]

# Steps go so much further than to where something is foreseen [of the way there]: near its ends a
# step's dense output is as good as the step, and nothing is made twice.
FURTHER = 0.02


@borrowing
def until_stopping(slip: np.ndarray, accelerations: np.ndarray, ways: np.ndarray) -> float:
    """How long a step may be to end soon after the first slip stops [s]; infinite without one.

    Slip s with the rate a has nothing left along itself at t = −s²/(s·a).

    Args:
        slip, accelerations: (3n,) of the points, the normal last [m/s], [m/s²].
        ways: (n, 3) as ``Sliding`` has them.

    Example:
        >>> slip, slows = np.array([0.5, 0.0, 0.0]), np.array([-2.0, 0.0, 0.0])
        >>> float(until_stopping(slip, slows, np.array([[1.0, 0.0, 1.0]])))
        0.255
    """
    slip, accelerations, ways = borrowed(slip), borrowed(accelerations), borrowed(ways)
    soonest = math.inf
    if len(slip) != 3 * len(ways):
        # Of points that rested before.
        return soonest
    for i in range(len(ways)):
        s1, s2 = slip[3 * i], slip[3 * i + 1]
        slows = -(s1 * accelerations[3 * i] + s2 * accelerations[3 * i + 1])
        if ways[i, 2] == SLIDES and slows > 0.0:
            soonest = min(soonest, (s1 * s1 + s2 * s2) / slows)
    return soonest * (1.0 + FURTHER) if soonest > 0.0 else math.inf
