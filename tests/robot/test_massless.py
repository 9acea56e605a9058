"""Joints that move no mass are known from the structure, at every configuration."""

from __future__ import annotations

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text
from impulsekit.errors import SingularMassError

from ..robots import random_state


def arm(masses, axes, root="freeflyer"):
    """A chain of links of these masses under a base of the first; 0 for a link without mass."""
    parts = [
        link_text(f"link_{k}", mass or None, 1e-2 * mass, at="0.01 0.02 0.1")
        for k, mass in enumerate(masses)
    ]
    for k, axis in enumerate(axes):
        ends, turn = (f"link_{k}", f"link_{k + 1}"), (0.2, 0.3, k)
        parts.append(
            joint_text(f"joint_{k + 1}", "continuous", *ends, axis, at="0.1 0 0.3", turn=turn)
        )
    return ik.Robot.from_urdf(robot_text("arm", *parts), root=root)


def poses(robot, count, seed=0):
    rng = np.random.default_rng(seed)
    return [
        pin.integrate(robot.model, robot.neutral(), rng.normal(size=robot.nv)) for _ in range(count)
    ]


@pytest.mark.parametrize("masses", [(0, 1, 1, 1, 1, 1, 1), (0, 1e-3, 10, 1, 1, 1e-2, 1)])
def test_a_massless_base_that_turns_on_a_joint_is_refused_at_every_pose(masses):
    robot = arm(masses, ["0 0 1", "0 1 0", "0 0 1", "0 1 0", "0 0 1", "0 1 0"])
    assert robot.massless_joints == ("joint_1",)
    scene = ik.Scene(robot, [ik.AppliedImpulse("link_6", linear=[0, 0.5, 1])])
    for q in poses(robot, 20):
        with pytest.raises(SingularMassError, match=r'joint "joint_1".*link "link_0"') as caught:
            ik.solve(scene, q, robot.velocity())
        assert caught.value.joints == ("joint_1",)
    batch = ik.solve_batch(scene, np.array(poses(robot, 4)))
    assert (batch.status == ik.Status.SINGULAR_MASS.code).all()
    with pytest.raises(SingularMassError, match="joint_1"):
        ik.simulate(ik.Scene(robot), robot.neutral(), robot.velocity(), duration=0.1)
    with pytest.raises(SingularMassError, match="joint_1"):
        ik.design.effective_mass(robot, robot.neutral(), "link_6", [0, 0, 1])


@pytest.mark.parametrize("root", ["fixed", "freeflyer"])
def test_grippers_without_mass_are_locked_as_the_error_advises(root):
    """Whatever they move at: a lock on what moves no mass carries what strikes it and no more."""
    robot = ik.Robot.from_example("romeo_laas_small", root=root)
    joints = robot.massless_joints
    assert set(joints) == {"r_gripper_joint", "l_gripper_joint"}
    locks = [ik.JointLock(joint) for joint in joints]
    first = next(link.name for link in robot.links if link.joint_id > 0)
    blow = ik.AppliedImpulse(first, linear=[1, 2, 3])
    push = ik.JointImpulse("l_gripper_joint", 0.25)
    q, v = random_state(robot, 0)
    still = v.copy()
    for joint in joints:
        still[robot.model.joints[robot.joint_id(joint)].idx_v] = 0.0
    for speed in (v, still):
        impact = ik.solve(ik.Scene(robot, [blow, push], locks), q, speed)
        assert impact.is_valid()
        carried = [result.impulse[0] for result in impact.constraints]
        assert carried == [-0.25 if joint == "l_gripper_joint" else 0.0 for joint in joints]
    # Of M Δv = I without these joints.
    masses, kept = impact.mechanics.mass_matrix, np.flatnonzero(impact.mechanics.mass_matrix.any(0))
    struck = impact.impulse_shares["impulses[0]"][kept]
    expected = np.linalg.solve(masses[np.ix_(kept, kept)], struck)
    np.testing.assert_allclose(impact.dv[kept], expected, atol=1e-9 * np.abs(expected).max())


def test_a_point_mass_on_a_hinge_through_it_is_massless_and_off_it_is_not():
    for offset, found in ((0.0, ("hinge",)), (0.1, ())):
        model = pin.Model()
        joint = model.addJoint(0, pin.JointModelRZ(), pin.SE3.Identity(), "hinge")
        point = pin.Inertia(1.0, np.array([offset, 0.0, 0.3]), np.zeros((3, 3)))
        model.appendBodyToJoint(joint, point, pin.SE3.Identity())
        assert ik.Robot.from_model(model).massless_joints == found


def test_an_armature_is_mass_enough():
    robot = arm((1, 1, 0), ["0 0 1", "0 1 0"])
    model = pin.Model(robot.model)
    model.armature[-1] = 0.01
    geared = ik.Robot.from_model(model)
    assert geared.massless_joints == ()
    scene = ik.Scene(geared, [ik.JointImpulse("joint_2", 0.3)])
    impact = ik.solve(scene, geared.neutral(), geared.velocity())
    assert impact.dv[-1] == pytest.approx(30.0)
    batch = ik.solve_batch(scene, geared.neutral(), outputs=("dv",))
    np.testing.assert_allclose(batch.dv[0], impact.dv, atol=1e-12)
