"""Newton's and Coulomb's laws as they are written down: what velocities leave of them."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

__all__ = ["left_of_coulomb", "left_of_the_law"]


def left_of_the_law(scene, q, before, after):
    """The most that v⁺ leaves of the law, relative; impulses are worked out from it alone.

    For contacts with level ground, Newton's law, slip at the end.
    """
    robot, model = scene.robot, scene.robot.model
    data = model.createData()
    upper = np.triu(pin.crba(model, data, q))
    masses = upper + np.triu(upper, 1).T
    pin.computeJointJacobians(model, data, q)
    rows = []
    for contact in scene.contacts:
        frame = model.frames[robot.frame_id(contact.frame)]
        place = frame.placement * pin.SE3(np.eye(3), np.array(contact.at))
        axes = pin.LOCAL_WORLD_ALIGNED
        rows.append(pin.getFrameJacobian(model, data, frame.parentJoint, place, axes)[:3])
    rows, momentum = np.vstack(rows), masses @ (after - before)
    P = np.linalg.lstsq(rows.T, momentum, rcond=None)[0]
    assert np.abs(rows.T @ P - momentum).max() < 1e-10 * np.abs(momentum).max(initial=1e-3)
    start, xi = rows @ before, rows @ after
    xi[2::3] += [c.restitution for c in scene.contacts] * np.minimum(start[2::3], 0.0)
    return left_of_coulomb(xi, P, [c.friction for c in scene.contacts], np.abs(before).max())


def left_of_coulomb(xi, P, friction, speed):
    """The most that is left of 0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n and P_t |ξ_t| = −µ P_n ξ_t.

    Args:
        xi, P: (3n,) velocities [m/s] and impulses.
        friction: (n,). speed: of all that moves [m/s].
    """
    load, left = np.abs(P).max() or 1.0, []
    for u, p, mu in zip(xi.reshape(-1, 3), P.reshape(-1, 3), friction, strict=True):
        bound, slip = mu * p[2], np.hypot(*u[:2])
        left += [-p[2] / load, -u[2] / speed, abs(p[2] * u[2]) / (load * speed)]
        left += [(np.hypot(*p[:2]) - bound) / load]
        left += [np.abs(p[:2] * slip + bound * u[:2]).max() / (load * speed)]
    return max(left)
