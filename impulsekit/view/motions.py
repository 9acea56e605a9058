"""Motions that can be shown: a trajectory, a recording, or an impact with a short coast.

An ``Impact`` is one instant. It is shown with a moment of coasting before and after it: joint
speeds constant, loops and pins that held kept shut, without forces.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np
import pinocchio as pin

from ..errors import InputError, RangeError, a_thing
from ..impact.mechanics import Mechanics
from ..measured.recording import Recording
from ..robot import Robot
from ..scene.numbers import number

if TYPE_CHECKING:
    from ..impact import Impact
    from ..motion import Trajectory
    from ..scene import Scene

STEPS = 40
# The fastest joint turns this far [rad], and the fastest body goes this share of the size.
LARGEST_TURN = 0.9
LARGEST_SHARE = 0.3
LONGEST = 2.0  # [s]
# Rows that move by less than this share of the speeds are held after the impact, too.
HELD = 1e-6
# Singular values below this share of the largest are of rows that repeat others.
REDUNDANT = 1e-9
# In place of a scale of zero, where nothing moves.
TINY = 1e-300
# How much an axis is preferred where a normal is as far from two.
PREFERRED = 1e-12


@dataclass(frozen=True, eq=False)
class Plane:
    """A plane of the world: a point of it [m] and its unit normal, (3,) each."""

    origin: np.ndarray
    normal: np.ndarray

    def placement(self, near: np.ndarray) -> pin.SE3:
        """Return a frame on the plane: z along the normal, its origin the foot of ``near``."""
        foot = near - self.normal * float(self.normal @ (near - self.origin))
        return pin.SE3(triad(self.normal), foot)


def triad(normal: np.ndarray) -> np.ndarray:
    """Return a (3, 3) right-handed frame with ``normal`` as z, the world's own if that is up."""
    across = np.zeros(3)
    across[int(np.argmin(np.abs(normal) - np.array([0.0, PREFERRED, 0.0])))] = 1.0
    first = np.array([1.0, 0.0, 0.0]) if abs(normal[0]) < 0.5 else across
    first = first - normal * float(normal @ first)
    first /= np.linalg.norm(first)
    return np.column_stack([first, np.cross(normal, first), normal])


