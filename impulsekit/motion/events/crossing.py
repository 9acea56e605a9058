"""The first gap that closes within a step: none is passed over.

A step is looked at window by window, so that bodies that turn often in it are seen as often.
Gaps with a rate are searched as smooth functions (``zeros.closing``); of colliding bodies time
advances by what is surely free of contact (``gaps.advancing``).
"""

from __future__ import annotations

import time
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from ..gaps.advancing import BodyMotion, bound_of, may_meet, motion_of, touch_finder
from ..gaps.contacts import Gaps
from ..gaps.pairs import PairOfPieces
from ..gaps.turning_planes import Pose
from ..zeros.closing import Node
from ..zeros.roots import States, first_zero
from ..zeros.windows import nodes_between
from .passage import Passage
from .touch import TOUCH, touch_pairs

__all__ = ["Crossing", "Seen", "first_crossing"]

# Colliding bodies this near touch [m], where their gap is coal's.
TOUCH_OF_COAL = 1e-10

# Of pairs of pieces that are functions of time.
_first_touch = touch_finder(lambda sight, t: sight(t))


@dataclass(frozen=True)
class Crossing:
    """The first time at which gaps close.

    Attributes:
        t: [s].
        gaps: the indices of those that close then, or within the window after it.
    """

    t: float
    gaps: tuple[int, ...]


@dataclass(frozen=True)
class Seen:
    """What may happen in a step.

    Attributes:
        closes: whether a gap may close.
        stops: whether a resting point may stop or lift.
        crossing: when gaps close; None where that is still to be found out.
        bends: whether a one-sided spring may begin or cease to act.
    """

    closes: bool
    stops: bool
    crossing: Crossing | None = None
    bends: bool = True


def first_crossing(
    gaps: Gaps,
    states: States,
    start: float,
    end: float,
    base: np.ndarray,
    resting: Sequence[int],
    window: float,
    passing: Collection[int] = (),
    passage: Passage | None = None,
) -> Crossing | None:
    """The first closing of a gap in a step.

    Args:
        gaps: of all contacts.
        states: (q, v) at a time within the step.
        start, end: of the step [s].
        base: (m,) what counts as zero of each gap [m].
        resting: the indices of gaps that are closed and stay so.
        window: gaps that close this soon after the first count as closing with it [s].
        passing: the indices of gaps that are below zero, and looked at for when they open.
        passage: the step as compiled code sees it; None where it does not.
    """
    watched = np.ones(len(gaps.items), dtype=bool)
    watched[list(resting)] = False
    if not watched.any():
        return None
    compiled = passage is not None and passage.can_touch
    search = _Search(gaps, states, base, watched, passing, not compiled)
    t, found = search.in_step(start, end)
    if passage is not None and compiled:
        t, found = search.before(t, found, end, passage)
    return None if found < 0 else Crossing(t, search.together(t, found, window))


