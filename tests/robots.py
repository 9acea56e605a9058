"""Robots and random states that several tests use."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import impulsekit as ik
from benchmarks.urdf import one_body

__all__ = ["STRUCK", "masses_on_slides", "one_body", "random_blow", "random_state", "relative"]

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


def masses_on_slides(masses: tuple[float, float, float]) -> ik.Robot:
    """Three masses, each on a slide of the one before: along x, y and z."""
    inertia = '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/>'
    limit = '<limit lower="-1e9" upper="1e9" effort="1e9" velocity="1e9"/>'
    parts = "".join(
        f'<link name="link_{i}"><inertial><mass value="{m}"/>{inertia}</inertial></link>'
        f'<joint name="joint_{i}" type="prismatic"><parent link="link_{i - 1}"/>'
        f'<child link="link_{i}"/><axis xyz="{axis}"/>{limit}</joint>'
        for i, (m, axis) in enumerate(zip(masses, ("1 0 0", "0 1 0", "0 0 1"), strict=True))
    ).replace('"link_-1"', '"rail"')
    return ik.Robot.from_urdf(f'<robot name="slides"><link name="rail"/>{parts}</robot>')
