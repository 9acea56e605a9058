"""A ball that is dropped straight onto a box comes to rest, wherever the box is."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ...robots import one_body

FLOOR = """<robot name="f"><link name="f"><collision><origin xyz="0 0 -.5"/>
<geometry><box size="10 10 1"/></geometry></collision></link></robot>"""
PLACES = {
    "at the origin": pin.SE3.Identity(),
    "above it": pin.SE3(np.eye(3), np.array([0.0, 0.0, 3.0])),
    "far away": pin.SE3(np.eye(3), np.array([50.0, -30.0, 20.0])),
    "tilted": pin.SE3(pin.utils.rpyToMatrix(0.7, -0.4, 1.1), np.array([1.0, 2.0, 3.0])),
}


@pytest.mark.slow
@pytest.mark.parametrize("place", PLACES.values(), ids=PLACES)
def test_bounces_of_a_ball_die_down_to_rest(place):
    world = ik.combine(
        b=one_body("b", 1, 0.004, '<sphere radius=".1"/>'),
        f=ik.Robot.from_urdf(FLOOR),
        placements={"f": place},
    )
    start = place.act(np.array([0.0, 0.0, 0.2]))
    q = world.configuration({"b/root_joint": [*start, 0, 0, 0, 1]})
    scene = ik.Scene(
        world,
        contacts=[ik.Collision("b/b", "f/f", restitution=0.5, friction=0.3)],
        gravity=place.rotation @ np.array([0.0, 0.0, -9.81]),
    )
    motion = ik.simulate(scene, q, world.velocity(), duration=0.6, samples=3, max_impacts=60)
    assert motion.status.finished
    assert len(motion.impacts) < 40
    # Each approach is e times the last, down to rest.
    up = place.rotation[:, 2]
    speeds = [-up @ impact.contacts[0].velocity_before for _, impact in motion.impacts]
    np.testing.assert_allclose(speeds[:8], np.sqrt(2 * 9.81 * 0.1) * 0.5 ** np.arange(8), rtol=1e-8)
    end = place.actInv(motion.q[-1][:3])
    np.testing.assert_allclose(end, [0.0, 0.0, 0.1], atol=1e-8)
