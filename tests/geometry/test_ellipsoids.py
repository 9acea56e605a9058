"""An ellipsoid over a half-space: its lowest point, wherever both are."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import quad

import impulsekit as ik

EGG = """<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1"/>
<body name="egg"><freejoint name="free"/>
<geom name="shell" type="ellipsoid" size="0.2 0.12 0.08" mass="3"/></body></worldbody></mujoco>"""


def test_one_that_falls_flat_bounces_down_to_rest():
    # Its bounces went on below what could be told: EVENT_STORM, and PENETRATION with a robot on it.
    robot = ik.Robot.from_mjcf(EGG)
    scene = ik.Scene(
        robot, contacts=[ik.Collision("shell", "floor", restitution=0.3, friction=0.6)]
    )
    q = robot.configuration(free=[0, 0, 0.2, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, robot.velocity(), duration=0.6, samples=3)
    assert motion.status.finished
    assert motion.q[-1, 2] == pytest.approx(0.08, abs=1e-9)
    assert np.abs(motion.v[-1]).max() < 1e-9
    speeds = [-impact.contacts[0].velocity_before[2] for _, impact in motion.impacts]
    assert speeds[1:6] == pytest.approx([0.3 * speed for speed in speeds[:5]], rel=1e-6)


def test_one_that_rocks_without_friction_swings_as_its_energy_says():
    """It slides so that its middle falls straight down, h(θ) above the floor."""
    a, b, mass, begin = 0.2, 0.08, 3.0, 0.7
    moment = mass * (a * a + b * b) / 5.0

    def height(tilt):
        return np.hypot(a * np.sin(tilt), b * np.cos(tilt))

    def slowness(s):
        # θ = begin − s²: nothing is singular at the start.
        tilt = begin - s * s
        slope = (a * a - b * b) * np.sin(tilt) * np.cos(tilt) / height(tilt)
        square = 2.0 * mass * 9.81 * (height(begin) - height(tilt)) / (moment + mass * slope**2)
        return 2.0 * s / np.sqrt(square)

    level, _ = quad(slowness, 1e-9, np.sqrt(begin))
    robot = ik.Robot.from_mjcf(EGG)
    scene = ik.Scene(robot, contacts=[ik.Collision("shell", "floor")])
    turn = [0, np.sin(begin / 2), 0, np.cos(begin / 2)]
    q = robot.configuration(free=[0, 0, height(begin), *turn])
    motion = ik.simulate(scene, q, robot.velocity(), duration=4.0 * level, samples=5)
    assert motion.status.finished
    # Level after a quarter, tilted the other way after half, and back.
    tilts = 2.0 * np.arctan2(motion.q[:, 4], motion.q[:, 6])
    assert tilts == pytest.approx([begin, 0.0, -begin, 0.0, begin], abs=1e-8)
    assert motion.q[:, 2] == pytest.approx(height(tilts), abs=1e-10)
    assert not motion.impacts
