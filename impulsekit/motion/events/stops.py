"""When a sliding point stops, a resting contact lifts, or bodies touch elsewhere."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from itertools import pairwise

import numpy as np

from ...geometry.features import BESIDE
from ..gaps.contacts import Gaps
from ..rest.contacts import Resting
from ..rest.slip import LIFTED_OFF_STOP, write_signs
from ..zeros.roots import States, falling_root
from .passage import Passage

__all__ = ["first_stop"]

# A body that rests has come down elsewhere, this deep [m].
ELSEWHERE = 1e-10
# A point so far beside its face, or beyond the end of its edge, has left it [m].
LEFT = 2.0 * BESIDE


def first_stop(
    gaps: Gaps,
    resting: Resting,
    states: States,
    start: float,
    end: float,
    pushing: Callable[[float], np.ndarray],
    left_to_tear: Callable[[float], np.ndarray],
    passage: Passage | None = None,
) -> tuple[float, bool] | None:
    """When a sliding point first stops or has got going, or a contact has lifted, in a step.

    Or when a resting body comes down elsewhere, or a point leaves its face or edge; gives the
    time, and whether it was one of these two. ``left_to_tear``: by point, the margin of static
    friction [m/s²]. ``pushing``: by point, whether it is loaded: between the ends of a step the
    velocity is known to tolerance only, so that a loaded point may seem to leave: it does when its
    load ends. ``passage``: the step as compiled code sees it, where it does.
    """
    contacts = resting.contacts
    if not contacts:
        return None
    count = len(resting.slips())

    def loaded(i: int, t: float) -> bool:
        return bool(pushing(t)[i : i + 1].any())

    times = gaps.turning.nodes(states, start, end)
    told = None if passage is None else passage.crossings(resting, times)
    if told is None:
        fallen = _fallen(_Signs(gaps, resting, states, start, left_to_tear), times)
    else:
        fallen = _by_piece(told, len(times) - 1)
    opening: dict[int, float] = {}
    for right, found in zip(times[1:], fallen, strict=True):
        stop = _first_of(found, count, loaded, opening)
        if opening:
            speeds = gaps.velocities(contacts, *states(right))[2::3]
            let_go = _let_go(opening, speeds, loaded, right)
            if let_go is not None and (stop is None or let_go < stop[0]):
                stop = let_go, False
        if stop is not None:
            return stop
    return None


def _by_piece(told: np.ndarray, pieces: int) -> Iterator[list[tuple[float, int]]]:
    """By piece of a step, when which of its signs fall to zero, as ``crossings_of`` tells."""
    for k in range(pieces):
        yield [(t, int(i)) for _, i, t in told[told[:, 0] == k].tolist()]


def _fallen(signs: _Signs, times: list[float]) -> Iterator[list[tuple[float, int]]]:
    """By piece of a step, when which of its signs fall to zero."""
    before = signs.all(times[0])
    for left, right in pairwise(times):
        after = signs.all(right)
        crossed = np.flatnonzero((before > 0.0) & (after <= 0.0) & np.isfinite(before))
        yield [(falling_root(partial(signs.one, i), left, right), i) for i in crossed.tolist()]
        before = after


class _Signs:
    """What falls below zero within a step where something happens to what rests.

    By point: slip along its first direction, −lift, growth of slip, and whether it is still on its
    face or edge; one for all that comes down elsewhere; then what rolls and tears.
    """

    def __init__(
        self,
        gaps: Gaps,
        resting: Resting,
        states: States,
        start: float,
        left_to_tear: Callable[[float], np.ndarray],
    ) -> None:
        self._gaps, self._resting, self._states = gaps, resting, states
        self._left_to_tear = left_to_tear
        self._slips, rolling = resting.slips(), resting.rolling
        self._count = len(self._slips)
        many = 0 if rolling is None else 4 * len(rolling.points(resting.contacts))
        many += self._count if resting.may_tear else 0
        self._more = np.full(many, np.inf)
        lowest, _ = gaps.beyond_held(resting.contacts, *states(start))
        # Where something touches already, it may come no deeper than by rounding.
        self._lowest = min(lowest, 0.0) - ELSEWHERE

    def all(self, t: float) -> np.ndarray:
        q, v = self._states(t)
        speeds, by_point = self._of_speeds(t, q, v), 3 * self._count
        return np.concatenate([speeds[:by_point], self._of_places(q, v), speeds[by_point:]])

    def one(self, i: int, t: float) -> float:
        q, v = self._states(t)
        count = self._count
        if 3 * count <= i <= 4 * count:
            return float(self._of_places(q, v)[i - 3 * count])
        return float(self._of_speeds(t, q, v)[i if i < 3 * count else i - count - 1])

    def _of_places(self, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Below zero where a point has left its face or edge; last, where one came down."""
        below, inside = self._gaps.beyond_held(self._resting.contacts, q, v)
        if len(inside) != self._count:
            inside = np.full(self._count, np.inf)
        return np.concatenate([inside + LEFT, [below - self._lowest]])

    def _of_speeds(self, t: float, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Below zero where something has happened: slip along its first direction, or −lift."""
        resting, more = self._resting, self._more
        contacts, rolling = resting.contacts, resting.rolling
        u = self._gaps.velocities(contacts, q, v)
        if len(u) != 3 * self._count:
            return np.concatenate([np.full(3 * self._count, np.inf), more])
        turning = np.empty(0)
        if rolling is not None:
            turning = rolling.signs(contacts, rolling.turning(self._gaps, contacts, q, v))
        if resting.may_tear:
            turning = np.concatenate([turning, self._left_to_tear(t)])
        own = np.empty((self._count, 3))
        write_signs(u, self._slips, resting.grown, own)
        return np.concatenate([own.T.ravel(), turning if len(turning) == len(more) else more])


def _first_of(
    crossed: list[tuple[float, int]],
    count: int,
    loaded: Callable[[int, float], bool],
    opening: dict[int, float],
) -> tuple[float, bool] | None:
    """The first of the signs that fall to zero, for which see ``first_stop``; None without one.

    Points that seem to leave while they are loaded are written to ``opening``, with the time.
    """
    for t, i in sorted(crossed):
        point = i - count
        if not 0 <= point < count:
            return t, 3 * count <= i <= 4 * count
        if not loaded(point, t):
            when = _end_of_load(loaded, point, opening[point], t) if point in opening else t
            return when, False
        opening[point] = t
    return None


def _let_go(
    opening: dict[int, float],
    speeds: np.ndarray,
    loaded: Callable[[int, float], bool],
    end: float,
) -> float | None:
    """When the first of the points that seemed to leave is loaded no longer; None without one.

    Their signs are below zero already and do not fall again: it is the load that is asked, at the
    end of each piece of a step. Those that are closed again there may seem to leave once more.

    Args:
        opening: by point, when it was loaded last [s].
        speeds: (n,) at which points open at the end [m/s].
        end: of the piece [s].
    """
    first = None
    for i, low in opening.items():
        if loaded(i, end):
            opening[i] = end
        elif i < len(speeds) and speeds[i] > LIFTED_OFF_STOP:
            let_go = _end_of_load(loaded, i, low, end)
            first = let_go if first is None else min(first, let_go)
    return first


def _end_of_load(
    loaded: Callable[[int, float], bool], point: int, low: float, high: float
) -> float:
    """The last double at which a point is loaded, between a time at which it is and one later.

    A step that ends there has no jump of the load in it, nor has the next one, in which the point
    leaves: dense output of a step that has one wavers by more than ``LIFTED_OFF_STOP``.
    """
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if loaded(point, middle) else (low, middle)
    return low
