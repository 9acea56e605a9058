"""Known impulses: a blow on a link, a kick in a joint."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

from ..errors import InputError, ShapeError, a_thing
from ..robot import Robot
from ..robot.base import WORLD, WORLD_LINK
from .numbers import Numbers, Vector, axes_name, check_name, each, keep, number, text, vector
from .validation import Acting, InJoint, check_frame_moves


@dataclass(frozen=True)
class AppliedImpulse(Acting):
    """An external force impulse and couple impulse at a point of a frame.

    In Chang & Huston 1995, eq. (18), these are the integrals of F_k and M_k.

    Attributes:
        frame: the struck frame.
        linear: force impulse ∫F dt [N s].
        angular: couple impulse ∫M dt about the point [N m s].
        at: the point, in the frame's coordinates [m].
        axes: "world" or "local": in whose axes ``linear`` and ``angular`` are given.
        name: its name in results; by default its index in the scene.

    Raises:
        ShapeError, NotFiniteError, RangeError, InputError.

    Example:
        >>> AppliedImpulse("link_10", linear=[0, 5, 0], at=[1, 0, 0]).linear
        (0.0, 5.0, 0.0)
    """

    frame: str
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)
    at: Vector = (0.0, 0.0, 0.0)
    axes: str = "world"
    name: str | None = None

    def __post_init__(self) -> None:
        text(self.frame, "AppliedImpulse: frame")
        what = f'AppliedImpulse on "{self.frame}"'
        keep(self, what, vector, "linear", "angular", "at")
        axes_name(self.axes, f"{what}: axes")
        check_name(self.name, what)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame,)


@dataclass(frozen=True)
class JointImpulse(InJoint):
    """An impulse inside a joint: a motor's kick, combustion in a cylinder.

    It acts along the joint's own generalized speeds, on the child, and with opposite sign on
    the parent.

    Attributes:
        joint: the joint's name.
        impulse: one number [N m s, or N s for a prismatic joint], or one for each
            degree of freedom of the joint, in Pinocchio's order; kept as a tuple.
        name: its name in results; by default its index in the scene.

    Raises:
        NotFiniteError, RangeError, InputError.

    Example:
        >>> JointImpulse("elbow", 0.4).impulse
        (0.4,)
    """

    joint: str
    impulse: Numbers
    name: str | None = None

    def __post_init__(self) -> None:
        text(self.joint, "JointImpulse: joint")
        what = f'JointImpulse in "{self.joint}"'
        given = enumerate(each(self.impulse))
        impulse = tuple(number(x, f"{what}: impulse[{i}]") for i, x in given)
        object.__setattr__(self, "impulse", impulse)
        check_name(self.name, what)

    @property
    def values(self) -> tuple[float, ...]:
        """The impulse as it is kept: one number for each degree of freedom of the joint."""
        return cast("tuple[float, ...]", self.impulse)


def check_impulse(robot: Robot, impulse: Any, where: str) -> None:
    """Prove that an impulse fits a robot.

    Raises:
        UnknownNameError: a frame or joint that the robot does not have.
        ShapeError: a joint impulse that does not have the joint's length.
        InputError: an impulse on the world, or something that is no impulse.
    """
    if isinstance(impulse, AppliedImpulse):
        way_out = 'strike a link that can move, or load the robot with root="freeflyer"'
        if impulse.frame == WORLD and WORLD_LINK in robot.frame_names:
            way_out = f'the link that its file calls "world" is "{WORLD_LINK}" here'
        check_frame_moves(robot, impulse.frame, where, "an impulse", way_out)
    elif isinstance(impulse, JointImpulse):
        joint = robot.model.joints[robot.joint_id(impulse.joint, where)]
        if len(impulse.values) != joint.nv:
            raise ShapeError.of(
                f'{where}: impulse in joint "{impulse.joint}"', (joint.nv,), (len(impulse.values),)
            )
    else:
        raise InputError(
            f"{where} must be an AppliedImpulse or a JointImpulse, got {a_thing(impulse)}"
        )
