"""Robots and random states that several tests use."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import impulsekit as ik

# A link on each at which a blow is of interest.
STRUCK = {
    "talos": "gripper_left_base_link",
    "panda": "panda_hand",
    "solo12": "FR_FOOT",
    "allegro_right_hand": "link_3.0_tip",
}


def one_body(
    name: str, mass: float, moments: object, shape: str = "", root: str = "freeflyer"
) -> ik.Robot:
    """A robot of one link.

    ``moments``: of inertia, three or one for all axes; ``shape``: what collides, in the words of
    a URDF.
    """
    x, y, z = np.broadcast_to(np.asarray(moments, dtype=float), 3).tolist()
    collision = f"<collision><geometry>{shape}</geometry></collision>" if shape else ""
    return ik.Robot.from_urdf(
        f'<robot name="{name}"><link name="{name}"><inertial><mass value="{mass!r}"/><inertia '
        f'ixx="{x!r}" iyy="{y!r}" izz="{z!r}" ixy="0" ixz="0" iyz="0"/></inertial>{collision}'
        "</link></robot>",
        root=root,
    )


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
