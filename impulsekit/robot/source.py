"""The sources of a robot, the parts added to it, and the loops that its file closes."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING

import numpy as np

from ..errors.calls import public

if TYPE_CHECKING:
    from .mjcf_shapes import PlainShape, TouchingPair

Triple = tuple[float, float, float]


# Where (3, 3) of an inertia stand in ixx, ixy, ixz, iyy, iyz, izz.
WHOLE = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


@dataclass(frozen=True)
class LinkInertial:
    """The inertia of a link in a URDF.

    Attributes:
        mass: [kg]
        com: mass centre in the link's frame [m].
        rpy: the turn of the inertia's axes against the link's [rad], as URDF has it.
        moments: ixx, ixy, ixz, iyy, iyz, izz about the mass centre [kg m²].
    """

    mass: float
    com: Triple
    rpy: Triple = (0.0, 0.0, 0.0)
    moments: tuple[float, ...] = (0.0,) * 6


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
        """Return the loop of a part of a combined world, whose names begin with ``prefix``."""
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
        shared: whether its name has no prefix, though the part that keeps it has one: the ground
            of a combined world.
    """

    name: str = "ground"
    normal: Triple = (0.0, 0.0, 1.0)
    height: float = 0.0
    shared: bool = False


@dataclass(frozen=True)
class Changes:
    """Changes made to a part of a robot after it was read, names without its prefix.

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


@public
@dataclass(frozen=True)
class RobotPart:
    """One URDF (or one given model) in the world.

    Attributes:
        urdf: XML text, or None for a robot made from a ``pin.Model``.
        path: the file the text was read from, or None.
        root: "fixed", "planar", "sagittal", "freeflyer", or the short name of a ``pin.JointModel``.
        mimic: whether mimic joints follow their leader instead of moving on their own.
        prefix: what stands before every name, such as "arm/"; "" for a robot alone.
        placement: the 4×4 placement of the root in the world, row by row; None at the origin.
        package_dirs: folders in which "package://" is looked up.
        assumptions: what was assumed where the file leaves something open.
        loops: equality constraints of a file that is no URDF.
        shapes: the geometry of such a file.
        pairs: which of the shapes may touch, with their friction.
        changes: what was added to the part after it was read.
        geometry: URDF text that counts for its geometry alone, since masses are other ones.
        source: the file or kind of text that was written anew as ``urdf``, for messages.
        srdf: the SRDF that goes with it, or None.
        inertials: by link of the URDF, which Pinocchio merges behind fixed joints.
    """

    urdf: str | None
    path: str | None = None
    root: str = "fixed"
    mimic: bool = False
    prefix: str = ""
    placement: tuple[tuple[float, ...], ...] | None = None
    package_dirs: tuple[str, ...] = ()
    assumptions: tuple[str, ...] = ()
    loops: tuple[Loop, ...] = ()
    shapes: tuple[PlainShape, ...] = ()
    pairs: tuple[TouchingPair, ...] = ()
    changes: Changes = NONE
    geometry: str | None = None
    source: str | None = None
    srdf: str | None = None
    inertials: Mapping[str, LinkInertial] = field(default_factory=dict, repr=False, compare=False)

    def name_of(self, ground: Ground) -> str:
        """Return the name of one of the part's grounds in the world."""
        return ground.name if ground.shared else self.prefix + ground.name

    @property
    def label(self) -> str:
        """A name for messages: the file's path, or what else is known."""
        if self.source is not None:
            return self.source
        if self.path is not None:
            return os.fspath(self.path)
        if self.urdf is not None or self.geometry is not None:
            return "URDF text"
        return "MJCF text" if self.shapes else "a given model"
