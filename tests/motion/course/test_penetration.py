"""No contact is pressed in deeper than can be true, or the motion ends and says so."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import MotionStatus

from ..models import MODELS


def two_boxes(turn, height, **law):
    """A box that falls on a fixed one of the same size."""
    low = ik.Robot.from_urdf(MODELS / "box.urdf")
    top = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
    robot = ik.combine(low=low, top=top)
    place = [0, 0, height, *pin.Quaternion(pin.rpy.rpyToMatrix(*turn)).coeffs()]
    scene = ik.Scene(robot, contacts=[ik.Collision("top/box", "low/box", **law)])
    return scene, robot.configuration({"top/root_joint": place}), robot.velocity()


def depths(motion):
    """(T,) the gap of the contact at the samples [m]."""
    at_rest = np.zeros(motion.scene.robot.nv)
    return np.array([ik.solve(motion.scene, q, at_rest).contacts[0].gap for q in motion.q])


def test_a_box_that_falls_edge_on_edge_does_not_sink_in_unsaid():
    scene, q, v = two_boxes((np.pi / 4, 0.3, 0.8), 0.25, friction=0.5)
    motion = ik.simulate(scene, q, v, duration=0.295, samples=200)
    assert motion.status in (MotionStatus.FINISHED, MotionStatus.PENETRATION)
    assert depths(motion).min() > -1e-5
    assert motion.t[-1] == motion.duration


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
