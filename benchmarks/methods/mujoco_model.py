"""A mechanism as MuJoCo's model, joint by joint, so that both move the same inertias.

MuJoCo's free joint has linear velocity in world axes, Pinocchio's in the body's.

A contact of MuJoCo is soft: its velocity and depth follow u̇ = −b u − k r. One without restitution
loses its velocity in a step or a few (k = 0); one with restitution is a damped half swing of
``CONTACT_TIME``.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from .mechanism import Body, Hold, Mechanism, Touch, third_along
from .method import damping_ratio

# Of an impact with restitution [s]: so short that the bodies move by rounding's square root.
CONTACT_TIME = 1e-7
# How much of an approach is gone in a step, or in a tenth of that time, without restitution.
GONE = 0.9
# As hard as MuJoCo makes a contact, at any depth.
HARD = [0.9999, 0.9999, 1.0, 0.5, 1.0]
# Of the sphere that stands for a point, and how far the bodies behind planes reach [m].
POINT, REACH = 1e-12, 1e-2
# Its solver goes on down to rounding [relative], in so many steps at most.
SOLVED, MOST_ITERATIONS = 1e-15, 50
# MuJoCo takes no smaller friction.
LEAST_FRICTION = 1e-5
# The stiffness of what only damps; with 0 MuJoCo takes it for a time constant [1/s²].
NO_SPRING = 1e-12


def mujoco_model(mechanism: Mechanism, step: float = 1e-3, holds: Sequence[Hold] = ()) -> Any:
    """The compiled model, without gravity and with no geometry but that of contacts."""
    import mujoco

    spec = mujoco.MjSpec()
    spec.option.gravity = [0.0, 0.0, 0.0]
    spec.option.timestep = step
    made = [_add_body(mujoco, spec, made_of, mechanism) for made_of in mechanism.bodies]
    for i, touch in enumerate(mechanism.touches):
        _add_contact(mujoco, spec, made, mechanism, touch, i, step)
    for hold in holds:
        _add_hold(mujoco, spec, made, hold, step)
    if mechanism.touches or holds:
        spec.option.cone = mujoco.mjtCone.mjCONE_ELLIPTIC
        spec.option.tolerance, spec.option.iterations = SOLVED, MOST_ITERATIONS
    else:
        spec.option.disableflags |= (
            mujoco.mjtDisableBit.mjDSBL_CONSTRAINT | mujoco.mjtDisableBit.mjDSBL_CONTACT
        )
    model = spec.compile()
    # The compiler refuses rods without thickness, its dynamics do not.
    for body, at in zip(mechanism.bodies, made, strict=True):
        moments, axes = _principal(body)
        model.body_mass[at.id], model.body_inertia[at.id] = body.mass, moments
        mujoco.mju_mat2Quat(model.body_iquat[at.id], axes.ravel())
    for data, hold in zip(model.eq_data, holds, strict=True):
        # The compiler would have it where the joints are at zero.
        rotation, place = mechanism.rotations[hold.body], mechanism.places[hold.body]
        if hold.rows == 3:
            data[:6] = [*hold.at, *(place + rotation @ hold.at)]
        else:
            data[:10] = [*hold.at, *place, *_quaternion(mujoco, rotation)]
    mujoco.mj_setConst(model, mujoco.MjData(model))
    return model


def _add_body(mujoco: Any, spec: Any, body: Body, mechanism: Mechanism) -> Any:
    parent = spec.worldbody if body.parent < 0 else spec.body(mechanism.bodies[body.parent].name)
    made = parent.add_body(name=body.name, pos=body.offset, quat=_quaternion(mujoco, body.rotation))
    kinds = mujoco.mjtJoint
    if body.kind == "free":
        made.add_joint(type=kinds.mjJNT_FREE)
    elif body.kind == "ball":
        made.add_joint(type=kinds.mjJNT_BALL)
    else:
        for slides, axis in zip(body.slides, body.axes, strict=True):
            kind = kinds.mjJNT_SLIDE if slides else kinds.mjJNT_HINGE
            made.add_joint(type=kind, axis=axis)
    made.explicitinertial = True
    made.mass, made.inertia, made.ipos = 1.0, [1.0, 1.0, 1.0], body.centre
    made.iquat = _quaternion(mujoco, _principal(body)[1])
    return made


def _add_contact(
    mujoco: Any,
    spec: Any,
    made: list[Any],
    mechanism: Mechanism,
    touch: Touch,
    i: int,
    step: float,
) -> None:
    made[touch.body].add_geom(
        name=f"point {i}",
        type=mujoco.mjtGeom.mjGEOM_SPHERE,
        size=[POINT, 0, 0],
        pos=touch.at,
        contype=0,
        conaffinity=0,
    )
    fixed = touch.other < 0
    carrier = spec.worldbody if fixed else made[touch.other]
    back = np.eye(3) if fixed else mechanism.rotations[touch.other].T
    start = np.zeros(3) if fixed else mechanism.places[touch.other]
    # A plane of MuJoCo does not move; the face of a box does.
    behind = np.zeros(3) if fixed else touch.normal * REACH
    carrier.add_geom(
        name=f"plane {i}",
        type=mujoco.mjtGeom.mjGEOM_PLANE if fixed else mujoco.mjtGeom.mjGEOM_BOX,
        size=[REACH] * 3,
        pos=back @ (touch.place - behind - start),
        quat=_quaternion(mujoco, back @ third_along(touch.normal)),
        contype=0,
        conaffinity=0,
    )
    if touch.restitution:
        ratio = damping_ratio(touch.restitution)
        swing = np.pi / CONTACT_TIME
        softness = [-(swing**2), -2.0 * ratio * swing]
    else:
        softness = _plastic(step)
    spec.add_pair(
        geomname1=f"plane {i}",
        geomname2=f"point {i}",
        condim=3 if touch.friction else 1,
        friction=[max(touch.friction, LEAST_FRICTION)] * 2 + [0.0] * 3,
        solref=softness,
        solimp=HARD,
    )


def _add_hold(mujoco: Any, spec: Any, made: list[Any], hold: Hold, step: float) -> None:
    body = made[hold.body].name
    kinds = mujoco.mjtEq
    spec.add_equality(
        type=kinds.mjEQ_CONNECT if hold.rows == 3 else kinds.mjEQ_WELD,
        objtype=mujoco.mjtObj.mjOBJ_BODY,
        name1=body if hold.rows == 3 else "world",
        name2="world" if hold.rows == 3 else body,
        solref=_plastic(step),
        solimp=HARD,
    )


def _plastic(step: float) -> list[float]:
    """Velocity goes in a step or a few, and does not come back."""
    return [-NO_SPRING, -min(GONE / step, 10.0 / CONTACT_TIME)]


def _principal(body: Body) -> tuple[np.ndarray, np.ndarray]:
    """(3,) moments and (3, 3) axes, right-handed."""
    moments, axes = np.linalg.eigh(body.inertia)
    return moments, axes * np.sign(np.linalg.det(axes))


def _quaternion(mujoco: Any, rotation: np.ndarray) -> np.ndarray:
    quaternion = np.zeros(4)
    mujoco.mju_mat2Quat(quaternion, np.ascontiguousarray(rotation).ravel())
    return quaternion / np.linalg.norm(quaternion)


class Turned:
    """Between Pinocchio's velocities and MuJoCo's: those of free bodies are turned."""

    def __init__(self, mechanism: Mechanism) -> None:
        self._free = [
            (slice(body.first, body.first + 3), np.ascontiguousarray(rotation))
            for body, rotation in zip(mechanism.bodies, mechanism.rotations, strict=True)
            if body.kind == "free"
        ]

    def to(self, v: np.ndarray) -> np.ndarray:
        """(nv,) in MuJoCo's axes."""
        turned = v.copy()
        for own, rotation in self._free:
            turned[own] = rotation @ v[own]
        return turned

    def back(self, v: np.ndarray) -> np.ndarray:
        """(nv,) in the bodies' axes."""
        turned = v.copy()
        for own, rotation in self._free:
            turned[own] = v[own] @ rotation
        return turned


