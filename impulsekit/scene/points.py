"""Points whose velocity a report prints."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Any

from ..errors import InputError, a_thing
from .numbers import Vector, keep, optional, text, vector

__all__ = ["ReportPoint", "report_points"]


@dataclass(frozen=True)
class ReportPoint:
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

    frame: str
    at: Vector = (0.0, 0.0, 0.0)
    label: str | None = None

    def __post_init__(self) -> None:
        text(self.frame, "ReportPoint: frame")
        what = f'ReportPoint on "{self.frame}"'
        keep(self, what, vector, "at")
        keep(self, what, optional(text), "label")

    @property
    def title(self) -> str:
        """The label, or the frame with the point where it is not the frame's origin."""
        if self.label is not None:
            return self.label
        return self.frame + (f" {self.at}" if any(self.at) else "")


def report_points(value: Any, what: str) -> tuple[ReportPoint, ...]:
    """Points as they are given: ``ReportPoint``, or the name of a frame for its origin.

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
