"""When a sliding point stops, a resting contact lifts, or bodies touch elsewhere."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from ..geometry.features import BESIDE
from .gaps import Gaps
from .resting import Resting
from .roots import States, falling_root

if TYPE_CHECKING:
    from .passage import Passage

__all__ = ["first_stop"]

# Normal speed at which a resting contact has lifted [m/s].
LIFTED = 1e-8
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
    velocity is known to tolerance only, so that a loaded point may seem to leave. ``passage``: the
    step as compiled code sees it, where it does.
    """
    if not resting.contacts:
        return None
    count = len(resting.slides())
    times = gaps.turning.nodes(states, start, end)
    told = None if passage is None else passage.crossings(resting, times)
    if told is not None:
        for k in range(len(times) - 1):
            fallen = [(t, int(i)) for _, i, t in told[told[:, 0] == k].tolist()]
            stop = _first_of(fallen, count, pushing)
            if stop is not None:
                return stop
        return None
    signs = _Signs(gaps, resting, states, start, left_to_tear)
    before = signs.all(times[0])
    for left, right in pairwise(times):
        after = signs.all(right)
        crossed = np.flatnonzero((before > 0.0) & (after <= 0.0) & np.isfinite(before))
        # scipy's brentq wants the sign to differ strictly; zero itself is one of them.
        found = [(falling_root(partial(signs.one, i), left, right), i) for i in crossed.tolist()]
        stop = _first_of(found, count, pushing)
        if stop is not None:
            return stop
        before = after
    return None


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
        self._slides, self._begins = resting.slides(), resting.begins()
        self._count, rolling = len(self._slides), resting.rolling
        many = 0 if rolling is None else 4 * len(rolling.owners(resting.contacts))
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
        along = [
            np.inf if s is None else float(u[3 * i : 3 * i + 2].dot(s))
            for i, s in enumerate(self._slides)
        ]
        grows = [
            resting.grown - float(np.hypot(*u[3 * i : 3 * i + 2])) if begins else np.inf
            for i, begins in enumerate(self._begins)
        ]
        own = [along, LIFTED - u[2::3], grows]
        return np.concatenate([*own, turning if len(turning) == len(more) else more])


def _first_of(
    crossed: list[tuple[float, int]], count: int, pushing: Callable[[float], np.ndarray]
) -> tuple[float, bool] | None:
    """The first of the signs that fall to zero, for which see ``first_stop``; None without one."""
    for t, i in sorted(crossed):
        lifted = count <= i < 2 * count
        if not (lifted and pushing(t)[i - count : i - count + 1].any()):
            return t, 3 * count <= i <= 4 * count
    return None
