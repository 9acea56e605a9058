"""A step between its start and end as compiled code sees it, with bodies that may collide."""

from __future__ import annotations

import numpy as np

from ...laws.compiled import Entry
from ..events.corners import crossings_of
from ..events.touch import touch_pairs
from ..gaps.advancing import slope_of
from ..gaps.contacts import Gaps
from ..gaps.pairs import Pairs
from ..rest.contacts import Resting
from ..steps.explicit import Output
from ..zeros.roots import PIECES
from .mover import Mover

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
        """See ``events.passage.Passage``."""
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

    def crossings(self, resting: Resting, times: list[float]) -> np.ndarray | None:
        """What ``crossings_of`` tells of points that rest; None where it can't be told."""
        contacts, mover, dense = resting.contacts, self._mover, self._dense
        if resting.rolling is not None or resting.may_tear or not _is_there(crossings_of):
            return None
        table = self._gaps.table(contacts)
        held = None if table is None else self._gaps.ends_of_held(contacts)
        if table is None or held is None:
            return None
        system = mover.flown(self._reference)
        system = system._replace(table=table, sliding=resting.sliding())
        work = mover.room._replace(before=dense.before, powers=dense.powers)
        return crossings_of(
            system, work, self._pairs, held, dense.start, dense.length, np.array(times)
        )

    @property
    def can_touch(self) -> bool:
        """Whether ``touch`` is compiled."""
        return _is_there(touch_pairs)


def _is_there(entry: Entry) -> bool:
    entry.load()
    return entry.is_compiled
