"""Springs that act one way, torques from tables, and the damping that a file tells of."""

import numpy as np
import pytest

import impulsekit as ik

from ..models import particle, sliders

NOWHERE = [0, 0, 0]


@pytest.mark.parametrize(("acts", "way"), [("above", 1.0), ("below", -1.0)])
def test_a_stop_that_gives_way_throws_back_after_half_a_period(acts, way):
    robot = sliders(1)
    k, m, rest, speed = 400.0, robot.mass, way * 0.2, way * 1.5
    stop = ik.JointSpring("z00", stiffness=k, rest=rest, acts=acts, name="stop")
    scene = ik.Scene(robot, forces=[stop], gravity=NOWHERE)
    motion = ik.simulate(scene, [0.0], [speed], duration=1.0, samples=101, accuracy="high")
    omega = np.sqrt(k / m)
    met = rest / speed
    gone = met + np.pi / omega
    t = motion.t
    inside = rest + speed / omega * np.sin(omega * (t - met))
    expected = np.where(t < met, speed * t, np.where(t < gone, inside, rest - speed * (t - gone)))
    np.testing.assert_allclose(motion.q[:, 0], expected, atol=1e-9)
    np.testing.assert_allclose(motion.energy().total, 0.5 * m * speed**2, rtol=1e-8)
    assert motion.forces["stop"].force(0.5 * met)[0] == 0.0
    assert motion.forces["stop"].force(0.5 * (met + gone))[0] * way < 0.0


def test_a_damper_on_one_side_only_pushes():
    robot = sliders(1)
    k, c, m = 100.0, 6.0, robot.mass
    pad = ik.JointSpring("z00", stiffness=k, damping=c, acts="above")
    scene = ik.Scene(robot, forces=[pad], gravity=NOWHERE)
    motion = ik.simulate(scene, [0.0], [1.0], duration=1.0, samples=401, accuracy="high")
    # While it pushes it is a damped oscillator from 0; it lets go when k q + c v is zero.
    decay, omega = c / (2 * m), np.sqrt(k / m - (c / (2 * m)) ** 2)
    t = motion.t
    x = np.exp(-decay * t) * np.sin(omega * t) / omega
    v = np.exp(-decay * t) * np.cos(omega * t) - decay * x
    lets_go = int(np.argmax(k * x + c * v < 0.0))
    np.testing.assert_allclose(motion.q[:lets_go, 0], x[:lets_go], atol=1e-9)
    # From there on it flies at the speed it has.
    np.testing.assert_allclose(motion.v[lets_go:, 0], motion.v[-1, 0], rtol=1e-9)
    assert x[lets_go] > 0.0 > v[lets_go]


def test_a_rubber_rope_pulls_and_a_buffer_pushes():
    robot = particle(mass=2.0)
    k, length, omega = 50.0, 1.0, 5.0
    for acts, start, speed, sign in (("pull", 0.5, 1.0, 1.0), ("push", 1.5, -1.0, -1.0)):
        between = ik.Spring("z", stiffness=k, rest_length=length, acts=acts, name="between")
        scene = ik.Scene(robot, forces=[between], gravity=NOWHERE)
        q, v = robot.configuration(along_x=start), robot.velocity(along_x=speed)
        motion = ik.simulate(scene, q, v, duration=1.2, samples=61, accuracy="high")
        t, met = motion.t, 0.5
        gone = met + np.pi / omega
        inside = length + sign / omega * np.sin(omega * (t - met))
        back = length - sign * (t - gone)
        free = start + speed * t
        expected = np.where(t < met, free, np.where(t < gone, inside, back))
        np.testing.assert_allclose(motion.q[:, 0], expected, atol=1e-9)
        assert not motion.forces["between"].force(0.2).any()
        np.testing.assert_allclose(motion.energy().total, 1.0, rtol=1e-8)


def test_a_table_of_torques_is_followed_to_its_corners():
    robot = sliders(1)
    # A triangle that lasts a ten-thousandth of the motion, and a constant end.
    table = ik.TorqueTable([1.0, 1.0001, 1.0002, 2.0, 3.0], [0.0, 40.0, 0.0, 0.0, 2.0])
    scene = ik.Scene(robot, forces=[ik.Actuator("z00", table)], gravity=NOWHERE)
    motion = ik.simulate(
        scene, [0.0], [0.0], duration=4.0, samples=[0.9, 1.5, 3.0, 4.0], accuracy="high"
    )
    momentum = robot.mass * motion.v[:, 0]
    np.testing.assert_allclose(momentum, [0.0, 0.004, 1.004, 3.004], atol=1e-12)


def test_the_damping_of_joints_is_there_on_request():
    panda = ik.Robot.from_example("panda")
    assert ik.Scene.of_robot(panda).forces == ()
    forces = ik.Scene.of_robot(
        panda, joint_damping=True, forces=[ik.Actuator("panda_joint1", 1.0)]
    ).forces
    assert isinstance(forces[-1], ik.Actuator)
    told = {force.joint: force.damping for force in forces[:-1]}
    assert told == dict(zip(panda.joint_names, panda.model.damping.tolist(), strict=True))
    # A joint that turns alone comes to rest as exp(-c t / I).
    rod = ik.models.pendulum_urdf(1).replace("<axis", '<dynamics damping="0.7"/><axis')
    robot = ik.Robot.from_urdf(rod)
    scene = ik.Scene.of_robot(robot, joint_damping=True, gravity=NOWHERE)
    motion = ik.simulate(scene, [0.0], [2.0], duration=1.0, samples=5, accuracy="high")
    (link,) = [link for link in robot.links if link.mass > 0]
    inertia = link.inertia_in_joint_axes[1, 1] + link.mass * link.com_in_joint @ link.com_in_joint
    np.testing.assert_allclose(motion.v[:, 0], 2.0 * np.exp(-0.7 * motion.t / inertia), rtol=1e-9)
