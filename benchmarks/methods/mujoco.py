"""MuJoCo: its mass matrix, its forward dynamics, one step, a batch, its soft contacts, its motion.

Soft contacts take a contact time of 0.1 µs, cut into the steps of the setting. Friction and normal
velocity share one convex problem, so a point that slides is lifted at µ times its slip: such
landings are not solved at any step.
"""

from __future__ import annotations

from functools import partial

import numpy as np
import pinocchio as pin

from ..problems.motions import FRICTION, SIDE, SLIDING
from ..problems.problem import Problem
from .mechanism import (
    Mechanism,
    has_plain_joints,
    hold_of,
    is_blow,
    is_flight,
    is_held,
    is_landing,
    mechanism_of,
)
from .method import Answer, Method
from .mujoco_model import (
    CONTACT_TIME,
    Jump,
    Turned,
    mujoco_configuration,
    mujoco_loads,
    mujoco_model,
)

WORLD = """<mujoco><worldbody><geom type="plane" size="0 0 1" friction="{mu} .005 .0001"/><body>
<freejoint/><geom type="box" size="{half} {half} {half}" mass="{mass}" friction="{mu} .005 .0001"/>
</body></worldbody></mujoco>"""


def by_steps(problem: Problem, step: float, integrator: str) -> Answer:
    """q and v at the end, by steps of about ``step`` [s] of MuJoCo's ``integrator``."""
    import mujoco

    mechanism = mechanism_of(problem)
    count = max(1, round(problem.duration / step))
    model, turned = mujoco_model(mechanism, problem.duration / count), Turned(mechanism)
    model.opt.gravity = problem.scene.gravity
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    data = mujoco.MjData(model)
    q, v = mujoco_configuration(mechanism, model), turned.to(mechanism.v)
    back = _Back(problem, mechanism, model.jnt_qposadr[model.body_jntadr[1:]].tolist())
    jump = Jump(mechanism, model, data)

    def state_after() -> np.ndarray:
        mujoco.mj_resetData(model, data)
        data.qpos = q
        data.qvel = v + jump()
        mujoco.mj_step(model, data, count)
        return back(data.qpos, data.qvel)

    return state_after


def is_sliding(problem: Problem) -> bool:
    """Whether it is the motion of a block over a floor."""
    return problem.family == SLIDING


def with_contact_by_steps(problem: Problem, step: float, integrator: str) -> Answer:
    """q and v of a block on a floor at the end, by steps of about ``step`` [s]; soft contact."""
    import mujoco

    world = WORLD.format(mu=FRICTION, half=0.5 * SIDE, mass=problem.scene.robot.mass)
    model = mujoco.MjModel.from_xml_string(world)
    count = max(1, round(problem.duration / step))
    model.opt.timestep, model.opt.gravity = problem.duration / count, problem.scene.gravity
    model.opt.integrator = getattr(mujoco.mjtIntegrator, f"mjINT_{integrator}")
    data = mujoco.MjData(model)

    def state_after() -> np.ndarray:
        mujoco.mj_resetData(model, data)
        data.qpos, data.qvel = problem.q[[0, 1, 2, 6, 3, 4, 5]], problem.v
        mujoco.mj_step(model, data, count)
        pose = _pose(data.qpos[:3], data.qpos[3:])
        linear = pose.rotation.T @ data.qvel[:3]
        return np.concatenate([pin.SE3ToXYZQUAT(pose), linear, data.qvel[3:]])

    return state_after


