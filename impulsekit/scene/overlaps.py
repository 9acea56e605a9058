"""Links that overlap where nothing has moved: how a robot is drawn, and no collision."""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from .._core import Shape, contact_points
from ..geometry.axes import core_place
from ..geometry.shapes import shapes_of
from ..robot import Robot
from ..robot.geometry import geometry_ids
from ..robot.placing import Posture

__all__ = ["overlaps", "sentence_on"]

# Deeper than this bodies overlap [m]: what the start of a motion refuses.
OVERLAP = 1e-6
# A sentence names so many pairs.
NAMED = 12

Pair = tuple[str, str]


class _Body(NamedTuple):
    """The shapes of a link or a piece of geometry, and a ball around them, in a joint's axes."""

    shapes: list[Shape]
    joint: int
    centre: np.ndarray
    reach: float


def overlaps(robot: Robot, pairs: Iterable[Pair]) -> dict[Pair, float]:
    """Return the pairs that overlap in the neutral or a named pose, and how deep at most [m].

    Only what these poses place: two links of one robot. Where a robot stands in the world, and
    where robots and free bodies stand beside each other, they say nothing.
    """
    chosen = [pair for pair in pairs if _is_placed(robot, pair)]
    if not chosen:
        return {}
    bodies = {name: _body(robot, name) for name in dict.fromkeys(sum(chosen, ()))}
    found: dict[Pair, float] = {}
    for q in (robot.neutral(), *robot.poses.values()):
        posture = Posture(robot, q)
        places = {name: posture.joint(body.joint) for name, body in bodies.items()}
        centres = {name: places[name].act(body.centre) for name, body in bodies.items()}
        for pair in chosen:
            one, two = (bodies[name] for name in pair)
            apart = centres[pair[0]] - centres[pair[1]]
            if apart.dot(apart) > (one.reach + two.reach) ** 2:
                continue
            depth = _depth(one, places[pair[0]], two, places[pair[1]])
            if depth > max(OVERLAP, found.get(pair, 0.0)):
                found[pair] = depth
    return found


def sentence_on(found: dict[Pair, float]) -> list[str]:
    """Return the sentence on pairs that were left out; none where there are none."""
    if not found:
        return []
    named = [f'"{a}" and "{b}" ({1e3 * depth:.2g} mm)' for (a, b), depth in found.items()]
    more = f" and {len(named) - NAMED} more" if len(named) > NAMED else ""
    return [
        "pairs that overlap in the neutral or a named pose do not collide: "
        f"{', '.join(named[:NAMED])}{more}; a Collision of its own lets a pair collide"
    ]


def _body(robot: Robot, name: str) -> _Body:
    ids, joint = geometry_ids(robot, name)
    shapes = shapes_of(robot, ids)
    centres = np.array([shape.centre for shape in shapes])
    centre = centres.mean(axis=0)
    sizes = np.linalg.norm(centres - centre, axis=1) + [shape.reach for shape in shapes]
    return _Body(shapes, joint, centre, float(sizes.max()))


def _depth(one: _Body, at: pin.SE3, two: _Body, there: pin.SE3) -> float:
    """Return the depth to which two bodies overlap [m]; 0 where they do not."""
    points = contact_points(one.shapes, core_place(at), two.shapes, core_place(there), 0.0)
    return max((-point.gap for point in points), default=0.0)


def _is_placed(robot: Robot, pair: Pair) -> bool:
    """Return True if the joints between two bodies are those of one robot."""
    bases = [_base(robot, geometry_ids(robot, name)[0][0]) for name in pair]
    (one, top), (two, other) = bases
    return one == two >= 0 and (top == other or 0 in (top, other))


def _base(robot: Robot, index: int) -> tuple[int, int]:
    """The part that a piece of geometry belongs to, -1 for a piece of the world.

    And, of a file that may hold several robots, the first joint that moves it.
    """
    model, piece = robot.model, robot.collision_model.geometryObjects[index]
    if piece.parentFrame == 0:
        return -1, 0
    name = model.frames[piece.parentFrame].name
    fitting = [i for i, part in enumerate(robot.parts) if name.startswith(part.prefix)]
    part = max(fitting, key=lambda i: len(robot.parts[i].prefix))
    above = list(model.supports[piece.parentJoint])
    one_tree = (robot.parts[part].urdf or robot.parts[part].geometry) is not None
    return part, 0 if one_tree or len(above) < 2 else int(above[1])
