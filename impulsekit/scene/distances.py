"""Entries on the distance of two points alone: a rod that keeps it, a rope that bounds it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from ..errors import RangeError
from .coefficients import checked_restitution
from .constraints import check_ends, velocity_of
from .contacts import check_stiffness
from .numbers import Vector, Velocity, keep, number, vector
from .validation import BetweenFrames

# Why both ends must be on two bodies.
KEPT_ANYWAY = "their points keep their distance anyway"
_ONE_FRAME = "two points of one frame keep their distance anyway"


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

    frame: str
    other: str = "world"
    at: Vector = (0.0, 0.0, 0.0)
    other_at: Vector = (0.0, 0.0, 0.0)
    velocity: Velocity = 0.0
    name: str | None = None

    def __post_init__(self) -> None:
        what = check_ends(self, vector, _ONE_FRAME)
        keep(self, what, velocity_of(1), "velocity")


@dataclass(frozen=True)
class Rope(BetweenFrames):
    """Two points that a rope joins: no further apart than its length, and free when nearer.

    A contact without friction whose gap is length − distance. It pulls and never pushes. In
    ``solve`` it acts when the points are its length apart, or further; in ``simulate`` it jerks
    taut as an impact. The impulse is the one that ``frame`` receives.

    Attributes:
        frame, other: the frames; "world" is the fixed one.
        at, other_at: the points, each in its own frame [m].
        length: the largest distance [m], above 0.
        restitution: of the speed along the rope: as for ``Contact``.
        name: its name in results; by default its index in the scene.
        stiffness: as for ``Contact``.

    Raises:
        InputError, ShapeError, NotFiniteError, RangeError.

    Example:
        >>> Rope("ball", length=0.8, other_at=[0, 0, 2], restitution=0.3).other
        'world'
    """

    frame: str
    other: str = "world"
    at: Vector = (0.0, 0.0, 0.0)
    other_at: Vector = (0.0, 0.0, 0.0)
    length: float = 1.0
    restitution: float | Callable[[float], float] = 0.0
    name: str | None = None
    stiffness: float | None = None

    def __post_init__(self) -> None:
        what = check_ends(self, vector, _ONE_FRAME)
        keep(self, what, _length, "length")
        keep(self, what, checked_restitution, "restitution")
        check_stiffness(self, what)


def _length(value: Any, what: str) -> float:
    result = number(value, what)
    if not result > 0.0:
        raise RangeError.of(what, result, "above 0 m")
    return result
