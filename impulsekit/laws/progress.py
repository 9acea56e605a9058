"""How far one impact along its path has come, and the workspace that this takes."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .borrowed import borrowing
from .compiled import compiled
from .words import NEWTON, POISSON

__all__ = [
    "COMPRESSING", "FALLS", "FRICTION", "NORMAL", "ORDER", "P1", "P2", "PRESSED", "REGAINED",
    "RESIDUAL", "SPENT", "U1", "U2", "UN", "Block", "P", "PathMemory", "Triple", "is_over",
    "left_to_go", "path_memory",
]  # fmt: skip

# A target below this share of the velocities counts as zero.
NO_TARGET = 1e-15
# W of one contact: t1t1, t1t2, t2t2, t1n, t2n, nn [1/kg].
Block = tuple[float, float, float, float, float, float]
# Along the tangents and the normal.
Triple = tuple[float, float, float]

# Where in ``PathMemory.now`` is what. The relative velocity [m/s]; the impulse [N s]; work of
# friction [J]; impulse and (negative) work of compression, work of restitution; 1 in compression,
# else 0; 1 where slip pressed the contact further in. At the end: the work of the normal
# impulse, and how far the end is from what the law asks, relative.
U1, U2, UN, P1, P2, P, FRICTION, PRESSED, SPENT, REGAINED = range(10)
COMPRESSING, FALLS, NORMAL, RESIDUAL, _COUNT = range(10, 15)
# Of the Taylor series.
ORDER = 20


class PathMemory(NamedTuple):
    """What one impact writes while it is followed; it may be used again.

    Attributes:
        now: (14,) how far it has come, by the names above.
        series: (8, ORDER + 1) Taylor coefficients, see ``taylor``.
    """

    now: np.ndarray[tuple[int], np.dtype[np.float64]]
    series: np.ndarray[tuple[int, int], np.dtype[np.float64]]


@compiled
def path_memory() -> PathMemory:
    """New memory for ``follow``."""
    return PathMemory(np.zeros(_COUNT), np.zeros((8, ORDER + 1)))


@borrowing
def left_to_go(
    now: np.ndarray[tuple[int], np.dtype[np.float64]], law: int, e: float, target: float
) -> Triple:
    """What ends the phase at hand, in u_n, in p and in work; infinite where it is not asked."""
    if now[COMPRESSING] > 0.0:
        return -now[UN], math.inf, math.inf
    if law == NEWTON:
        return target - now[UN], math.inf, math.inf
    if law == POISSON:
        return math.inf, (1.0 + e) * now[PRESSED] - now[P], math.inf
    return math.inf, math.inf, -e * e * now[SPENT] - now[REGAINED]


@borrowing
def is_over(
    now: np.ndarray[tuple[int], np.dtype[np.float64]],
    law: int,
    e: float,
    target: float,
    scale: float,
) -> bool:
    """Go over from compression to restitution, or tell that the impact is over."""
    if now[COMPRESSING] == 0.0:
        return True
    now[COMPRESSING] = 0.0
    now[UN] = 0.0
    return e == 0.0 or (law == NEWTON and target <= NO_TARGET * scale)
