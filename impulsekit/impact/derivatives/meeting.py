"""Points at which round and flat bodies meet, and how they move with the configuration.

coal tells where two pieces of geometry meet, but not how that changes. For a ball against
a ball or a flat face the point and normal are known in closed form: between two centres
c_a − c_b = L n, or along the normal of the face.
"""

from __future__ import annotations

from typing import NamedTuple

import coal
import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...geometry.collision import Solid, solids_of
from ...geometry.convex import HalfSpace
from ...geometry.features import borders_of, inside_of
from ...geometry.polyhedron import endless_face
from ...robot import Robot
from ...robot.geometry import geometry_ids
from ...rows.frame_pair import turning_of_line
from ...scene import Collision
from ..outcome import Touch
from .expanded import ExpandedModel
from .motion import Motion
from .pairs import PlacedPair, Side
from .pulls import skew

__all__ = ["Meetings"]

# A point and normal that differ from those found by less than this [m, rad] are the same.
SAME_POINT = 1e-5
_EYE = np.eye(3)


class _Piece(NamedTuple):
    """One piece of geometry: its joint in the expanded model, what it is and its place there."""

    joint: int
    solid: Solid
    place: pin.SE3

    @property
    def ball(self) -> coal.Sphere | None:
        """It as a ball; None of other shapes."""
        shape = self.solid.geometry
        return shape if isinstance(shape, coal.Sphere) else None


class _Met(NamedTuple):
    """A point of meeting: (3,) world, normal from the second body to the first, and how
    the point moves and the normal turns with the configuration, (3, nv) each."""

    position: np.ndarray
    normal: np.ndarray
    moving: np.ndarray
    turning: np.ndarray


class Meetings:
    """The pieces of a scene's ``Collision``."""

    def __init__(self, robot: Robot, expanded: ExpandedModel, entry: Collision, name: str) -> None:
        objects = robot.collision_model.geometryObjects
        self._name = name
        self._first, self._other = (
            [
                _Piece(expanded.joint_ids[objects[i].parentJoint], solid, pin.SE3(place))
                for i, (solid, place) in zip(ids, solids_of(robot, ids), strict=True)
            ]
            for ids in (geometry_ids(robot, of)[0] for of in (entry.first, entry.other))
        )

    def placed(self, touch: Touch, motion: Motion) -> PlacedPair:
        """The rows of a point at which they were found to meet.

        Raises:
            InputError: shapes whose point is not known in closed form.
        """
        if touch.axes is None or touch.position is None:
            raise TypeError("a point of a Collision has axes and a position")
        for a in self._first:
            for b in self._other:
                met = _met(a, b, touch.position, touch.axes[:, 2], motion)
                if met is not None:
                    return _pair(a, b, met, touch, motion)
        shapes = [
            " or ".join(sorted({type(piece.solid.geometry).__name__ for piece in pieces}))
            for pieces in (self._first, self._other)
        ]
        raise InputError(
            f"derivatives: {self._name}: how the point moves at which {shapes[0]} and {shapes[1]} "
            "meet is not known in closed form (a ball against a ball or a flat face is); give it "
            "as a Contact"
        )


def _met(
    a: _Piece, b: _Piece, position: np.ndarray, normal: np.ndarray, motion: Motion
) -> _Met | None:
    """How two pieces meet at a point; None where they do not, or not in closed form."""
    found = None
    if a.ball is not None and b.ball is not None:
        found = _balls(a, b, motion)
    elif a.ball is not None:
        found = _ball_on_face(a, b, normal, motion)
    elif b.ball is not None:
        turned = _ball_on_face(b, a, -normal, motion)
        found = None if turned is None else turned._replace(normal=-turned.normal)
    if found is None:
        return None
    away = np.abs(found.position - position).max()
    across = np.abs(found.normal - normal).max()
    return found if max(away, across) < SAME_POINT else None


