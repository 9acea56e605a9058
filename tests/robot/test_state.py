"""Configurations and velocities by joint name."""

from __future__ import annotations

import fractions
import math
import warnings

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.robot.state import checked_velocity


@pytest.fixture(scope="module")
def robot() -> ik.Robot:
    """A free-flyer with a revolute, a continuous and a spherical joint."""
    model = pin.Model()
    body = pin.Inertia(1.0, np.zeros(3), np.eye(3))
    joints = (
        ("base", pin.JointModelFreeFlyer()),
        ("hinge", pin.JointModelRZ()),
        ("wheel", pin.JointModelRUBY()),
        ("ball", pin.JointModelSpherical()),
    )
    for parent, (name, joint) in enumerate(joints):
        model.addJoint(parent, joint, pin.SE3.Identity(), name)
        model.appendBodyToJoint(parent + 1, body, pin.SE3.Identity())
    return ik.Robot.from_model(model)


def test_joints_not_named_are_neutral(robot):
    assert np.array_equal(robot.configuration(), pin.neutral(robot.model))
    assert not robot.velocity().any()


def test_each_kind_of_joint_takes_its_own_numbers(robot):
    q = robot.configuration(
        base=[1, 2, 3, 0, 0, 0, 1], hinge=0.3, wheel=0.4, ball=[0, 0, math.sin(0.1), math.cos(0.1)]
    )
    np.testing.assert_array_equal(q[:3], [1, 2, 3])
    assert q[7] == 0.3
    np.testing.assert_allclose(q[8:10], [math.cos(0.4), math.sin(0.4)])
    v = robot.velocity(base=[1, 2, 3, 4, 5, 6], wheel=-1.0, ball=[7, 8, 9])
    np.testing.assert_array_equal(v, [1, 2, 3, 4, 5, 6, 0, -1, 7, 8, 9])


def test_a_continuous_joint_takes_cosine_and_sine_too(robot):
    assert np.array_equal(
        robot.configuration(wheel=[0.6, 0.8]), robot.configuration(wheel=math.atan2(0.8, 0.6))
    )


def test_a_planar_root_takes_an_angle():
    robot = ik.Robot.from_urdf(ik.models.chain_urdf(2), root="planar")
    q = robot.configuration(root_joint=[1, 2, math.pi / 6])
    np.testing.assert_allclose(q[:4], [1, 2, math.sqrt(0.75), 0.5])


def test_names_that_are_no_identifiers_go_in_a_mapping():
    arm = ik.Robot.from_example("panda")
    both = ik.combine(left=arm, right=arm)
    q = both.configuration({"right/panda_joint1": 0.5})
    assert q[9] == 0.5


def test_an_angle_without_limits_that_reads_like_degrees_is_told():
    """Wheels turn many times: only whole multiples of 15 up to 360 are doubted."""
    arm = ik.Robot.from_example("kinova")
    with pytest.warns(ik.errors.SetupWarning, match=r"14\.3 turns; degrees\? 90° is 1\.5708 rad"):
        arm.configuration(j2s6s200_joint_1=90)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for angle in (0.0, 3.0, -6.2, 14.0, 523.6, 720.0, np.radians(90), [0.0, 1.0]):
            arm.configuration(j2s6s200_joint_1=angle)


def test_what_holds_real_numbers_is_taken_whatever_holds_it(robot):
    v = np.arange(float(robot.nv))
    for same in (
        v.tolist(),
        tuple(v),
        v.astype(int),
        v.astype(np.float32),
        v.astype(">f8"),
        v.astype(object),
        [fractions.Fraction(x) for x in range(robot.nv)],
        np.ma.masked_array(v),
        np.ma.masked_array(v, mask=v < 0),
    ):
        assert np.array_equal(checked_velocity(robot.model, same), v)


def test_what_is_given_is_copied(robot):
    given = np.zeros(robot.nv)
    checked_velocity(robot.model, given)[0] = 1.0
    checked_velocity(robot.model, np.ma.masked_array(given, copy=False))[0] = 1.0
    assert not given.any()
