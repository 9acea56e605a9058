"""Dry friction in joints: held up to a bound, opposed when they move."""

import numpy as np
import pinocchio as pin
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import impulsekit as ik
from benchmarks.urdf import joint_text, link_text, robot_text

from ..models import particle, sliders

NOWHERE = [0, 0, 0]
G = 9.81


def test_an_oscillator_loses_two_widths_a_half_swing_and_stops_in_its_dead_zone():
    robot, k, bound, start = sliders(1), 100.0, 3.0, 0.5
    forces = [ik.JointSpring("z00", k), ik.JointFriction("z00", bound, name="dry")]
    motion = ik.simulate(
        ik.Scene(robot, forces=forces, gravity=NOWHERE), [start], [0.0], duration=5
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


def test_a_pendulum_turns_where_its_energy_is_used_up_and_stops_when_it_should():
    robot = ik.Robot.from_urdf(ik.models.pendulum_urdf(1))
    link = next(link for link in robot.links if link.mass > 0)
    inertia = link.inertia_in_joint_axes[1, 1] + link.mass * link.com_in_joint @ link.com_in_joint
    heavy = robot.mass * G * np.linalg.norm(link.com_in_joint)
    bound = 0.15 * heavy
    scene = ik.Scene(robot, forces=[ik.JointFriction("joint_1", bound, name="dry")])
    rest = pin.rnea(robot.model, robot.model.createData(), np.array([0.5]), *2 * [np.zeros(1)])
    sign = np.sign(rest[0]) * heavy
    # It hangs at q = 0, or at pi: heavy (1 - cos q) is its energy from there.
    bottom = 0.0 if sign > 0 else np.pi
    angle, time, turned = 1.2, 0.0, []
    while heavy * np.sin(abs(angle)) > bound:
        side = np.sign(angle)

        def left(other, angle=angle, side=side):
            return heavy * (np.cos(other) - np.cos(angle)) - bound * abs(other - angle)

        end = brentq(left, -angle, angle - 1e-6 * side, xtol=1e-14)

        def rates(t, y, side=side):
            return [y[1], (side * bound - heavy * np.sin(y[0])) / inertia]

        def stops(t, y, side=side):
            return y[1] * side

        stops.terminal, stops.direction = True, 1.0
        still = [angle, -1e-14 * side]
        own = solve_ivp(rates, (0, 9), still, "DOP853", events=stops, rtol=3e-14, atol=1e-15)
        time, angle = time + own.t[-1], end
        turned.append((time, angle))
    motion = ik.simulate(scene, [bottom + 1.2], [0.0], duration=time + 0.5)
    assert len(turned) > 2
    for when, where in turned:
        assert np.abs(motion.step_times - when).min() < 1e-9
        np.testing.assert_allclose(motion.at(when)[0], bottom + where, atol=1e-9)
    np.testing.assert_allclose(motion.q[-1], bottom + angle, atol=1e-9)
    lost = np.diff(motion.energy().total[[0, -1]])
    np.testing.assert_allclose(motion.forces["dry"].work(), lost, atol=1e-9)


@pytest.mark.parametrize(("bound", "moves"), [(0.99, True), (1.01, False)])
def test_a_slider_on_an_incline_is_held_or_runs_down(bound, moves):
    robot, tilt = sliders(1), np.deg2rad(30)
    weight = robot.mass * G * np.sin(tilt)
    scene = ik.Scene(
        robot,
        forces=[ik.JointFriction("z00", bound * weight)],
        gravity=[G * np.cos(tilt), 0, -G * np.sin(tilt)],
    )
    motion = ik.simulate(scene, [0.0], [0.0], duration=2.0)
    fallen = 0.5 * (1.0 - bound) * weight / robot.mass * 4.0 if moves else 0.0
    np.testing.assert_allclose(motion.q[-1, 0], -fallen, atol=1e-12)


def test_two_joints_give_way_one_after_the_other():
    # Carriage x on the ground (c1), carriage y on it (c2): y is pulled by 2 t N.
    m1, m2, c1, c2 = 2.0, 1.0, 1.0, 3.0
    parts = [link_text("w"), link_text("x", m1), link_text("y", m2)]
    parts += [joint_text(n, "prismatic", p, n, far=9) for n, p in (("x", "w"), ("y", "x"))]
    robot = ik.Robot.from_urdf(robot_text("two", *parts))
    pull = ik.AppliedForce("y", linear=lambda t: [2.0 * t, 0, 0])
    dry = [ik.JointFriction("x", c1, name="x_dry"), ik.JointFriction("y", c2, name="y_dry")]
    motion = ik.simulate(ik.Scene(robot, forces=[pull, *dry], gravity=NOWHERE), [0, 0], [0, 0], 6.0)
    # Both move with (2 t - c1)/(m1 + m2) from 0.5 s on, until c2 = m1 a + c1 no longer does it.
    first, t = c1 / 2.0, 0.5 * (c1 + (c2 - c1) * (m1 + m2) / m1)
    x, v = (t - first) ** 3 / 3.0 / (m1 + m2), (t - first) ** 2 / (m1 + m2)
    np.testing.assert_allclose(motion.at(t)[0], [x, 0.0], atol=1e-10)
    later = 6.0 - t
    x_end = x + v * later + 0.5 * (c2 - c1) / m1 * later**2
    pulled = v * later + ((6.0**3 - t**3) / 3 - t**2 * later - 0.5 * c2 * later**2) / m2
    np.testing.assert_allclose(motion.q[-1], [x_end, x + pulled - x_end], rtol=1e-10)
    np.testing.assert_allclose(motion.forces["y_dry"].force(0.4), -0.8, atol=1e-10)
    np.testing.assert_allclose(motion.forces["x_dry"].force([0.4, 1.0])[:, 0], [-0.8, -c1])


def check_law(motion, bounds, q, v, rate, given, off):
    """M v̇ + h - τ is a friction that obeys the law; v̇ from outside."""
    robot = motion.scene.robot
    model = robot.model.copy()
    model.gravity.linear = np.array(motion.scene.gravity)
    dry = pin.rnea(model, model.createData(), q, v, rate) - given
    for torque, bound, speed in zip(dry, bounds, v, strict=True):
        if speed == 0.0:
            assert abs(torque) <= bound + off
        else:
            assert abs(torque + bound * np.sign(speed)) <= off
    return dry


@pytest.mark.slow
@pytest.mark.parametrize("seed", range(4))
def test_random_chains_obey_the_law_at_every_time(seed):
    # Against accelerations by differences of the velocity, and Newton-Euler.
    rng = np.random.default_rng(seed)
    robot = ik.Robot.from_urdf(ik.models.pendulum_urdf(4))
    bounds = rng.choice([0.0, 1.0, 5.0, 20.0], robot.nv)
    names = robot.joint_names
    forces = [ik.JointFriction(n, b, name=n) for n, b in zip(names, bounds, strict=True)]
    forces += [ik.JointSpring(n, 30.0, 0.5) for n in names]
    scene = ik.Scene(robot, forces=forces)
    start = rng.normal(0.0, 0.5, robot.nq), rng.normal(0.0, 1.0, robot.nv)
    motion = ik.simulate(scene, *start, duration=1.5, rtol=1e-11)
    assert motion.status.finished
    step, seen = 1e-5, 0
    for t in rng.uniform(0.01, 1.49, 40):
        if np.abs(motion.step_times - t).min() < 2.0 * step:
            continue
        (_, a), (q, v), (_, b) = (motion.at(t + s * step) for s in (-1.0, 0.0, 1.0))
        v = np.where(np.abs(v) < 1e-13, 0.0, v)
        given = -30.0 * q - 0.5 * v
        dry = check_law(motion, bounds, q, v, (b - a) / (2.0 * step), given, 1e-4)
        told = [motion.forces[n].force(t)[0] for n in names]
        np.testing.assert_allclose(told, dry, atol=1e-4)
        seen += int(((v == 0.0) & (bounds > 0)).any())
    energy = motion.energy().total
    work = sum(motion.forces[i].work() for i in motion.forces)
    stored = motion.energy().springs
    np.testing.assert_allclose(
        work + stored[-1] - stored[0], energy[-1] - energy[0], atol=1e-7 * abs(energy).max()
    )


def test_a_loop_is_held_by_all_of_its_joints_together():
    # Two cranks on one coupler: the joints share the load; alone none could hold it.
    robot = sliders(3)
    tie = [ik.JointCoupling("z00", "z01"), ik.JointCoupling("z00", "z02")]
    for bound, holds in ((robot.mass * G / 3 * 1.001, True), (robot.mass * G / 3 * 0.999, False)):
        dry = [ik.JointFriction(f"z0{i}", bound, name=f"d{i}") for i in range(3)]
        scene = ik.Scene(robot, constraints=tie, forces=dry, gravity=[0, 0, -G])
        motion = ik.simulate(scene, [0, 0, 0], [0, 0, 0], duration=1.0)
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
    motion = ik.simulate(scene, robot.neutral(), robot.velocity(), duration=4.0)
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
    motion = ik.simulate(scene, [0.0], [0.0], duration=1.0)
    assert abs(motion.v[-1, 0]) < 1e-13
    assert motion.contacts["stop"].force(0.9) + motion.forces["dry"].force(0.9) == pytest.approx(
        -10
    )