def _centre(piece: _Piece, motion: Motion) -> tuple[np.ndarray, np.ndarray]:
    """(3,) the centre of a ball in the world, and (6, nv) how it moves."""
    at = piece.place.translation
    if piece.joint == 0:
        return at, motion.zero
    point = pin.SE3(_EYE, at)
    return motion.placements[piece.joint].act(at), motion.jacobians(piece.joint, point)[1]


def _balls(a: _Piece, b: _Piece, motion: Motion) -> _Met | None:
    (here, moves_a), (there, moves_b) = _centre(a, motion), _centre(b, motion)
    way = here - there
    length = float(np.sqrt(way @ way))
    if length == 0.0:
        return None
    normal = way / length
    apart = (moves_a - moves_b)[:3]
    turning = np.array(turning_of_line(tuple(normal.tolist()), length, tuple(apart)))
    more = 0.5 * (b.solid.geometry.radius - a.solid.geometry.radius)
    # The normal turns by Ω × n.
    tilting = -skew(normal) @ turning
    moving = 0.5 * (moves_a + moves_b)[:3] + more * tilting
    return _Met(0.5 * (here + there) + more * normal, normal, moving, turning)


def _ball_on_face(ball: _Piece, flat: _Piece, normal: np.ndarray, motion: Motion) -> _Met | None:
    """A ball on the face of another piece that looks along ``normal``, towards the ball."""
    centre, moves = _centre(ball, motion)
    place = flat.place if flat.joint == 0 else motion.placements[flat.joint] * flat.place
    height = _height(flat.solid, place.actInv(centre), place.rotation.T @ normal)
    if height is None:
        return None
    # The face as a plane of its body, at the foot of the centre.
    turning, carried = motion.zero[3:], motion.zero[:3]
    if flat.joint > 0:
        point = pin.SE3(_EYE, motion.placements[flat.joint].actInv(centre))
        whole = motion.jacobians(flat.joint, point)[1]
        carried, turning = whole[:3], whole[3:]
    # Halfway between both surfaces.
    down = 0.5 * (ball.solid.geometry.radius + height)
    lifted = np.outer(normal, normal @ (moves[:3] - carried))
    tilting = -skew(normal) @ turning
    return _Met(centre - down * normal, normal, moves[:3] - 0.5 * lifted - down * tilting, turning)


def _height(solid: Solid, centre: np.ndarray, normal: np.ndarray) -> float | None:
    """How far a point is above the face that looks along ``normal``, in the shape's own axes.

    None where it has no such face, or the foot of the point is not on it.
    """
    flat = solid.polyhedron
    if isinstance(solid.convex, HalfSpace):
        flat = endless_face(solid.convex.normal, solid.convex.height)
    if flat is None:
        return None
    face = int(flat.normals.dot(normal).argmax())
    if np.abs(flat.normals[face] - normal).max() > SAME_POINT:
        return None
    if not flat.is_endless:
        borders = borders_of(flat, face)
        if not inside_of(borders, 0, len(borders), tuple(centre.tolist())) > 0.0:
            return None
    return float(flat.normals[face] @ centre - flat.heights[face])


def _pair(a: _Piece, b: _Piece, met: _Met, touch: Touch, motion: Motion) -> PlacedPair:
    """The rows t₁, t₂, n at a point that both bodies pass through."""
    if touch.axes is None or touch.position is None:
        raise TypeError("a point of a Collision has axes and a position")
    sides = []
    for piece, sign in ((a, 1.0), (b, -1.0)):
        if piece.joint == 0:
            continue
        point = pin.SE3(_EYE, motion.placements[piece.joint].actInv(touch.position))
        raw, jacobian = motion.jacobians(piece.joint, point)
        sides.append(Side(piece.joint, sign, point, raw, jacobian, met.moving - jacobian[:3]))
    selector = np.concatenate((touch.axes.T, np.zeros((3, 3))), axis=1)
    return PlacedPair(motion, sides, selector, met.turning, False)
