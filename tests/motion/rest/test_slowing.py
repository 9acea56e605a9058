"""Steps end soon after slip stops, so that rounding does not grow where slip all but vanishes."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.motion.rest.slowing import FURTHER, until_stopping

MU, G, HALF, SPEED = 0.3, 9.81, 0.1, 1.0
BLOCK = f"""<robot name="block"><link name="block"><inertial><mass value="1"/>
<inertia ixx="{HALF**2 / 1.5}" iyy="{HALF**2 / 1.5}" izz="{HALF**2 / 1.5}"
ixy="0" ixz="0" iyz="0"/></inertial></link></robot>"""


@pytest.mark.parametrize("rtol", [1e-4, 1e-6, 1e-8, 1e-10, 1e-12])
def test_a_block_slides_straight_on_whatever_its_direction(tmp_path, rtol):
    # Four corners share the load in many ways; each turns the block by rounding.
    path = tmp_path / "block.urdf"
    path.write_text(BLOCK)
    block = ik.Robot.from_urdf(path, root="freeflyer")
    corners = [
        ik.Contact("block", at=[x, y, -HALF], friction=MU)
        for x in (-HALF, HALF)
        for y in (-HALF, HALF)
    ]
    scene = ik.Scene(block, contacts=corners, gravity=[0, 0, -G])
    way = SPEED**2 / (2.0 * MU * G)
    for angle in np.random.default_rng(0).uniform(0.0, 2.0 * np.pi, 8):
        c, s = np.cos(angle), np.sin(angle)
        q = block.configuration(
            root_joint=[2, -3, HALF, 0, 0, np.sin(angle / 2), np.cos(angle / 2)]
        )
        v = block.velocity(root_joint=[SPEED * c, -SPEED * s, 0, 0, 0, 0])
        motion = ik.simulate(scene, q, v, 0.5, rtol=rtol, atol=1e-2 * rtol, samples=2)
        # Along x of the world, as far as friction lets it, and turned by nothing.
        assert np.abs(motion.q[-1, :3] - [2.0 + way, -3.0, HALF]).max() < 1e-12
        assert np.abs(motion.q[-1, 3:] - q[3:]).max() < 1e-12


def test_the_slip_that_stops_first_bounds_the_step():
    slip = np.array([0.5, 0.0, 0.0, 0.0, 1.0, 0.0])
    accelerations = np.array([-2.0, 7.0, 3.0, 0.0, -5.0, 0.0])
    slides = np.array([[1.0, 0.0, 1.0], [0.0, 1.0, 1.0]])
    first = until_stopping(slip, accelerations, slides)
    assert first == pytest.approx(0.2 * (1.0 + FURTHER), rel=1e-15)
    slides[1, 2] = 0.0
    assert until_stopping(slip, accelerations, slides) == pytest.approx(0.25 * (1.0 + FURTHER))


def test_what_does_not_slow_down_bounds_nothing():
    slip, slides = np.array([0.5, 0.0, 0.0]), np.array([[1.0, 0.0, 1.0]])
    assert until_stopping(slip, np.array([2.0, -1.0, 0.0]), slides) == np.inf
    assert until_stopping(np.zeros(3), np.array([-2.0, 0.0, 0.0]), slides) == np.inf
    # Slip of points that rested before says nothing of those that do now.
    assert until_stopping(slip, np.array([-2.0, 0.0, 0.0]), np.vstack([slides, slides])) == np.inf
