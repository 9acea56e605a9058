"""Sensitivities of motions without gravity, where flights last to within rounding of their end."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik


def point_on_slider():
    """A point of 1 kg that moves along z alone."""
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelPZ(), pin.SE3.Identity(), "z")
    inertia = pin.Inertia(1.0, np.zeros(3), 0.1 * np.eye(3))
    model.appendBodyToJoint(joint, inertia, pin.SE3.Identity())
    model.addFrame(pin.Frame("point", joint, 0, pin.SE3.Identity(), pin.FrameType.BODY))
    return ik.Robot.from_model(model)


@pytest.mark.parametrize("duration", [1.0, 2.0])
def test_a_point_thrown_at_a_wall_has_the_closed_form(duration):
    # x⁺ = −e (x⁻ + v t), v⁺ = −e v: [[−e, −e T], [0, −e]].
    floor = ik.Contact("point", normal=[0, 0, 1], restitution=1.0)
    scene = ik.Scene(point_on_slider(), contacts=[floor], gravity=[0, 0, 0])
    for height in np.linspace(0.3, 1.5, 30) * 0.6 * duration:
        found = ik.sensitivity(ik.simulate(scene, [height], [-1.0], duration=duration))
        assert found.exists
        np.testing.assert_allclose(found.matrix, [[-1.0, -duration], [0.0, -1.0]], atol=1e-9)


@pytest.mark.parametrize("gap", [0.21, 0.47, 0.83])
def test_two_equal_balls_change_places(gap):
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    pair = ik.combine(left=ball, right=ball)
    strike = ik.Collision("right/ball", "left/ball", restitution=1.0)
    scene = ik.Scene(pair, contacts=[strike], gravity=[0, 0, 0])
    q, v = pair.neutral(), np.zeros(12)
    at = {n: pair.model.joints[pair.joint_id(f"{n}/root_joint")] for n in ("left", "right")}
    q[at["right"].idx_q] = 1.0 + gap
    v[at["left"].idx_v] = 3.0
    found = ik.sensitivity(ik.simulate(scene, q, v, duration=1.0))
    assert found.exists and len(found.saltations) == 1
    along = [at["left"].idx_v, at["right"].idx_v]
    speeds = [12 + i for i in along]
    # The distance along their line, and velocities, are exchanged.
    np.testing.assert_allclose(found.matrix[np.ix_(speeds, speeds)], [[0, 1], [1, 0]], atol=1e-7)
    np.testing.assert_allclose(found.matrix[np.ix_(along, along)], [[0, 1], [1, 0]], atol=1e-7)


@pytest.mark.parametrize("height", [0.55, 0.76, 0.9])
def test_a_robot_thrown_without_gravity_has_finite_derivatives(height):
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    foot = ik.Contact("FL_FOOT", normal=[0, 0, 1], restitution=0.5, friction=0.4)
    scene = ik.Scene(solo, contacts=[foot], gravity=[0, 0, 0])
    q, v = solo.neutral(), solo.velocity()
    q[2], v[2] = height, -1.0
    motion = ik.simulate(scene, q, v, duration=1.0)
    found = ik.sensitivity(motion)
    assert found.exists and np.isfinite(found.matrix).all()
