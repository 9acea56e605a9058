"""Small robots whose motion is known in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import impulsekit as ik

MODELS = Path(__file__).parents[2] / "models"
GRAVITY = 9.81
_INERTIAL = (
    '<inertial><mass value="{m}"/>'
    '<inertia ixx="1" iyy="1" izz="1" ixy="0" ixz="0" iyz="0"/></inertial>'
)
_FREE = '<limit lower="-1e4" upper="1e4" effort="1" velocity="1"/>'


def sliders(count: int, axis: str = "0 0 1") -> ik.Robot:
    """Bodies b00, b01, ... side by side, each on its own slide from the world."""
    parts = ['<robot name="sliders"><link name="base"/>']
    for i in range(count):
        parts.append(f'<link name="b{i:02d}">{_INERTIAL.format(m=1 + 0.1 * i)}</link>')
        parts.append(
            f'<joint name="z{i:02d}" type="prismatic"><parent link="base"/>'
            f'<child link="b{i:02d}"/><axis xyz="{axis}"/>{_FREE}</joint>'
        )
    return ik.Robot.from_urdf("".join(parts) + "</robot>")


def particle(mass: float = 2.0) -> ik.Robot:
    """A body "z" that slides along x, y and z of the world and does not turn."""
    parts = ['<robot name="particle"><link name="w"/>']
    for name, parent, axis in (("x", "w", "1 0 0"), ("y", "x", "0 1 0"), ("z", "y", "0 0 1")):
        inertial = _INERTIAL.format(m=mass) if name == "z" else ""
        parts.append(f'<link name="{name}">{inertial}</link>')
        parts.append(
            f'<joint name="along_{name}" type="prismatic"><parent link="{parent}"/>'
            f'<child link="{name}"/><axis xyz="{axis}"/>{_FREE}</joint>'
        )
    return ik.Robot.from_urdf("".join(parts) + "</robot>")


def bounces(height: float, restitution: float, until: float, slowest: float) -> list[float]:
    """When a ball dropped from rest meets the floor, approaching no slower than ``slowest``."""
    time, speed = np.sqrt(2.0 * height / GRAVITY), np.sqrt(2.0 * height * GRAVITY)
    times = []
    while time < until and speed > slowest:
        times.append(float(time))
        speed *= restitution
        time += 2.0 * speed / GRAVITY
    return times


def hits(motion: ik.Trajectory, contact: int, slowest: float) -> list[float]:
    """When a contact was struck, approaching no slower than ``slowest``."""
    found = []
    for time, impact in motion.impacts:
        for touch in impact.outcome.touches:
            if touch.entry == contact and touch.jacobian[2] @ impact.v_before < -slowest:
                found.append(time)
    return found
