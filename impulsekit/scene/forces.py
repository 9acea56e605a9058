"""Forces that act in the motion after an impact: springs, dampers, actuators, applied forces.

An impact is instantaneous and knows none of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property, partial
from inspect import signature
from typing import Annotated, Any, TypeAlias

import numpy as np

from ..errors import InputError, quoted
from ..errors.calls import public
from ..robot import Robot
from .entry import (
    BetweenFrames,
    Checked,
    Entry,
    InJoint,
    check_frame_moves,
    check_one_degree,
)
from .functions import numbers_from
from .numbers import (
    Axes,
    Name,
    NotNegative,
    Number,
    Vector,
    choice,
    each,
    keep_table,
    number,
    vector,
)


@public
@dataclass(frozen=True)
class JointFriction(InJoint):
    """Dry (Coulomb) friction in a joint with one degree of freedom.

    τ = −torque · sign(v) while the joint moves; while it stands still τ is whatever holds it, at
    most ``torque`` either way. Joints and contacts at rest hold together: what they can carry
    between them does not move. Where joints of a loop, or joints and feet, are redundant, they
    share the load as stiff springs would. ``JointSpring`` has viscous damping.

    In an impact it carries nothing: a finite torque has no impulse in no time.

    Attributes:
        joint: the joint.
        torque: the largest torque or force τ_c [N m, N], 0 or more.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, NotFiniteError, RangeError.

    Example:
        >>> from impulsekit import Robot, Scene, simulate
        >>> from impulsekit.models import pendulum_urdf
        >>> arm = Robot.from_urdf(pendulum_urdf(1))
        >>> stiff = Scene(arm, forces=[JointFriction("joint_1", 100.0, name="bearing")])
        >>> motion = simulate(stiff, [1.0], [0.0], duration=1.0)
        >>> float(motion.q[-1, 0]), motion.forces["bearing"].force(0.5).shape
        (1.0, (1,))
    """

    section, wording = "forces", '{kind} in "{joint}"'

    joint: Name
    torque: NotNegative
    name: Name | None = None


# Which way springs act: in a joint on one side of the rest, between points by push or pull.
Side: TypeAlias = Annotated[str, choice("both", "above", "below")]
Way: TypeAlias = Annotated[str, choice("both", "push", "pull")]


@public
@dataclass(frozen=True)
class JointSpring(InJoint):
    """A spring and a damper in a joint with one degree of freedom.

    τ = −stiffness · (q − rest) − damping · v. For a continuous joint q − rest is taken
    between −π and π.

    Attributes:
        joint: the joint.
        stiffness: [N m/rad, N/m], 0 or more.
        damping: [N m s/rad, N s/m], 0 or more.
        rest: the coordinate without force [rad, m].
        acts: "both", or on one side of the rest coordinate only, "above" or "below": a
            compliant stop. It then only pushes, also with damping.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, NotFiniteError, RangeError.

    Example:
        >>> JointSpring("hip", stiffness=50, damping=1).rest
        0.0
        >>> JointSpring("hip", stiffness=1e4, rest=1.2, acts="above").acts
        'above'
    """

    section, wording = "forces", '{kind} in "{joint}"'

    joint: Name
    stiffness: NotNegative = 0.0
    damping: NotNegative = 0.0
    rest: Number = 0.0
    acts: Side = "both"
    name: Name | None = None


@public
@dataclass(frozen=True)
class Spring(BetweenFrames):
    """A spring and a damper between two points.

    The force on ``frame`` along the line from ``other_at`` to ``at`` is
    −stiffness · (length − rest_length) − damping · (rate of length); ``other`` gets the
    opposite one.

    Attributes:
        frame, other: the frames; "world" is the fixed one.
        at, other_at: the points, each in its own frame [m].
        stiffness: [N/m], 0 or more.
        damping: [N s/m], 0 or more.
        rest_length: the length without force [m], 0 or more.
        acts: "both"; "pull" for an elastic rope, without force while it is shorter; "push"
            for a bumper, without force while it is longer.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> Spring("link_10", at=[1, 0, 0], other_at=[0, 0, 2], stiffness=100).other
        'world'
    """

    section, wording = "forces", '{kind} from "{frame}" to "{other}"'
    within = "a spring between them moves nothing"
    alone = "a spring within one frame moves nothing"

    frame: Name
    other: Name = "world"
    at: Vector = (0.0, 0.0, 0.0)
    other_at: Vector = (0.0, 0.0, 0.0)
    stiffness: NotNegative = 0.0
    damping: NotNegative = 0.0
    rest_length: NotNegative = 0.0
    acts: Way = "both"
    name: Name | None = None


@public
@dataclass(frozen=True)
class PD(Checked):
    """A proportional-derivative law: τ = stiffness (target − q) + damping (velocity − v).

    Attributes:
        stiffness: [N m/rad, N/m], 0 or more.
        damping: [N m s/rad, N s/m], 0 or more.
        target: desired coordinate [rad, m].
        velocity: desired velocity [rad/s, m/s].
        limit: the largest torque or force, either way [N m, N]; None for no limit.

    Raises:
        NotFiniteError, RangeError.

    Example:
        >>> PD(stiffness=100, damping=2, target=0.5, limit=20).limit
        20.0
    """

    stiffness: NotNegative
    damping: NotNegative = 0.0
    target: Number = 0.0
    velocity: Number = 0.0
    limit: NotNegative | None = None


@public
@dataclass(frozen=True)
class TorqueTable:
    """A torque over time from a table, linear between its times and constant beyond them.

    Steps of a motion end at its times, so that nothing of it is stepped over.

    Attributes:
        times: rising [s]. values: at these times [N m, N].

    Raises:
        ShapeError, RangeError, NotFiniteError.

    Example:
        >>> TorqueTable([0.0, 0.5, 1.0], [0.0, 4.0, 0.0])(0.25, None, None)
        2.0
    """

    times: tuple[float, ...]
    values: tuple[float, ...]

    def __post_init__(self) -> None:
        keep_table(self, "times", number, "each above the last")

    def __call__(self, t: float, q: Any, v: Any) -> float:
        """The torque at a time [s]; of the state it knows nothing."""
        return float(np.interp(t, self.times, self.values))


@public
@dataclass(frozen=True)
class Actuator(InJoint):
    """A torque or force in a joint, along its own generalized speeds.

    Attributes:
        joint: the joint.
        torque: a number or one for each degree of freedom [N m, N]; a ``PD`` or a
            ``TorqueTable``, for a joint with one; or a function of (t, q, v), with read-only
            copies of the whole robot's q and v, that returns the same. It must depend on these
            alone: the integrator calls it at trial states, not in order of time.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, NotFiniteError, RangeError.

    Example:
        >>> Actuator("elbow", 0.4).torque
        (0.4,)
    """

    section, wording = "forces", '{kind} in "{joint}"'

    joint: Name
    torque: float | tuple[float, ...] | PD | TorqueTable | Callable[[float, Any, Any], Any]
    name: Name | None = None

    def _check(self, what: str) -> None:
        if isinstance(self.torque, PD) or callable(self.torque):
            return
        if isinstance(self.torque, str):
            raise InputError(
                f"{what}: torque must be a number, a PD, a TorqueTable or a function of (t, q, v), "
                f"got {quoted(self.torque)}"
            )
        torque = tuple(number(x, f"{what}: torque") for x in each(self.torque))
        object.__setattr__(self, "torque", torque)

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the joint, and the torque its degrees of freedom."""
        if isinstance(self.torque, PD | TorqueTable):
            check_one_degree(robot, self.joint, where, f"a {type(self.torque).__name__}")
        self.check_length(robot, where, self.torque, "torque in")


