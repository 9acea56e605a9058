"""All forces at one time of a motion, from its state and from what rested then.

They come out of the very evaluation of the accelerations that made the motion:
M a = τ − h + Aᵀλ + JᵀP, of which a, λ and P are one answer.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from ..._core import ForcesAt, ForcesOfMotion, LoadsAt
from ...impact.flat.links import flat_links_of
from ...scene import Actuator, GapContact, JointFriction, JointSpring, JointStop, Scene
from ..flat import flat_motion

if TYPE_CHECKING:
    from .path import Path

__all__ = ["ForceBetween", "Loads", "LoadsOfMotion", "PushedPoint", "pushed_points"]

# So many times are kept with their forces: those of one look at a motion.
MOST_KEPT = 4096
# Of a polynomial of degree 15, which a step's forces are to rounding.
_NODES, _WEIGHTS = np.polynomial.legendre.leggauss(8)


@dataclass(frozen=True, eq=False)
class PushedPoint:
    """One point of a contact that rests.

    Attributes:
        entry: which contact of the scene it belongs to.
        position: (3,) world [m]; None for a joint stop.
        force: (3,) on the first body, world axes [N]; (1,) in the joint of a stop [N m, N].
        power: of that force and the one on the other body, and of the moments [W].
        moment: (3,) on the first body against rolling and spin, world axes [N m]; None where
            nothing resists them.
    """

    entry: int
    position: np.ndarray | None
    force: np.ndarray
    power: float
    moment: np.ndarray | None = None


@dataclass(frozen=True, eq=False)
class ForceBetween:
    """The force of a spring, an actuator or an applied force at one time.

    Attributes:
        value: (k,) in a joint, by degree of freedom [N m, N]; of a body (6,), force [N] before
            couple [N m] about the point that it acts on, world axes.
        power: [W].
    """

    value: np.ndarray
    power: float


class Loads:
    """All forces at one time.

    Attributes:
        t: [s]. q: (nq,). v: (nv,). acceleration: (nv,) v̇.
        points: where contacts that rest push.
        multipliers: (m,) by row of the constraints [N, N m].
        unique: (m,) which of them are determined; None where all are.
    """

    def __init__(self, of: LoadsOfMotion, t: float) -> None:
        self._of = of
        start, end = of.path.span(t)
        # A force that jumps where a step ends counts as it is within the step.
        inside = math.nextafter(start, math.inf), math.nextafter(end, -math.inf)
        self.t = min(max(t, inside[0]), inside[1]) if inside[0] < inside[1] else t
        self.q, self.v = of.path.state(t)
        self._found = found = of.core.at(self.t, self.q, self.v, of.path.resting_state(t))
        self.acceleration = found.acceleration
        self.points = tuple(pushed_points(of.scene, found))
        self.multipliers, unique = found.multipliers, found.unique
        self.unique = None if unique.all() else unique

    @cached_property
    def row_velocities(self) -> np.ndarray:
        """(m,) the velocities of the constraints' rows [m/s, rad/s]."""
        return self._loads.row_velocities

    @cached_property
    def _loads(self) -> LoadsAt:
        links = flat_links_of(self._of.scene.robot).core
        return self._of.core.loads(links, self.t, self.q, self.v, self._found)

    @cached_property
    def forces(self) -> tuple[ForceBetween, ...]:
        """The scene's forces, in their order."""
        own, loads = self._of.torques, self._loads
        torques, wrenches = (
            loads.torques.reshape(len(own), len(self.v)),
            loads.wrenches.reshape(-1, 6),
        )
        each = zip(own, torques, wrenches, loads.power.tolist(), strict=True)
        return tuple(ForceBetween(w if at is None else t[at], power) for at, t, w, power in each)

    @cached_property
    def reactions(self) -> dict[str, np.ndarray]:
        """By joint name, (6,) the wrench that the parent gives the child [N, N m].

        At the joint's origin, world axes; fixed joints and "root_joint" as for an ``Impact``.
        """
        return flat_links_of(self._of.scene.robot).reactions(self._loads.loads)

    @cached_property
    def wrenches(self) -> np.ndarray:
        """(entries + 2, 6) the wrenches on all moving bodies: by entry, of weight and the base.

        World axes, force [N] before couple about the world's origin [N m]: of ``held``,
        ``contacts`` and ``forces``, of weight, and of all that joints to the world transmit.
        Forces between bodies that move are zero.
        """
        own = self._loads
        parts = (own.loads.entries, own.weight, own.loads.base)
        return np.concatenate(parts).reshape(-1, 6)


class LoadsOfMotion:
    """The forces of a motion at any of its times.

    Attributes:
        scene: of the motion.
        path: its states.
        core: the scene in the core.
        rows: of each constraint where its rows stand among all.
        torques: by the scene's forces where one in a joint has its torques among all; None of
            those on bodies.
    """

    def __init__(self, scene: Scene, path: Path, slow: float) -> None:
        self.scene, self.path = scene, path
        flat = flat_motion(scene)
        self.core = ForcesOfMotion(flat.core, slow)
        self.torques = [_torques_of(scene, force) for force in scene.forces]
        self.rows = flat.flat.slices
        self._kept: dict[float, Loads] = {}

    def at(self, t: float) -> Loads:
        """All forces at a time [s] of the motion: of two steps that meet, those after."""
        found = self._kept.get(t)
        if found is None:
            if len(self._kept) >= MOST_KEPT:
                self._kept.clear()
            with np.errstate(over="ignore", invalid="ignore", divide="ignore"):
                found = self._kept[t] = Loads(self, t)
        return found

    def integral(self, start: float, end: float, value: Callable[[Loads], Any], size: int) -> Any:
        """(size,) of the forces over a span of time, by Gauss's rule on every step."""
        total = np.zeros(size)
        for a, b in self.path.between(start, end):
            middle, half = 0.5 * (a + b), 0.5 * (b - a)
            for node, weight in zip(_NODES.tolist(), _WEIGHTS.tolist(), strict=True):
                total += half * weight * value(self.at(middle + half * node))
        return total


def pushed_points(scene: Scene, found: ForcesAt) -> Iterator[PushedPoint]:
    """Return the points at which resting contacts push, as the core found them."""
    forces, slip = found.forces.reshape(-1, 3), found.slip.reshape(-1, 3)
    axes, places = found.axes.reshape(-1, 3, 3), found.places.reshape(-1, 3)
    moments, turning = found.moments.reshape(-1, 3), found.turning.reshape(-1, 3)
    turns = {i: k for k, i in enumerate(found.turning_of)}
    for i, entry in enumerate(found.entries):
        power = float(forces[i] @ slip[i])
        if isinstance(scene.contacts[entry], JointStop):
            yield PushedPoint(entry, None, np.array([found.signs[i] * forces[i, 2]]), power)
            continue
        moment = None
        if i in turns:
            k = turns[i]
            power += float(moments[k] @ turning[k])
            moment = axes[i] @ moments[k]
        by_functions = isinstance(scene.contacts[entry], GapContact)
        place = None if by_functions else places[i]
        yield PushedPoint(entry, place, axes[i] @ forces[i], power, moment)


def _torques_of(scene: Scene, force: Any) -> slice | None:
    """Where a force in a joint has its torques among all; None of one on bodies."""
    if not isinstance(force, Actuator | JointSpring | JointFriction):
        return None
    joint = scene.robot.model.joints[scene.robot.joint_id(force.joint)]
    return slice(joint.idx_v, joint.idx_v + joint.nv)
