"""States drawn without a library of functions, so that every machine draws the same bits."""

from __future__ import annotations

import numpy as np

from impulsekit.robot import Robot

__all__ = ["drawn_state"]


def drawn_state(robot: Robot, seed: int, spread: float = 1.0) -> tuple[np.ndarray, np.ndarray]:
    """(nq,) configuration and (nv,) velocity.

    Joint coordinates are uniform within ``spread`` [rad, m] of neutral, about as much for
    what lies on a circle or sphere; velocities are uniform within 1.
    """
    rng = np.random.default_rng(seed)
    model, q = robot.model, robot.neutral()
    for joint in list(model.joints)[1:]:
        at = slice(joint.idx_q, joint.idx_q + joint.nq)
        draws = rng.uniform(-spread, spread, joint.nq)
        if joint.nq == joint.nv:
            q[at] = draws
        elif joint.nq == 2:
            q[at] = _on_circle(draws[0])
        elif joint.nq == 4 and joint.nv == 3 and joint.shortname() == "JointModelPlanar":
            q[at] = [draws[0], draws[1], *_on_circle(draws[2])]
        else:
            # The last four are a quaternion x, y, z, w.
            quaternion = np.array([*(0.5 * draws[-4:-1]), 1.0])
            quaternion /= np.sqrt(quaternion.dot(quaternion))
            q[at] = [*draws[:-4], *quaternion]
    return q, rng.uniform(-1.0, 1.0, robot.nv)


def _on_circle(turn: float) -> tuple[float, float]:
    """Cosine and sine of about ``turn``: t = tan(α/2) and the two rational functions of it."""
    t = 0.5 * turn
    return (1.0 - t * t) / (1.0 + t * t), 2.0 * t / (1.0 + t * t)
