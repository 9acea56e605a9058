"""When a joint with dry friction stops, or breaks away: steps of a motion end there.

A joint that moves stops, or turns round, where its velocity falls to zero. One that stands still
moves as soon as friction does not hold it: its acceleration, zero until then, grows.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from itertools import pairwise

import numpy as np
import pinocchio as pin

from ..forces.laws import BEYOND
from ..rest.joints import DryJoints
from ..zeros.roots import States, falling_root
from ..zeros.windows import Turning
from .kink import PART, Kink, first_fall, with_rate

__all__ = ["JointKinks"]


Accelerate = Callable[[float, np.ndarray, np.ndarray], np.ndarray]


class JointKinks:
    """The joints of a motion that have dry friction, and when they stop or move.

    Args:
        joints: what they do now.
        model: of the robot.
        accelerate: evaluates the accelerations at a time and state, and with them the friction.
    """

    def __init__(self, joints: DryJoints, model: pin.Model, accelerate: Accelerate) -> None:
        self._joints, self._accelerate = joints, accelerate
        self._turning = Turning(model)

    def begin(self, q: np.ndarray, v: np.ndarray) -> None:
        """Let joints move as a velocity (nv,) says, at the start or after a jump of it."""
        self._joints.begin(v)

    def first(self, states: States, start: float, end: float) -> Kink | None:
        """The first stop or break-away within a step; see ``Kinks.first``."""
        times = np.array(self._turning.nodes(states, start, end))
        stop = self._first_stop(states, times)
        until = end if stop is None else stop.t
        torn = self._first_tear(states, [*times[times < until].tolist(), until])
        return stop if torn is None else torn

    def _first_stop(self, states: States, times: np.ndarray) -> Kink | None:
        moving = np.flatnonzero(self._joints.ways)
        if not len(moving):
            return None
        signs, rows = self._joints.ways[moving], self._joints.rows[moving]

        def speeds(t: float) -> np.ndarray:
            return signs * states(t)[1][rows] + BEYOND

        t, i = first_fall(speeds, times, BEYOND)
        if i < 0:
            return None
        off = with_rate(self._speed(int(rows[i]), float(signs[i])), PART * (times[1] - times[0]))
        return Kink(t, partial(self._set, int(moving[i]), 0.0), off)

    def _speed(self, row: int, sign: float) -> Callable[[float, States], float]:
        return lambda t, states: sign * float(states(t)[1][row])

    def _first_tear(self, states: States, times: list[float]) -> Kink | None:
        joints = self._joints
        if not len(joints.still):
            return None

        def margin(t: float, states: States = states) -> float:
            self._accelerate(t, *states(t))
            return joints.left_to_tear()

        for left, right in pairwise(times):
            if margin(right) < 0.0:
                t, step = falling_root(margin, left, right), PART * (right - left)
                off = with_rate(margin, step)
                return Kink(t, partial(self._let_go, states, (t, min(t + step, right), right)), off)
        return None

    def _set(self, joint: int, way: float) -> None:
        self._joints.ways[joint] = way

    def _let_go(self, states: States, times: Sequence[float]) -> None:
        """Let move what does not hold at the first of these times at which something does not."""
        for t in times:
            self._accelerate(t, *states(t))
            if self._joints.tear():
                return
