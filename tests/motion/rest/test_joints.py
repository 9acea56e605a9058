"""Dry friction in joints: held up to a bound, opposed when they move."""

import numpy as np
import pytest

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text

from ..models import particle, sliders

NOWHERE = [0, 0, 0]
G = 9.81


def test_an_oscillator_loses_two_widths_a_half_swing_and_stops_in_its_dead_zone():
    robot, k, bound, start = sliders(1), 100.0, 3.0, 0.5
    forces = [ik.JointSpring("z00", k), ik.JointFriction("z00", bound, name="dry")]
    motion = ik.simulate(
        ik.Scene(robot, forces=forces, gravity=NOWHERE), [start], [0.0], duration=5, accuracy="high"
    )
    half, width = np.pi / np.sqrt(k / robot.mass), bound / k
    # |x| = 0.5, 0.44, ... at each turn; below 0.03 it stays.
    turns = [start - 2.0 * n * width for n in range(20)]
    count = next(n for n, x in enumerate(turns) if x <= width)
    for n in range(1, count + 1):
        assert np.abs(motion.step_times - n * half).min() < 1e-10
        q, v = motion.at(n * half)
        np.testing.assert_allclose([q[0], v[0]], [(-1) ** n * turns[n], 0.0], atol=1e-9)
    assert np.abs(motion.q[-1] - (-1) ** count * turns[count]).max() < 1e-11
    assert abs(motion.v[-1, 0]) < 1e-13
    # It holds what the spring pulls with, and took what the spring has lost.
    dry, last = motion.forces["dry"], turns[count]
    np.testing.assert_allclose(dry.force(5.0), [(-1) ** count * k * last], atol=1e-9)
    np.testing.assert_allclose(dry.work(), 0.5 * k * (last**2 - start**2), atol=1e-9)
    assert abs(dry.power(5.0)) < 1e-12


def test_two_joints_give_way_one_after_the_other():
    # Carriage x on the ground (c1), carriage y on it (c2): y is pulled by 2 t N.
    m1, m2, c1, c2 = 2.0, 1.0, 1.0, 3.0
    parts = [link_text("w"), link_text("x", m1), link_text("y", m2)]
    parts += [joint_text(n, "prismatic", p, n, far=9) for n, p in (("x", "w"), ("y", "x"))]
    robot = ik.Robot.from_urdf(robot_text("two", *parts))
    pull = ik.AppliedForce("y", linear=lambda t: [2.0 * t, 0, 0])
    dry = [ik.JointFriction("y", c2, name="y_dry")]
    dry += [ik.JointFriction("x", share * c1, name=f"x {share}") for share in (0.4, 0.6)]
    motion = ik.simulate(
        ik.Scene(robot, forces=[pull, *dry], gravity=NOWHERE), [0, 0], [0, 0], 6.0, accuracy="high"
    )
    # Both move with (2 t - c1)/(m1 + m2) from 0.5 s on, until c2 = m1 a + c1 no longer does it.
    first, t = c1 / 2.0, 0.5 * (c1 + (c2 - c1) * (m1 + m2) / m1)
    x, v = (t - first) ** 3 / 3.0 / (m1 + m2), (t - first) ** 2 / (m1 + m2)
    np.testing.assert_allclose(motion.at(t)[0], [x, 0.0], atol=1e-10)
    later = 6.0 - t
    x_end = x + v * later + 0.5 * (c2 - c1) / m1 * later**2
    pulled = v * later + ((6.0**3 - t**3) / 3 - t**2 * later - 0.5 * c2 * later**2) / m2
    np.testing.assert_allclose(motion.q[-1], [x_end, x + pulled - x_end], rtol=1e-10)
    np.testing.assert_allclose(motion.forces["y_dry"].force(0.4), -0.8, atol=1e-10)
    both = sum(motion.forces[f"x {share}"].force([0.4, 1.0])[:, 0] for share in (0.4, 0.6))
    np.testing.assert_allclose(both, [-0.8, -c1])


