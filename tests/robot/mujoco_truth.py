"""Δv by MuJoCo's own mass matrix, Jacobians and equality rows, to hold robots from MJCF against."""

from __future__ import annotations

import warnings
from types import SimpleNamespace

import mujoco
import numpy as np

import impulsekit as ik

KEPT = [int(kind) for kind in (
    mujoco.mjtEq.mjEQ_CONNECT, mujoco.mjtEq.mjEQ_WELD, mujoco.mjtEq.mjEQ_JOINT
)]  # fmt: skip
# Rows of an equality that is open at qpos0 differ: MuJoCo's are of where the points are [m, rad].
CLOSED = 1e-9


def state(mj, rng):
    """A random state of MuJoCo's, in its data."""
    data = mujoco.MjData(mj)
    data.qpos[:] = mj.qpos0
    mujoco.mj_integratePos(mj, data.qpos, rng.normal(size=mj.nv), 1.0)
    data.qvel[:] = rng.normal(size=mj.nv)
    mujoco.mj_forward(mj, data)
    return data


def state_from_mujoco(mj, qpos, qvel):
    """``mujoco_state`` of numbers that stand in no data."""
    return ik.mujoco_state(SimpleNamespace(model=mj, qpos=qpos, qvel=qvel))


def full_mass(mj, data):
    """(nv, nv) by ``mj_fullM``, whose arguments MuJoCo 4 changed."""
    mass = np.zeros((mj.nv, mj.nv))
    try:
        mujoco.mj_fullM(mj, data, mass)
    except TypeError:
        mujoco.mj_fullM(mj, mass, data.qM)
    return mass


def jump(mj, data, body, at, blow, *, loops=False):
    """(nv,) Δq̇ by a blow (3,) at a point (3,) of a body, from the dense KKT system.

    M Δv + Eᵀ λ = Jᵀ p, E Δv = 0, with MuJoCo's equality rows E if ``loops``.
    """
    jacobian = np.zeros((3, mj.nv))
    point = data.xpos[body] + data.xmat[body].reshape(3, 3) @ at
    mujoco.mj_jac(mj, data, jacobian, None, point, body)
    mass = full_mass(mj, data)
    free = np.linalg.solve(mass, jacobian.T @ blow)
    rows = np.zeros((0, mj.nv))
    if loops:
        # Equalities of tendons have no place in the model, as its assumptions say.
        kept = [int(mj.eq_type[i]) in KEPT for i in data.efc_id[: data.ne]]
        rows = np.array(data.efc_J).reshape(-1, mj.nv)[: data.ne][kept]
    if not len(rows):
        return free
    # Scaled to unit length, so that neither units nor scales decide which rows count.
    rows = rows[np.abs(rows).max(axis=1) > 0.0]
    half = np.linalg.solve(np.linalg.cholesky(mass), rows.T)
    rows = rows / np.linalg.norm(half, axis=0)[:, None]
    bearing = -np.linalg.pinv(rows @ np.linalg.solve(mass, rows.T), rcond=1e-12) @ (rows @ free)
    return free + np.linalg.solve(mass, rows.T @ bearing)


def difference(mj, seed=0, *, loops=False):
    """Largest entry by which Δv of ``solve`` is off, over the largest; None if nothing moves.

    Without loops at a random state; with the loops of the file at ``qpos0``, where they close.
    """
    mj.opt.jacobian = mujoco.mjtJacobian.mjJAC_DENSE
    mj.opt.disableflags |= mujoco.mjtDisableBit.mjDSBL_CONTACT
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        robot = ik.Robot.from_mjcf(mj)
        rng = np.random.default_rng(seed)
        data = state(mj, rng)
        if loops:
            data = mujoco.MjData(mj)
            mujoco.mj_forward(mj, data)
            # A weld that does not hold turns becomes one that does, as its assumption says.
            if any(mj.eq_data[i][10] == 0.0 for i in np.flatnonzero(mj.eq_type == KEPT[1])):
                return None
            if not data.ne or np.abs(data.efc_pos[: data.ne]).max() > CLOSED:
                return None
        moving = [i for i in range(1, mj.nbody) if mj.body_weldid[i] > 0 and mj.body_mass[i] > 0.0]
        if not moving or robot.nv != mj.nv:
            return None
        body = int(rng.choice(moving))
        blow, at = rng.normal(size=3), 0.1 * rng.normal(size=3)
        entry = ik.AppliedImpulse(robot.links[body - 1].name, linear=blow, at=at)
        scene = ik.Scene.of_robot(robot, impulses=[entry]) if loops else ik.Scene(robot, [entry])
        q, v = state_from_mujoco(mj, data.qpos, 0.0 * data.qvel)
        impact = ik.solve(scene, q, v)
        _, expected = state_from_mujoco(mj, data.qpos, jump(mj, data, body, at, blow, loops=loops))
    # Where loops hold all, what they let through is rounding of what the blow alone would do.
    _, free = state_from_mujoco(mj, data.qpos, jump(mj, data, body, at, blow))
    return float(np.abs(impact.dv - expected).max() / max(np.abs(free).max(), 1e-300))
