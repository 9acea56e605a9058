"""Small robots whose motion is known in closed form."""

from __future__ import annotations

from pathlib import Path

import numpy as np

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text

MODELS = Path(__file__).parents[2] / "models"
GRAVITY = 9.81


def sliders(count: int, axis: str = "0 0 1") -> ik.Robot:
    """Bodies b00, b01, ... side by side, each on its own slide from the world."""
    parts = [link_text("base")]
    for i in range(count):
        parts.append(link_text(f"b{i:02d}", 1 + 0.1 * i))
        parts.append(joint_text(f"z{i:02d}", "prismatic", "base", f"b{i:02d}", axis))
    return ik.Robot.from_urdf(robot_text("sliders", *parts))


def particle(mass: float = 2.0) -> ik.Robot:
    """A body "z" that slides along x, y and z of the world and does not turn."""
    parts = [link_text("w")]
    for name, parent, axis in (("x", "w", "1 0 0"), ("y", "x", "0 1 0"), ("z", "y", "0 0 1")):
        parts.append(link_text(name, mass if name == "z" else None))
        parts.append(joint_text(f"along_{name}", "prismatic", parent, name, axis))
    return ik.Robot.from_urdf(robot_text("particle", *parts))


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
