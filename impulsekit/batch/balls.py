"""``Collision`` entries that kernels know: a ball and one shape that may touch it."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from ..robot import Robot
from ..robot.geometry import geometry_ids
from ..scene import Collision
from .errors import NoKernelError
from .kernels.layout import BALL, BOX, CAPSULE, CYLINDER

__all__ = ["Ball", "ball_of"]


@dataclass(frozen=True, eq=False)
class Ball:
    """A ball and a shape.

    Attributes:
        joint_ids: of the ball and of the shape.
        sign: 1 if the ball is the first of the entry, else -1.
        centre: (3,) of the ball in its joint's axes [m].
        radius: [m].
        kind: BALL, CAPSULE, BOX or CYLINDER.
        rotation, translation: of the shape in its joint's axes.
        sizes: (3,) of the shape: half sides; or radius, half length.
    """

    joint_ids: tuple[int, int]
    sign: int
    centre: np.ndarray
    radius: float
    kind: int
    rotation: np.ndarray
    translation: np.ndarray
    sizes: tuple[float, float, float]


def ball_of(robot: Robot, entry: Collision) -> Ball:
    """The ball and the shape of an entry.

    Raises:
        NoKernelError: it is no ball and one shape; the message says what it is.
    """
    import coal

    pieces: list[Any] = []
    for name in (entry.first, entry.other):
        ids, _ = geometry_ids(robot, name)
        if len(ids) != 1:
            raise NoKernelError(f'a Collision of "{name}", which has {len(ids)} shapes')
        pieces.append(robot.collision_model.geometryObjects[ids[0]])
    sign = 1 if isinstance(pieces[0].geometry, coal.Sphere) else -1
    ball, other = pieces[::sign]
    shape = other.geometry
    names = " and ".join(type(piece.geometry).__name__ for piece in pieces)
    if not isinstance(ball.geometry, coal.Sphere):
        raise NoKernelError(f"a Collision of {names}: points are found for balls alone")
    if isinstance(shape, coal.Sphere):
        kind, sizes = BALL, (shape.radius, 0.0, 0.0)
    elif isinstance(shape, coal.Capsule):
        kind, sizes = CAPSULE, (shape.radius, shape.halfLength, 0.0)
    elif isinstance(shape, coal.Cylinder):
        kind, sizes = CYLINDER, (shape.radius, shape.halfLength, 0.0)
    elif isinstance(shape, coal.Box):
        kind, sizes = BOX, tuple(shape.halfSide.tolist())
    else:
        raise NoKernelError(f"a Collision of {names}: the second is no ball, box or cylinder")
    if any(piece.geometry.getSweptSphereRadius() for piece in pieces):
        raise NoKernelError("a Collision of shapes that are thickened")
    return Ball(
        (ball.parentJoint, other.parentJoint),
        sign,
        np.array(ball.placement.translation),
        float(ball.geometry.radius),
        kind,
        np.array(other.placement.rotation),
        np.array(other.placement.translation),
        sizes,
    )