def test_a_loop_is_held_by_all_of_its_joints_together():
    # Two cranks on one coupler: the joints share the load; alone none could hold it.
    robot = sliders(3)
    tie = [ik.JointCoupling("z00", "z01"), ik.JointCoupling("z00", "z02")]
    for bound, holds in ((robot.mass * G / 3 * 1.001, True), (robot.mass * G / 3 * 0.999, False)):
        dry = [ik.JointFriction(f"z0{i}", bound, name=f"d{i}") for i in range(3)]
        scene = ik.Scene(robot, constraints=tie, forces=dry, gravity=[0, 0, -G])
        motion = ik.simulate(scene, [0, 0, 0], [0, 0, 0], duration=1.0, accuracy="high")
        told = sum(motion.forces[f"d{i}"].force(0.5)[0] for i in range(3))
        fallen = 0.0 if holds else 0.5 * 0.001 * G
        np.testing.assert_allclose(told, robot.mass * (G - 2 * fallen), rtol=1e-9)
        np.testing.assert_allclose(motion.q[-1], -fallen * np.ones(3), atol=1e-11)


def test_contacts_and_joints_hold_together():
    # A block pressed on the ground sticks with µ m g and the bound of its slide along x.
    robot, mu, bound = particle(mass=2.0), 0.3, 4.0
    floor = ik.Contact("z", friction=mu, name="floor")
    dry = ik.JointFriction("along_x", bound, name="dry")
    pull = ik.AppliedForce("z", linear=lambda t: [4.0 * t, 0, 0])
    scene = ik.Scene(robot, contacts=[floor], forces=[dry, pull])
    motion = ik.simulate(scene, robot.neutral(), robot.velocity(), duration=4.0, accuracy="high")
    most = mu * 2.0 * G + bound
    late = 4.0 - most / 4.0
    np.testing.assert_allclose(motion.q[-1, 0], late**3 / 3.0, rtol=1e-9)
    both = motion.contacts["floor"].force(2.0)[0] + motion.forces["dry"].force(2.0)[0]
    np.testing.assert_allclose(both, -8.0, atol=1e-9)
    np.testing.assert_allclose(motion.contacts["floor"].force(3.5)[0], -mu * 2.0 * G, rtol=1e-9)


def test_a_file_s_dry_friction_on_request(tmp_path):
    text = ik.models.pendulum_urdf(1).replace(
        "</joint>", '<dynamics damping="0.25" friction="0.75"/></joint>'
    )
    robot = ik.Robot.from_urdf(text)
    assert ik.Scene.of_robot(robot).forces == ()
    scene = ik.Scene.of_robot(robot, joint_friction=True, joint_damping=True)
    assert scene.forces == (
        ik.JointSpring("joint_1", damping=0.25),
        ik.JointFriction("joint_1", 0.75),
    )
    ik.save_scene(tmp_path / "dry.toml", scene)
    assert ik.load_scene(tmp_path / "dry.toml").scene.forces == scene.forces
    mjcf = """<mujoco><worldbody><body><joint name="j" axis="0 1 0" frictionloss="0.4"/>
      <geom size="0.1" pos="0 0 1"/></body></worldbody></mujoco>"""
    own = ik.Scene.of_robot(ik.Robot.from_mjcf(mjcf), joint_friction=True)
    assert own.forces == (ik.JointFriction("j", 0.4),)


def test_a_joint_at_its_stop_is_held_by_both():
    # The motor pulls with 10, friction takes its 3 in the way it came, the stop the rest.
    robot = sliders(1)
    stop = ik.JointStop("z00", upper=0.2, restitution=0.5, name="stop")
    forces = [ik.Actuator("z00", 10.0), ik.JointFriction("z00", 3.0, name="dry")]
    scene = ik.Scene(robot, contacts=[stop], forces=forces, gravity=NOWHERE)
    motion = ik.simulate(scene, [0.0], [0.0], duration=1.0, accuracy="high")
    assert abs(motion.v[-1, 0]) < 1e-13
    assert motion.contacts["stop"].force(0.9) + motion.forces["dry"].force(0.9) == pytest.approx(
        -10
    )
