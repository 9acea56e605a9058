"""Springs, dampers, actuators and applied forces against closed forms; what they refuse."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit import errors

from ..models import sliders


def follow(robot, q, v, duration, **parts):
    changes = parts.pop("changes", {})
    scene = ik.Scene(robot, gravity=[0, 0, 0], **parts)
    return ik.simulate(scene, q, v, duration=duration, **changes, accuracy="high")


def test_a_stiff_damper_is_radaus_work():
    damper = ik.JointSpring("z00", stiffness=1e4, damping=1e4)
    motion = follow(
        sliders(1), [1.0], [0.0], 5.0, forces=[damper], changes={"method": "radau", "rtol": 1e-8}
    )
    # s² + 10⁴ s + 10⁴ = 0: the slow root.
    slow = 0.5 * (-1e4 + np.sqrt(1e8 - 4e4))
    assert motion.q[-1, 0] == pytest.approx(np.exp(5 * slow), rel=1e-3)
    assert motion.steps < 520


def test_springs_between_points_pull_both_ends():
    robot = sliders(2)
    spring = ik.Spring("b00", "b01", stiffness=3.0, rest_length=1.0)
    motion = follow(robot, [0.0, 1.5], [0.0, 0.0], 4.0, forces=[spring])
    momentum = motion.v @ [1.0, 1.1]
    np.testing.assert_allclose(momentum, 0.0, atol=1e-10)
    rate = np.sqrt(3.0 * (1 / 1.0 + 1 / 1.1))
    length = motion.q[:, 1] - motion.q[:, 0]
    np.testing.assert_allclose(length, 1.0 + 0.5 * np.cos(rate * motion.t), atol=1e-8)
    np.testing.assert_allclose(motion.energy().total, 0.375, rtol=1e-8)


@pytest.mark.parametrize("axes", ["world", "local"])
def test_applied_forces_turn_with_the_body_or_not(axes):
    body = ik.Robot.from_example("solo12", root="freeflyer")
    mass = body.mass
    force = ik.AppliedForce("base_link", linear=[0, mass, 0], axes=axes)
    locks = [ik.JointLock(name) for name in body.joint_names[1:]]
    q = body.configuration(root_joint=[0, 0, 0, 0, 0, np.sin(0.5), np.cos(0.5)])
    motion = follow(body, q, body.velocity(), 1e-3, forces=[force], constraints=locks)
    speed = motion.momentum().linear[-1] / mass
    direction = [0, 1, 0] if axes == "world" else [-np.sin(1.0), np.cos(1.0), 0]
    np.testing.assert_allclose(speed, 1e-3 * np.array(direction), atol=1e-7)


def test_a_couple_turns():
    body = ik.Robot.from_example("solo12", root="freeflyer")
    force = ik.AppliedForce("base_link", angular=[0, 0, 2.0], at=[0.1, 0.2, 0.3])
    motion = follow(body, body.neutral(), body.velocity(), 0.1, forces=[force])
    np.testing.assert_allclose(motion.momentum().angular[-1], [0, 0, 0.2], atol=1e-10)


def test_names_are_shared_with_the_other_entries():
    forces = [ik.JointSpring("z00", name="it")]
    with pytest.raises(errors.InputError, match='"it"'):
        ik.Scene(sliders(1), contacts=[ik.Contact("b00", name="it")], forces=forces)


def test_a_function_of_the_wrong_shape_is_told():
    bad = ik.Actuator("z00", lambda t, q, v: [1.0, 2.0])
    with pytest.raises(errors.ShapeError, match="torque at t"):
        follow(sliders(1), [0.0], [0.0], 1.0, forces=[bad])


@pytest.mark.parametrize("axes", ["local", "world"])
def test_drag_slows_as_the_closed_form_says(axes):
    # m dv/dt = −c v²: 1/v = 1/v₀ + c t/m, and the way is m/c log(1 + c v₀ t/m).
    ball = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
    turn = pin.Quaternion(pin.rpy.rpyToMatrix(0.3, -0.8, 1.2))
    q = ball.configuration(root_joint=[0, 0, 0, *turn.coeffs()])
    v = ball.velocity(root_joint=[*(turn.matrix().T @ [3.0, 0, 0]), 0, 0, 0])
    c = 0.2

    def drag(t, q, v):
        speed = v[:3] if axes == "local" else pin.XYZQUATToSE3(q).rotation @ v[:3]
        return -c * np.linalg.norm(speed) * speed

    force = ik.AppliedForce("ball", linear=drag, axes=axes, name="drag")
    motion = follow(ball, q, v, 2.0, forces=[force])
    rate = c / ball.mass * 3.0 * motion.t
    np.testing.assert_allclose(motion.q[:, 0], np.log1p(rate) * ball.mass / c, rtol=0, atol=1e-8)
    np.testing.assert_allclose(
        np.linalg.norm(motion.v[:, :3], axis=1), 3.0 / (1.0 + rate), rtol=1e-9
    )
    there = 3.0 / (1.0 + c / ball.mass * 3.0)
    pull = motion.forces["drag"].force(1.0)
    assert np.linalg.norm(pull[:3]) == pytest.approx(c * there**2, rel=1e-8)


def test_a_force_of_place_swings_beside_one_of_time():
    # m x″ = −k x + F: about F/k, from x = 0 at rest.
    robot = sliders(1)
    spring = ik.AppliedForce("b00", linear=lambda t, q, v: (0, 0, -4.0 * q[0]))
    push = ik.AppliedForce("b00", linear=lambda t, F=2.0: (0, 0, F))
    motion = follow(robot, [0.0], [0.0], 3.0, forces=[spring, push])
    np.testing.assert_allclose(motion.q[:, 0], 0.5 * (1 - np.cos(2 * motion.t)), atol=1e-8)


def test_a_force_of_two_arguments_is_refused():
    with pytest.raises(
        errors.InputError, match=r"linear must be a function of t, or of \(t, q, v\)"
    ):
        ik.AppliedForce("b00", linear=lambda t, q: (0, 0, 0))
