"""When the torque of a PD law comes to its limit, or back from it: steps of a motion end there."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np
import pinocchio as pin

from .compiled_loads import BEYOND, SIDE
from .force_field import LimitedPD
from .kink import PART, Kink, first_fall, with_rate
from .roots import States
from .windows import Turning

__all__ = ["LimitKinks"]


class LimitKinks:
    """The PD laws of a motion that have a limit: whether they are at it now.

    Each is below its limit (0), at the upper one (1) or at the lower one (−1).
    """

    def __init__(self, laws: Sequence[LimitedPD], model: pin.Model) -> None:
        self._laws, self._turning = laws, Turning(model)
        self._sides = np.zeros(len(laws))
        self._tables: list[tuple[np.ndarray, int]] = []

    def connect(self, tables: list[tuple[np.ndarray, int]]) -> None:
        """Keep rows of compiled code's tables, by law, up to date as well."""
        self._tables = tables
        self._write()

    def begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Set all for a state, at the start or after a jump of the velocity."""
        torques = [law.unlimited(q, v) for law in self._laws]
        self._sides = np.array(
            [
                np.sign(torque) if abs(torque) > law.limit else 0.0
                for torque, law in zip(torques, self._laws, strict=True)
            ]
        )
        self._write()

    def first(self, states: States, start: float, end: float) -> Kink | None:
        """The first torque that comes to its limit, or back; see ``Kinks.first``."""
        times = np.array(self._turning.nodes(states, start, end))
        beyond = BEYOND * max(law.limit for law in self._laws)

        def left(t: float) -> np.ndarray:
            state = states(t)
            return np.array([self._left(i, *state) for i in range(len(self._laws))]) + beyond

        t, i = first_fall(left, times, beyond)
        if i < 0:
            return None
        torque = self._laws[i].unlimited(*states(t))
        becomes = float(np.sign(torque)) if self._sides[i] == 0.0 else 0.0

        def off(t: float, states: States) -> float:
            return self._left(i, *states(t))

        return Kink(t, partial(self._set, i, becomes), with_rate(off, PART * (times[1] - times[0])))

    def _left(self, i: int, q: np.ndarray, v: np.ndarray) -> float:
        """Positive until a law comes to its limit, or back [N m, N]."""
        law, side = self._laws[i], self._sides[i]
        torque = law.unlimited(q, v)
        return law.limit - abs(torque) if side == 0.0 else side * torque - law.limit

    def _set(self, i: int, side: float) -> None:
        self._sides[i] = side
        self._write()

    def _write(self) -> None:
        for (table, row), side in zip(self._tables, self._sides.tolist(), strict=False):
            table[row, SIDE] = side
