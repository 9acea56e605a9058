"""Bilateral constraints: what two frames, or two joints, may not do against each other."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, cast

from ..errors import InputError, RangeError, ShapeError, quoted
from ..errors.calls import public
from ..robot import Robot
from .entry import BetweenFrames, InJoint, check_one_degree
from .numbers import (
    Axes,
    Check,
    Name,
    Names,
    Numbers,
    Vector,
    Velocity,
    each,
    is_list,
    keep,
    number,
    text,
)

# Why both ends of an anchor, and of what acts on a distance, are on two bodies and in two frames.
ANCHORED = ("an anchor between them holds nothing", "a frame cannot be anchored to itself")
KEPT_ANYWAY = (
    "their points keep their distance anyway",
    "two points of one frame keep their distance anyway",
)

# The six directions of a frame, linear before angular.
DIRECTIONS = ("x", "y", "z", "rx", "ry", "rz")

# The velocity after the impact is what it was before.
KEPT = "kept"


@public
@dataclass(frozen=True)
class PointAnchor(BetweenFrames):
    """Two points share one velocity: a pin, a loop closed by a ball joint.

    Three rows: the velocity of the point of ``frame`` relative to that of ``other``,
    in world axes. The impulse is the one that ``frame`` receives.

    Attributes:
        frame, other: the frames; "world" is the fixed one.
        at: the point in ``frame`` [m].
        other_at: the point in ``other`` [m]; None for the one that coincides with ``at``.
        velocity: the relative velocity after the impact [m/s]: one number for all rows,
            three numbers, or "kept" for what it was before; or a function of time [s] that
            gives numbers, in ``solve`` taken at 0.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> PointAnchor("rod_a", "rod_b", at=[1, 0, 0], other_at=[1, 0, 0]).velocity
        (0.0, 0.0, 0.0)
    """

    section, within, alone = "constraints", *ANCHORED

    frame: Name
    other: Name = "world"
    at: Vector = (0.0, 0.0, 0.0)
    other_at: Vector | None = None
    velocity: Velocity = 0.0
    name: Name | None = None

    def _check(self, what: str) -> None:
        super()._check(what)
        keep(self, what, velocity_of(3), "velocity")


@public
@dataclass(frozen=True)
class FrameAnchor(BetweenFrames):
    """Two frames share their velocity in all or some directions: a weld, a grip, a hinge.

    Up to six rows: the velocity of ``frame`` at the point ``at`` relative to ``other``,
    linear before angular. The impulse is the one that ``frame`` receives.

    Attributes:
        frame, other: the frames; "world" is the fixed one.
        at: the point in ``frame`` [m] to which linear rows and impulses refer.
        other_at: the point in ``other`` [m]; None for the one that coincides with ``at``.
        directions: the constrained directions among "x", "y", "z", "rx", "ry", "rz". A hinge
            about the frame's own z axis leaves out "rz" and has ``axes="local"``.
        axes: "world" or "local" (those of ``frame``): in whose axes the directions lie.
        velocity: the relative velocity after the impact [m/s, rad/s]: one number for all
            rows, one for each, or "kept" for what it was before; or a function of time [s]
            that gives numbers, in ``solve`` taken at 0.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> hinge = FrameAnchor("coupler", "rocker", directions=("x", "y", "z", "rx", "ry"),
        ...                     axes="local")
        >>> len(hinge.velocity)
        5
    """

    section, within, alone = "constraints", *ANCHORED

    frame: Name
    other: Name = "world"
    at: Vector = (0.0, 0.0, 0.0)
    other_at: Vector | None = None
    directions: tuple[str, ...] = DIRECTIONS
    axes: Axes = "world"
    velocity: Velocity = 0.0
    name: Name | None = None

    def _check(self, what: str) -> None:
        super()._check(what)
        given = _several(self.directions, f"{what}: directions")
        object.__setattr__(self, "directions", _directions(given, what))
        velocity = checked_velocity(self.velocity, len(self.directions), f"{what}: velocity")
        if isinstance(velocity, tuple):
            # Each number stays with its direction when these are put in order.
            velocity = tuple(velocity[given.index(d)] for d in self.directions)
        object.__setattr__(self, "velocity", velocity)


@public
@dataclass(frozen=True)
class DistanceAnchor(BetweenFrames):
    """Two points keep their distance: a massless rod with a ball joint at each end.

    One row: the rate of the distance, n·(v_frame − v_other) with n from ``other_at`` to ``at``.
    Its impulse is along n, positive where it pushes the points apart. In ``simulate`` the
    distance stays what it is at the start.

    Attributes:
        frame, other: the frames; "world" is the fixed one.
        at, other_at: the points, each in its own frame [m].
        velocity: the rate of the distance after the impact [m/s]: a number, or "kept" for what
            it was before.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> DistanceAnchor("piston", "crank", at=[0, 0, 0.1], other_at=[0.05, 0, 0]).velocity
        (0.0,)
    """

    section, within, alone = "constraints", *KEPT_ANYWAY

    frame: Name
    other: Name = "world"
    at: Vector = (0.0, 0.0, 0.0)
    other_at: Vector = (0.0, 0.0, 0.0)
    velocity: Velocity = 0.0
    name: Name | None = None

    def _check(self, what: str) -> None:
        super()._check(what)
        keep(self, what, velocity_of(1), "velocity")


@public
@dataclass(frozen=True)
class JointLock(InJoint):
    """A joint stops, or moves at a given speed: a brake, an axle that locks.

    Attributes:
        joint: the joint.
        velocity: the joint's velocity after the impact [rad/s, m/s]: one number for all
            its degrees of freedom, one for each, or "kept" for what it was before; or a
            function of time [s] that gives numbers, in ``solve`` taken at 0.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> JointLock("knee").velocity
        0.0
    """

    section = "constraints"

    joint: Name
    velocity: Velocity = 0.0
    name: Name | None = None

    def _check(self, what: str) -> None:
        keep(self, what, velocity_of(None), "velocity")

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the joint, and the velocity its degrees of freedom."""
        self.check_length(robot, where, self.velocity, "velocity of")


