"""Distances that are kept or bounded: ropes and rods against closed forms and other models."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

BALL = "models/ball.urdf"
G = 9.81


def ball_at(place, velocity=(0, 0, 0, 0, 0, 0)):
    ball = ik.Robot.from_urdf(BALL, root="freeflyer")
    q = ball.configuration(root_joint=[*place, 0, 0, 0, 1])
    return ball, q, ball.velocity(root_joint=velocity)


@pytest.mark.parametrize("kind", ["contacts", "constraints"])
def test_a_ball_swings_on_a_taut_rope_or_a_rod_as_a_pendulum(kind):
    """The rope rests: the same motion as of a point mass on a revolute joint, and its pull."""
    length, speed = 0.8, 1.3
    ball, q, v = ball_at([0, 0, -length], (speed, 0, 0, 0, 0, 0))
    rope, rod = ik.Rope("ball", length=length, name="it"), ik.DistanceAnchor("ball", name="it")
    entries = {"contacts": [rope], "constraints": [rod]}
    motion = ik.simulate(ik.Scene(ball, **{kind: entries[kind]}), q, v, duration=1.0)
    assert motion.status is ik.MotionStatus.FINISHED and len(motion.impacts) <= 1
    model = pin.Model()
    joint = model.addJoint(0, pin.JointModelRY(), pin.SE3.Identity(), "hinge")
    mass = ball.model.inertias[1].mass
    body = pin.Inertia(mass, np.array([0, 0, -length]), np.zeros((3, 3)))
    model.appendBodyToJoint(joint, body, pin.SE3.Identity())
    hinge = ik.Robot.from_model(model)
    swing = ik.simulate(
        ik.Scene(hinge), hinge.neutral(), np.array([-speed / length]), duration=1.0, rtol=1e-12
    )
    angles = swing.q[:, 0]
    right = length * np.stack([-np.sin(angles), 0 * angles, -np.cos(angles)], axis=1)
    np.testing.assert_allclose(motion.q[:, :3], right, atol=2e-9)
    pull = getattr(motion, kind)["it"].force(0.5)
    angle, rate = swing.at(0.5)[0][0], swing.at(0.5)[1][0]
    expected = mass * (G * np.cos(angle) + length * rate**2)
    np.testing.assert_allclose(np.linalg.norm(pull), expected, rtol=1e-8)
