"""An ellipsoid over a half-space: its lowest point, wherever both are."""

from __future__ import annotations

import coal
import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import quad

import impulsekit as ik
from impulsekit.geometry.collision import gap_and_normal, is_exact, meeting_points, solid_of

EGG = """<mujoco><worldbody><geom name="floor" type="plane" size="0 0 1"/>
<body name="egg"><freejoint name="free"/>
<geom name="shell" type="ellipsoid" size="0.2 0.12 0.08" mass="3"/></body></worldbody></mujoco>"""


def surface(radii, place, count=400):
    """(count², 3) points of an ellipsoid's surface."""
    polar, around = np.meshgrid(np.linspace(0, np.pi, count), np.linspace(0, 2 * np.pi, count))
    unit = [np.sin(polar) * np.cos(around), np.sin(polar) * np.sin(around), np.cos(polar)]
    own = radii * np.stack(unit, axis=-1).reshape(-1, 3)
    return own @ place.rotation.T + place.translation


@pytest.mark.parametrize("far", [0.0, 1e6])
def test_the_lowest_point_of_its_surface_is_found(far):
    rng = np.random.default_rng(3)
    ground, height = np.array([0.6, 0.0, 0.8]), 0.1
    for _ in range(5):
        radii = rng.uniform(0.05, 0.4, 3)
        place = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
        heights = surface(radii, place) @ ground - height
        world = pin.SE3(pin.exp3(rng.normal(size=3)), far * rng.normal(size=3))
        egg, floor = solid_of(coal.Ellipsoid(*radii)), solid_of(coal.Halfspace(ground, height))
        assert is_exact(egg, floor) and is_exact(floor, egg)
        gap, normal = gap_and_normal(egg, world * place, floor, world)
        # Of the sampled points the lowest is a little higher; far away places are rounded.
        assert -1e-9 - 1e-15 * far < heights.min() - gap < 1e-4 + 1e-9 * far
        assert normal == pytest.approx(world.rotation @ ground, abs=1e-14)
        (point,) = meeting_points([(egg, world * place)], [(floor, world)], margin=gap + 1e-3)
        on_it = world.actInv(point.position + 0.5 * gap * normal)
        assert on_it @ ground - height == pytest.approx(gap, abs=1e-13 + 1e-15 * far)
        inside = (place.actInv(on_it) / radii) @ (place.actInv(on_it) / radii)
        assert inside == pytest.approx(1.0, abs=1e-12 + 1e-14 * far)
        assert not [*meeting_points([(egg, world * place)], [(floor, world)], margin=gap - 1e-3)]
        again = gap_and_normal(floor, world, egg, world * place)
        assert again[0] == gap
        assert (again[1] == -normal).all()


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
