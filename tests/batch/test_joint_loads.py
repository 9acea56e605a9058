"""Joint reactions and link velocities of many states at once."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.reference.whittaker import struck_chain


def states(robot, count, seed=0):
    rng = np.random.default_rng(seed)
    q = np.array(
        [pin.integrate(robot.model, robot.neutral(), rng.normal(size=robot.nv))
         for _ in range(count)]
    )  # fmt: skip
    return q, rng.normal(size=(count, robot.nv))


def test_blows_that_vary_row_by_row():
    robot = ik.Robot.from_example("panda")
    scene = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", linear=[0, 0, 1])])
    blows = np.random.default_rng(1).normal(size=(5, 6))
    batch = ik.solve_batch(scene, robot.neutral(), impulses=blows, outputs=("reactions",))
    for blow, told in zip(blows, batch.reactions, strict=True):
        own = ik.Scene(robot, [ik.AppliedImpulse("panda_hand", blow[:3], blow[3:])])
        impact = ik.solve(own, robot.neutral(), robot.velocity())
        expected = [impact.reactions[name] for name in robot.joint_names]
        np.testing.assert_allclose(told, expected, atol=1e-11 * np.abs(expected).max())


def test_whittakers_pins_carry_what_the_fractions_say():
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(10), root="planar")
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_10", [0, 5, 0], at=[1, 0, 0])])
    batch = ik.solve_batch(scene, np.array([robot.neutral()] * 3), outputs=("reactions",))
    exact = [float(s) for s in struck_chain(10, impulse=5).pin_impulses]
    pins = np.abs(batch.reactions[0, 1:, 1])
    # The first is the blow itself; nine pins follow.
    np.testing.assert_allclose(pins[::-1], np.abs(exact[1:10]), atol=1e-12)


def test_moments_against_rolling_and_spin_are_borne_by_joints():
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(3))
    tip = ik.Contact("link_3", at=[0, 0, -1], normal=[1, 0.2, 0.3], friction=0.4, rolling=0.2)
    scene = ik.Scene(arm, contacts=[tip], gap_bound=99)
    q, v = states(arm, 4)
    batch = ik.solve_batch(scene, q, v, outputs=("reactions",))
    turned = 0.0
    for row in range(4):
        one = ik.solve(scene, q[row], v[row])
        turned = max(turned, float(np.abs(one.contacts[0].angular_impulse).max()))
        own = np.array([one.reactions[name] for name in arm.joint_names])
        assert batch.reactions[row] == pytest.approx(own, abs=1e-12)
    assert turned > 0.1


def test_a_robot_without_links_has_no_bodies_to_tell():
    model = pin.Model()
    kind = pin.JointModelUniversal(np.array((1.0, 0.0, 0.0)), np.array((0.0, 1.0, 0.0)))
    joint = model.addJoint(0, kind, pin.SE3.Identity(), "cross")
    model.appendBodyToJoint(joint, pin.Inertia.Random(), pin.SE3.Identity())
    placement = pin.SE3(np.eye(3), np.array((0.0, 0.0, 1.0)))
    model.addFrame(pin.Frame("tip", joint, 0, placement, pin.FrameType.OP_FRAME))
    robot = ik.Robot.from_model(model)
    scene = ik.Scene(robot, contacts=[ik.Contact("tip", normal=[1, 0, 0])], gap_bound=np.inf)
    v = np.array([[1.0, -1.0]] * 2)
    batch = ik.solve_batch(scene, robot.neutral(), v, outputs=("bodies",))
    assert batch.bodies.shape == (2, 0, 6)
