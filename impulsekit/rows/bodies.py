"""The two bodies of a ``Collision``: their pieces, and up to which gap they count as touching."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from ..geometry.collision import Solids, solids_of
from ..robot import Robot
from ..robot.geometry import geometry_ids
from ..scene import Collision

__all__ = ["CLOSE_BY", "Bodies", "ball_around", "bodies_of"]

# Meshes of flat faces are flat to this share of the body's size: within it bodies touch. Below 4e-4
# the corners of Talos's soles that touch no longer lie around the load.
MESH_NOISE = 5e-4
# Points within this share that do not count are likely meant to.
CLOSE_BY = 1e-3


class Bodies(NamedTuple):
    """Two bodies whose geometry may meet.

    Attributes:
        pieces: of each, with placements in its joint.
        joint_ids, frame_ids: of each.
        size: the diameter of a ball around the smaller one [m].
        margin: gaps up to this count as touching [m].
    """

    pieces: tuple[Solids, Solids]
    joint_ids: tuple[int, int]
    frame_ids: tuple[int, int]
    size: float
    margin: float


def bodies_of(robot: Robot, entry: Collision) -> Bodies:
    """The bodies of an entry."""
    (first, here), (other, there) = (
        geometry_ids(robot, name) for name in (entry.first, entry.other)
    )
    pieces = solids_of(robot, first), solids_of(robot, other)
    size = 2.0 * min(ball_around(own)[1] for own in pieces)
    margin = MESH_NOISE * size if entry.margin is None else entry.margin
    objects = robot.collision_model.geometryObjects
    frame_ids = objects[first[0]].parentFrame, objects[other[0]].parentFrame
    return Bodies(pieces, (here, there), frame_ids, size, margin)


def ball_around(pieces: Solids) -> tuple[np.ndarray, float]:
    """A ball around all pieces of a body, in its joint's frame: centre [m] and radius [m]."""
    balls = []
    for solid, placement in pieces:
        shape = solid.geometry
        shape.computeLocalAABB()
        balls.append((placement.act(np.array(shape.aabb_center)), float(shape.aabb_radius)))
    centre = np.mean([middle for middle, _ in balls], axis=0)
    return centre, max(float(np.linalg.norm(middle - centre)) + r for middle, r in balls)
