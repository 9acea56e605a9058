"""``Recording``: configurations over time, from wherever they come."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..display import OneLine
from ..errors import InputError, NotFiniteError, RangeError, ShapeError, a_thing, quoted
from ..robot import Robot
from ..robot.state import QUATERNION_TOLERANCE, checked_configuration

if TYPE_CHECKING:
    from ..impact import Impact

__all__ = ["Recording"]


@dataclass(frozen=True, eq=False, repr=False)
class Recording(OneLine):
    """Configurations of a robot over time: a log, the result of another simulator, a path.

    Attributes:
        robot: the robot.
        t: (T,) times [s], not decreasing; read-only.
        q: (T, nq) configurations; read-only.
        impacts: pairs of a time [s] and an ``Impact``.

    Raises:
        InputError: no instant, or an impact of another robot.
        ShapeError, NotFiniteError, RangeError: the arrays do not match.
        StateError: a quaternion is not of unit length.

    Example:
        >>> robot = Robot.from_example("panda")
        >>> q = np.array([robot.neutral(), robot.configuration(panda_joint1=1.0)])
        >>> round(float(Recording(robot, [0.0, 2.0], q).at(np.array([0.5]))[0, 0]), 3)
        0.25
    """

    robot: Robot
    t: Any
    q: Any
    impacts: Iterable[tuple[float, Impact]] = ()

    def __post_init__(self) -> None:
        if not isinstance(self.robot, Robot):
            raise InputError(f"Recording: robot is {a_thing(self.robot)}, not a Robot")
        t, q = (_floats(array, what) for what, array in (("t", self.t), ("q", self.q)))
        if t.ndim != 1:
            raise ShapeError.of("Recording: t", (t.size,), t.shape)
        if t.size == 0:
            raise InputError("Recording: there is no instant in it, so nothing can be shown")
        if q.shape != (t.size, self.robot.nq):
            raise ShapeError.of("Recording: q", (t.size, self.robot.nq), q.shape)
        for what, array in (("t", t), ("q", q)):
            if not np.isfinite(array).all():
                index = int(np.flatnonzero(~np.isfinite(array.reshape(t.size, -1)).all(axis=1))[0])
                raise NotFiniteError.of(f"Recording: {what}", f"instant {index}", array[index])
        if (np.diff(t) < 0.0).any():
            index = int(np.flatnonzero(np.diff(t) < 0.0)[0])
            raise RangeError.of(f"Recording: t[{index + 1}]", t[index + 1], f"{t[index]} or more")
        for row in q:
            if not pin.isNormalized(self.robot.model, row, QUATERNION_TOLERANCE):
                checked_configuration(self.robot.model, row)
        impacts = tuple((float(time), impact) for time, impact in self.impacts)
        for time, impact in impacts:
            if impact.scene.robot.nq != self.robot.nq:
                raise InputError(f"Recording: the impact at {time:g} s is of another robot")
        for array in (t, q):
            array.setflags(write=False)
        for field, value in (("t", t), ("q", q), ("impacts", impacts)):
            object.__setattr__(self, field, value)

    def at(self, times: np.ndarray) -> np.ndarray:
        """(F, nq) configurations at (F,) times [s], along geodesics between the instants."""
        after = np.clip(np.searchsorted(self.t, times, side="right"), 1, max(len(self.t) - 1, 1))
        found = np.empty((len(times), self.robot.nq))
        for row, (time, i) in enumerate(zip(times, after, strict=True)):
            if len(self.t) == 1:
                found[row] = self.q[0]
                continue
            span = self.t[i] - self.t[i - 1]
            share = float(np.clip((time - self.t[i - 1]) / span, 0.0, 1.0)) if span > 0 else 1.0
            if share in (0.0, 1.0):
                found[row] = self.q[i - 1 + round(share)]
            else:
                found[row] = pin.interpolate(self.robot.model, self.q[i - 1], self.q[i], share)
        return found


def _floats(values: Any, what: str) -> np.ndarray:
    try:
        return np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        sentence = f"Recording: {what} must be numbers, got {quoted(values)}"
        raise NotFiniteError(sentence, what=what, where=what) from None
