"""The first gap that closes within a step.

Gaps with a rate are cubics between nodes of the step; wherever such a cubic comes near zero
(its Bernstein coefficients bound it), the dense output itself is searched, extrema
included. Colliding bodies come without a rate: there time advances by no more than gap
over largest closing speed (conservative advancement; Mirtich & Canny 1995).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from .gaps import Gaps
from .roots import PIECES, States, falling_root, quadratic_roots

__all__ = ["Crossing", "first_crossing"]

MARGIN = 1e-3
# A gap that only dips this far below zero [m] was grazed.
GRAZED = 1e-12
# Colliding bodies this near touch [m], where their gap is told to rounding and where it is coal's.
TOUCH, TOUCH_OF_COAL = 1e-12, 1e-10
# Steps of conservative advancement are no shorter than this part of a step.
FINEST = 1.0 / 128.0


@dataclass(frozen=True)
class Crossing:
    """The first time at which gaps close.

    Attributes:
        t: [s].
        gaps: the indices of those that close then, or within the window after it.
    """

    t: float
    gaps: tuple[int, ...]


def first_crossing(
    gaps: Gaps,
    states: States,
    start: float,
    end: float,
    base: np.ndarray,
    resting: Sequence[int],
    window: float,
) -> Crossing | None:
    """The first closing of a gap in a step.

    Args:
        gaps: of all contacts.
        states: (q, v) at a time within the step.
        start, end: of the step [s].
        base: (m,) what counts as zero of each gap [m].
        resting: the indices of gaps that are closed and stay so.
        window: gaps that close this soon after the first count as closing with it [s].
    """
    watched = np.ones(len(gaps.items), dtype=bool)
    watched[list(resting)] = False
    if not watched.any():
        return None
    times = np.linspace(start, end, PIECES + 1)
    times[-1] = end
    rated = np.flatnonzero(watched & gaps.rated)
    others = np.flatnonzero(watched & ~gaps.rated)
    first = np.inf
    found = -1
    speeds = np.zeros(len(gaps.items))
    values, rates = np.empty((len(times), len(base))), np.empty((len(times), len(base)))
    for row, t in enumerate(times.tolist()):
        values[row], rates[row] = gaps.measure(*states(t), rated.tolist())
        for i in others.tolist():
            speeds[i] = max(speeds[i], gaps.items[i].speed_bound(gaps.data))
    if rated.size:
        search = _Search(gaps, states, base)
        first, found = search.first(times, values, rates, rated)
    for i in others.tolist():
        t = _advance(gaps, states, i, float(base[i]), start, min(end, first), speeds[i])
        if t < first:
            first, found = t, i
    if found < 0:
        return None
    q, v = states(first)
    gap, rate = gaps.measure(q, v, np.flatnonzero(watched).tolist())
    together = {found}
    for i in np.flatnonzero(watched).tolist():
        speed = -rate[i] if gaps.rated[i] else speeds[i]
        if speed > 0.0 and gap[i] - base[i] <= speed * window:
            together.add(i)
    return Crossing(first, tuple(sorted(together)))


class _Search:
    """The first downward zero of rated gaps."""

    def __init__(self, gaps: Gaps, states: States, base: np.ndarray) -> None:
        self._gaps, self._states, self._base = gaps, states, base

    def first(
        self, times: np.ndarray, values: np.ndarray, rates: np.ndarray, rated: np.ndarray
    ) -> tuple[float, int]:
        """The time and the gap; infinity and -1 where none closes."""
        for k in range(len(times) - 1):
            h = times[k + 1] - times[k]
            left, right = (
                values[k, rated] - self._base[rated],
                values[k + 1, rated] - self._base[rated],
            )
            slope_left, slope_right = rates[k, rated], rates[k + 1, rated]
            bounds = np.array(
                [left, left + h * slope_left / 3.0, right - h * slope_right / 3.0, right]
            )
            lowest, highest = bounds.min(axis=0), bounds.max(axis=0)
            near = lowest <= MARGIN * (highest - lowest)
            best, found = np.inf, -1
            for j in np.flatnonzero(near).tolist():
                t = self._within(
                    int(rated[j]),
                    (float(times[k]), float(times[k + 1])),
                    (float(left[j]), float(right[j])),
                    (float(slope_left[j]), float(slope_right[j])),
                    at_start=k == 0,
                )
                if t < best:
                    best, found = t, int(rated[j])
            if found >= 0:
                return best, found
        return np.inf, -1

    def _within(
        self,
        i: int,
        span: tuple[float, float],
        values: tuple[float, float],
        slopes: tuple[float, float],
        *,
        at_start: bool,
    ) -> float:
        """The first downward zero of gap i between two nodes."""
        start, end = span
        marks = [start, *self._extrema(i, span, values, slopes), end]
        heights = [values[0], *(self._value(i, t) for t in marks[1:-1]), values[1]]
        # A gap that has just been left is as good as open.
        open_already = heights[0] > 0.0 or (at_start and slopes[0] > 0.0)
        if not open_already and heights[0] <= 0.0:
            if slopes[0] < 0.0 or heights[1] < heights[0]:
                return start
            open_already = True
        for k in range(1, len(marks)):
            if heights[k] >= 0.0 or (k < len(marks) - 1 and heights[k] > -GRAZED):
                continue
            if heights[k - 1] <= 0.0:
                # Left and met again between two nodes, nearer than numbers can tell.
                return marks[k - 1] if k > 1 else self._after_launch(i, marks[0], marks[1])
            return self._root(i, marks[k - 1], marks[k])
        return np.inf

    def _after_launch(self, i: int, start: float, end: float) -> float:
        """The zero of a gap that starts at zero and opens at first."""
        span = end - start
        for _ in range(60):
            span *= 0.5
            if self._value(i, start + span) > 0.0:
                return self._root(i, start + span, min(end, start + 2.0 * span))
        return start

    def _extrema(
        self,
        i: int,
        span: tuple[float, float],
        values: tuple[float, float],
        slopes: tuple[float, float],
    ) -> list[float]:
        """The times at which the gap is highest or lowest between two nodes."""
        start, end = span
        h = end - start
        d = (values[1] - values[0]) / h
        # The cubic's slope at s in (0, 1): a s² + b s + c.
        a = 3.0 * (slopes[0] + slopes[1] - 2.0 * d)
        b = 2.0 * (3.0 * d - 2.0 * slopes[0] - slopes[1])
        c = slopes[0]
        zeros = quadratic_roots(a, b, c)
        inside = [start + s * h for s in zeros if 0.0 < s < 1.0]
        return [self._refined(i, t, span) for t in inside]

    def _refined(self, i: int, t: float, span: tuple[float, float]) -> float:
        """The zero of the rate itself near that of the cubic's."""
        for _ in range(3):
            rate = self._rate(i, t)
            width = 1e-4 * (span[1] - span[0])
            low, high = max(span[0], t - width), min(span[1], t + width)
            if not high > low:
                break
            bend = (self._rate(i, high) - self._rate(i, low)) / (high - low)
            if bend == 0.0:
                break
            better = min(max(t - rate / bend, span[0]), span[1])
            if abs(better - t) <= 1e-12 * (span[1] - span[0]):
                return better
            t = better
        return t

    def _value(self, i: int, t: float) -> float:
        return float(self._gaps.measure(*self._states(t), (i,))[0][i] - self._base[i])

    def _rate(self, i: int, t: float) -> float:
        return float(self._gaps.measure(*self._states(t), (i,))[1][i])

    def _root(self, i: int, start: float, end: float) -> float:
        return falling_root(lambda t: self._value(i, t), start, end)


