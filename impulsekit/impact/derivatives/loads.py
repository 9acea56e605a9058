"""Joint loads as a function of q, Δv and the impulses at contacts, and its derivatives.

The wrench that a parent gives its child is, by Newton and Euler, the change of momentum of all that
the joint carries, less the impulses that act on it from outside (Featherstone 2008, ch. 5.3):

    f_k = Σ_i Y_i V_i − Σ_c w_c,   V_i = Σ_j J_j Δv_j

with i and c on the joint's subtree, in the axes of the joint's frame and at its origin. At fixed Δv
and impulses it changes with q because inertias, axes and contact points move with the joints.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ...errors import InputError
from ...robot.arrays import lock
from ...scene import Contact

if TYPE_CHECKING:
    from ...scene import Scene

__all__ = ["JointLoadSlopes", "joint_load_slopes", "refuse_loads"]

# Joints whose axes turn within the joint, or that follow another one.
_TURNING = ("SphericalZYX", "Universal", "Composite", "Mimic", "Ellipsoid")


@dataclass(frozen=True, eq=False)
class JointLoadSlopes:
    """Derivatives of the loads of J joints, force before moment; arrays are read-only.

    Attributes:
        by_q: (6 J, nv) on the tangent of q, with Δv and the impulses fixed.
        by_dv: (6 J, nv). by_impulses: (6 J, 3 C) in world axes, contact after contact.
    """

    by_q: np.ndarray = field(repr=False)
    by_dv: np.ndarray = field(repr=False)
    by_impulses: np.ndarray = field(repr=False)


def refuse_loads(scene: Scene) -> None:
    """Refuse scenes of which joint loads are not differentiated.

    Raises:
        InputError: it says what, and what to do instead.
    """
    if scene.held or scene.impulses or not all(isinstance(c, Contact) for c in scene.contacts):
        raise InputError(
            "derivatives of joint loads: available where all impulses act at entries of kind "
            "Contact; take finite differences of joint_loads for others"
        )
    for name, joint in zip(scene.robot.model.names, scene.robot.model.joints, strict=True):
        if any(kind in joint.shortname() for kind in _TURNING):
            raise InputError(
                f'derivatives of joint loads: not available for joint "{name}" '
                f"({joint.shortname()}), whose axes move within the joint"
            )


def joint_load_slopes(
    scene: Scene, q: np.ndarray, dv: np.ndarray, impulses: np.ndarray
) -> JointLoadSlopes:
    """Return the derivatives of all joint loads.

    Args:
        scene: one that ``refuse_loads`` lets pass.
        q: (nq,). dv: (nv,). impulses: (C, 3) at the contacts, in world axes.
    """
    model = scene.robot.model
    data = model.createData()
    J = pin.computeJointJacobians(model, data, q)
    pin.updateFramePlacements(model, data)
    parents = list(model.parents)
    velocities, momenta, inertias = _subtrees(model, data, J, dv)
    below = _is_below(parents)
    ends = [_end(scene, data, c) for c in scene.contacts if isinstance(c, Contact)]
    signs = _signs(ends, below)
    at_points = zip(ends, impulses, strict=True)
    wrenches = [np.concatenate([p, np.cross(at, p)]) for (_, at), p in at_points]
    forces = momenta - signs @ np.reshape(wrenches, (-1, 6))
    count, nv = model.njoints - 1, model.nv
    by_q, by_dv = np.zeros((2, count, 6, nv))
    owner = np.repeat(np.arange(1, model.njoints), [joint.nv for joint in list(model.joints)[1:]])
    for j, joint in enumerate(owner.tolist()):
        turn = _cross(J[:, j])
        carried = -turn.T  # the dual action on forces
        for k in range(1, model.njoints):
            deeper = k if below[k, joint] else joint if below[joint, k] else 0
            if not deeper:
                continue
            by_dv[k - 1, :, j] = inertias[deeper] @ J[:, j]
            by_q[k - 1, :, j] = carried @ momenta[deeper] - inertias[deeper] @ (
                turn @ velocities[parents[joint]]
            )
            if below[k, joint]:
                by_q[k - 1, :, j] -= carried @ forces[k]
        for c, ((bodies, at), p) in enumerate(zip(ends, impulses, strict=True)):
            if below[bodies[0], joint]:
                shift = np.cross(J[:3, j] + np.cross(J[3:, j], at), p)
                by_q[:, 3:, j] -= np.multiply.outer(signs[1:, c], shift)
    by_impulses = np.zeros((count, 6, len(ends), 3))
    for c, (_, at) in enumerate(ends):
        by_impulses[:, :, c] = -np.multiply.outer(signs[1:, c], np.vstack([np.eye(3), _skew(at)]))
    local = [data.oMi[k].toActionMatrix().T for k in range(1, model.njoints)]
    tables = [
        (np.array(local) @ table.reshape(count, 6, -1)).reshape(6 * count, -1)
        for table in (by_q, by_dv, by_impulses)
    ]
    lock(*tables)
    return JointLoadSlopes(*tables)


def _subtrees(
    model: pin.Model, data: pin.Data, J: np.ndarray, dv: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """By joint V (6,), and of all it carries the momentum (6,) and the inertia (6, 6)."""
    velocities, momenta = np.zeros((2, model.njoints, 6))
    inertias = np.zeros((model.njoints, 6, 6))
    for i in range(1, model.njoints):
        own = slice(model.joints[i].idx_v, model.joints[i].idx_v + model.joints[i].nv)
        velocities[i] = velocities[model.parents[i]] + J[:, own] @ dv[own]
        inertias[i] = data.oMi[i].act(model.inertias[i]).matrix()
        momenta[i] = inertias[i] @ velocities[i]
    for i in range(model.njoints - 1, 0, -1):
        momenta[model.parents[i]] += momenta[i]
        inertias[model.parents[i]] += inertias[i]
    return velocities, momenta, inertias


def _is_below(parents: Sequence[int]) -> np.ndarray:
    """(joints, joints) whether the first is the second or carried by it."""
    below = np.eye(len(parents), dtype=bool)
    for i in range(1, len(parents)):
        below[i] |= below[parents[i]]
    return below


def _end(scene: Scene, data: pin.Data, entry: Contact) -> tuple[tuple[int, int], np.ndarray]:
    """The joints of a contact's two bodies, and its point in the world (3,)."""
    robot = scene.robot
    frame = robot.frame_id(entry.frame)
    against = robot.frame_id(entry.against)
    frames = robot.model.frames
    return (
        (frames[frame].parentJoint, frames[against].parentJoint),
        data.oMf[frame].act(np.array(entry.at)),
    )


def _signs(ends: Sequence[tuple[tuple[int, int], np.ndarray]], below: np.ndarray) -> np.ndarray:
    """(joints, C) 1 where the contact's first body is carried by the joint, −1 for the other."""
    signs = [below[bodies[0]].astype(float) - below[bodies[1]] for bodies, _ in ends]
    return np.array(signs).reshape(-1, len(below)).T


def _skew(a: np.ndarray) -> np.ndarray:
    return np.array([[0.0, -a[2], a[1]], [a[2], 0.0, -a[0]], [-a[1], a[0], 0.0]])


def _cross(motion: np.ndarray) -> np.ndarray:
    """(6, 6) the motion cross product, linear before angular."""
    linear, angular = _skew(motion[:3]), _skew(motion[3:])
    return np.block([[angular, linear], [np.zeros((3, 3)), angular]])