class _Back:
    """From MuJoCo's state to Pinocchio's q and v.

    MuJoCo's planar and ball joints start at zero in the body's pose, its free ones have the
    body's pose in the world.
    """

    def __init__(self, problem: Problem, mechanism: Mechanism, places: list[int]) -> None:
        self._model = problem.scene.robot.model
        self._mechanism, self._places, self._q = mechanism, places, problem.q

    def __call__(self, qpos: np.ndarray, qvel: np.ndarray) -> np.ndarray:
        q, v = np.zeros(self._model.nq), qvel.copy()
        joints = list(self._model.joints)[1:]
        for i, (body, joint, at) in enumerate(
            zip(self._mechanism.bodies, joints, self._places, strict=True)
        ):
            own = slice(joint.idx_q, joint.idx_q + joint.nq)
            first = pin.SE3(body.rotation, body.offset)
            placement = self._model.jointPlacements[i + 1]
            if body.kind in ("turn", "slide"):
                angle = qpos[at]
                q[own] = angle if joint.nq == 1 else (np.cos(angle), np.sin(angle))
            elif body.kind == "planar":
                moved = pin.SE3(_turn(qpos[at + 2]), np.array([*qpos[at : at + 2], 0.0]))
                moved = placement.actInv(first * moved)
                x, y = moved.translation[:2]
                q[own] = x, y, moved.rotation[0, 0], moved.rotation[1, 0]
                # Its slides keep their directions while the body turns.
                v[body.first : body.first + 2] = _turn(-qpos[at + 2])[:2, :2] @ v[body.first :][:2]
            elif body.kind == "free":
                pose = _pose(qpos[at : at + 3], qpos[at + 3 : at + 7])
                q[own] = self._near(pin.SE3ToXYZQUAT(placement.actInv(pose)), own)
                v[body.first : body.first + 3] = pose.rotation.T @ v[body.first :][:3]
            elif body.kind == "ball":
                moved = placement.actInv(first * _pose(np.zeros(3), qpos[at : at + 4]))
                q[own] = self._near(pin.SE3ToXYZQUAT(moved), own)[3:]
            else:
                q[own] = placement.actInv(first.act(qpos[at : at + 3]))
        return np.concatenate([q, v])

    def _near(self, q: np.ndarray, own: slice) -> np.ndarray:
        """Of the two quaternions of a rotation the one that the start leads to, within a turn."""
        if q[3:] @ self._q[own][-4:] < 0.0:
            q[3:] *= -1.0
        return q


def _turn(angle: float) -> np.ndarray:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([[c, -s, 0.0], [s, c, 0.0], [0.0, 0.0, 1.0]])


def _pose(place: np.ndarray, quaternion: np.ndarray) -> pin.SE3:
    """MuJoCo's quaternions are w, x, y, z."""
    return pin.SE3(pin.Quaternion(*quaternion).matrix(), place)


NEEDS = ("mujoco",)
BATCH = 4096
# Contact times that are followed: half a swing, and time for those that are struck in turn.
LASTS = 3.0


def _by_mass_matrix(problem: Problem) -> Answer:
    import mujoco

    mechanism = mechanism_of(problem)
    model, turned = mujoco_model(mechanism), Turned(mechanism)
    data = mujoco.MjData(model)
    q, v, jump = mujoco_configuration(mechanism, model), mechanism.v, Jump(mechanism, model, data)

    def velocity_after() -> np.ndarray:
        data.qpos = q
        return v + turned.back(jump())

    return velocity_after


def _by_forward(problem: Problem) -> Answer:
    import mujoco

    mechanism = mechanism_of(problem)
    model, turned = mujoco_model(mechanism), Turned(mechanism)
    data = mujoco.MjData(model)
    q, v = mujoco_configuration(mechanism, model), mechanism.v
    loads, joint_impulse = mujoco_loads(mechanism, model), turned.to(mechanism.joint_impulse)

    def velocity_after() -> np.ndarray:
        # At rest and without weight, the acceleration by the impulse is the jump.
        data.qpos, data.xfrc_applied, data.qfrc_applied = q, loads, joint_impulse
        mujoco.mj_forward(model, data)
        return v + turned.back(data.qacc)

    return velocity_after


