"""``Scene``: a robot and what strikes, holds and touches it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from ..errors import InputError, ShapeError
from ..robot import Robot
from ..robot.robot import WORLD
from .constraints import Constraint, check_constraint
from .impulses import AppliedImpulse, JointImpulse
from .numbers import Vector, vector

__all__ = ["Scene"]


@dataclass(frozen=True, eq=False)
class Scene:
    """A robot and what strikes it. Frozen, picklable, checked against the robot when made.

    Attributes:
        robot: the robot.
        impulses: known impulses, from outside or inside joints.
        constraints: what holds: loops that are closed already, or grips, locks and
            landings that close at the instant of the impact.
        gravity: [m/s²] in world axes; it moves the robot in the motion after an
            impact. An impact is instantaneous and does not know it.

    Raises:
        UnknownNameError: a frame or joint that the robot does not have.
        ShapeError: a joint impulse or velocity of the wrong length.
        InputError: an impulse on the world, an anchor within one body, two entries of
            one name.

    Example:
        >>> robot = Robot.from_example("panda")
        >>> scene = Scene(robot, impulses=[AppliedImpulse("panda_hand", linear=[0, 0, 1])])
        >>> scene.impulses[0].frame
        'panda_hand'
    """

    robot: Robot
    impulses: Sequence[AppliedImpulse | JointImpulse] = ()
    constraints: Sequence[Constraint] = ()
    gravity: Vector = (0.0, 0.0, -9.81)

    def __post_init__(self) -> None:
        if not isinstance(self.robot, Robot):
            raise InputError(f"Scene: robot is a {type(self.robot).__name__}, not a Robot")
        set_field = object.__setattr__
        set_field(self, "impulses", _entries(self.impulses, "impulses"))
        set_field(self, "constraints", _entries(self.constraints, "constraints"))
        set_field(self, "gravity", vector(self.gravity, "Scene: gravity"))
        for i, impulse in enumerate(self.impulses):
            _check_impulse(self.robot, impulse, f"impulses[{i}]")
        for i, constraint in enumerate(self.constraints):
            check_constraint(self.robot, constraint, f"constraints[{i}]")
        self._check_names()

    def _check_names(self) -> None:
        counts = Counter((*self.entry_names("impulses"), *self.entry_names("constraints")))
        twice = [name for name, count in counts.items() if count > 1]
        if twice:
            raise InputError(f'Scene: {counts[twice[0]]} entries are called "{twice[0]}"')

    def entry_names(self, kind: str) -> tuple[str, ...]:
        """What results call the entries of a ``kind`` such as "impulses": name or place."""
        return tuple(entry.name or f"{kind}[{i}]" for i, entry in enumerate(getattr(self, kind)))


def _entries(value: Any, what: str) -> tuple[Any, ...]:
    try:
        return tuple(value)
    except TypeError:
        raise InputError(f"Scene: {what} is a {type(value).__name__}, a list is wanted") from None


def _check_impulse(robot: Robot, impulse: Any, where: str) -> None:
    if isinstance(impulse, AppliedImpulse):
        frame_id = robot.frame_id(impulse.frame, where)
        if robot.model.frames[frame_id].parentJoint == 0:
            whole = (
                "the world" if impulse.frame == WORLD else f'"{impulse.frame}", fixed to the world,'
            )
            raise InputError(
                f"{where}: an impulse on {whole} moves nothing; strike a link that can move, "
                'or load the robot with root="freeflyer"'
            )
    elif isinstance(impulse, JointImpulse):
        joint = robot.model.joints[robot.joint_id(impulse.joint, where)]
        if len(impulse.impulse) != joint.nv:
            raise ShapeError.of(
                f'{where}: impulse in joint "{impulse.joint}"', (joint.nv,), (len(impulse.impulse),)
            )
    else:
        raise InputError(
            f"{where} is a {type(impulse).__name__}, wanted is an AppliedImpulse or a JointImpulse"
        )
