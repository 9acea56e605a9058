"""Contacts that rest: friction that stops, sticks and slides, contacts that let go."""

import numpy as np
import pinocchio as pin
import pytest
import scipy.integrate

import impulsekit as ik
from benchmarks.urdf import solid_box
from impulsekit.robot.combine import combine

from ..models import GRAVITY, MODELS, particle, sliders


def test_a_contact_lets_go_when_its_force_turns():
    robot = sliders(1)
    lift = ik.AppliedForce("b00", linear=lambda t: (0.0, 0.0, 20.0 * t))
    scene = ik.Scene(robot, contacts=[ik.Contact("b00", name="floor")], forces=[lift])
    motion = ik.simulate(scene, [0.0], [0.0], duration=1.5, accuracy="high")
    off = GRAVITY / 20.0
    (rest,) = motion.rests
    assert rest.end == pytest.approx(off, abs=1e-3)
    t = np.maximum(motion.t - off, 0.0)
    np.testing.assert_allclose(motion.q[:, 0], 20.0 * t**3 / 6.0, atol=1e-8)


def test_a_stop_bears_a_joint_and_lets_it_go():
    robot = sliders(1)
    pull = ik.AppliedForce("b00", linear=lambda t: (0.0, 0.0, 4.0 * GRAVITY if t > 1.0 else 0.0))
    stop = ik.JointStop("z00", lower=-0.5)
    scene = ik.Scene(robot, contacts=[stop], forces=[pull])
    motion = ik.simulate(scene, [0.0], [0.0], duration=1.2, accuracy="high")
    (rest,) = motion.rests
    assert rest.start == pytest.approx(np.sqrt(1.0 / GRAVITY), abs=1e-9)
    assert rest.end == pytest.approx(1.0, abs=1e-6)
    assert motion.q[-1, 0] == pytest.approx(-0.5 + 1.5 * GRAVITY * 0.2**2, abs=1e-6)


