"""When the torque of a PD law comes to its limit, or back from it: steps of a motion end there."""

from __future__ import annotations

from functools import partial

import numpy as np
import pinocchio as pin

from ..forces.laws import BEYOND, LIMITED, SIDE, Loads, left_of_limit, torque_of
from ..zeros.roots import States
from ..zeros.windows import Turning
from .kink import PART, Kink, first_fall, with_rate

__all__ = ["LimitKinks"]


class LimitKinks:
    """The PD laws of a motion that have a limit: whether they are at it now.

    Each is below its limit (0), at the upper one (1) or at the lower one (−1).
    """

    def __init__(self, loads: Loads, model: pin.Model) -> None:
        rows = loads.kinks[loads.kinks[:, 0] == LIMITED, 1].tolist()
        self._laws = [(loads.joints[i], loads.in_joints[i]) for i in rows]
        self._turning = Turning(model)

    def begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Set all for a state, at the start or after a jump of the velocity."""
        for joint, numbers in self._laws:
            torque = torque_of(joint, numbers, q, v)
            numbers[SIDE] = np.sign(torque) if abs(torque) > numbers[5] else 0.0

    def first(self, states: States, start: float, end: float) -> Kink | None:
        """The first torque that comes to its limit, or back; see ``Kinks.first``."""
        times = np.array(self._turning.nodes(states, start, end))
        beyond = BEYOND * max(float(numbers[5]) for _, numbers in self._laws)

        def left(t: float) -> np.ndarray:
            state = states(t)
            return np.array([left_of_limit(*law, *state) for law in self._laws]) + beyond

        t, which = first_fall(left, times, beyond)
        if which < 0:
            return None
        joint, numbers = self._laws[which]
        torque = torque_of(joint, numbers, *states(t))
        becomes = float(np.sign(torque)) if numbers[SIDE] == 0.0 else 0.0

        def off(t: float, states: States) -> float:
            return left_of_limit(joint, numbers, *states(t))

        step = PART * (times[1] - times[0])
        return Kink(t, partial(numbers.__setitem__, SIDE, becomes), with_rate(off, step))
