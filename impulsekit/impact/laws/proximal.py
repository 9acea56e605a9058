"""Newton through nearby problems that are regular, for contacts redundant in their modes too.

W + εI with b − εP_k has its solution near P_k, and a fixed point P_{k+1} = P_k solves the
problem itself (Rockafellar 1976, the proximal point method). ε falls while Newton gets
there, and grows where it does not.
"""

from __future__ import annotations

import numpy as np

from .modes import Modes

__all__ = ["approach"]

FIRST, LEAST, MOST = 0.1, 1e-6, 1.0
# Rows that move next to nothing count as moving this share of what the lightest does.
LIGHTEST = 1e-14
MOST_STEPS = 80
# What a step's own residual must come down to.
STEP_BAR = 1e-9


def approach(modes: Modes, start: np.ndarray, bar: float) -> tuple[np.ndarray, float, int]:
    """P, its residual and the number of steps, from ``start``.

    Args:
        modes: the problem.
        start: (3n,) where to begin [N s].
        bar: the residual to come down to.
    """
    share = FIRST
    # Each contact by its own mass, whichever way its tangents point.
    sizes = modes.delassus.diagonal().reshape(-1, 3).sum(axis=1)
    rates = np.repeat(np.maximum(sizes, LIGHTEST * modes.largest), 3)
    impulse, best, least = start, start, np.inf
    for count in range(1, MOST_STEPS + 1):
        epsilon = share * rates
        regular = modes.delassus.copy()
        regular.ravel()[:: len(start) + 1] += epsilon
        nearby = modes.shifted - epsilon * impulse
        near = Modes(regular, nearby, modes.friction, modes.floor, modes.scale)
        found, left = near.polish(impulse)
        if left > STEP_BAR:
            share = min(4.0 * share, MOST)
            continue
        impulse, share = found, max(0.5 * share, LEAST)
        residual = modes.residual(impulse)
        if residual < least:
            best, least = impulse, residual
            if least <= bar:
                # From here Newton on the problem itself may reach rounding level.
                found, left = modes.polish(best)
                return (found, left, count) if left < least else (best, least, count)
    return best, least, MOST_STEPS
