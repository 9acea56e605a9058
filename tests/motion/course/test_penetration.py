"""No contact is pressed in deeper than can be true, or the motion ends and says so."""

import pytest

import impulsekit as ik
from impulsekit import MotionStatus


@pytest.mark.parametrize("floor", ["plane", "box"])
def test_an_egg_that_bounces_too_often_ends_with_a_status(floor):
    robot = ik.Robot.from_mjcf(
        f"""<mujoco><worldbody><geom name="floor" type="{floor}" size="2 2 1"/>
        <body name="egg" pos="0 0 2"><freejoint name="free"/>
        <geom name="shell" type="ellipsoid" size="0.2 0.12 0.08" mass="3"/></body>
        </worldbody></mujoco>"""
    )
    scene = ik.Scene(robot, contacts=[ik.Collision("shell", "floor", restitution=0.5, name="egg")])
    q = robot.configuration(free=[0, 0, 0.2 if floor == "plane" else 1.2, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, robot.velocity(), duration=1.0, max_impacts=2)
    assert motion.status is MotionStatus.EVENT_STORM
    assert motion.detail.startswith("max_impacts is 2")
