"""The instant within a step at which geoms come to touch or a limit is reached."""

from __future__ import annotations

from typing import Any

import numpy as np

from .._core import ClosingGaps, ContactListing
from .listing import DEEPER, StepModels

__all__ = ["TOUCHING", "find_instant"]

# A contact this far apart at the instant of an impact is a row of it [m].
TOUCHING = 1e-6
# A gap is closed where it is smaller than this [m, rad], and not below zero: there MuJoCo's soft
# contact would brake what parts.
CLOSED = 1e-11
# Parabolas close a gap in two or three; bisection to the last bit needs fifty.
MOST_ROUNDS = 60


def find_instant(
    models: StepModels, data: Any, start: np.ndarray,
    duration: float, gaps: ClosingGaps, threshold: float, is_exact: bool,
) -> tuple[float, ContactListing, list[int]]:  # fmt: skip
    """Bring ``data`` to the instant of the first impact among closing gaps, and look at it.

    Args:
        start: the state at the start of the step, of the kinds ``KEPT``.
        duration: of the step. gaps: as they are at its end.
        threshold: approach speed above which what closes is an impact [m/s].
        is_exact: False for the start of the step in place of the instant.

    Returns:
        The time passed, what is listed then, and the numbers in it of what hits then; none where
        all that closes does so slowly.
    """
    reach = DEEPER + 2.0 * duration * gaps.fastest
    models.restore(data, start)
    listing = models.look(data, reach)
    gaps.follow(listing, 0.0)
    if not is_exact:
        return 0.0, listing, gaps.hits(np.inf, threshold)
    # What touched from the start and approaches faster is hit at once.
    passed, closed = 0.0, CLOSED
    while not (hits := gaps.hits(closed, threshold)):
        gaps.drop(closed)
        if not gaps.count:
            break
        low, high = passed, duration
        for _ in range(MOST_ROUNDS):
            passed = gaps.closing_time(low, high, 0.5 * CLOSED)
            models.restore(data, start)
            models.fly(data, passed)
            listing = models.look(data, reach)
            gaps.follow(listing, passed)
            least = gaps.least
            if 0.0 <= least <= CLOSED or high - low <= np.spacing(high):
                break
            # What touches slowly is no impact: its instant need not be known better.
            if abs(least) <= TOUCHING and not gaps.hits(TOUCHING, threshold):
                break
            low, high = (passed, high) if least > CLOSED else (low, passed)
        closed = max(TOUCHING, gaps.least)
    return passed, listing, hits
