"""Whether contacts are penetrated deeper than a motion that is right can press them in."""

from __future__ import annotations

import numpy as np

from ..gaps.contacts import Gaps
from ..record.status import MotionStatus
from .present import Present, Stopped

__all__ = ["Penetration"]

# Overlaps of bodies that are right stay below 2e-6 m: what a start may have, and the 1e-7 m to
# which coal tells those of round bodies. Deeper than this [m] something was missed.
OF_BODIES = 1e-5
# Small bodies overlap by no more than this part of the smaller one's radius,
PART_OF_RADIUS = 1e-3
# but coal and the start may be off by this [m] whatever their size.
ALWAYS = 2e-6
# Points over planes [m] and stops [m, rad]: their drift is taken out after every step.
OF_OTHERS = 1e-4


class Penetration:
    """Watches the gaps of a motion, beside what they were when it began.

    Attributes:
        deepest: (m,) how deep each may be [m, rad].
    """

    def __init__(self, now: Present) -> None:
        self._now = now
        self.deepest = np.empty(0)
        if now.gaps is not None:
            gap, _ = now.gaps.everything(now.q, now.v)
            gap[sorted(now.passing)] = 0.0
            self.deepest = np.minimum(gap, 0.0) - _allowed(now.gaps)

    def refuse(self) -> None:
        """Look at the gaps once.

        Raises:
            Stopped: one of them is deeper than it was at the start by more than is credible.
        """
        now, gaps = self._now, self._now.gaps
        if gaps is None or not len(self.deepest):
            return
        gap, _ = gaps.everything(now.q, now.v)
        gap[sorted(now.passing)] = 0.0
        worst = int(np.argmin(gap - self.deepest))
        if gap[worst] < self.deepest[worst]:
            name = now.scene.entry_names("contacts")[gaps.entries[worst]]
            raise Stopped(
                MotionStatus.PENETRATION,
                f"{name} would be penetrated by {-gap[worst]:.3g} (m, or rad of a stop) "
                f"at t = {now.t:.6g} s",
            )


def _allowed(gaps: Gaps) -> np.ndarray:
    """(m,) how deep gaps may be [m, rad]."""
    allowed = [
        OF_OTHERS if rated else max(min(OF_BODIES, PART_OF_RADIUS * item.smaller_radius), ALWAYS)
        for item, rated in zip(gaps.items, gaps.rated, strict=True)
    ]
    return np.array(allowed)
