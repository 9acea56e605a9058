"""The two bodies of a ``Collision``: their shapes, and up to which gap they count as touching."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .._core import Shape
from ..geometry.shapes import shapes_of
from ..robot import Robot
from ..robot.geometry import geometry_ids
from ..scene import Collision

__all__ = ["Bodies", "Body", "bodies_between", "bodies_of", "body_of"]

# Meshes of flat faces are flat to this share of the body's size: within it bodies touch. Below 4e-4
# the corners of Talos's soles that touch no longer lie around the load.
MESH_NOISE = 5e-4
# Points within this share that do not count are likely meant to.
CLOSE_BY = 1e-3


class Body(NamedTuple):
    """A body whose geometry may meet another's.

    Attributes:
        shapes: its pieces, in the axes of its joint.
        joint_id, frame_id: that carry it.
        size: the diameter of a ball around it [m].
    """

    shapes: list[Shape]
    joint_id: int
    frame_id: int
    size: float


class Bodies(NamedTuple):
    """Two bodies whose geometry may meet.

    Attributes:
        first, other: the bodies.
        size: the diameter of a ball around the smaller one [m].
        margin: gaps up to this count as touching [m].
    """

    first: Body
    other: Body
    size: float
    margin: float

    @property
    def close(self) -> float:
        """Gaps up to this are likely meant to touch [m]."""
        return self.margin + CLOSE_BY * self.size


def body_of(robot: Robot, name: str) -> Body:
    """The body of a link or of one piece of geometry."""
    ids, joint_id = geometry_ids(robot, name)
    shapes = shapes_of(robot, ids)
    centres = [shape.centre for shape in shapes]
    middle = np.mean(centres, axis=0)
    reach = max(
        float(np.linalg.norm(own - middle)) + shape.reach
        for own, shape in zip(centres, shapes, strict=True)
    )
    frame_id = robot.collision_model.geometryObjects[ids[0]].parentFrame
    return Body(shapes, joint_id, frame_id, 2.0 * reach)


def bodies_of(robot: Robot, entry: Collision) -> Bodies:
    """The bodies of an entry."""
    return bodies_between(body_of(robot, entry.first), body_of(robot, entry.other), entry.margin)


def bodies_between(first: Body, other: Body, margin: float | None) -> Bodies:
    """Two bodies; ``margin`` of their entry, None for the noise of meshes."""
    size = min(first.size, other.size)
    return Bodies(first, other, size, MESH_NOISE * size if margin is None else margin)
