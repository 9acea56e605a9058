"""Springs, dampers, actuators and applied forces against closed forms; what they refuse."""

import pickle

import numpy as np
import pytest

import impulsekit as ik
from impulsekit import errors

from ..models import particle, sliders


def follow(robot, q, v, duration, **parts):
    changes = parts.pop("changes", {})
    scene = ik.Scene(robot, gravity=[0, 0, 0], **parts)
    return ik.simulate(scene, q, v, duration=duration, **changes)


def test_a_joint_spring_swings():
    spring = ik.JointSpring("z00", stiffness=4.0, rest=0.5)
    motion = follow(sliders(1), [1.5], [0.0], 5.0, forces=[spring])
    np.testing.assert_allclose(motion.q[:, 0], 0.5 + np.cos(2 * motion.t), atol=1e-8)
    energy = motion.energy()
    np.testing.assert_allclose(energy.total, 2.0, rtol=1e-9)
    assert energy.springs[0] == pytest.approx(2.0)


def test_a_damper_damps():
    damper = ik.JointSpring("z00", stiffness=4.0, damping=1.2)
    motion = follow(sliders(1), [1.0], [0.0], 5.0, forces=[damper])
    decay, rate = 0.6, np.sqrt(4.0 - 0.36)
    wanted = np.exp(-decay * motion.t) * (
        np.cos(rate * motion.t) + decay / rate * np.sin(rate * motion.t)
    )
    np.testing.assert_allclose(motion.q[:, 0], wanted, atol=1e-8)


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


def test_a_spring_damper_of_a_particle_in_space():
    spring = ik.Spring("z", other_at=[0, 0, 0], stiffness=8.0, damping=4.0)
    motion = follow(particle(2.0), [0.3, 0.4, 0.0], [0, 0, 0], 3.0, forces=[spring])
    decay, rate = 1.0, np.sqrt(3.0)
    wanted = (
        0.5
        * np.exp(-decay * motion.t)
        * (np.cos(rate * motion.t) + decay / rate * np.sin(rate * motion.t))
    )
    np.testing.assert_allclose(motion.q @ [0.6, 0.8, 0.0], wanted, atol=1e-8)


@pytest.mark.parametrize(
    ("torque", "position"),
    [
        (3.0, lambda t: 1.5 * t**2),
        (lambda t, q, v: 6.0 * t, lambda t: t**3),
        (lambda t, q, v: [-4.0 * (q[0] - 1.0)], lambda t: 1.0 - np.cos(2 * t)),
        (ik.PD(4.0, target=1.0), lambda t: 1.0 - np.cos(2 * t)),
        (ik.PD(1e6, target=1e3, limit=3.0), lambda t: 1.5 * t**2),
    ],
)
def test_actuators(torque, position):
    motion = follow(sliders(1), [0.0], [0.0], 2.0, forces=[ik.Actuator("z00", torque)])
    np.testing.assert_allclose(motion.q[:, 0], position(motion.t), atol=1e-8)


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


@pytest.mark.parametrize(
    ("make", "error", "words"),
    [
        (lambda: ik.JointSpring("z00", stiffness=-1.0), errors.RangeError, "stiffness"),
        (lambda: ik.JointSpring("z00", rest=np.nan), errors.NotFiniteError, "rest"),
        (lambda: ik.Spring("b00", "b00"), errors.InputError, "one frame"),
        (lambda: ik.Spring("b00", rest_length=-1), errors.RangeError, "rest_length"),
        (lambda: ik.PD(1.0, limit=-2.0), errors.RangeError, "limit"),
        (lambda: ik.Actuator("z00", "strong"), errors.NotFiniteError, "torque"),
        (lambda: ik.AppliedForce("b00", linear=[1, 2]), errors.ShapeError, "linear"),
        (lambda: ik.AppliedForce("b00", axes="body"), errors.RangeError, "axes"),
    ],
)
def test_what_is_wrong_alone_is_told_when_made(make, error, words):
    with pytest.raises(error, match=words):
        make()


@pytest.mark.parametrize(
    ("force", "error", "words"),
    [
        (ik.JointSpring("z0"), errors.UnknownNameError, "z00"),
        (ik.Spring("b00", "b99"), errors.UnknownNameError, "b99"),
        (ik.Spring("base", "world"), errors.InputError, "both belong to the world"),
        (ik.Actuator("z00", [1.0, 2.0]), errors.ShapeError, "torque"),
        (ik.AppliedForce("base"), errors.InputError, "moves nothing"),
        (ik.Contact("b00"), errors.InputError, "must be a JointSpring"),
    ],
)
def test_what_does_not_fit_the_robot_is_told_by_the_scene(force, error, words):
    with pytest.raises(error, match=words):
        ik.Scene(sliders(1), forces=[force])


def test_a_joint_with_several_degrees_takes_no_spring():
    ball = ik.Robot.from_example("solo12", root="freeflyer")
    with pytest.raises(errors.InputError, match="degrees of freedom"):
        ik.Scene(ball, forces=[ik.JointSpring("root_joint")])


def test_names_are_shared_with_the_other_entries():
    forces = [ik.JointSpring("z00", name="it")]
    with pytest.raises(errors.InputError, match='"it"'):
        ik.Scene(sliders(1), contacts=[ik.Contact("b00", name="it")], forces=forces)


def test_a_function_of_the_wrong_shape_is_told():
    bad = ik.Actuator("z00", lambda t, q, v: [1.0, 2.0])
    with pytest.raises(errors.ShapeError, match="torque at t"):
        follow(sliders(1), [0.0], [0.0], 1.0, forces=[bad])


def test_forces_are_frozen_and_pickle_and_impacts_do_not_know_them():
    scene = ik.Scene(sliders(1), forces=[ik.Actuator("z00", ik.PD(1.0)), ik.JointSpring("z00", 2)])
    again = pickle.loads(pickle.dumps(scene))
    assert again.forces == scene.forces
    assert not ik.solve(scene, [0.0], [1.0]).dv.any()
