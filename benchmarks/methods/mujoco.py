"""MuJoCo: its mass matrix, its forward dynamics, one step, a batch, its soft contacts, its motion.

Soft contacts take a contact time of 0.1 µs, cut into the steps of the setting. Friction and normal
velocity share one convex problem, so a point that slides is lifted at µ times its slip: such
landings are not solved at any step.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from ..problems.problem import Problem
from .holds import hold_of, is_held
from .mechanism import has_plain_joints, is_blow, is_flight, is_landing, mechanism_of
from .method import Answer, Method
from .mujoco_model import (
    CONTACT_TIME,
    Jump,
    Turned,
    mujoco_configuration,
    mujoco_loads,
    mujoco_model,
)
from .mujoco_motion import by_steps, is_sliding, with_contact_by_steps

__all__ = ["METHODS"]

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
