"""Names that entries of a scene act on, and the proof that they fit a robot."""

from __future__ import annotations

from collections.abc import Sequence

from ..errors import InputError
from ..robot import Robot
from ..robot.base import WORLD


class Acting:
    """An entry that acts on no frame and in no joint by name."""

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return ()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints it acts in."""
        return ()


class BetweenFrames(Acting):
    """One that acts on two frames."""

    frame: str
    other: str

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame, self.other)


class InJoint(Acting):
    """One that acts in a joint."""

    joint: str

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints it acts in."""
        return (self.joint,)


def check_two_bodies(robot: Robot, frames: Sequence[str], where: str, why: str) -> None:
    """Prove that a robot has both frames, on two bodies; ``why`` else nothing happens.

    Raises:
        UnknownNameError: a frame that the robot does not have.
        InputError: both are on one rigid body.
    """
    first, other = frames
    joints = [robot.model.frames[robot.frame_id(name, where)].parentJoint for name in frames]
    if joints[0] == joints[1]:
        body = "the world" if joints[0] == 0 else "one rigid body"
        raise InputError(f'{where}: "{first}" and "{other}" both belong to {body}; {why}')


def check_frame_moves(robot: Robot, frame: str, where: str, what: str, advice: str = "") -> None:
    """Prove that a robot has a frame, and that it can move.

    Raises:
        UnknownNameError: the robot does not have it.
        InputError: it is fixed to the world.
    """
    if robot.model.frames[robot.frame_id(frame, where)].parentJoint == 0:
        whole = "the world" if frame == WORLD else f'"{frame}", fixed to the world,'
        raise InputError(f"{where}: {what} on {whole} moves nothing{advice and '; ' + advice}")


def check_one_degree(robot: Robot, joint: str, where: str, what: str) -> None:
    """Prove that a joint moves, with one degree of freedom.

    Raises:
        UnknownNameError: the robot does not have it.
        InputError: it is fixed, or has several.
    """
    count = robot.model.joints[robot.joint_id(joint, where)].nv
    if count != 1:
        raise InputError(
            f'{where}: joint "{joint}" has {count} degrees of freedom, {what} takes a joint with '
            "one"
        )
