"""What was added to a part of a robot after it was read, as plain data."""

from __future__ import annotations

from dataclasses import dataclass

__all__ = ["NONE", "AddedBody", "Changes", "Ground"]

Triple = tuple[float, float, float]


@dataclass(frozen=True)
class AddedBody:
    """A body welded to a frame: a payload, a tool, a sensor.

    Attributes:
        frame: the link that carries it.
        name: of the new link.
        mass: [kg]
        com: mass centre in ``frame`` [m].
        inertia: ixx, ixy, ixz, iyy, iyz, izz about the mass centre, axes of ``frame`` [kg m²].
    """

    frame: str
    name: str
    mass: float
    com: Triple = (0.0, 0.0, 0.0)
    inertia: tuple[float, ...] = (0.0,) * 6


@dataclass(frozen=True)
class Ground:
    """A half-space of the world: everything below a plane.

    Attributes:
        name: of its collision geometry.
        normal: out of the ground, world axes.
        height: how far the plane is from the world's origin along the normal [m].
    """

    name: str = "ground"
    normal: Triple = (0.0, 0.0, 1.0)
    height: float = 0.0


@dataclass(frozen=True)
class Changes:
    """What was added to a part of a robot after it was read, names without its prefix.

    Attributes:
        text: the URDF as it was read; None where nothing was changed.
        bodies, locks, armature, grounds: in the order they were added.
    """

    text: str | None = None
    bodies: tuple[AddedBody, ...] = ()
    locks: tuple[tuple[str, float], ...] = ()
    armature: tuple[tuple[str, tuple[float, ...]], ...] = ()
    grounds: tuple[Ground, ...] = ()


NONE = Changes()