def _advance(
    gaps: Gaps, states: States, i: int, base: float, start: float, end: float, speed: float
) -> float:
    """When two bodies touch; infinity where they do not."""

    def gap(t: float) -> float:
        q, v = states(t)
        return float(gaps.measure(q, v, (i,))[0][i]) - base

    # The bound is from nodes; between them speed changes little.
    speed = 1.2 * speed + 1e-9
    start, end = float(start), float(end)
    exact = gaps.exact(i)
    touch = TOUCH if exact else TOUCH_OF_COAL
    least = FINEST * (end - start)
    t, before = start, start
    value = gap(t)
    leaving = value <= touch
    while t < end:
        if leaving:
            step = least
        else:
            step = max(value / speed, least)
        before, t = t, min(end, max(t + step, float(np.nextafter(t, end))))
        last, value = value, gap(t)
        if leaving:
            if value > touch:
                leaving = False
            # What coal tells may go deeper little by little where nothing closes.
            elif value < (-touch if exact else min(last, 0.0) - 10.0 * touch):
                return _hop(gap, before, t, touch)
            continue
        if value <= touch:
            return falling_root(gap, before, t) if value < 0.0 < last else t
    return np.inf


def _hop(gap: Callable[[float], float], start: float, end: float, touch: float) -> float:
    """When bodies that touch at the start, and overlap at the end, have met again."""
    span = end - start
    for _ in range(40):
        span *= 0.5
        if gap(start + span) > touch:
            return falling_root(gap, start + span, start + 2.0 * span)
    return start