class _Search:
    """The first gap that closes in a window of time."""

    def __init__(
        self,
        gaps: Gaps,
        states: States,
        base: np.ndarray,
        watched: np.ndarray,
        passing: Collection[int],
        one_by_one: bool,
    ) -> None:
        # What opens is what closes upside down.
        self._signs = np.ones(len(base))
        self._signs[sorted(passing)] = -1.0
        self._gaps, self._states, self._base = gaps, states, base
        self._watched = np.flatnonzero(watched)
        self._rated = np.flatnonzero(watched & gaps.rated)
        others = watched & ~gaps.rated
        self._others = np.flatnonzero(others if one_by_one else others & ~gaps.paired).tolist()
        self._paired = np.flatnonzero(others & gaps.paired)
        self._joints = {j for i in self._others for j in gaps.items[i].joint_ids}
        self._speeds = np.zeros(len(base))

    def in_step(self, start: float, end: float) -> tuple[float, int]:
        """The time and the gap, in a step; infinity and -1 where none closes."""
        states, turning = self._states, self._gaps.turning
        if not (len(self._rated) or self._others):
            return np.inf, -1
        nodes = nodes_between(start, end)
        seen = [states(t) for t in nodes]
        windows = turning.windows([v for _, v in seen], start, end)
        for left, right in pairwise(windows):
            if len(windows) > 2:
                nodes = nodes_between(left, right)
                seen = [states(t) for t in nodes]
            t, found = self.first(nodes, seen)
            if found >= 0:
                return t, found
        return np.inf, -1

    def before(self, t: float, found: int, end: float, passage: Passage) -> tuple[float, int]:
        """The same of colliding bodies where they touch before another gap closes at t."""
        base, own = np.full(len(self._base), np.inf), self._paired
        if not len(own):
            return t, found
        base[own], speeds = self._base[own], np.zeros(len(base))
        first, gap = passage.touch(base, min(end, t), speeds)
        self._speeds[own] = speeds[own]
        return (first, gap) if first < t else (t, found)

    def first(
        self, nodes: Sequence[float], seen: Sequence[tuple[np.ndarray, np.ndarray]]
    ) -> tuple[float, int]:
        """The time and the gap, from the states at the nodes of a window.

        Infinity and -1 where none closes.
        """
        times, (start, end) = np.array(nodes), (nodes[0], nodes[-1])
        rated = self._rated.tolist()
        values, rates = np.empty((2, len(times), len(self._base)))
        poses: dict[int, list] = {j: [] for j in self._joints}
        for row, state in enumerate(seen):
            values[row], rates[row] = self._gaps.measure(*state, rated)
            for joint_id, known in poses.items():
                known.append(self._gaps.pose(joint_id))
        first, found = np.inf, -1
        if rated:
            own = (values[:, rated] - self._base[rated]) * self._signs[rated]
            slopes = rates[:, rated] * self._signs[rated]
            first, which = first_zero(times, own, slopes, self._node, self._rounding)
            found = rated[which] if which >= 0 else -1
        if self._others:
            begin = time.thread_time()
            motions = {j: motion_of(times, known) for j, known in poses.items()}
            for i in self._others:
                t = self._touch(i, motions, start, min(end, first))
                if t < first:
                    first, found = t, i
            touch_pairs.wait(time.thread_time() - begin)
        return first, found

    def together(self, t: float, found: int, window: float) -> tuple[int, ...]:
        """The gaps that close with the first, within a window after it [s]."""
        watched = self._watched.tolist()
        gap, rate = self._gaps.measure(*self._states(t), watched)
        together = {found}
        for i in watched:
            speed = -rate[i] if self._gaps.rated[i] else self._speeds[i]
            if self._signs[i] > 0.0 and speed > 0.0 and gap[i] - self._base[i] <= speed * window:
                together.add(i)
        return tuple(sorted(together))

    def _node(self, i: int, t: float) -> Node:
        """A gap with a rate, the i-th of those that are watched, at a time."""
        i = int(self._rated[i])
        gap, rate = self._gaps.measure(*self._states(t), (i,))
        sign = float(self._signs[i])
        return Node(t, sign * float(gap[i] - self._base[i]), sign * float(rate[i]))

    def _rounding(self, i: int, size: float) -> float:
        return self._gaps.rounding(int(self._rated[i]), size)

    def _touch(self, i: int, motions: dict[int, BodyMotion], start: float, end: float) -> float:
        """When two bodies touch; infinity where they do not."""
        item = self._gaps.items[i]
        own = (motions[item.joint_ids[0]], motions[item.joint_ids[1]])
        exact = item.exact
        touch = TOUCH if exact else TOUCH_OF_COAL

        def sight_of(pair: PairOfPieces) -> Callable[[float], tuple]:
            def sight(t: float) -> tuple[float, np.ndarray, Pose, Pose]:
                self._gaps.move(*self._states(t))
                one, two = (self._gaps.pose(j) for j in item.joint_ids)
                gap, normal = pair.gap([self._gaps.data.oMi[j] for j in item.joint_ids])
                return gap, normal, one, two

            return sight

        self._speeds[i], first = 0.0, np.inf
        base = float(self._base[i])
        for pair in item.pairs:
            one, two = pair.supports
            meets, speed = may_meet(one, two, *own)
            self._speeds[i] = max(self._speeds[i], speed)
            if meets:
                bound, last = bound_of(one, two, *own), min(end, first)
                t = _first_touch(sight_of(pair), bound, start, last, base, touch, exact)
                first = min(first, t)
        return first