def _by_step(problem: Problem, step: float) -> Answer:
    import mujoco

    mechanism = mechanism_of(problem)
    model, turned = mujoco_model(mechanism, step), Turned(mechanism)
    data = mujoco.MjData(model)
    q, v = mujoco_configuration(mechanism, model), turned.to(mechanism.v)
    forces = mujoco_loads(mechanism, model) / step
    joint_forces = turned.to(mechanism.joint_impulse) / step

    def velocity_after() -> np.ndarray:
        data.qpos, data.qvel, data.xfrc_applied, data.qfrc_applied = q, v, forces, joint_forces
        mujoco.mj_step(model, data)
        return turned.back(data.qvel)

    return velocity_after


def _by_batch(problem: Problem) -> Answer:
    from mujoco.batch import Batch

    mechanism = mechanism_of(problem)
    model, turned = mujoco_model(mechanism), Turned(mechanism)
    batch, v = Batch(model, BATCH), mechanism.v
    batch.bind("qpos")[:] = mujoco_configuration(mechanism, model)
    batch.bind("xfrc_applied")[:] = mujoco_loads(mechanism, model)
    batch.bind("qfrc_applied")[:] = turned.to(mechanism.joint_impulse)
    jumps = batch.bind("qacc")

    def velocity_after() -> np.ndarray:
        batch.forward()
        return v + turned.back(jumps[-1])

    return velocity_after


def _by_soft_contacts(problem: Problem, steps: int) -> Answer:
    """Contacts or holds, followed for some contact times; a blow's jump comes first."""
    import mujoco

    mechanism = mechanism_of(problem)
    holds = [hold_of(problem, constraint) for constraint in problem.scene.constraints]
    model = mujoco_model(mechanism, LASTS * CONTACT_TIME / steps, holds)
    data, turned = mujoco.MjData(model), Turned(mechanism)
    q, v = mujoco_configuration(mechanism, model), turned.to(mechanism.v)
    jump = Jump(mechanism, model, data) if problem.scene.impulses else None
    kinds = mujoco.mjtWarning
    wrong = (kinds.mjWARN_BADQPOS, kinds.mjWARN_BADQVEL, kinds.mjWARN_BADQACC)

    def velocity_after() -> np.ndarray:
        mujoco.mj_resetData(model, data)
        data.qpos = q
        data.qvel = v + jump() if jump else v
        mujoco.mj_step(model, data, steps)
        # MuJoCo starts anew from a state that it cannot go on from.
        went_wrong = any(data.warning[kind].number for kind in wrong)
        return np.full(model.nv, np.nan) if went_wrong else turned.back(data.qvel)

    return velocity_after


def _suits_soft(problem: Problem) -> bool:
    """Contacts alone, or holds with or without blows."""
    scene = problem.scene
    if not scene.constraints:
        return is_landing(problem)
    held = all(is_held(problem, constraint) for constraint in scene.constraints)
    return held and not scene.contacts and not problem.duration and has_plain_joints(problem)


_theirs = partial(Method, peer=True, needs=NEEDS)
METHODS: tuple[Method, ...] = (
    _theirs("mujoco, mass matrix", is_blow, _by_mass_matrix),
    _theirs("mujoco, forward", is_blow, _by_forward),
    _theirs("mujoco, batch", is_blow, _by_batch, states=BATCH),
    *_theirs("mujoco, one step", is_blow, _by_step).at((1e-3, 1e-6)),
    *_theirs("mujoco, soft contacts", _suits_soft, _by_soft_contacts).at((10, 100, 1000)),
    *_theirs("mujoco, Euler", is_flight, partial(by_steps, integrator="EULER")).at((1e-3, 1e-4)),
    *_theirs("mujoco, RK4", is_flight, partial(by_steps, integrator="RK4")).at(
        (4e-3, 1e-3, 2.5e-4)
    ),
    *(
        method
        for name in ("Euler", "implicitfast")
        for method in _theirs(
            f"mujoco, contact, {name}",
            is_sliding,
            partial(with_contact_by_steps, integrator=name.upper()),
        ).at((4e-3, 1e-3, 2.5e-4, 5e-5))
    ),
)
