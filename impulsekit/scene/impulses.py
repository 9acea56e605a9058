"""Known impulses: applied to a link, or inside a joint."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np

from ..errors import InputError, ShapeError, UnknownNameError
from ..errors.calls import public
from ..robot import Robot
from ..robot.arrays import floats
from ..robot.base import WORLD, WORLD_LINK
from .entry import Entry, InJoint, check_frame_moves
from .numbers import Axes, Name, Numbers, Vector, each, number


@public
@dataclass(frozen=True)
class AppliedImpulse(Entry):
    """An external force impulse and couple impulse at a point of a frame.

    In Chang & Huston 1995, eq. (18), these are the integrals of F_k and M_k.

    Attributes:
        frame: the frame that it acts on.
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

    section, wording = "impulses", '{kind} on "{frame}"'

    frame: Name
    linear: Vector = (0.0, 0.0, 0.0)
    angular: Vector = (0.0, 0.0, 0.0)
    at: Vector = (0.0, 0.0, 0.0)
    axes: Axes = "world"
    name: Name | None = None

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the frame, and that it can move."""
        way_out = 'strike a link that can move, or load the robot with root="freeflyer"'
        if self.frame == WORLD and WORLD_LINK in robot.frame_names:
            way_out = f'the link that its file calls "world" is "{WORLD_LINK}" here'
        check_frame_moves(robot, self.frame, where, "an impulse", way_out)

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame,)

    @property
    def values(self) -> tuple[float, ...]:
        """Its six numbers: force impulse, then couple."""
        return cast("tuple[float, ...]", (*self.linear, *self.angular))

    def with_values(self, values: Sequence[float]) -> AppliedImpulse:
        """Return the same with other numbers."""
        return replace(self, linear=values[:3], angular=values[3:])


@public
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

    section, wording = "impulses", '{kind} in "{joint}"'

    joint: Name
    impulse: Numbers
    name: Name | None = None

    def _check(self, what: str) -> None:
        given = enumerate(each(self.impulse))
        impulse = tuple(number(x, f"{what}: impulse[{i}]") for i, x in given)
        object.__setattr__(self, "impulse", impulse)

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the joint, and the impulse its degrees of freedom."""
        self.check_length(robot, where, self.values, "impulse in")

    @property
    def values(self) -> tuple[float, ...]:
        """The impulse as it is kept: one number for each degree of freedom of the joint."""
        return cast("tuple[float, ...]", self.impulse)

    def with_values(self, values: Sequence[float]) -> JointImpulse:
        """Return the same with other numbers."""
        return replace(self, impulse=tuple(values))


def impulse_numbers(
    entries: Sequence[AppliedImpulse | JointImpulse], names: Sequence[str], impulses: Any = None
) -> np.ndarray:
    """Return (1 or B, columns) the numbers of known impulses, entry after entry.

    Args:
        entries: the impulses of a scene, and their ``names``.
        impulses: by name, numbers in place of an entry's own: (6,) or (3,), the force impulse
            alone, for an ``AppliedImpulse``, (k,) for a ``JointImpulse``, or (B, ...) of these;
            of one impulse alone without its name.

    Raises:
        UnknownNameError, ShapeError, NotFiniteError.
        InputError: no mapping, and not one impulse.
    """
    stops = np.cumsum([0, *(len(entry.values) for entry in entries)]).tolist()
    base = np.array([x for entry in entries for x in entry.values], dtype=float).reshape(1, -1)
    if impulses is None:
        return base
    if not isinstance(impulses, Mapping):
        if len(names) != 1:
            raise InputError(
                f"impulses: the scene has {len(names)} known impulses; give a mapping from "
                "their names to arrays"
            )
        impulses = {names[0]: impulses}
    for name, values in impulses.items():
        if name not in names:
            raise UnknownNameError.among("impulse", str(name), names)
        index = list(names).index(name)
        what, first = f'impulses["{name}"]', stops[index]
        width, is_applied = stops[index + 1] - first, isinstance(entries[index], AppliedImpulse)
        array = floats(values, what, copied=False)
        array = array.reshape(1) if array.ndim == 0 else array
        if array.ndim > 2 or array.shape[-1] not in ((3, 6) if is_applied else (width,)):
            hint = "(3,) or (B, 3) for the force impulse alone" if is_applied else ""
            raise ShapeError.of(what, ("B", width), array.shape, hint)
        array = array.reshape(-1, array.shape[-1])
        if not len(array):
            raise ShapeError.of(what, ("B", width), array.shape, "the batch is empty")
        if len(array) > 1 and len(base) == 1:
            base = np.repeat(base, len(array), axis=0)
        elif len(array) not in (1, len(base)):
            raise ShapeError.of(what, (len(base), width), array.shape, "leading axes must agree")
        base[:, first : first + array.shape[1]] = array
    return base


def with_numbers(
    entries: Sequence[AppliedImpulse | JointImpulse], numbers: np.ndarray
) -> tuple[AppliedImpulse | JointImpulse, ...]:
    """Return the entries with other numbers (columns,), as ``impulse_numbers`` has them."""
    stops = np.cumsum([len(entry.values) for entry in entries])[:-1]
    parts = np.split(numbers, stops) if entries else []
    return tuple(x.with_values(part.tolist()) for x, part in zip(entries, parts, strict=True))
