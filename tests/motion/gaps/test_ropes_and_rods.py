"""Distances that are kept or bounded: ropes and rods against closed forms and other models."""

from __future__ import annotations

import numpy as np
import pinocchio as pin

import impulsekit as ik

BALL = "models/ball.urdf"
G = 9.81


def ball_at(place, velocity=(0, 0, 0, 0, 0, 0)):
    ball = ik.Robot.from_urdf(BALL, root="freeflyer")
    q = ball.configuration(root_joint=[*place, 0, 0, 0, 1])
    return ball, q, ball.velocity(root_joint=velocity)


def test_a_ball_swings_on_a_taut_rope_as_a_pendulum():
    """The rope rests: the same motion as of a point mass on a revolute joint, and its pull."""
    length, speed = 0.8, 1.3
    ball, q, v = ball_at([0, 0, -length], (speed, 0, 0, 0, 0, 0))
    rope = ik.Rope("ball", length=length, name="rope")
    motion = ik.simulate(ik.Scene(ball, contacts=[rope]), q, v, duration=1.0)
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
    pull = motion.contacts["rope"].force(0.5)
    angle, rate = swing.at(0.5)[0][0], swing.at(0.5)[1][0]
    expected = mass * (G * np.cos(angle) + length * rate**2)
    np.testing.assert_allclose(np.linalg.norm(pull), expected, rtol=1e-8)


def two_rods():
    """A double pendulum whose last joint is replaced by a rod: two balls on a chain of rods."""
    ball = ik.Robot.from_urdf(BALL, root="freeflyer")
    return ik.combine(a=ball, b=ball)


def test_rods_move_as_a_double_pendulum():
    robot, l1, l2 = two_rods(), 0.5, 0.7
    scene = ik.Scene(
        robot,
        constraints=[
            ik.DistanceAnchor("a/ball", name="upper"),
            ik.DistanceAnchor("b/ball", "a/ball"),
        ],
    )
    angles, rates = np.array([0.4, 1.1]), np.array([0.3, -0.8])

    def place(angles):
        one = l1 * np.array([np.sin(angles[0]), 0, -np.cos(angles[0])])
        return one, one + l2 * np.array([np.sin(angles[1]), 0, -np.cos(angles[1])])

    h = 1e-6
    speeds = [
        (p - m) / (2 * h)
        for p, m in zip(place(angles + h * rates), place(angles - h * rates), strict=True)
    ]
    one, two = place(angles)
    q = robot.configuration(
        **{"a/root_joint": [*one, 0, 0, 0, 1], "b/root_joint": [*two, 0, 0, 0, 1]}
    )
    v = robot.velocity(
        **{"a/root_joint": [*speeds[0], 0, 0, 0], "b/root_joint": [*speeds[1], 0, 0, 0]}
    )
    motion = ik.simulate(scene, q, v, duration=1.0)
    assert motion.status is ik.MotionStatus.FINISHED
    right = double_pendulum(angles, rates, l1, l2, 1.0)
    found = motion.q[-1]
    one, two = place(right)
    np.testing.assert_allclose(found[:3], one, atol=2e-8)
    np.testing.assert_allclose(found[7:10], two, atol=2e-8)


def double_pendulum(angles, rates, l1, l2, duration):
    """Lagrange's equations of two equal point masses, written by hand, to 1e-12."""
    from scipy.integrate import solve_ivp

    def slope(t, y):
        a, b, p, r = y
        c, s = np.cos(a - b), np.sin(a - b)
        mass = np.array([[2 * l1, l2 * c], [l1 * c, l2]])
        force = np.array([-l2 * r * r * s - 2 * G * np.sin(a), l1 * p * p * s - G * np.sin(b)])
        return [p, r, *np.linalg.solve(mass, force)]

    found = solve_ivp(slope, (0, duration), [*angles, *rates], "DOP853", rtol=1e-12, atol=1e-13)
    return found.y[:2, -1]
