"""Points whose impact design measures are wanted."""

from __future__ import annotations

from dataclasses import dataclass

from .numbers import Vector, keep, optional, text, vector

__all__ = ["DesignPoint"]


@dataclass(frozen=True)
class DesignPoint:
    """A point where a robot may be struck, and what is of interest there.

    Attributes:
        frame: the frame that carries the point.
        at: the point, in the frame's coordinates [m].
        direction: of a blow, in world axes; its effective mass is told beside those along
            the point's own axes.
        joint: a joint whose share of a blow there is told.
        until: with ``joint``, the other end of a line from ``at`` on which the joint is to
            be spared [m].
        label: how it is called; by default the frame and the point.

    Raises:
        ShapeError, NotFiniteError, RangeError, InputError.

    Example:
        >>> DesignPoint("fore_arm", at=[0, 0, 0.2], joint="elbow").title
        'fore_arm (0.0, 0.0, 0.2)'
    """

    frame: str
    at: Vector = (0.0, 0.0, 0.0)
    direction: Vector | None = None
    joint: str | None = None
    until: Vector | None = None
    label: str | None = None

    def __post_init__(self) -> None:
        text(self.frame, "DesignPoint: frame")
        what = f'DesignPoint on "{self.frame}"'
        keep(self, what, optional(vector), "at", "direction", "until")
        keep(self, what, optional(text), "joint", "label")

    @property
    def title(self) -> str:
        """The label, or the frame with the point where it is not the frame's origin."""
        if self.label is not None:
            return self.label
        return self.frame + (f" {self.at}" if any(self.at) else "")
