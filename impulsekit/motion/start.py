"""``core_of``, ``begin``: a motion in the core, brought to just after its start."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

from .._core import Ended, GapAt, Method, Motion
from .._core import MotionSettings as CoreSettings
from ..errors import InputError, RangeError, SingularMassError
from ..impact import Impact, ImpactSolver
from ..impact.singular import check_pivots, refuse_massless
from ..robot.geometry import geometry_ids
from ..scene import Collision, JointStop, Scene
from ..scene.coefficients import EllipticFriction
from ..scene.motion import MotionSettings
from .flat import check_driven, flat_motion

__all__ = ["begin", "core_of"]

# Speeds [m/s] whose squares may overflow.
HUGE = 1e100
# What may overlap at the start [m]: rounding of a state written by hand.
PENETRATION = 1e-6
# So many overlaps are listed in one error.
LISTED = 12


def core_of(scene: Scene, q: np.ndarray, v: np.ndarray, settings: MotionSettings) -> Motion:
    """The motion in the core, before it begins."""
    flat = flat_motion(scene)
    stops = {*settings.stop_times, *flat.corners}
    own = CoreSettings(
        method=Method[settings.method.replace("-", "_")],
        rtol=settings.rtol,
        atol=settings.atol,
        fixed_length=settings.step,
        max_step=settings.max_step or 0.0,
        capture_speed=settings.capture_speed,
        together=settings.together,
        scale_of_time=settings.duration or 1.0,
        stop_times=sorted(t for t in stops if t > 0.0),
        max_impacts=settings.max_impacts,
        max_steps=settings.max_steps,
    )
    return Motion(flat.core, own, q, v)


def begin(core: Motion, scene: Scene, q: np.ndarray, v: np.ndarray) -> list[tuple[float, Impact]]:
    """Bring a motion to just after t = 0; the impact then, if there is one.

    Raises:
        InputError: a contact that is penetrated, a joint beside where it is driven.
        SingularMassError: a joint moves no inertia.
    """
    largest = float(np.abs(v).max(initial=0.0))
    if not largest < HUGE:
        raise RangeError.of("velocity v: its largest entry", largest, f"below {HUGE:g}")
    if any(isinstance(getattr(c, "friction", 0.0), EllipticFriction) for c in scene.contacts):
        # An axis of friction along a normal is an error.
        flat_motion(scene).flat.rows(q, v)
    touching = core.gaps_closed_at_start()
    _refuse_penetration(scene, touching)
    check_driven(scene, q)
    if not scene.constraints:
        _refuse_singular(scene, q)
    struck: list[tuple[float, Impact]] = []
    closed = [at.gap for at in touching]
    if scene.impulses or core.is_struck_at_start(closed):
        impact = ImpactSolver(scene).solve_touching(q, v, {at.entry for at in touching})
        struck.append((0.0, impact))
        v = impact.v_after
        if not impact.status.valid:
            return struck
    core.begin(np.ascontiguousarray(v), closed)
    if core.ended is Ended.not_finite:
        raise SingularMassError(
            "the acceleration at the start is not finite: a joint moves no inertia, or a "
            "force of the scene is not a number",
            joints=scene.robot.joint_names,
        )
    return struck


def _refuse_singular(scene: Scene, q: np.ndarray) -> None:
    """Check that the mass matrix is regular: rounding would say how bodies fall."""
    robot = scene.robot
    refuse_massless(robot, robot.joint_names)
    if robot.nv == 0 or robot.is_always_regular or robot.model.mimicking_joints:
        return
    data = robot.model.createData()
    pin.crba(robot.model, data, q)
    pin.cholesky.decompose(robot.model, data)
    check_pivots(robot.model, data)


def _refuse_penetration(scene: Scene, touching: list[GapAt]) -> None:
    """Raise one error on all contacts that overlap at the start, the deepest first."""
    deepest: dict[int, float] = {}
    for at in touching:
        if at.value < -PENETRATION:
            deepest[at.entry] = min(at.value, deepest.get(at.entry, 0.0))
    if not deepest:
        return
    names = scene.entry_names("contacts")
    sentences = [
        _overlap(scene, entry, names[entry], -gap)
        for entry, gap in sorted(deepest.items(), key=lambda one: one[1])
    ]
    if len(sentences) > LISTED:
        sentences[LISTED:] = [f"and {len(sentences) - LISTED} more"]
    first = min(deepest, key=deepest.__getitem__)
    raise InputError("; ".join(sentences), contact=names[first], gap=deepest[first])


def _overlap(scene: Scene, index: int, name: str, depth: float) -> str:
    entry = scene.contacts[index]
    if isinstance(entry, JointStop):
        return f"{name} starts {depth:.3g} (rad or m) past its limit; move the joint or the limit"
    if not isinstance(entry, Collision):
        return f"{name} starts {depth:.3g} m in penetration; raise the robot or move the plane"
    pair = f'"{entry.first}" and "{entry.other}" overlap by {1e3 * depth:.3g} mm at the start'
    moving = all(geometry_ids(scene.robot, one)[1] for one in (entry.first, entry.other))
    return f"{pair}: {'exclude the pair or change q' if moving else 'change q'}"
