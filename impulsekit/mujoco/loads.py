"""The wrenches that bodies pass on in an impact, from MuJoCo's own kinematics."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np

from ..errors import InputError
from ..robot.arrays import read_only

__all__ = ["body_loads"]


def body_loads(
    model: Any, state: np.ndarray, equalities: int, dv: np.ndarray,
    geoms: np.ndarray, places: np.ndarray, wrenches: np.ndarray,
) -> dict[str, np.ndarray]:  # fmt: skip
    """Return by body the wrench of its parent in an impact.

    The momentum that a subtree gains, less what contacts give it, comes through its joint.

    Args:
        model: a ``mujoco.MjModel``. state: at the impact, as ``mjSTATE_INTEGRATION``.
        equalities: number of their active rows.
        dv: (nv,) change of generalized velocity.
        geoms, places: (n, 2), (n, 3) of each contact.
        wrenches: (n, 6) what the second geom of each contact receives, at the contact.

    Raises:
        InputError: equality constraints were active.
    """
    if equalities:
        raise InputError(
            "joint_impulses: equality constraints were active, which carry part of the load"
        )
    data = mujoco.MjData(model)
    mujoco.mj_setState(model, data, state, mujoco.mjtState.mjSTATE_INTEGRATION)
    mujoco.mj_kinematics(model, data)
    mujoco.mj_comPos(model, data)
    centres, cdof = data.subtree_com[model.body_rootid], data.cdof
    # MuJoCo's spatial vectors: angular before linear, at the centre of mass of the tree.
    twist = np.zeros((model.nbody, 6))
    for i in range(1, model.nbody):
        first, count = model.body_dofadr[i], model.body_dofnum[i]
        twist[i] = twist[model.body_parentid[i]]
        if count:
            twist[i] += dv[first : first + count] @ cdof[first : first + count]
    passed = _momenta(data.cinert, twist)
    for (first, second), wrench, place in zip(
        model.geom_bodyid[geoms], wrenches, places, strict=True
    ):
        for body, own in ((first, -wrench), (second, wrench)):
            passed[body, 3:] -= own[:3]
            passed[body, :3] -= own[3:] + np.cross(place - centres[body], own[:3])
    found = {}
    for i in range(model.nbody - 1, 0, -1):
        parent = int(model.body_parentid[i])
        if parent:
            passed[parent] += passed[i]
        name = mujoco.mj_id2name(model, mujoco.mjtObj.mjOBJ_BODY, i) or f"body {i}"
        angular = passed[i, :3] - np.cross(data.xpos[i] - centres[i], passed[i, 3:])
        found[name] = read_only(np.concatenate([passed[i, 3:], angular]))
    return found


def _momenta(cinert: np.ndarray, twist: np.ndarray) -> np.ndarray:
    """Momenta (nbody, 6), angular first, of MuJoCo's inertias (nbody, 10) and velocities.

    An inertia is xx, yy, zz, xy, xz, yz, m r, m about the origin of the velocities.
    """
    turning, linear = twist[:, :3], twist[:, 3:]
    moment, mass = cinert[:, 6:9], cinert[:, 9:]
    about = cinert[:, [0, 3, 4, 3, 1, 5, 4, 5, 2]].reshape(-1, 3, 3)
    angular = np.einsum("nij,nj->ni", about, turning) + np.cross(moment, linear)
    return np.hstack([angular, mass * linear - np.cross(moment, turning)])
