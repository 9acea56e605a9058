"""What closes a loop in a robot's file, as plain data: a scene makes a constraint of it."""

from __future__ import annotations

from dataclasses import dataclass, replace

__all__ = ["Loop"]

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class Loop:
    """An equality constraint of a file.

    Attributes:
        kind: "point" (a ``PointAnchor``), "frame" (a ``FrameAnchor``), "hinge" (a
            ``FrameAnchor`` free about z of ``first``), "slide" (one free along z of
            ``first``), "lock" (a ``JointLock``) or "coupling" (a ``JointCoupling``).
        name: as in the file.
        first, second: the frames, or the joints.
        at, other_at: the points in the frames [m].
        ratio: of a coupling, v_first = ratio · v_second.
    """

    kind: str
    name: str
    first: str
    second: str = "world"
    at: Triple = (0.0, 0.0, 0.0)
    other_at: Triple | None = None
    ratio: float = 1.0

    def within(self, prefix: str) -> Loop:
        """The loop of a part of a combined world, whose names begin with ``prefix``."""
        if not prefix:
            return self
        return replace(
            self,
            name=prefix + self.name,
            first=_within(self.first, prefix),
            second=_within(self.second, prefix),
        )


def _within(name: str, prefix: str) -> str:
    return name if name == "world" else prefix + name