def mujoco_configuration(mechanism: Mechanism, model: Any) -> np.ndarray:
    """(nq,) of MuJoCo."""
    q = model.qpos0.copy()
    for i, body in enumerate(mechanism.bodies):
        if body.kind in ("turn", "slide"):
            q[model.jnt_qposadr[model.body_jntadr[i + 1]]] = body.coordinate
    return q


class Jump:
    """M⁻¹ Jᵀ p of all blows, by MuJoCo's mass matrix at the configuration of its data."""

    def __init__(self, mechanism: Mechanism, model: Any, data: Any) -> None:
        import mujoco

        self._mujoco, self._model, self._data = mujoco, model, data
        self._joint_impulse = Turned(mechanism).to(mechanism.joint_impulse)
        self._blows = [
            (b.linear[:, None], b.angular[:, None], b.place[:, None], b.body + 1)
            for b in mechanism.blows
        ]
        self._momentum, self._jump = np.zeros((1, model.nv)), np.zeros((1, model.nv))

    def __call__(self) -> np.ndarray:
        """(nv,) in MuJoCo's axes, overwritten by the next call."""
        mujoco, model, data, momentum = self._mujoco, self._model, self._data, self._momentum
        mujoco.mj_kinematics(model, data)
        mujoco.mj_comPos(model, data)
        mujoco.mj_makeM(model, data)
        mujoco.mj_factorM(model, data)
        momentum[0] = self._joint_impulse
        for blow in self._blows:
            mujoco.mj_applyFT(model, data, *blow, momentum[0])
        mujoco.mj_solveM(model, data, self._jump, momentum)
        return self._jump[0]


def mujoco_loads(mechanism: Mechanism, model: Any) -> np.ndarray:
    """(nbody, 6) impulse and couple impulse at the centres of mass, in the world."""
    loads = np.zeros((model.nbody, 6))
    for blow in mechanism.blows:
        body = mechanism.bodies[blow.body]
        centre = mechanism.places[blow.body] + mechanism.rotations[blow.body] @ body.centre
        couple = blow.angular + np.cross(blow.place - centre, blow.linear)
        loads[blow.body + 1] += np.concatenate([blow.linear, couple])
    return loads