def coasting(impact: Impact, span: float | None = None) -> Recording:
    """Return the motion around an impact, which is at time 0.

    Args:
        impact: the impact.
        span: time before and after it [s]; None for one that the eye can follow.
    """
    robot = impact.scene.robot
    lasting = _fitting_span(impact) if span is None else span
    after = _path(impact, impact.v_after, lasting)
    moves_before = bool(np.any(impact.v_before))
    before = _path(impact, impact.v_before, -0.5 * lasting)[::-1] if moves_before else []
    if not moves_before:
        # It stands still for a moment before the impulse.
        before = [np.array(impact.q)] * (STEPS // 2 + 1)
    t = np.concatenate(
        [np.linspace(-0.5 * lasting, 0.0, len(before)), np.linspace(0.0, lasting, len(after))[1:]]
    )
    return Recording(robot, t, np.array([*before, *after[1:]]), [(0.0, impact)])


def _fitting_span(impact: Impact) -> float:
    """Return the time for which the fastest part can be followed [s]."""
    robot = impact.scene.robot
    data = robot.model.createData()
    pin.forwardKinematics(robot.model, data, impact.q)
    places = np.array([data.oMi[i].translation for i in range(1, robot.model.njoints)])
    size = max(float(np.ptp(places, axis=0).max()) if len(places) else 0.0, 0.3)
    limits = [LONGEST]
    for v in (impact.v_before, impact.v_after):
        pin.forwardKinematics(robot.model, data, impact.q, np.array(v))
        for link in robot.links:
            twist = data.v[link.joint_id]
            speed = np.linalg.norm(twist.linear + np.cross(twist.angular, link.com_in_joint))
            turn = np.linalg.norm(twist.angular)
            if speed > 0.0:
                limits.append(LARGEST_SHARE * size / float(speed))
            if turn > 0.0:
                limits.append(LARGEST_TURN / float(turn))
    return min(limits)


def _path(impact: Impact, v: np.ndarray, span: float) -> list[np.ndarray]:
    """Return configurations from the impact on, for ``span`` seconds (backwards if negative)."""
    robot = impact.scene.robot
    steps = STEPS if span > 0 else STEPS // 2
    step = span / steps
    speed = _kept_shut(impact, v)
    path = [np.array(impact.q)]
    for _ in range(steps):
        # The midpoint rule: loops open by the cube of the step only.
        half = pin.integrate(robot.model, path[-1], 0.5 * step * speed(path[-1]))
        path.append(pin.integrate(robot.model, path[-1], step * speed(half)))
    return path


def _kept_shut(impact: Impact, v: np.ndarray) -> Callable[[np.ndarray], np.ndarray]:
    """Return the velocity nearest to v at any q that keeps the rows shut that v keeps shut."""
    v = np.array(v)
    scene = impact.scene
    if not scene.held:
        return lambda q: v
    rates = impact.mechanics.constraint_matrix @ v
    scale = max(float(np.abs(v).max()), TINY)
    held = np.abs(rates) < HELD * scale

    def speed(q: np.ndarray) -> np.ndarray:
        matrix = Mechanics(scene, q).constraint_matrix[held]
        return v - np.linalg.pinv(matrix, rcond=REDUNDANT) @ (matrix @ v)

    return speed if held.any() else lambda q: v


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
        trajectory: the motion, if it knows its forces.
    """

    robot: Robot
    start: float
    end: float
    at: Callable[[np.ndarray], np.ndarray]
    impacts: tuple[tuple[float, Impact], ...]
    planes: tuple[Plane, ...]
    impact_alone: Impact | None = None
    trajectory: Trajectory | None = None


def resting_forces(shown: Shown, times: np.ndarray) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return by contact that pushes between impacts, at (T,) ``times``, its place and resultant.

    Returns:
        (T, 3) the middle of its points, each as heavy as its force [m], and (T, 3) the force
        on its first body in world axes [N]; zero, at the last place, while it does not push.
    """
    if shown.trajectory is None:
        return {}
    found = {}
    for name, history in shown.trajectory.contacts.items():
        places, forces = np.full((len(times), 3), np.nan), np.zeros((len(times), 3))
        for place, force, time in zip(places, forces, times.tolist(), strict=True):
            points, forces_there = history.points(min(time, shown.end))
            sizes = np.linalg.norm(forces_there, axis=1)
            if sizes.sum() > 0.0:
                force[:], place[:] = forces_there.sum(axis=0), sizes @ points / sizes.sum()
        acts = np.flatnonzero(np.isfinite(places[:, 0]))
        if len(acts):
            last = acts[np.maximum(np.searchsorted(acts, np.arange(len(times)), "right") - 1, 0)]
            found[name] = places[last], forces
    return found


def shown_motion(motion: Any, span: float | None = None) -> Shown:
    """Return the motion of a ``Trajectory``, a ``Recording`` or an ``Impact``.

    Raises:
        InputError: none of these, or one without an instant.
    """
    from ..impact import Impact
    from ..motion import Trajectory

    if span is not None and not 0.0 <= number(span, "replay: span") < np.inf:
        raise RangeError.of("replay: span", span, "0 s or more")
    if isinstance(motion, Impact):
        return _of_recording(coasting(motion, span), planes_of(motion.scene), motion)
    if isinstance(motion, Recording):
        scenes = [impact.scene for _, impact in motion.impacts]
        return _of_recording(motion, planes_of(scenes[0]) if scenes else ())
    if not isinstance(motion, Trajectory):
        raise InputError(
            f"replay: {a_thing(motion)} cannot be shown; expected a Trajectory, a "
            "Recording or an Impact"
        )
    return Shown(
        motion.scene.robot,
        float(motion.t[0]),
        float(motion.t[-1]),
        lambda times: np.array([motion.at(float(t))[0] for t in times]),
        tuple(motion.impacts),
        planes_of(motion.scene),
        trajectory=motion,
    )


def planes_of(scene: Scene) -> tuple[Plane, ...]:
    """Return the planes of the world that a scene's contacts touch, each once, level ones first."""
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
