"""A motion beside a recording of it: how far apart bodies are, and how far turned."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, Protocol

import numpy as np
import pinocchio as pin

from ...errors import InputError, RangeError, a_thing
from ...formatting import OneLine
from ...robot.arrays import lock

if TYPE_CHECKING:
    from ...robot import Robot
    from .sampled import SampledMotion

__all__ = ["Comparison", "compare", "first_link", "frame_distances", "moving_links"]


class Recorded(Protocol):
    """A recording for comparison: times and configurations, measured or computed."""

    @property
    def t(self) -> np.ndarray:
        """(T,) times [s]."""

    @property
    def q(self) -> np.ndarray:
        """(T, nq) configurations."""


@dataclass(frozen=True, eq=False, repr=False)
class Comparison(OneLine):
    """Distances between a frame of a motion and the same frame of a recording. Read-only.

    Attributes:
        frame: its name.
        t: (T,) the recording's times within the motion [s].
        position: (T,) the distance between its origins [m].
        rotation: (T,) the angle between its axes [rad].
    """

    frame: str
    t: np.ndarray
    position: np.ndarray
    rotation: np.ndarray

    @property
    def rms_position(self) -> float:
        """The root of the mean square of the distances [m]."""
        return float(np.sqrt(np.mean(self.position**2)))

    @property
    def rms_rotation(self) -> float:
        """The root of the mean square of the angles [rad]."""
        return float(np.sqrt(np.mean(self.rotation**2)))


def compare(motion: SampledMotion, recording: Recorded, frame: str | None) -> Comparison:
    """See ``Trajectory.compare``."""
    robot = motion.scene.robot
    times, q = getattr(recording, "t", None), getattr(recording, "q", None)
    if not isinstance(times, np.ndarray) or not isinstance(q, np.ndarray):
        raise InputError(f"compare takes a Recording or a Trajectory, got {a_thing(recording)}")
    if q.shape != (len(times), robot.nq):
        raise InputError(
            f"the recording has configurations of {q.shape[-1]} numbers, this robot has {robot.nq}"
        )
    inside = (times >= 0.0) & (times <= motion.duration)
    if not inside.any():
        raise RangeError.of(
            "the recording's times", f"{times[0]:g} to {times[-1]:g} s",
            f"some from 0 to {motion.duration:g} s",
        )  # fmt: skip
    name = first_link(motion.scene.robot) if frame is None else frame
    ours = np.array([motion.at(time)[0] for time in times[inside]])
    position, rotation = frame_distances(robot, name, ours, q[inside])
    arrays = times[inside].copy(), position, rotation
    lock(*arrays)
    return Comparison(name, *arrays)


def frame_distances(
    robot: Robot, frame: str, ours: np.ndarray, theirs: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(T,) distances [m] and (T,) angles [rad] between a frame at (T, nq) configurations."""
    frame_id = robot.frame_id(frame)
    model, data = robot.model, robot.model.createData()
    position, rotation = np.empty(len(ours)), np.empty(len(ours))
    for k, pair in enumerate(zip(ours, theirs, strict=True)):
        places = []
        for configuration in pair:
            pin.forwardKinematics(model, data, np.array(configuration))
            places.append(pin.SE3(pin.updateFramePlacement(model, data, frame_id)))
        position[k] = np.linalg.norm(places[0].translation - places[1].translation)
        rotation[k] = np.linalg.norm(pin.log3(places[1].rotation.T @ places[0].rotation))
    return position, rotation


def first_link(robot: Robot) -> str:
    """The first body that moves.

    Raises:
        InputError: there is none.
    """
    for _, name in _links(robot):
        return name
    raise InputError("this robot has no link that moves; name a frame")


def _links(robot: Robot) -> Iterator[tuple[int, str]]:
    """The bodies that move, with the joints that carry them."""
    for frame in robot.model.frames:
        if frame.type == pin.FrameType.BODY and frame.parentJoint > 0:
            yield int(frame.parentJoint), str(frame.name)


def moving_links(robot: Robot) -> list[str]:
    """The first body behind each joint that moves, in the order of the joints.

    Raises:
        InputError: there is none.
    """
    found: dict[int, str] = {}
    for joint_id, name in _links(robot):
        found.setdefault(joint_id, name)
    if not found:
        first_link(robot)
    return [found[joint] for joint in sorted(found)]
