"""Round bodies on faces: their tips are followed, and where another comes down is an impact."""

import numpy as np
import pytest
from scipy.integrate import quad

import impulsekit as ik

from ...robots import one_body
from ..models import GRAVITY

RADIUS, LENGTH = 0.1, 0.5
ACROSS, ALONG = 2.0 * (3 * RADIUS**2 + LENGTH**2) / 12, 2.0 * RADIUS**2 / 2
CYLINDER = f'<cylinder radius="{RADIUS}" length="{LENGTH}"/>'


def body(name, shape):
    return one_body(name, 2, (ACROSS, ACROSS, ALONG), shape)


def height(tilt):
    """Of the middle of a cylinder whose lower rim is on the floor [m]."""
    return LENGTH / 2 * np.sin(tilt) + RADIUS * np.cos(tilt)


def rate(tilt, begin):
    """How fast a cylinder falls over on a floor without friction, by its energy [rad/s]."""
    slope = LENGTH / 2 * np.cos(tilt) - RADIUS * np.sin(tilt)
    fallen = 2.0 * GRAVITY * (height(begin) - height(tilt))
    return np.sqrt(2.0 * fallen / (2.0 * slope**2 + ACROSS))


@pytest.mark.parametrize("e", [0.0, 0.5])
def test_the_other_end_of_a_cylinder_that_falls_over_is_an_impact(e):
    begin, world = 0.6, body("b", CYLINDER).with_ground()
    scene = ik.Scene(world, contacts=[ik.Collision("b", "ground", restitution=e)])
    # Its axis lies along z before it is turned about y.
    q = np.r_[0, 0, height(begin), np.sin(0.25 * np.pi - begin / 2) * np.eye(3)[1], 0]
    q[6] = np.cos(0.25 * np.pi - begin / 2)
    # θ̇ ~ √(begin − θ): with θ = begin − s² nothing is singular.
    time, _ = quad(lambda s: 2.0 * s / rate(begin - s * s, begin), 1e-9, np.sqrt(begin))
    motion = ik.simulate(
        scene, q, np.zeros(6), duration=time + 1e-5, max_steps=1000, accuracy="high"
    )
    assert motion.status.finished
    met = [(t, impact) for t, impact in motion.impacts if t > 0.5 * time]
    assert met[0][0] == pytest.approx(time, abs=1e-8)
    # The end that comes down is as fast as a cylinder that turns about its other rim is long.
    impact = met[0][1]
    end, speed = [0, 0, LENGTH / 2], LENGTH * rate(0.0, begin)
    other = [0, 0, -LENGTH / 2]
    ends = [impact.velocity_at("b", at).before[2] for at in (end, other)]
    assert sorted(ends) == pytest.approx([-speed, 0.0], abs=1e-4)
    after = [impact.velocity_at("b", at).after[2] for at in (end, other)]
    assert max(after) == pytest.approx(e * speed, abs=1e-4)
    assert min(after) > -1e-6
