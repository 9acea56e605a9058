"""Constraints and contacts that are given by functions of the configuration."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar

from ..errors import InputError, RangeError, a_thing
from .acting import Acting
from .constraints import velocity_of
from .contacts import check_stiffness
from .numbers import Velocity, between, check_name, keep, not_negative, number
from .restitution import checked_restitution

__all__ = ["GapConstraint", "GapContact"]

MOST_ROWS = 1000


@dataclass(frozen=True)
class GapConstraint(Acting):
    """What functions of the configuration keep: g(q) = 0, or what it is at the start.

    A bead on a wire, a cam that drives its follower, a gear of varying ratio. The multipliers act
    along the generalized speeds, as motors in the joints would.

    Attributes:
        g: function of q (nq,), read-only, that gives ``rows`` numbers. In ``simulate`` it keeps
            the value of the start; within 1e-6 of zero there it is zero.
        gradient: function of q that gives (rows, nv): ġ = gradient(q) · v, with the speeds of
            Pinocchio (of a joint with one degree of freedom dq/dt). It is held against differences
            of g. None for these differences themselves, right to some 1e-10.
        bias: function of (q, v) that gives d/dt(gradient) · v (rows,); None for differences.
        rows: how many numbers g gives.
        velocity: the value of ġ after the impact: a number for all rows, one for each, "kept",
            or a function of time [s].
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, RangeError, NotFiniteError, ShapeError.

    Example:
        A bead with coordinates x and z on the parabola z = x².

        >>> wire = GapConstraint(
        ...     lambda q: q[1] - q[0] ** 2, gradient=lambda q: [[-2 * q[0], 1]], name="wire"
        ... )
        >>> wire.rows
        1
    """

    g: Callable[[Any], Any]
    gradient: Callable[[Any], Any] | None = None
    bias: Callable[[Any, Any], Any] | None = None
    rows: int = 1
    velocity: Velocity = 0.0
    name: str | None = None

    def __post_init__(self) -> None:
        what = "GapConstraint"
        _check_functions(self, what, ("g",), ("gradient", "bias"))
        rows = number(self.rows, f"{what}: rows")
        if rows != int(rows) or not 1 <= rows <= MOST_ROWS:
            raise RangeError.of(f"{what}: rows", self.rows, f"1 to {MOST_ROWS}")
        object.__setattr__(self, "rows", int(rows))
        keep(self, what, velocity_of(self.rows), "velocity")
        check_name(self.name, what)

    # What a function of q depends on is not known by name.
    of_whole_robot: ClassVar[bool] = True


@dataclass(frozen=True)
class GapContact(Acting):
    """A contact whose gap is a function of the configuration: a cam and its follower, clearance.

    In ``solve`` it touches where the gap is zero or less. Impulses, forces and velocities are
    given by row: along both tangents, then the normal.

    Attributes:
        gap: function of q (nq,), read-only: 0 where it touches, positive apart [m or rad].
        normal: function of q that gives (nv,): the rate of the gap is normal(q) · v, with the
            speeds of Pinocchio. It is held against differences of the gap. None for these.
        tangents: function of q that gives (2, nv) or (1, nv): how fast it slips; needed for
            friction. Their scale must be that of a velocity where the normal's is.
        restitution, friction, tangential_restitution, stiffness: as for ``Contact``.
        name: its name in results; by default its index in the scene.

    Raises:
        InputError, RangeError, NotFiniteError.

    Example:
        A follower's height q[1] over a cam that turns by q[0].

        >>> import math
        >>> cam = GapContact(lambda q: q[1] - 0.2 - 0.05 * math.cos(q[0]), restitution=0.3)
        >>> cam.friction
        0.0
    """

    gap: Callable[[Any], Any]
    normal: Callable[[Any], Any] | None = None
    tangents: Callable[[Any], Any] | None = None
    restitution: float | Callable[[float], float] = 0.0
    friction: float = 0.0
    tangential_restitution: float = 0.0
    name: str | None = None
    stiffness: float | None = None

    def __post_init__(self) -> None:
        what = "GapContact"
        _check_functions(self, what, ("gap",), ("normal", "tangents"))
        keep(self, what, checked_restitution, "restitution")
        keep(self, what, not_negative, "friction")
        keep(self, what, between(-1.0, 1.0), "tangential_restitution")
        check_stiffness(self, what)
        if self.friction and self.tangents is None:
            raise InputError(f"{what}: friction needs tangents, the rows of its slip")
        check_name(self.name, what)

    # What a function of q depends on is not known by name.
    of_whole_robot: ClassVar[bool] = True


def _check_functions(
    entry: Any, what: str, needed: tuple[str, ...], others: tuple[str, ...]
) -> None:
    for field in (*needed, *others):
        given = getattr(entry, field)
        if not callable(given) and (given is not None or field in needed):
            raise InputError(f"{what}: {field} must be a function, got {a_thing(given)}")
