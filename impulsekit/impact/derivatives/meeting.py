"""Points at which round and flat bodies meet, as the core can differentiate them.

coal tells where two pieces of geometry meet, but not how that changes. For a ball against a ball or
a flat face the point and normal are known in closed form, which the core has.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

import coal
import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...geometry.axes import contact_axes, place_numbers
from ...geometry.collision import Solid, solids_of
from ...geometry.convex import HalfSpace
from ...geometry.features import borders_of, inside_of
from ...geometry.polyhedron import endless_face
from ...robot.geometry import geometry_ids
from ...scene import Collision
from ..flat.scene import Flattening

if TYPE_CHECKING:
    from ..._core import Scene as CoreScene
    from ...scene import Scene
    from ..flat.scene import FlatScene
    from ..outcome import Touch

__all__ = ["touched_scene"]

# A point and normal that differ from those found by less than this [m, rad] are the same.
SAME_POINT = 1e-5
# As ``core/scene.hpp`` numbers shapes.
_BALL, _PLANE = 0, 4


def touched_scene(
    scene: Scene, flat: FlatScene, q: np.ndarray, touches: Sequence[Touch]
) -> CoreScene:
    """The scene in the core with the contacts that touch alone, in their order.

    Raises:
        InputError: bodies whose point is not known in closed form.
    """
    return _Touched(scene, flat, q, touches).done().core


class _Piece(NamedTuple):
    """One piece of geometry: its joint, what it is, and its places in the joint and the world."""

    joint_id: int
    solid: Solid
    in_joint: pin.SE3
    place: pin.SE3

    @property
    def radius(self) -> float | None:
        """Of a ball; None of other shapes."""
        shape = self.solid.geometry
        return float(shape.radius) if isinstance(shape, coal.Sphere) else None


class _Touched(Flattening):
    """A scene on its way into the core, with some of its contacts at points that are known."""

    def __init__(
        self, scene: Scene, flat: FlatScene, q: np.ndarray, touches: Sequence[Touch]
    ) -> None:
        super().__init__(scene, flat.model)
        self._found, self._touches = set(flat.shaped), touches
        self._placement_of = flat.placements(q)

    def _touch_all(self) -> None:
        done: set[int] = set()
        for touch in self._touches:
            if touch.entry in self._found:
                self._meet(touch)
            elif touch.entry not in done:
                self._ends.append(self._touch(self._scene.contacts[touch.entry], touch.entry))
            done.add(touch.entry)

    def _meet(self, touch: Touch) -> None:
        """Bring a point over at which two bodies meet."""
        entry: Any = self._scene.contacts[touch.entry]
        bodies = self._pieces(entry)
        for a in bodies[0]:
            for b in bodies[1]:
                for ball, shape, sign in ((a, b, 1.0), (b, a, -1.0)):
                    plain = _plain_shape(ball, shape, touch, sign)
                    if plain is None:
                        continue
                    in_shape, given = plain
                    site, other = (
                        (self._model.bodies[piece.joint_id], place_numbers(place))
                        for piece, place in (
                            (ball, ball.in_joint),
                            (shape, shape.in_joint * in_shape),
                        )
                    )
                    self._core.touch_bodies(site, other, np.inf, False, given, [], [])
                    return
        shapes = [
            " or ".join(sorted({type(piece.solid.geometry).__name__ for piece in pieces}))
            for pieces in bodies
        ]
        name = self._scene.entry_names("contacts")[touch.entry]
        raise InputError(
            f"derivatives: {name}: how the point moves at which {shapes[0]} and {shapes[1]} "
            "meet is not known in closed form (a ball against a ball or a flat face is); give it "
            "as a Contact"
        )

    def _pieces(self, entry: Collision) -> tuple[list[_Piece], list[_Piece]]:
        """The pieces of both bodies."""
        objects = self._robot.collision_model.geometryObjects
        found = []
        for name in (entry.first, entry.other):
            ids = geometry_ids(self._robot, name)[0]
            joints = [objects[i].parentJoint for i in ids]
            found.append(
                [
                    _Piece(joint, solid, pin.SE3(place), self._placement_of(joint) * place)
                    for joint, (solid, place) in zip(
                        joints, solids_of(self._robot, ids), strict=True
                    )
                ]
            )
        return found[0], found[1]


def _plain_shape(
    ball: _Piece, shape: _Piece, touch: Touch, sign: float
) -> tuple[pin.SE3, tuple[int, float, np.ndarray, float]] | None:
    """What a ball meets at a touching point, if that is known in closed form.

    Args:
        sign: 1 where the ball is the first body of the contact, −1 where it is the other.

    Returns:
        The place of the plain shape in the axes of the piece, and shape and ball as the core
        takes them: kind, radius of the ball, size, and ``sign``.
    """
    if ball.radius is None or touch.axes is None or touch.position is None:
        return None
    centre, normal = ball.place.translation, sign * touch.axes[:, 2]
    if shape.radius is not None:
        way = centre - shape.place.translation
        gap = float(np.linalg.norm(way)) - ball.radius - shape.radius
        place, kind, size = pin.SE3.Identity(), _BALL, shape.radius
    else:
        face = _face(shape, centre, normal)
        if face is None:
            return None
        above = shape.place.actInv(centre) - face.translation
        gap = float(face.rotation[:, 2] @ above) - ball.radius
        way = shape.place.rotation @ face.rotation[:, 2]
        place, kind, size = face, _PLANE, 0.0
    towards = way / np.linalg.norm(way)
    position = centre - (ball.radius + 0.5 * gap) * towards
    away = np.abs(position - touch.position).max(), np.abs(towards - normal).max()
    if max(away) >= SAME_POINT:
        return None
    return place, (kind, ball.radius, np.array([size, 0.0, 0.0]), sign)


def _face(shape: _Piece, centre: np.ndarray, normal: np.ndarray) -> pin.SE3 | None:
    """The plane z = 0 of the face that looks along a normal, in the axes of the shape.

    None where it has no such face, or the foot of the centre is not on it.
    """
    flat = shape.solid.polyhedron
    if isinstance(shape.solid.convex, HalfSpace):
        flat = endless_face(shape.solid.convex.normal, shape.solid.convex.height)
    if flat is None:
        return None
    own = shape.place.rotation.T @ normal
    face = int(flat.normals.dot(own).argmax())
    if np.abs(flat.normals[face] - own).max() > SAME_POINT:
        return None
    if not flat.is_endless:
        borders, foot = borders_of(flat, face), shape.place.actInv(centre)
        if not inside_of(borders, 0, len(borders), tuple(foot.tolist())) > 0.0:
            return None
    axes, height = contact_axes(flat.normals[face]), flat.heights[face]
    return pin.SE3(np.ascontiguousarray(axes), height * axes[:, 2])
