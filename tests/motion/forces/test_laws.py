"""Springs, dampers, actuators and applied forces against closed forms; what they refuse."""

import numpy as np
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