def test_a_slip_that_begins_slowly_turns_as_it_should():
    def pull(t):
        return np.array([5.8 + 600.0 * t, 0.9, 0.0])

    contact = ik.Contact("z", friction=0.3, name="floor")
    scene = ik.Scene(particle(), contacts=[contact], forces=[ik.AppliedForce("z", linear=pull)])
    motion = ik.simulate(scene, [0, 0, 0], [0, 0, 0], duration=0.02, accuracy="high")
    assert motion.status.finished

    hold = 0.3 * 2.0 * GRAVITY
    start = (np.sqrt(hold**2 - 0.9**2) - 5.8) / 600.0

    def rates(t, y):
        return np.concatenate([y[2:], (pull(t)[:2] - hold * y[2:] / np.hypot(*y[2:])) / 2.0])

    nearly_still = 1e-11 * pull(start)[:2]
    path = scipy.integrate.solve_ivp(
        rates, (start, 0.02), [0, 0, *nearly_still], "Radau", rtol=1e-9, atol=1e-14
    )
    np.testing.assert_allclose(motion.q[-1, :2], path.y[:2, -1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(motion.v[-1, :2], path.y[2:, -1], rtol=0, atol=1e-7)
    # The slower the slip, the faster it may turn: below the capture speed it does not.
    assert motion.steps < 500


FEET = ("FL_FOOT", "FR_FOOT", "HL_FOOT", "HR_FOOT")


@pytest.mark.slow
def test_solo12_dropped_on_a_rough_floor_comes_to_rest():
    solo = ik.Robot.from_example("solo12", root="freeflyer")
    pose = {"root_joint": [0, 0, 0, 0, 0, 0, 1]}
    for leg, sign in (("FL", 1), ("FR", 1), ("HL", -1), ("HR", -1)):
        pose |= {f"{leg}_HFE": 0.8 * sign, f"{leg}_KFE": -1.6 * sign}
    q = solo.configuration(pose)
    data = solo.model.createData()

    def lowest(q):
        pin.framesForwardKinematics(solo.model, data, q)
        return min(data.oMf[solo.frame_id(foot)].translation[2] for foot in FEET)

    q[2] = 0.3 - lowest(q)
    joints = [solo.model.joints[solo.model.getJointId(name)] for name in solo.joint_names[1:]]
    forces = [
        ik.JointSpring(name, stiffness=20, damping=0.5, rest=q[joint.idx_q])
        for name, joint in zip(solo.joint_names[1:], joints, strict=True)
    ]
    contacts = [ik.Contact(foot, friction=0.8, restitution=0.2, name=foot) for foot in FEET]
    scene = ik.Scene(solo, contacts=contacts, forces=forces)
    motion = ik.simulate(scene, q, solo.velocity(), duration=5.0, samples=501, accuracy="high")
    assert motion.status.finished, motion.detail
    assert min(lowest(motion.at(t)[0]) for t in np.linspace(0, 5, 3001)) > -1e-6
    assert np.abs(motion.v[-1]).max() < 1e-9
    assert {rest.contact for rest in motion.rests if rest.end == np.inf} == set(FEET)
    energy = motion.energy().total
    assert np.diff(energy).max() < 1e-12 * energy[0]


def test_slow_slip_at_the_start_is_kept():
    # Half the capture speed, against a friction that the pull just balances: it goes on.
    robot, mu, slip = particle(mass=2.0), 0.5, 5e-8
    pull = ik.AppliedForce("z", linear=[mu * 2.0 * GRAVITY, 0, 0])
    scene = ik.Scene(robot, contacts=[ik.Contact("z", friction=mu)], forces=[pull])
    motion = ik.simulate(
        scene, robot.neutral(), robot.velocity(along_x=slip), duration=1.0, accuracy="high"
    )
    np.testing.assert_allclose(motion.q[-1, 0], slip, rtol=1e-6)


def test_very_slow_slip_takes_few_steps():
    # Yaw of a box that slides is damped at a rate of some 15 / slip.
    box, mu = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer"), 0.5
    corners = [
        ik.Contact("box", at=[x, y, -0.05], friction=mu)
        for x in (-0.05, 0.05)
        for y in (-0.05, 0.05)
    ]
    pull = [mu * box.mass * GRAVITY * (1 + 1e-4), 0, 0]
    scene = ik.Scene(box, contacts=corners, forces=[ik.AppliedForce("box", pull, at=[0, 0, -0.05])])
    q = box.configuration(root_joint=[0, 0, 0.05, 0, 0, 0, 1])
    motion = ik.simulate(scene, q, box.velocity(), duration=0.2, max_steps=60, accuracy="high")
    assert motion.status.finished, motion.detail
    np.testing.assert_allclose(motion.v[-1, 0], 0.2 * mu * GRAVITY * 1e-4, rtol=1e-4)


def test_bodies_that_do_not_touch_rest_as_if_alone():
    box = solid_box("box", 1.0, (0.2, 0.2, 0.2))
    corners = [(x, y, -0.1) for x in (-0.1, 0.1) for y in (-0.1, 0.1)]
    pair = combine(one=box, two=box)

    def forces(robot, names, **places):
        contacts = [
            ik.Contact(f"{name}box", at=corner, friction=0.4, name=f"{name}{i}")
            for name in names
            for i, corner in enumerate(corners)
        ]
        scene = ik.Scene(robot, contacts=contacts, gravity=[0.3, 0.2, -9.81])
        motion = ik.simulate(scene, robot.configuration(**places), robot.velocity(), duration=0.1)
        return [[motion.contacts[f"{name}{i}"].force(0.05) for i in range(4)] for name in names]

    here = {"root_joint": [0, 0, 0.1, 0, 0, 0, 1]}
    apart = {f"{name}/root_joint": [x, 0, 0.1, 0, 0, 0, 1] for x, name in enumerate(("one", "two"))}
    (alone,) = forces(box, [""], **here)
    np.testing.assert_array_equal(forces(pair, ["one/", "two/"], **apart), [alone, alone])
