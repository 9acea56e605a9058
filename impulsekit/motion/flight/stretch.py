"""Steps that compiled code has made at once, as pieces of a path when somebody asks for them."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from ..gaps.contacts import Gaps
from ..gaps.resting import RestingContact
from ..record.path import Piece
from ..rest.contacts import Resting
from ..rest.footing import NOTHING, Footing
from ..steps.explicit import Output
from ..travel.advance import Log
from ..travel.journey import Ledger

__all__ = ["Stretch"]


class Stretch:
    """The first steps of a log, which are copied.

    Args:
        log, ledger: of the call that made them. count: how many.
        gaps, resting: of the motion.
    """

    def __init__(
        self, log: Log, ledger: Ledger, count: int, gaps: Gaps | None, resting: Resting
    ) -> None:
        self._log = Log._make(array[:count].copy() for array in log)
        stood = (ledger.resting, ledger.gaps, ledger.since)
        self._resting, self._gaps, self._since = (array[:count].copy() for array in stood)
        self._items, self._slow, self._negligible = gaps, resting.slow, resting.negligible
        self._footings: dict[int, Footing] = {}

    def piece(self, k: int) -> Piece:
        """One of the steps."""
        log, first = self._log, int(self._firsts[k])
        footing = self._footings.get(first)
        if footing is None:
            footing = self._footings[first] = self._footing(first)
        start, end = float(log.starts[k]), float(log.ends[k])
        dense = Output(start, float(log.lengths[k]), log.before[k], log.powers[k])
        return Piece(start, end, log.references[k], dense, footing)

    @cached_property
    def _firsts(self) -> np.ndarray:
        """(k,) the first of the steps before each in which all rested as in it."""
        k = len(self._resting)
        differs = np.ones(k, dtype=bool)
        differs[1:] = False
        stood = (self._resting, self._gaps, self._since, self._log.slides)
        for own in stood:
            flat = own.reshape(k, -1)
            differs[1:] |= (flat[1:] != flat[:-1]).any(axis=1)
        return np.maximum.accumulate(np.where(differs, np.arange(k), 0))

    def _footing(self, k: int) -> Footing:
        gaps, n = self._items, int(self._resting[k])
        if gaps is None or not n:
            return NOTHING
        contacts = []
        for at in range(n):
            i, point = int(self._gaps[k, at]), slice(at, at + 1)
            own = int(gaps.entries[i]), gaps.items[i].friction, float(self._since[k, at])
            contacts.append(RestingContact(i, *own, 1, self._log.slides[k, point]))
        return Footing(tuple(contacts), (None,) * n, self._slow, self._negligible)
