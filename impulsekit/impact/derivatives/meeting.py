"""Points at which round and flat bodies meet, as the core can differentiate them.

How the point moves is known in closed form where a corner, a ball or the end of a capsule meets a
flat face, and for two balls.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..._core import Feature, Shape, touching
from ...errors import InputError
from ...geometry.axes import contact_axes, place_numbers
from ...rows.bodies import Body, bodies_of
from ..flat.scene import Flattening

if TYPE_CHECKING:
    from ..._core import Scene as CoreScene
    from ...scene import Scene
    from ..flat.scene import FlatScene
    from ..outcome import Touch

__all__ = ["touched_scene"]

# A point and normal that differ from those found by less than this [m, rad] are the same.
SAME_POINT = 1e-5
# As ``core/scene.hpp`` numbers what a ball may touch, and ``core/geometry/shapes.hpp`` features: a
# corner or the tip of a round body on a face.
_BALL, _PLANE = 0, 4
_ON_FACE = (0, 2)


def touched_scene(
    scene: Scene, flat: FlatScene, q: np.ndarray, touches: Sequence[Touch]
) -> CoreScene:
    """The scene in the core with the contacts that touch alone, in their order.

    Raises:
        InputError: bodies whose point is not known in closed form.
    """
    return _Touched(scene, flat, q, touches).done().core


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
        bodies = bodies_of(self._robot, entry)
        both = bodies.first, bodies.other
        places = [place_numbers(self._placement_of(body.joint_id)) for body in both]
        for a in both[0].shapes:
            for b in both[1].shapes:
                if self._is_met(touch, both, (a, b), places):
                    return
        kinds = [" or ".join(sorted({shape.kind for shape in body.shapes})) for body in both]
        name = self._scene.entry_names("contacts")[touch.entry]
        raise InputError(
            f"derivatives: {name}: how the point moves at which {kinds[0]} and {kinds[1]} "
            "meet is not known in closed form (of two balls, and of a corner, ball or capsule's "
            "end on a flat face, it is); give it as a Contact"
        )

    def _is_met(
        self,
        touch: Touch,
        both: tuple[Body, Body],
        shapes: tuple[Shape, Shape],
        places: Sequence[np.ndarray],
    ) -> bool:
        """Whether two pieces meet at a touch in closed form; it is brought over then."""
        if touch.axes is None or touch.position is None or touch.gap is None:
            return False
        within = max(touch.gap, 0.0) + SAME_POINT
        for point in touching([shapes[0]], places[0], [shapes[1]], places[1], within):
            apart = point.point - touch.position, point.normal - touch.axes[:, 2]
            if np.abs(apart).max() < SAME_POINT:
                return self._bring(point.feature, both, shapes)
        return False

    def _bring(
        self, feature: Feature, both: tuple[Body, Body], shapes: tuple[Shape, Shape]
    ) -> bool:
        """Bring a ball's, corner's or tip's point over, if it is one's."""
        side = feature.index[0] if feature.kind in _ON_FACE else int(shapes[1].kind == "ball")
        own, shape, other_ball = shapes[side], shapes[1 - side], feature.kind not in _ON_FACE
        tip = own.tip(feature.index[1])
        if tip is None or (other_ball and {own.kind, shape.kind} != {"ball"}):
            return False
        if other_ball:
            at, kind, size = pin.SE3(np.eye(3), shape.centre), _BALL, shape.radius
        else:
            normal, offset = shape.face(feature.index[2])
            axes = contact_axes(normal)
            at, kind, size = pin.SE3(axes, offset * axes[:, 2]), _PLANE, 0.0
        site, other = (
            (self._model.bodies[body.joint_id], place_numbers(place))
            for body, place in ((both[side], pin.SE3(np.eye(3), tip)), (both[1 - side], at))
        )
        given = kind, own.radius, np.array([size, 0.0, 0.0]), 1.0 - 2.0 * side
        self._core.touch_bodies(site, other, np.inf, False, given, [], [])
        return True
