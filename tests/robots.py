"""Robots and random states that several tests use."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import impulsekit as ik
from benchmarks.urdf import one_body

__all__ = ["STRUCK", "one_body", "random_blow", "random_state", "relative"]

# A link on each at which a blow is of interest.
STRUCK = {
    "talos": "gripper_left_base_link",
    "panda": "panda_hand",
    "solo12": "FR_FOOT",
    "allegro_right_hand": "link_3.0_tip",
}


def random_state(robot: ik.Robot, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """A configuration on its manifold and a velocity, both of order one."""
    rng = np.random.default_rng(seed)
    q = pin.integrate(robot.model, robot.neutral(), rng.uniform(-1.5, 1.5, robot.nv))
    return q, rng.normal(size=robot.nv)


def random_blow(frame: str, seed: int, axes: str = "world") -> ik.AppliedImpulse:
    """A force and couple impulse at a point off the frame's origin."""
    rng = np.random.default_rng(seed)
    return ik.AppliedImpulse(
        frame,
        linear=rng.normal(size=3),
        angular=0.3 * rng.normal(size=3),
        at=0.1 * rng.normal(size=3),
        axes=axes,
    )


def relative(difference: np.ndarray, scale: np.ndarray) -> float:
    """Norm of a difference over the norm of what it is a difference of."""
    return float(np.linalg.norm(difference) / np.linalg.norm(scale))
