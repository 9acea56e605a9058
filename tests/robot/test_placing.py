"""Placements, velocities and placing, against closed forms and finite differences."""

import math

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import RangeError
from tests.close import close

SPHERE = "<inertial><mass value='1'/><inertia ixx='1' iyy='1' izz='1' ixy='0' ixz='0' iyz='0'/>"
BALL = f"<robot name='b'><link name='ball'>{SPHERE}</inertial></link></robot>"


def test_a_tip_of_two_links_is_where_trigonometry_puts_it():
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(2))
    a, b = 0.4, -1.1
    q = arm.configuration(joint_1=a, joint_2=b)
    # Rods of 1 m hang down along -z and turn about y.
    tip = arm.placement(q, "link_2").point([0, 0, -1])
    close(tip, [-math.sin(a) - math.sin(a + b), 0, -math.cos(a) - math.cos(a + b)], 1e-15)
    assert arm.placement(q, "world").matrix.tolist() == np.eye(4).tolist()


@pytest.mark.parametrize(("name", "root"), [("panda", "fixed"), ("solo12", "freeflyer")])
def test_velocities_are_rates_of_places(name, root):
    robot = ik.Robot.from_example(name, root=root)
    rng = np.random.default_rng(3)
    model = robot.model
    q = pin.integrate(model, robot.neutral(), rng.normal(size=robot.nv))
    v = rng.normal(size=robot.nv)
    h = 1e-6
    before, after = (pin.integrate(model, q, sign * h * v) for sign in (-1, 1))
    for frame in robot.frame_names[::5]:
        at = rng.normal(size=3)
        found = robot.velocity_of(q, v, frame, at=at)
        ends = [robot.placement(each, frame) for each in (before, after)]
        close(found.linear, (ends[1].point(at) - ends[0].point(at)) / (2 * h), 1e-7)
        turn = ends[1].rotation @ ends[0].rotation.T
        close(found.angular, pin.log3(turn) / (2 * h), 1e-7)


def arm_and_ball(root="freeflyer", **ball):
    # The root of the part that is placed has axes of its own.
    turned = pin.SE3(pin.rpy.rpyToMatrix(0.0, 0.0, 0.7), np.zeros(3)).homogeneous
    parts = {"arm": ik.Robot.from_example("ur5"), "ball": ik.Robot.from_urdf(BALL, root=root)}
    return ik.combine(parts, placements={"ball": turned}, **ball)


def random_pose(robot, seed):
    rng = np.random.default_rng(seed)
    return pin.integrate(robot.model, robot.neutral(), rng.normal(size=robot.nv))


@pytest.mark.parametrize("seed", range(4))
def test_a_ball_lies_in_the_gripper(seed):
    robot = arm_and_ball()
    q = random_pose(robot, seed)
    at, point = [0.01, -0.02, 0.1], [0.3, 0.1, 0.2]
    placed = ik.place(robot, q, "ball/ball", at_frame="arm/tool0", at=at, point=point)
    hand, ball = (robot.placement(placed, frame) for frame in ("arm/tool0", "ball/ball"))
    close(ball.point(point), hand.point(at), 1e-15)
    close(ball.rotation, robot.placement(q, "ball/ball").rotation, 0.0)
    # Nothing else moves.
    close(placed[:6], q[:6], 0.0)


@pytest.mark.parametrize("seed", range(4))
def test_it_is_turned_as_asked(seed):
    robot = arm_and_ball()
    q = random_pose(robot, seed)
    turn = pin.exp3(np.array([0.3, -2.0, 1.0]))
    ways = (turn, pin.Quaternion(turn).coeffs())
    for way in ways:
        placed = ik.place(robot, q, "ball/ball", at_frame="arm/tool0", at=[0, 0, 1], rotation=way)
        hand, ball = (robot.placement(placed, frame) for frame in ("arm/tool0", "ball/ball"))
        close(hand.rotation.T @ ball.rotation, turn, 1e-14)
        close(ball.position, hand.point([0, 0, 1]), 1e-14)


def test_a_planar_part_stays_in_its_plane():
    car = ik.Robot.from_urdf(BALL, root="planar")
    robot = ik.combine(one=car, two=car)
    q = robot.configuration({"one/root_joint": [1.0, 2.0, 0.5], "two/root_joint": [0, 0, -1.0]})
    turn = pin.exp3(np.array([0.0, 0.0, 0.25]))
    placed = ik.place(robot, q, "two/ball", at_frame="one/ball", at=[2, 0, 0], rotation=turn)
    wanted = [1 + 2 * math.cos(0.5), 2 + 2 * math.sin(0.5), math.cos(0.75), math.sin(0.75)]
    close(placed[4:], wanted, 1e-15)
    with pytest.raises(RangeError, match=r"out of the plane.*0\.3 m"):
        ik.place(robot, q, "two/ball", at_frame="one/ball", at=[2, 0, 0.3])
    with pytest.raises(RangeError, match="cannot make"):
        tilt = pin.exp3(np.array([0.1, 0, 0]))
        ik.place(robot, q, "two/ball", at_frame="one/ball", rotation=tilt)
