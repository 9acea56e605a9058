"""An error estimate of a motion: a second run at a tenth of its tolerance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..errors import InputError
from ..formatting import OneLine
from ..robot.arrays import lock
from ..scene.motion import LEAST_RTOL, MotionSettings
from .simulate import simulate

if TYPE_CHECKING:
    from .record.trajectory import Trajectory

__all__ = ["MotionCheck", "check_motion"]

# What the second run is held to, relative to the first.
TENTH = 0.1
# Of a fixed step; methods of order 4 are 16 times as accurate then.
HALF = 0.5


@dataclass(frozen=True, eq=False, repr=False)
class MotionCheck(OneLine):
    """A motion beside the same at a tenth of its tolerance. Arrays are read-only.

    Attributes:
        t: (T,) the sample times of both [s].
        position: (T,) the largest difference of a coordinate [m, rad].
        velocity: (T,) the largest difference of a speed [m/s, rad/s].
        comparable: (T,) where both have had as many impacts; between an impact of one and the
            same of the other their velocities have nothing to do with each other.
        impacts: how many there were, in the motion and in the second one.
        impact_times: (K,) how far apart their times are, of as many as both have [s].
        second: the second motion.
    """

    t: np.ndarray
    position: np.ndarray
    velocity: np.ndarray
    comparable: np.ndarray
    impacts: tuple[int, int]
    impact_times: np.ndarray
    second: Trajectory

    @property
    def same_impacts(self) -> bool:
        """True if both have the same number of impacts."""
        return self.impacts[0] == self.impacts[1]

    @property
    def position_error(self) -> float:
        """The largest difference of a coordinate in the whole motion [m, rad]."""
        return float(self.position.max(initial=0.0))

    @property
    def velocity_error(self) -> float:
        """The largest difference of a speed where the two are comparable [m/s, rad/s]."""
        return float(self.velocity[self.comparable].max(initial=0.0))


def check_motion(motion: Trajectory) -> MotionCheck:
    """Follow a motion once more at a tenth of its tolerance, or with half its fixed step.

    The difference is an estimate of the error of the first run, which is the larger one. Where
    motions depend on their start ever more (a box that tumbles) it grows as the error does.

    Raises:
        InputError: the tolerance cannot be any smaller, or a motion was not followed to its end.
        ImpulsekitError: as ``simulate``.
    """
    if not motion.status.finished:
        raise InputError(
            f"check takes a motion that was followed to its end, this one is {motion.status.name}"
        )
    robot = motion.scene.robot
    q, v = motion.at(0.0)
    if motion.impacts and motion.impacts[0][0] == 0.0:
        # Before the impulses strike.
        first = motion.impacts[0][1]
        q, v = np.array(first.q), np.array(first.v_before)
    second = simulate(motion.scene, q, v, samples=motion.t, settings=_tighter(motion.settings))
    count = len(second.t) if second.status.finished else len(second.t) - 1
    t, comparable = motion.t[:count].copy(), np.zeros(count, dtype=bool)
    position, velocity = np.empty(count), np.empty(count)
    hits = [np.array([time for time, _ in one.impacts]) for one in (motion, second)]
    for i, time in enumerate(t):
        own = pin.difference(robot.model, second.q[i], motion.q[i])
        position[i] = np.abs(own).max(initial=0.0)
        velocity[i] = np.abs(motion.v[i] - second.v[i]).max(initial=0.0)
        comparable[i] = (hits[0] <= time).sum() == (hits[1] <= time).sum()
    both = min(map(len, hits))
    times = np.abs(hits[0][:both] - hits[1][:both])
    lock(t, position, velocity, comparable, times)
    return MotionCheck(
        t, position, velocity, comparable, (len(hits[0]), len(hits[1])), times, second
    )


def _tighter(settings: MotionSettings) -> MotionSettings:
    """Settings with a tenth of the tolerance."""
    if settings.method in ("rk4", "semi-implicit"):
        return settings.changed(step=HALF * settings.step)
    if settings.rtol <= LEAST_RTOL:
        raise InputError(
            f"rtol is {settings.rtol:g}, the least there is: no second run can be more accurate"
        )
    return settings.changed(rtol=max(TENTH * settings.rtol, LEAST_RTOL), atol=TENTH * settings.atol)
