"""What entries of a scene act on, by name."""

from __future__ import annotations

__all__ = ["Acting", "BetweenFrames", "InJoint"]


class Acting:
    """An entry that acts on no frame and in no joint by name."""

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return ()

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints it acts in."""
        return ()


class BetweenFrames(Acting):
    """One that acts on two frames."""

    frame: str
    other: str

    @property
    def frame_names(self) -> tuple[str, ...]:
        """The frames it acts on."""
        return (self.frame, self.other)


class InJoint(Acting):
    """One that acts in a joint."""

    joint: str

    @property
    def joint_names(self) -> tuple[str, ...]:
        """The joints it acts in."""
        return (self.joint,)
