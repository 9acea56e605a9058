"""What can be shown: a trajectory, a recording, or an impact with what is around it."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from ..errors import InputError, RangeError, a_thing
from ..measured.recording import Recording
from ..robot import Robot
from ..scene.numbers import number
from .coasting import coasting
from .stage import Plane

if TYPE_CHECKING:
    from ..impact import Impact
    from ..scene import Scene

__all__ = ["Shown", "shown_motion"]

# [m] Planes nearer than this are drawn once.
SAME_PLANE = 1e-9


@dataclass(frozen=True, eq=False)
class Shown:
    """A motion, ready to be drawn.

    Attributes:
        robot: who moves.
        start, end: first and last instant [s].
        at: gives the (F, nq) configurations at (F,) instants [s].
        impacts: pairs of an instant [s] and an ``Impact``.
        planes: of the world, that contacts touch.
        impact_alone: the impact, if the motion was made up around one.
    """

    robot: Robot
    start: float
    end: float
    at: Callable[[np.ndarray], np.ndarray]
    impacts: tuple[tuple[float, Impact], ...]
    planes: tuple[Plane, ...]
    impact_alone: Impact | None = None


def shown_motion(motion: Any, span: float | None = None) -> Shown:
    """What a ``Trajectory``, a ``Recording`` or an ``Impact`` shows.

    Raises:
        InputError: none of these, or one without an instant.
    """
    from ..impact import Impact

    if span is not None and not 0.0 <= number(span, "replay: span") < np.inf:
        raise RangeError.of("replay: span", span, "0 s or more")
    if isinstance(motion, Impact):
        return _of_recording(coasting(motion, span), planes_of(motion.scene), motion)
    if isinstance(motion, Recording):
        scenes = [impact.scene for _, impact in motion.impacts]
        return _of_recording(motion, planes_of(scenes[0]) if scenes else ())
    scene = getattr(motion, "scene", None)
    robot = getattr(scene, "robot", None) or getattr(motion, "robot", None)
    if not isinstance(robot, Robot) or not hasattr(motion, "t") or not hasattr(motion, "q"):
        raise InputError(
            f"replay: {a_thing(motion)} cannot be shown; expected a Trajectory, a "
            "Recording or an Impact"
        )
    sampled = Recording(robot, motion.t, motion.q, getattr(motion, "impacts", ()))
    shown = _of_recording(sampled, () if scene is None else planes_of(scene))
    if not callable(getattr(motion, "at", None)):
        return shown
    return Shown(
        robot,
        shown.start,
        shown.end,
        lambda times: np.array([_configuration(motion.at(float(t))) for t in times]),
        shown.impacts,
        shown.planes,
    )


def planes_of(scene: Scene) -> tuple[Plane, ...]:
    """The planes of the world that contacts of a scene touch, each once, level ones first."""
    from ..scene import Contact

    planes: list[Plane] = []
    for entry in scene.contacts:
        if not isinstance(entry, Contact):
            continue
        frame = scene.robot.model.frames[scene.robot.frame_id(entry.against)]
        if frame.parentJoint != 0:
            continue
        normal = frame.placement.rotation @ np.array(entry.normal)
        origin = frame.placement.act(np.array(entry.origin))
        if not any(
            np.allclose(plane.normal, normal) and abs(normal @ (origin - plane.origin)) < SAME_PLANE
            for plane in planes
        ):
            planes.append(Plane(origin, normal))
    return tuple(sorted(planes, key=lambda plane: -round(float(plane.normal[2]), 9)))


def _of_recording(
    recording: Recording, planes: tuple[Plane, ...], impact: Impact | None = None
) -> Shown:
    start, end = float(recording.t[0]), float(recording.t[-1])
    impacts = tuple(recording.impacts)
    return Shown(recording.robot, start, end, recording.at, impacts, planes, impact)


def _configuration(state: Any) -> np.ndarray:
    """q out of a state, which is a pair (q, v) or has a ``q``."""
    return np.asarray(state.q if hasattr(state, "q") else state[0])
