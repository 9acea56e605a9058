"""All answers that Coulomb's law has at one contact: its modes in closed form."""

from __future__ import annotations

import numpy as np

from .approach import block_at
from .borrowed import borrowed
from .compiled import entry
from .coulomb import (
    NO_SLIP,
    bounded_friction,
    sliding_impulse,
    slips,
    sticking_impulse,
)
from .found import keep_if_new
from .quartic import slides
from .tolerances import AT_REST, ROUNDING_OF_SUMS

__all__ = ["answers_of_one"]


def _examples() -> tuple[object, ...]:
    return np.eye(3), np.ones(3), 0.5, 0.0, 1.0, np.ones((2, 3))


@entry(_examples, seconds=2.0, apart=True)
def answers_of_one(
    W: np.ndarray, b: np.ndarray, mu: float, floor: float, scale: float, found: np.ndarray
) -> tuple[int, bool]:
    """How many answers there are, and whether these are all.

    It parts or is given back its floor, sticks, or slides in a direction of the quartic. Where it
    sticks by many shares of one load, one of them stands for all: velocities are the same, but
    what is given back later may differ.

    Args:
        W: (3, 3) Delassus matrix [1/kg].
        b: (3,) ξ without impulse [m/s].
        mu: friction, above 0.
        floor: the least normal impulse [N s].
        scale: the size of the velocities [m/s].
        found: (most, 3), written: P [N s].
    """
    W, b, found = borrowed(W), borrowed(b), borrowed(found)
    block, P = block_at(W, 0), np.zeros(3)
    b1, b2, bn = b[0], b[1], b[2]
    count, determined = 0, True
    least1, least2 = bounded_friction(block, b1, b2, floor, mu)
    across, along = block[3] * least1 + block[4] * least2, block[5] * floor
    rounding = AT_REST * scale
    if floor > 0.0:
        rounding = ROUNDING_OF_SUMS * max(scale, abs(across), along)
    if bn + across + along >= -rounding:
        P[0], P[1], P[2] = least1, least2, floor
        count = keep_if_new(W, P, scale, found, count)
    if not block[5] > 0.0:
        return count, True
    (p1, p2, pn), sticks, determined = sticking_impulse(block, b1, b2, bn, mu, scale)
    if sticks and pn > floor:
        P[0], P[1], P[2] = p1, p2, pn
        count = keep_if_new(W, P, scale, found, count)
    if abs(bn) > NO_SLIP * scale:
        ways, one, two, three, four = slides(block, b1, b2, bn, mu)
        for k in range(ways):
            way = one if k == 0 else two if k == 1 else three if k == 2 else four
            impulse = sliding_impulse(block, bn, mu, way)
            # Slip that vanishes is one more share of what sticks.
            if impulse[2] > floor and (determined or slips(block, b1, b2, impulse, scale)):
                P[0], P[1], P[2] = impulse
                count = keep_if_new(W, P, scale, found, count)
    return count, determined