@public
@dataclass(frozen=True)
class JointCoupling(InJoint):
    """Joints that move in a fixed ratio: a gear, a differential, a mimic joint.

    One row: y_joint − Σ ratio_i · y_other_i.

    Attributes:
        joint: the joint that follows.
        other: the leading joint, or several.
        ratio: the speed of ``joint`` over that of ``other``; one for each leader.
        velocity: the value of the row after the impact: a number, "kept", or a function of
            time [s], in ``solve`` taken at 0.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> JointCoupling("carrier", ["left", "right"], ratio=[0.5, 0.5]).ratio
        (0.5, 0.5)
    """

    section = "constraints"

    joint: Name
    other: Names
    ratio: Numbers = 1.0
    velocity: Velocity = 0.0
    name: Name | None = None

    def _check(self, what: str) -> None:
        others = _several(self.other, f"{what}: other")
        for other in others:
            text(other, f"{what}: other")
        if not others or self.joint in others or len(set(others)) != len(others):
            raise InputError(f"{what}: other must be other joints, each once, got {others}")
        ratios = each(self.ratio)
        if len(ratios) != len(others):
            raise ShapeError.of(f"{what}: ratio", (len(others),), (len(ratios),))
        object.__setattr__(self, "other", others)
        object.__setattr__(self, "ratio", tuple(number(r, f"{what}: ratio") for r in ratios))
        keep(self, what, velocity_of(1), "velocity")

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the joints, with one degree of freedom each."""
        for name in self.joint_names:
            check_one_degree(robot, name, where, "a JointCoupling")

    @property
    def terms(self) -> tuple[tuple[str, float], ...]:
        """Joints and their factors in the row: 1 for ``joint``, −ratio for each leader."""
        ratios = cast("tuple[float, ...]", self.ratio)
        return ((self.joint, 1.0), *((o, -r) for o, r in zip(self.other, ratios, strict=True)))

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints it acts in."""
        return (self.joint, *self.other)


def velocity_keeping_lock(joint: str) -> JointLock:
    """Return a lock that keeps the velocity of a joint, as stiff control does in an impact."""
    return JointLock(joint, velocity="kept", name=f"controlled {joint}")


def _directions(directions: tuple[Any, ...], what: str) -> tuple[str, ...]:
    wrong = [d for d in directions if d not in DIRECTIONS]
    if wrong or not directions or len(set(directions)) != len(directions):
        raise RangeError.of(
            f"{what}: directions", directions, f"some of {', '.join(DIRECTIONS)}, each at most once"
        )
    # In the order of a spatial vector, whatever the order given.
    return tuple(d for d in DIRECTIONS if d in directions)


def _several(value: Any, what: str) -> tuple[Any, ...]:
    try:
        return (value,) if isinstance(value, str) else tuple(value)
    except TypeError:
        raise InputError(
            f"{what} must be a name or several, got {quoted(value)}", what=what
        ) from None


def velocity_of(rows: int | None) -> Check:
    """Return ``checked_velocity`` of so many rows."""
    return lambda value, what: checked_velocity(value, rows, what)


def checked_velocity(value: Any, rows: int | None, what: str) -> Any:
    """Return "kept", a function or ``rows`` numbers; a number stays one if rows is None."""
    if callable(value):
        return value
    if isinstance(value, str):
        if value != KEPT:
            raise RangeError.of(what, quoted(value), 'numbers or "kept"')
        return KEPT
    if is_list(value):
        entries = tuple(number(x, f"{what}[{i}]") for i, x in enumerate(value))
        if rows is not None and len(entries) != rows:
            raise ShapeError.of(what, (rows,), (len(entries),))
        return entries
    single = number(value, what)
    return single if rows is None else (single,) * rows
