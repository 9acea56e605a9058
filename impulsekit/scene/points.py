"""Points of a robot whose velocity, or whose impact design measures, a report prints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ..errors import InputError, a_thing
from ..errors.calls import public
from ..robot import Robot
from .entry import Checked
from .numbers import Name, Vector


class _Labelled(Checked):
    """A point of a frame that may have a label."""

    wording = '{kind} on "{frame}"'
    frame: str
    at: Vector
    label: str | None

    @property
    def title(self) -> str:
        """The label, or the frame with the point where it is not the frame's origin."""
        if self.label is not None:
            return self.label
        return self.frame + (f" {self.at}" if any(self.at) else "")

    def check_robot(self, robot: Robot, where: str) -> None:
        """Check that the robot has the frame, and the joint, which may be a fixed one."""
        robot.frame_id(self.frame, where)
        joint = getattr(self, "joint", None)
        if joint is not None and joint not in robot.frame_names:
            robot.joint_id(joint, where)


@public
@dataclass(frozen=True)
class ReportPoint(_Labelled):
    """A point of a frame, with the name that a report gives it.

    Attributes:
        frame: the frame that carries the point.
        at: the point, in the frame's coordinates [m].
        label: how a report calls it; by default the frame and the point.

    Raises:
        ShapeError, NotFiniteError, RangeError, InputError.

    Example:
        >>> ReportPoint("link_10", at=[1, 0, 0], label="far end").at
        (1.0, 0.0, 0.0)
    """

    frame: Name
    at: Vector = (0.0, 0.0, 0.0)
    label: Name | None = None


def report_points(value: Any, what: str) -> tuple[ReportPoint, ...]:
    """Return points as they are given: ``ReportPoint``, or the name of a frame for its origin.

    Raises:
        InputError: something else.

    Example:
        >>> report_points(["hand"], "replay: traces")[0].title
        'hand'
    """
    given = (value,) if isinstance(value, str | ReportPoint) else value
    if not isinstance(given, Iterable):
        raise InputError(f"{what} is {a_thing(value)}, expected a list of ReportPoint or names")
    points = []
    for i, one in enumerate(given):
        if not isinstance(one, str | ReportPoint):
            raise InputError(
                f"{what}[{i}] is {a_thing(one)}, expected a ReportPoint or the name of a frame"
            )
        points.append(one if isinstance(one, ReportPoint) else ReportPoint(one))
    return tuple(points)


@public
@dataclass(frozen=True)
class DesignPoint(_Labelled):
    """A point where a robot may be struck, and what is of interest there.

    Attributes:
        frame: the frame that carries the point.
        at: the point, in the frame's coordinates [m].
        direction: of a blow, in world axes; its effective mass is reported beside those along
            the point's own axes.
        joint: a joint whose share of a blow there is reported.
        until: with ``joint``, the other end of a line from ``at`` on which the joint is to
            be spared [m].
        label: how it is called; by default the frame and the point.

    Raises:
        ShapeError, NotFiniteError, RangeError, InputError.

    Example:
        >>> DesignPoint("fore_arm", at=[0, 0, 0.2], joint="elbow").title
        'fore_arm (0.0, 0.0, 0.2)'
    """

    frame: Name
    at: Vector = (0.0, 0.0, 0.0)
    direction: Vector | None = None
    joint: Name | None = None
    until: Vector | None = None
    label: Name | None = None
