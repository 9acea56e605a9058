"""How fast contacts approach, and how long a spring in their place takes to push back."""

from __future__ import annotations

import math

import numpy as np
import pinocchio as pin

from ..problems.problem import Problem
from .mechanism import Mechanism

__all__ = ["approach_speed", "half_swing", "normal_rows"]

# Of contacts that do not approach [m/s]: times are over it.
SLOWEST = 1e-12


def approach_speed(problem: Problem, mechanism: Mechanism) -> float:
    """The fastest approach of all contacts [m/s], above zero."""
    rows, _ = normal_rows(problem, mechanism)
    return max(float((-rows @ problem.v).max()), SLOWEST)


def half_swing(problem: Problem, mechanism: Mechanism, stiffness: float) -> float:
    """π √(m/k) [s] of the lightest contact, for springs of k [N/m]."""
    rows, inverse = normal_rows(problem, mechanism)
    lightest = float(np.einsum("ci,ij,cj->c", rows, inverse, rows).max())
    return math.pi / math.sqrt(stiffness * lightest)


def normal_rows(problem: Problem, mechanism: Mechanism) -> tuple[np.ndarray, np.ndarray]:
    """(c, nv) rows of the normal velocities, and the inverse of M."""
    model = problem.scene.robot.model
    data = model.createData()
    inverse = np.array(pin.computeMinverse(model, data, problem.q))
    inverse = np.triu(inverse) + np.triu(inverse, 1).T
    pin.computeJointJacobians(model, data, problem.q)
    rows = np.zeros((len(mechanism.touches), model.nv))
    for row, touch in zip(rows, mechanism.touches, strict=True):
        turning = np.cross(touch.place, touch.normal)
        for body, sign in ((touch.body, 1.0), (touch.other, -1.0)):
            if body >= 0:
                jacobian = pin.getJointJacobian(model, data, body + 1, pin.ReferenceFrame.WORLD)
                jacobian = jacobian.reshape(6, -1)
                row += sign * (touch.normal @ jacobian[:3] + turning @ jacobian[3:])
    return rows, inverse
