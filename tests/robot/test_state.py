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


TALOS = ik.Robot.from_example("talos", root="freeflyer").with_ground()
TURN = pin.rpy.rpyToMatrix(0.3, -0.4, 2.0)
W, X, Y, Z = (pin.Quaternion(TURN).coeffs()[i] for i in (3, 0, 1, 2))
FORMS = {
    "rpy": [0.3, -0.4, 2.0],
    "rotation_vector": pin.log3(TURN),
    "wxyz": [W, X, Y, Z],
    "xyzw": [2 * X, 2 * Y, 2 * Z, 2 * W],
    "rotation": TURN,
}


@pytest.mark.parametrize("form", FORMS)
def test_a_pose_takes_a_rotation_in_any_form(form):
    q = TALOS.configuration(root_joint=ik.pose([1, 2, 3], **{form: FORMS[form]}))
    place = TALOS.placement(q, "base_link").se3
    assert place.isApprox(pin.SE3(TURN, np.array([1.0, 2.0, 3.0])), 1e-14)


def test_a_planar_root_takes_a_pose_in_its_plane(robot):
    planar = ik.Robot.from_urdf(ik.models.chain_urdf(2), root="planar")
    q = planar.configuration(root_joint=ik.pose([1, 2, 0], rpy=[0, 0, 0.5]))
    np.testing.assert_allclose(q, planar.configuration(root_joint=[1, 2, 0.5]), atol=1e-15)
    with pytest.raises(ik.errors.RangeError, match="out of its plane must be within"):
        planar.configuration(root_joint=ik.pose([1, 2, 0.1]))
    with pytest.raises(ik.errors.InputError, match="takes numbers; free-flyers and planar"):
        robot.configuration(hinge=ik.pose())


def test_a_free_flyer_takes_its_velocity_in_world_axes():
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    two = ik.combine(a=ball, b=ball, placements={"b": pin.SE3(TURN.T, np.ones(3))})
    pose = ik.pose([0, 0, 1], rpy=[0.1, 0.2, 0.3])
    q = two.configuration({"a/root_joint": pose, "b/root_joint": pose})
    for name in ("a", "b"):
        v = two.velocity({f"{name}/root_world": [1, 2, 3, 4, 5, 6]}, q=q)
        found = two.velocity_of(q, v, f"{name}/ball")
        np.testing.assert_allclose(found.linear, [1, 2, 3], atol=1e-14)
        np.testing.assert_allclose(found.angular, [4, 5, 6], atol=1e-14)
    with pytest.raises(ik.errors.InputError, match="root_world needs q="):
        ball.velocity(root_world=[0, 0, -1, 0, 0, 0])
    with pytest.raises(ik.errors.UnknownNameError, match='unknown joint "c/root_joint"'):
        two.velocity({"c/root_world": [0, 0, -1, 0, 0, 0]}, q=q)


@pytest.mark.parametrize("height", [0.0, 1.3])
def test_a_robot_stands_on_its_ground(height):
    normal = np.array([0.1, -0.2, 1.0]) / np.linalg.norm([0.1, -0.2, 1.0])
    box = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
    world = ik.combine(a=box, b=box, placements={"a": pin.SE3(TURN, np.ones(3))})
    world = world.with_ground(height, normal=normal)
    on_ground = ik.Scene(world, contacts=[ik.Collision("b/box", "ground")])
    turned = world.configuration({"b/root_joint": ik.pose([1, 2, 3], rpy=[0.3, 0.2, 0.1])})
    below = world.configuration({"b/root_joint": ik.pose([0, 0, -9])})
    for start in (turned, below):
        q = world.stand(start, "b/root_joint")
        assert np.array_equal(np.r_[q[:7], q[10:]], np.r_[start[:7], start[10:]])
        moved = q[7:10] - start[7:10]
        assert np.abs(np.cross(moved, normal)).max() < 1e-14
        assert (
            abs(ik.touching(on_ground, q, world.velocity()).contacts[0].gap) < 1e-10
        )  # coal inflates a box by that


def test_talos_stands_and_lands_flat_as_on_eight_points():
    q = TALOS.stand(TALOS.neutral())
    v = TALOS.velocity(root_world=[0, 0, -1, 0, 0, 0], q=q)
    feet = [f"leg_{side}_6_link" for side in ("left", "right")]
    flat = [ik.Collision(foot, "ground", friction=0.7) for foot in feet]
    points = [
        ik.Contact(foot, at=[x, y, -0.107], friction=0.7)
        for foot in feet for x in (-0.1, 0.1) for y in (-0.06, 0.06)
    ]  # fmt: skip
    soles, corners = (ik.solve(ik.Scene(TALOS, contacts=own), q, v) for own in (flat, points))
    sums = [sum(contact.impulse for contact in impact.contacts) for impact in (soles, corners)]
    assert soles.is_valid() and sums[1][2] > 80.0
    np.testing.assert_allclose(sums[0], sums[1], atol=0.02 * sums[1][2])
