"""``flat_motion``: a scene with all that acts between impacts, as the native core takes it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from .._core import AppliedForce as CoreForce
from .._core import ConstantTorque, JointForce, MotionScene, PointSpring, Table, TimedTorque
from .._core import Site as CoreSite
from ..errors import InputError
from ..impact.flat.law import contact_law
from ..impact.flat.scene import FlatScene, flat_scene
from ..rows.entries import Site
from ..scene import (
    Actuator,
    AppliedForce,
    Driven,
    JointFriction,
    JointSpring,
    Scene,
    Spring,
)
from ..scene.driven import Rates, is_driven, velocity_at
from ..scene.forces import PD, TorqueTable
from ..scene.functions import numbers_from
from ..scene.gap_functions import FunctionRows
from ..scene.scene import SceneCache

__all__ = ["FlatMotion", "flat_motion"]

_SIDES = {"both": 0.0, "above": 1.0, "below": -1.0}
_WAYS = {"both": 0.0, "pull": 1.0, "push": -1.0}
# A motion begins where its driven joints are, but for this [m, rad].
OFF_AT_START = 1e-6


@dataclass(frozen=True, eq=False)
class FlatMotion:
    """A scene in the core.

    Attributes:
        flat: what holds and touches the robot.
        core: that, and what acts between impacts.
        corners: times at which a force has a corner [s].
    """

    flat: FlatScene
    core: MotionScene
    corners: tuple[float, ...]


def is_new(scene: Scene) -> bool:
    """Return whether a scene was not simulated yet."""
    return not _motions.has(scene)


def flat_motion(scene: Scene) -> FlatMotion:
    """The scene in the core, made once."""
    return _motions.of(scene)


def _made(scene: Scene) -> FlatMotion:
    flat = flat_scene(replace(scene, impulses=()) if scene.impulses else scene)
    places = [isinstance(entry, Driven) for entry in scene.constraints]
    speeds = [is_driven(entry) for entry in scene.constraints]
    core = MotionScene(
        flat.core,
        contact_law(scene),
        np.array(scene.gravity, dtype=float),
        places,
        [one and not place for one, place in zip(speeds, places, strict=True)],
    )
    forces = _Forces(scene, flat, core)
    forces.add_all()
    _hold(scene, flat, core)
    _touch(scene, flat, core)
    return FlatMotion(flat, core, tuple(forces.corners))


_motions: SceneCache[FlatMotion] = SceneCache(_made)


class _Forces:
    """The forces of a scene on their way into the core."""

    def __init__(self, scene: Scene, flat: FlatScene, core: MotionScene) -> None:
        self._scene, self._robot = scene, scene.robot
        self._flat, self._core = flat, core
        self._corners: set[float] = set()

    def add_all(self) -> None:
        names = self._scene.entry_names("forces")
        for force, name in zip(self._scene.forces, names, strict=True):
            self._add(force, name)

    @property
    def corners(self) -> list[float]:
        """Times at which a table has a corner [s]."""
        return sorted(self._corners)

    def _v(self, name: str) -> int:
        return int(self._robot.model.joints[self._robot.joint_id(name)].idx_v)

    def _site(self, frame: str, at: Any) -> CoreSite:
        return self._flat.model.site(Site.of(self._robot, frame, at))

    def _in_joint(self, name: str, **numbers: Any) -> None:
        joint = self._robot.model.joints[self._robot.joint_id(name)]
        is_circle = joint.nq == 2
        self._core.add(JointForce(v=joint.idx_v, q=joint.idx_q, is_circle=is_circle, **numbers))

    def _add(self, force: Any, name: str) -> None:
        core = self._core
        if isinstance(force, JointSpring):
            self._in_joint(
                force.joint, stiffness=force.stiffness, damping=force.damping, rest=force.rest,
                limit=np.inf, side=_SIDES[force.acts], stores=True,
            )  # fmt: skip
        elif isinstance(force, Spring):
            spring = PointSpring(
                first=self._site(force.frame, force.at),
                other=self._site(force.other, force.other_at), stiffness=force.stiffness,
                damping=force.damping, rest=force.rest_length, side=_WAYS[force.acts],
            )  # fmt: skip
            core.add(spring)
        elif isinstance(force, AppliedForce):
            site = self._site(force.frame, force.at)
            applied = CoreForce(site=site, is_local=force.axes == "local")
            if force.is_constant:
                applied.numbers = force.force_at(0.0)
            given = None if force.is_constant else partial(force.force_at, name=name)
            core.add(applied, given, force.is_of_time)
        elif isinstance(force, Actuator):
            self._actuate(force, name)
        elif isinstance(force, JointFriction):
            core.add_dry(self._v(force.joint), force.torque)
        else:
            raise TypeError(type(force).__name__)

    def _actuate(self, force: Actuator, name: str) -> None:
        joint, torque = self._robot.model.joints[self._robot.joint_id(force.joint)], force.torque
        if isinstance(torque, PD):
            self._in_joint(
                force.joint, stiffness=torque.stiffness, damping=torque.damping,
                rest=torque.target, torque=torque.damping * torque.velocity,
                limit=np.inf if torque.limit is None else torque.limit, stores=False,
            )  # fmt: skip
        elif isinstance(torque, TorqueTable):
            table = Table(list(torque.times), list(torque.values))
            self._core.add(TimedTorque(v=joint.idx_v, table=table))
            self._corners.update(torque.times)
        elif isinstance(torque, tuple):
            self._core.add(ConstantTorque(v=joint.idx_v, torque=list(torque)))
        else:
            own = partial(_torque, torque, name, joint.nv)
            self._core.add_function(joint.idx_v, joint.nv, own)


def _torque(function: Any, name: str, size: int, t: float, q: Any, v: Any) -> np.ndarray:
    def what() -> str:
        return f"{name}: torque at t = {t:g}"

    return numbers_from(function, what, size, t, q, v, infinite=True)


def _hold(scene: Scene, flat: FlatScene, core: MotionScene) -> None:
    """Bring over what constraints ask for as functions of users."""
    functions = flat.functions
    places: dict[int, Driven] = {}
    speeds: list[tuple[slice, Callable[[float], Any], Callable[[float], Any]]] = []
    names = scene.entry_names("constraints")
    for i, (entry, name) in enumerate(zip(scene.constraints, names, strict=True)):
        if isinstance(entry, Driven):
            places[i] = entry
            speeds.append((flat.slices[i], entry.rate, partial(entry.rate, order=2)))
        elif is_driven(entry):
            velocity: Any = entry.velocity
            size = np.size(velocity_at(velocity, name, 0.0))
            rates = Rates(velocity, f"{name}: velocity", size)
            speeds.append((flat.slices[i], partial(velocity_at, velocity, name), rates))
    core.set_constraints(
        rows=(lambda q: np.concatenate([f.matrix_at(q).ravel() for f in functions]))
        if functions
        else None,
        bias=(lambda q, v: np.concatenate([f.bias(q, v) for f in functions]))
        if functions
        else None,
        values=(lambda q: np.concatenate([f.value(q) for f in functions])) if functions else None,
        speeds=partial(_speeds, speeds) if speeds else None,
        place=(lambda entry, t: places[entry].place(t)) if places else None,
    )


class _Speeds(NamedTuple):
    """Rows that are driven in time, their velocities and the rates of these."""

    rows: list[int]
    velocity: list[float]
    rate: list[float]


def _speeds(speeds: Sequence[Any], t: float) -> _Speeds:
    found = _Speeds([], [], [])
    for where, first, second in speeds:
        count = where.stop - where.start
        found.rows.extend(range(where.start, where.stop))
        found.velocity.extend(np.broadcast_to(first(t), count).tolist())
        found.rate.extend(np.broadcast_to(second(t), count).tolist())
    return found


def _touch(scene: Scene, flat: FlatScene, core: MotionScene) -> None:
    functions = flat.contact_functions
    names = scene.entry_names("contacts")
    given = [getattr(entry, "active", None) for entry in scene.contacts]
    conditions = {
        i: (active, f"{names[i]}: active") for i, active in enumerate(given) if active is not None
    }
    core.set_gap_functions(
        rows=partial(_gap_rows, functions) if functions else None,
        bias=(lambda i, q, v: functions[i].bias(q, v)) if functions else None,
        counts=(lambda i, q, v: _counts(conditions, i, q, v)) if conditions else None,
        conditional=list(conditions),
    )
    pulls = [float(getattr(entry, "holding_force", 0.0) or 0.0) for entry in scene.contacts]
    if any(pulls):
        core.set_pulls(pulls)


def _gap_rows(functions: Sequence[FunctionRows], i: int, q: np.ndarray) -> np.ndarray:
    own = functions[i]
    return np.concatenate([own.value(q), own.matrix_at(q).ravel()])


def _counts(conditions: dict[int, Any], i: int, q: np.ndarray, v: np.ndarray) -> bool:
    function, what = conditions[i]
    return bool(numbers_from(function, what, 1, q, v)[0] > 0.0)


def check_driven(scene: Scene, q: np.ndarray) -> None:
    """Refuse a motion that begins beside where its joints are driven.

    Raises:
        InputError: it does.
    """
    model = scene.robot.model
    for entry, name in zip(scene.constraints, scene.entry_names("constraints"), strict=True):
        if not isinstance(entry, Driven):
            continue
        joint, place = model.joints[scene.robot.joint_id(entry.joint)], entry.place(0.0)
        at = joint.idx_q
        if joint.nq == 1:
            off = float(q[at] - place)
        else:
            c, s = np.cos(place), np.sin(place)
            off = float(np.arctan2(c * q[at + 1] - s * q[at], c * q[at] + s * q[at + 1]))
        if not abs(off) <= OFF_AT_START:
            raise InputError(
                f'{name}: joint "{entry.joint}" begins {off:.3g} (rad or m) beside where it '
                f"is driven, position(0) = {place:.9g}; begin the motion there"
            )
