"""Forces that are functions of time: looked at between the stages of a step, and where they jump.

An integrator knows a force at its own stages alone: where a quiet flight lets it make long steps,
a short pulse falls between them. Each step is therefore looked at on a grid of times; where a
force is not what the polynomial through eight of its values says, the step is made shorter.
"""

from __future__ import annotations

import math
from bisect import bisect_right
from collections.abc import Callable

import numpy as np

from ...scene.motion import MotionSettings
from ..forces.field import ForceField
from ..record.path import NODES, interpolated

__all__ = ["ForceWatch"]

# So many times a motion are its functions looked at: what acts for a thousandth of it is met at
# least once. Shorter pulses need ``max_step`` or ``stop_times``.
LOOKS = 2000
# Beyond this part of the largest value seen a force is not what the step takes it for. What a step
# within tolerance makes of a smooth force is a thousand times nearer.
UNLIKE = 1e-3


class ForceWatch:
    """Says where steps have to end, and which were too long."""

    def __init__(self, forces: ForceField, settings: MotionSettings) -> None:
        self._forces = forces
        self._end = settings.duration
        ends = {*settings.stop_times, *forces.driven.corners}
        self._stops = sorted(t for t in ends if 0.0 < t < settings.duration)
        self._spacing = settings.duration / LOOKS
        self._largest: np.ndarray | None = None
        self._firsts = np.zeros(0, dtype=int)
        self._from, self._to = -math.inf, math.inf

    def begin(self, t: float) -> float:
        """A stretch begins at a time: where it has to end at the latest [s]."""
        at = bisect_right(self._stops, t)
        stop = self._stops[at] if at < len(self._stops) else math.inf
        # A force that jumps at a stop has its value before it on this side, and after it on that.
        self._from = math.nextafter(t, math.inf) if t in self._stops else -math.inf
        self._to = math.nextafter(stop, -math.inf)
        return min(stop, self._end)

    def is_stop(self, t: float) -> bool:
        """Whether a step had to end at this time."""
        return t in self._stops

    def within(self, t: float) -> float:
        """The time at which forces are evaluated: on this stretch's side of its ends."""
        return min(max(t, self._from), self._to)

    def shorter(
        self,
        start: float,
        end: float,
        states: Callable[[float], tuple[np.ndarray, np.ndarray]],
    ) -> float | None:
        """The length [s] with which a step is to be made again, or None where it will do."""
        if not self._forces.has_functions or not end - start > 2.0 * self._spacing:
            return None
        first = math.floor(start / self._spacing) + 1
        grid = np.arange(first, math.ceil(end / self._spacing)) * self._spacing
        grid = grid[(grid > start) & (grid < end)]
        nodes = start + NODES * (end - start)
        every = self._values([*nodes.tolist(), *grid.tolist()], states)
        values, seen = every[: len(nodes)], every[len(nodes) :]
        largest = self._by_function(np.abs(every)).max(axis=0)
        largest[~np.isfinite(largest)] = 0.0
        if self._largest is not None:
            largest = np.maximum(largest, self._largest)
        self._largest = largest
        off = np.abs(seen - interpolated((grid - start) / (end - start), values))
        unlike = (self._by_function(off) > UNLIKE * largest).any(axis=1)
        if not unlike.any():
            return None
        before = float(grid[int(np.argmax(unlike))]) - self._spacing - start
        return max(self._spacing, min(before, 0.5 * (end - start)))

    def _by_function(self, values: np.ndarray) -> np.ndarray:
        """(k, f) the largest of the numbers that each function gives."""
        return np.maximum.reduceat(values, self._firsts, axis=1)

    def _values(
        self, times: list[float], states: Callable[[float], tuple[np.ndarray, np.ndarray]]
    ) -> np.ndarray:
        """(k, m) the numbers that all functions give."""
        forces, none = self._forces, (np.empty(0), np.empty(0))
        rows = [
            forces.given(self.within(t), *(states(t) if forces.asks_for_states else none))
            for t in times
        ]
        self._firsts = np.cumsum([0, *(len(own) for own in rows[0])])[:-1]
        return np.array([np.concatenate(row) for row in rows])
