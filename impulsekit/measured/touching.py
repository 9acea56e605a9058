"""Configurations that touch: what noise holds apart is brought to where it closed."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from ..geometry.gaps import AT_STOP
from ..rows.contacts import ContactRows
from ..rows.reach import reached_model
from ..scene import GapContact, JointStop, Rope, Scene

__all__ = ["at_touch"]

# Steps of Newton: gaps of noise are small against what curves them, and two or three do.
MOST_STEPS = 20


def at_touch(
    scene: Scene, names: Sequence[str], q: np.ndarray, covariance: np.ndarray
) -> np.ndarray:
    """(nq,) the configuration where contacts that closed touch, of those that noise left apart.

    Joints go to the limits that they hit. For a ``Rope`` and a ``GapContact`` it is the likeliest
    configuration without a gap g: δ = −C nᵀ (n C nᵀ)⁻¹ g, n the gradient of g, until g is 0. A
    ``Contact`` touches whatever its gap, and a ``Collision`` up to its margin: these move nothing.

    Args:
        names: of the contacts that closed.
        q: (nq,) as measured. covariance: (nv, nv) of it on its tangent.
    """
    q, model = q.copy(), scene.robot.model
    closed = []
    for k, (name, entry) in enumerate(
        zip(scene.entry_names("contacts"), scene.contacts, strict=True)
    ):
        if name not in names:
            continue
        if isinstance(entry, JointStop):
            at = model.joints[scene.robot.joint_id(entry.joint)].idx_q
            lower, upper = entry.limits(scene.robot)
            near_upper = upper - q[at] < q[at] - lower
            q[at] = max(q[at], upper) if near_upper else min(q[at], lower)
        elif isinstance(entry, Rope | GapContact):
            closed.append(k)
    if not closed:
        return q
    reached = reached_model(model, range(1, model.njoints), keep_places=True)
    rows, data = ContactRows(scene, reached), reached.model.createData()
    apart: np.ndarray | None = None
    for _ in range(MOST_STEPS):
        touches = rows.touching(data, q, closed)
        gaps = np.array([touch.gap for touch in touches], dtype=float)
        apart = gaps > AT_STOP if apart is None else apart
        if np.abs(gaps[apart]).max(initial=0.0) <= AT_STOP:
            break
        normals = np.array([touch.jacobian[2] for touch in touches])[apart]
        spread = covariance @ normals.T
        q = pin.integrate(model, q, -spread @ np.linalg.lstsq(normals @ spread, gaps[apart])[0])
    return q
