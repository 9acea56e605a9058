"""A step between its start and end as compiled code sees it, with bodies that may collide."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from ..laws.compiled import Entry
from .advancing import slope_of
from .compiled_look import Watched
from .compiled_mover import Mover
from .compiled_stops import signs_at
from .compiled_touch import touch_pairs
from .explicit import Output
from .gaps import Gaps
from .pairs import Pairs
from .resting import Resting
from .roots import PIECES

__all__ = ["Passage"]

SLOPE = slope_of(np.linspace(0.0, 1.0, PIECES + 1))


class Passage:
    """What compiled code tells of a step.

    Args:
        mover: what moves. gaps: of all contacts. pairs: of them.
        reference: (nq,) of the chart that the step was made in. dense: its states.
    """

    def __init__(
        self, mover: Mover, gaps: Gaps, pairs: Pairs, reference: np.ndarray, dense: Output
    ) -> None:
        self._mover, self._gaps, self._pairs, self._dense = mover, gaps, pairs, dense
        self._reference = reference

    def touch(self, base: np.ndarray, until: float, speeds: np.ndarray) -> tuple[float, int]:
        """As ``crossing.Touching``."""
        dense, system = self._dense, self._mover.flown(self._reference)
        work = self._mover.room._replace(before=dense.before, powers=dense.powers)
        turning = self._gaps.turning.speeds
        return touch_pairs(
            system,
            work,
            self._pairs,
            turning,
            SLOPE,
            base,
            dense.start,
            dense.length,
            until,
            speeds,
        )

    def signs(self, resting: Resting) -> Callable[[float], np.ndarray] | None:
        """What ``signs_at`` tells of points that rest, at a time; None where it can't be told."""
        contacts, mover, dense = resting.contacts, self._mover, self._dense
        if resting.rolling is not None or resting.may_tear or not _is_there(signs_at):
            return None
        table = self._gaps.table(contacts)
        held = None if table is None else self._gaps.ends_of_held(contacts)
        if table is None or held is None:
            return None
        ways, begins = resting.ways_of_slip()
        system = mover.flown(self._reference)._replace(table=table)
        work = mover.room._replace(before=dense.before, powers=dense.powers)
        watched: Watched = mover.slipping(ways, begins)
        start, length, pairs = dense.start, dense.length, self._pairs

        def signs(t: float) -> np.ndarray:
            return signs_at(system, work, watched, pairs, held, (t - start) / length)

        return signs

    @property
    def can_touch(self) -> bool:
        """Whether ``touch`` is compiled."""
        return _is_there(touch_pairs)


def _is_there(entry: Entry) -> bool:
    entry.load()
    return entry.is_compiled
