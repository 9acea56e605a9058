"""A rigid body of the system, and how a system's bodies are numbered."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, NamedTuple

from impulsekit.reference.arithmetic import Array, read_only
from impulsekit.reference.joint import Joint

__all__ = ["WORLD", "Bodies", "Body"]

WORLD = -1
"""The index that stands for the inertial frame R where a body's index is wanted."""


@dataclass(frozen=True, eq=False)
class Body:
    """A rigid body B_k: a link of the URDF.

    Attributes:
        parent: index of the body that its joint hangs on, or WORLD.
        mass: kg.
        mass_centre: (3,) m, in the link's frame.
        inertia: (3, 3) kg m² about the mass centre, in axes of the link's frame.
    """

    name: str
    parent: int
    joint: Joint
    mass: Any
    mass_centre: Array
    inertia: Array

    def __post_init__(self) -> None:
        read_only(self.mass_centre, self.inertia)


class Bodies(NamedTuple):
    """Bodies, parents before children, with the names of all speeds and coordinates."""

    bodies: tuple[Body, ...]
    speed_names: tuple[str, ...]
    coordinate_names: tuple[str, ...]
