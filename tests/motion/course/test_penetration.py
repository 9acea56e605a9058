"""No contact is pressed in deeper than can be true, or the motion ends and says so."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import MotionStatus
from impulsekit.motion import run
from impulsekit.motion.course.penetration import Penetration
from impulsekit.motion.course.present import Present, Stopped
from impulsekit.scene.motion import MotionSettings

from ..models import MODELS, sliders


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
    now = Present(motion.scene, motion.q[0], motion.v[0], MotionSettings())
    return np.array(
        [now.gaps.everything(q, v)[0].min() for q, v in zip(motion.q, motion.v, strict=True)]
    )


def test_a_box_that_falls_edge_on_edge_does_not_sink_in_unsaid():
    scene, q, v = two_boxes((np.pi / 4, 0.3, 0.8), 0.25, friction=0.5)
    motion = ik.simulate(scene, q, v, duration=0.295, samples=200)
    assert motion.status in (MotionStatus.FINISHED, MotionStatus.PENETRATION)
    assert depths(motion).min() > -1e-5
    assert motion.t[-1] == motion.duration


def test_a_step_that_presses_a_contact_in_is_not_kept(monkeypatch):
    def sink(now):
        now.q = now.q - 1e-3 * (now.t > 0.5)
        return True

    monkeypatch.setattr(run, "keep_up", sink)
    scene = ik.Scene(sliders(1), contacts=[ik.Contact("b00")])
    motion = ik.simulate(scene, [0.0], [0.0], duration=1.0, method="rk4", step=0.01)
    assert motion.status is MotionStatus.PENETRATION
    assert not motion.status.finished
    assert "contacts[0]" in motion.detail
    assert "0.001" in motion.detail
    assert motion.duration == pytest.approx(0.5, abs=0.011)
    np.testing.assert_array_equal(motion.q, 0.0)
    assert [rest.start for rest in motion.rests] == [0.0]


@pytest.mark.parametrize(("depth", "too_deep"), [(-0.9e-5, False), (-1.1e-5, True)])
def test_bodies_may_overlap_by_little(depth, too_deep):
    scene, q, v = two_boxes((0, 0, 0.8), 0.1, friction=0.5)
    now = Present(scene, q, v, MotionSettings())
    watch = Penetration(now)
    now.q = q + np.array([0, 0, depth, 0, 0, 0, 0])
    if not too_deep:
        watch.refuse()
        return
    with pytest.raises(Stopped) as caught:
        watch.refuse()
    assert caught.value.status is MotionStatus.PENETRATION


def test_what_overlaps_at_the_start_may_go_on_to():
    scene, q, v = two_boxes((0, 0, 0.8), 0.0995, friction=0.5)
    Penetration(Present(scene, q, v, MotionSettings())).refuse()


@pytest.mark.parametrize(("floor", "told"), [("plane", False), ("box", True)])
def test_a_storm_of_impacts_names_a_distance_that_is_not_told_to_rounding(floor, told):
    robot = ik.Robot.from_mjcf(
        f"""<mujoco><worldbody><geom name="floor" type="{floor}" size="2 2 1"/>
        <body name="egg" pos="0 0 2"><freejoint name="free"/>
        <geom name="shell" type="ellipsoid" size="0.2 0.12 0.08" mass="3"/></body>
        </worldbody></mujoco>"""
    )
    scene = ik.Scene(robot, contacts=[ik.Collision("shell", "floor", restitution=0.5, name="egg")])
    q = robot.configuration(free=[0, 0, 1.2, 0, 0, 0, 1] if told else [0, 0, 0.2, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, robot.velocity(), duration=1.0, max_impacts=2)
    assert motion.status is MotionStatus.EVENT_STORM
    assert motion.detail.startswith("max_impacts is 2")
    assert ("the distance of egg is found by iteration" in motion.detail) == told
