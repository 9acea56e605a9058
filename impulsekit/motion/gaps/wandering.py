"""Points of contact that wander over round bodies as these roll: their rows and rates."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pinocchio as pin

__all__ = ["MOVE", "bias_by_differences"]

# How far the bodies move for the rates of their rows [m, rad].
MOVE = 1e-4
# What moves more slowly is moved as if at this speed [m/s or rad/s]: not for seconds.
SLOWEST = 1e-3

# (3k, nv) rows and (k, 3) points; of data with joint Jacobians.
Rows = Callable[[pin.Data], tuple[np.ndarray, np.ndarray]]


def bias_by_differences(
    model: pin.Model,
    shifted: pin.Data,
    found: Rows,
    here: np.ndarray,
    q: np.ndarray,
    v: np.ndarray,
) -> np.ndarray:
    """(3k,) the rows' rates along the motion, by central differences.

    No point of either body tells them, for the points wander over both.

    Args:
        model: the model.
        shifted: a workspace.
        found: the rows and points at a configuration near q, those that lie near each other
            there included: what touches at q may have parted by the way between the two.
        here: (k, 3) the points at q.
        q, v: the state.
    """
    size = float(np.abs(v).max(initial=0.0))
    if size == 0.0 or not len(here):
        return np.zeros(3 * len(here))
    time = MOVE / max(size, SLOWEST)
    velocities = []
    for sign in (1.0, -1.0):
        there = pin.integrate(model, q, sign * time * v)
        pin.computeJointJacobians(model, shifted, there)
        rows, points = found(shifted)
        if not len(points):
            return np.zeros(3 * len(here))
        nearest = [int(np.argmin(np.linalg.norm(points - point, axis=1))) for point in here]
        velocities.append(rows.dot(v).reshape(-1, 3)[nearest])
    return ((velocities[0] - velocities[1]) / (2.0 * time)).ravel()