def _vector_or_function(value: Any, what: str) -> Any:
    if not callable(value):
        return vector(value, what)
    if not (_takes(value, 1) or _takes(value, 3)):
        raise InputError(f"{what} must be a function of t, or of (t, q, v)")
    return value


def _takes(function: Callable[..., Any], count: int) -> bool:
    """Return whether a function can be called with so many arguments; of time if none can say."""
    try:
        signature(function).bind(*range(count))
    except TypeError:
        return False
    except ValueError:  # of some that are compiled nothing is known
        return count == 1
    return True


VectorOfState: TypeAlias = Annotated[Vector | Callable[..., Any], _vector_or_function]


@public
@dataclass(frozen=True)
class AppliedForce(Entry):
    """An external force and couple at a point of a frame.

    Attributes:
        frame: the frame.
        linear: force [N]: three numbers; or a function that returns them, of time [s] or, such as
            drag, of (t, q, v) with read-only copies of the whole robot's q and v. It must depend on
            these alone: the integrator calls it at trial states, not in order of time.
        angular: couple about the point [N m], given in the same way.
        at: the point, in the frame's coordinates [m].
        axes: "world" or "local": in whose axes ``linear`` and ``angular`` are given.
        name: its name in results; by default its index in the scene.

    Raises:
        ShapeError, NotFiniteError, RangeError, InputError.

    Example:
        >>> AppliedForce("link_10", linear=lambda t: (0, 5 * t, 0)).force_at(2.0)[1]
        np.float64(10.0)
        >>> drag = AppliedForce("ball", linear=lambda t, q, v: -0.1 * v[:3], axes="local")
        >>> drag.force_at(0.0, [0, 0, 1, 0, 0, 0, 1], np.array([2.0, 0, 0, 0, 0, 0]))[0]
        np.float64(-0.2)
    """

    section, wording = "forces", '{kind} on "{frame}"'

    frame: Name
    linear: VectorOfState = (0.0, 0.0, 0.0)
    angular: VectorOfState = (0.0, 0.0, 0.0)
    at: Vector = (0.0, 0.0, 0.0)
    axes: Axes = "world"
    name: Name | None = None

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame,)

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the frame, and that it can move."""
        check_frame_moves(robot, self.frame, where, "a force")

    @property
    def is_constant(self) -> bool:
        """Return whether it is the same at all times and states, in its own axes."""
        return not callable(self.linear) and not callable(self.angular)

    @property
    def is_of_time(self) -> bool:
        """Return whether it does not depend on the state."""
        return all(self._of_time.values())

    @cached_property
    def _of_time(self) -> dict[str, bool]:
        """By field, whether its function is one of time alone."""
        fields = {"linear": self.linear, "angular": self.angular}
        return {name: _takes(own, 1) for name, own in fields.items() if callable(own)}

    def force_at(
        self, t: float, q: Any = None, v: Any = None, *, name: str | None = None
    ) -> np.ndarray:
        """Return (6,) force [N] before couple [N m] at a time [s] and state, in ``axes``.

        Args:
            t: time [s].
            q, v: (nq,), (nv,) the robot's state, for functions of it.
            name: what errors call it; by default its own name or its frame's.

        Raises:
            ShapeError, NotFiniteError, CallbackError: what a function gave, or that it raised.
        """
        name = name or self.name or f'AppliedForce on "{self.frame}"'
        numbers: list[float] = []
        for field in ("linear", "angular"):
            value = getattr(self, field)
            if callable(value):
                given = (t,) if self._of_time[field] else (t, q, v)
                what = partial(_at_time, name, field, t)
                value = numbers_from(value, what, 3, *given).tolist()
            numbers.extend(value)
        return np.array(numbers)


def _at_time(name: str, field: str, t: float) -> str:
    return f"{name}: {field} at t = {t:g}"


Force = JointSpring | JointFriction | Spring | Actuator | AppliedForce
