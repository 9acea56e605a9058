"""The points of contacts that rest, as tables for compiled code, kept while they are the same."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from operator import is_not
from typing import Any

import numpy as np

from ...geometry.point_table import Table, TableRow, table_of
from .pairs import Held, Pairs
from .resting import RestingContact

__all__ = ["PointTables"]

# So many tables of points are kept.
MOST_TABLES = 64


@dataclass(frozen=True, eq=False)
class _KnownTable:
    """The table of some gaps, the held points that it was made of, and how many each has."""

    held: list[object]
    counts: list[int]
    table: Table | None

    @classmethod
    def of(cls, held: list[object], found: list[list[TableRow] | None]) -> _KnownTable:
        rows: list[TableRow] = []
        for own in found:
            if own is None:
                return cls(held, [], None)
            rows += own
        return cls(held, [len(own or ()) for own in found], table_of(rows) if rows else None)


class PointTables:
    """Tables of the points of gaps.

    Args:
        items: the gaps one by one.
        rated: (m,) whether a gap comes with its rate.
    """

    def __init__(self, items: Sequence[Any], rated: np.ndarray) -> None:
        self._items, self._rated = items, rated
        self._tables: dict[tuple[int, ...], _KnownTable] = {}
        self._ends: tuple[tuple[int, ...], list, Held | None] | None = None

    def of(self, contacts: Sequence[RestingContact]) -> Table | None:
        """All points of contacts; None where some are found anew at each state."""
        key = tuple(contact.gap for contact in contacts)
        held = [self._items[i].held for i in key]
        known = self._tables.get(key)
        if known is None or any(map(is_not, known.held, held)):
            if len(self._tables) > MOST_TABLES:
                self._tables.clear()
            known = _KnownTable.of(held, [self._items[i].in_table() for i in key])
            self._tables[key] = known
        if known.table is not None:
            for contact, count in zip(contacts, known.counts, strict=True):
                contact.count = count
        return known.table

    def ends_of_held(
        self, contacts: Sequence[RestingContact], pairs: Pairs, paired: np.ndarray
    ) -> Held | None:
        """Where held points of contacts end; None where some are not of ``pairs`` or not held.

        ``paired``: (m,) which gaps are of the pairs.
        """
        key = tuple(c.gap for c in contacts)
        held = [self._items[i].held for i in key]
        known = self._ends
        if known is not None and known[0] == key and not any(map(is_not, known[1], held)):
            return known[2]
        self._ends = (key, held, self._made_ends(contacts, pairs, paired))
        return self._ends[2]

    def _made_ends(
        self, contacts: Sequence[RestingContact], pairs: Pairs, paired: np.ndarray
    ) -> Held | None:
        own = [(c, self._items[c.gap]) for c in contacts]
        if not all(
            self._rated[c.gap] or (paired[c.gap] and item.held is not None) for c, item in own
        ):
            return None
        borders, spans, rows, first = [np.zeros((0, 6))], [(0, 0)], [np.zeros((0, 3), int)], 0
        is_held: list[bool] = []
        for contact, item in own:
            held = [None] if self._rated[contact.gap] else item.held
            is_held += [point is not None for point in held]
            for point in held:
                edges = np.zeros((0, 6)) if point is None else point.borders
                borders.append(edges)
                spans.append((spans[-1][1], spans[-1][1] + len(edges)))
            if not self._rated[contact.gap]:
                numbers = np.flatnonzero(pairs.whole[:, 0] == contact.gap)
                last = np.full(len(numbers), first + len(held))
                rows.append(np.column_stack([numbers, np.full(len(numbers), first), last]))
            first += len(held)
        ends = np.concatenate(borders), np.array(spans[1:])
        return Held(*ends, np.concatenate(rows), np.array(is_held))
