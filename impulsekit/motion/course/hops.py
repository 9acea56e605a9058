"""How high and how long what has just been struck is about to hop."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from ..gaps.resting import RestingContact
from .present import Present

__all__ = ["Hop", "find_hops", "low_hops"]


class Hop(NamedTuple):
    """A gap that opens, and will close again if its acceleration stays.

    Attributes:
        gap: its index. duration: [s]. height: [m].
    """

    gap: int
    duration: float
    height: float


def size_of_hop(speed: float, pull: float) -> tuple[float, float]:
    """How long [s] and how high [m] what opens at a speed hops, and is pulled back [m/s²]."""
    return 2.0 * speed / pull, 0.5 * speed * speed / pull


def find_hops(now: Present, struck: Iterable[int]) -> list[Hop]:
    """The hops of gaps that have been struck and do not rest, point by point."""
    gaps = now.gaps
    if gaps is None:
        return []
    resting = {c.gap for c in now.resting.contacts}
    contacts = [
        RestingContact(i, int(gaps.entries[i]), 0.0, now.t) for i in struck if i not in resting
    ]
    if not contacts:
        return []
    acceleration = now.acceleration()
    rows, bias = gaps.rows_and_bias_at(contacts, now.q, now.v)
    speeds = rows.dot(now.v)[2::3].tolist()
    rates = (rows.dot(acceleration) + bias)[2::3].tolist()
    owners = [c.gap for c in contacts for _ in range(c.count)]
    seen = zip(owners, speeds, rates, strict=True)
    return [Hop(i, *size_of_hop(u, -a)) for i, u, a in seen if a < 0.0 < u]


def low_hops(now: Present, hops: Sequence[Hop]) -> list[int]:
    """The gaps whose hops are too low or too short to be told from rest.

    A hop within the rounding error of its gap ends at another speed than it began with: it would
    be followed by others without end. One no longer than ``together`` closes with what has just
    closed.
    """
    gaps = now.gaps
    if gaps is None or not hops:
        return []
    distances, _ = gaps.measure(now.q, now.v)
    found = []
    for hop in hops:
        if gaps.rated[hop.gap]:
            rounding = gaps.rounding(hop.gap, abs(float(distances[hop.gap])))
            if hop.height <= rounding or hop.duration <= now.settings.together:
                found.append(hop.gap)
    return found
