"""What holds during the motion: loops, welds, hinges, sliders, locks and gears."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik

from ..models import MODELS

LOOP = ik.PointAnchor("coupler", "rocker", at=[0.5, 0, 0], other_at=[0, 0.5, 0])


def place(robot, data, frame, at=(0, 0, 0)):
    return data.oMf[robot.frame_id(frame)].act(np.array(at, dtype=float))


def four_bar(**parts):
    robot = ik.Robot.from_urdf(MODELS / "four_bar.urdf")
    return ik.Scene(robot, **{"constraints": [LOOP], "gravity": [0, 0, 0], **parts})


def gaps(motion, times):
    robot = motion.scene.robot
    data = robot.model.createData()
    found = []
    for t in times:
        pin.framesForwardKinematics(robot.model, data, motion.at(t)[0])
        ends = place(robot, data, "coupler", (0.5, 0, 0)), place(robot, data, "rocker", (0, 0.5, 0))
        found.append(np.linalg.norm(ends[0] - ends[1]))
    return np.array(found)


@pytest.mark.slow
def test_a_struck_four_bar_stays_closed_for_ten_seconds():
    scene = four_bar(impulses=[ik.AppliedImpulse("crank", linear=[0.5, 0, 0], at=[0, 0.2, 0])])
    robot = scene.robot
    motion = ik.simulate(
        scene, robot.neutral(), robot.velocity(), duration=10.0, samples=501, accuracy="high"
    )
    assert motion.status.finished
    assert gaps(motion, np.linspace(0.0, 10.0, 1501)).max() < 1e-9
    energy = motion.energy().total
    assert np.ptp(energy) < 1e-8 * energy[0]
    # It has gone round several times: there was something to drift.
    assert abs(motion.q[-1, 0]) > 6 * np.pi


def two_bodies():
    one = ik.Robot.from_urdf(MODELS / "hammer.urdf", root="freeflyer")
    other = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
    world = ik.combine(a=one, b=other)
    rng = np.random.default_rng(5)
    q = pin.integrate(world.model, world.neutral(), rng.uniform(-0.5, 0.5, world.nv))
    return world, q, rng.normal(size=world.nv)


@pytest.mark.slow
@pytest.mark.parametrize(
    "constraint",
    [
        ik.FrameAnchor("a/handle", "b/box"),
        ik.FrameAnchor("a/handle", "b/box", directions=("x", "y", "z", "rx", "ry"), axes="local"),
        ik.FrameAnchor("a/handle", "b/box", directions=("y", "z", "rx", "ry", "rz"), axes="local"),
        ik.PointAnchor("a/handle", "b/box", at=[0.1, 0.2, 0]),
        ik.FrameAnchor("a/handle", directions=("z", "rx", "ry")),
    ],
    ids=["weld", "hinge", "slider", "pin", "table"],
)
def test_what_holds_keeps_energy_and_its_own_coordinates(constraint):
    world, q, v = two_bodies()
    scene = ik.Scene(world, constraints=[constraint], gravity=[0, 0, 0])
    motion = ik.simulate(scene, q, v, duration=3.0, samples=61, accuracy="high")
    assert motion.status.finished, motion.detail
    energy = motion.energy().total
    assert np.ptp(energy) < 1e-8 * energy[0]
    data = world.model.createData()
    seen = []
    for state in motion.q:
        pin.framesForwardKinematics(world.model, data, state)
        one, two = (data.oMf[world.frame_id(n)] for n in ("a/handle", "b/box"))
        if constraint.other == "world":
            seen.append(np.r_[one.translation[2], one.rotation[2]])
            continue
        between = two.actInv(one)
        if isinstance(constraint, ik.PointAnchor):
            seen.append(between.act(np.array([0.1, 0.2, 0.0])))
        elif len(constraint.directions) == 6:
            seen.append(between.homogeneous.ravel())
        elif "rz" not in constraint.directions:
            seen.append(np.r_[between.translation, between.rotation[:, 2]])
        else:
            along = between.rotation[:, 0]
            off = between.translation - along * (along @ between.translation)
            seen.append(np.r_[off, between.rotation.ravel()])
    assert np.ptp(np.array(seen), axis=0).max() < 1e-9


def test_a_locked_base_keeps_its_place_and_turn_while_an_arm_swings_on_it():
    arm = ik.Robot.from_urdf(ik.models.pendulum_urdf(2), root="freeflyer")
    scene = ik.Scene(arm, constraints=[ik.JointLock("root_joint")], gravity=[0, 0, -9.81])
    rng = np.random.default_rng(3)
    q = pin.integrate(arm.model, arm.neutral(), rng.uniform(-1.0, 1.0, arm.nv))
    motion = ik.simulate(scene, q, np.r_[np.zeros(6), 1.0, -2.0], duration=3.0, samples=31)
    assert motion.status.finished, motion.detail
    assert np.abs(motion.q[:, :7] - q[:7]).max() < 1e-9
    energy = motion.energy().total
    assert np.ptp(energy) < 1e-6 * np.abs(energy).max()
    assert np.abs(motion.v[:, 6:]).max() > 1.0


def test_a_loop_meets_a_stop_and_stays_closed():
    stop = ik.JointStop("rocker_pin", lower=-0.5, upper=0.3, restitution=0.5)
    scene = four_bar(
        contacts=[stop],
        impulses=[ik.AppliedImpulse("crank", linear=[0.3, 0, 0], at=[0, 0.2, 0])],
    )
    robot = scene.robot
    motion = ik.simulate(
        scene, robot.neutral(), robot.velocity(), duration=2.0, samples=201, accuracy="high"
    )
    assert motion.status.finished, motion.detail
    assert len(motion.impacts) > 1
    assert motion.q[:, 2].max() < 0.3 + 1e-9
    assert motion.q[:, 2].min() > -0.5 - 1e-9
    assert gaps(motion, motion.t).max() < 1e-9
    assert np.diff(motion.energy().total).max() < 1e-9


@pytest.mark.slow
@pytest.mark.parametrize("gravity", [0.0, 9.81, 1e4])
def test_a_straight_pendulum_caught_at_its_middle_pin_goes_on(gravity):
    # Across the straight upper rod the pin is held twice, along it by a row of rounding alone.
    given = ik.load_scene(MODELS.parent / "examples" / "pendulum_peg.toml")
    scene = replace(given.scene, gravity=(0.0, 0.0, -gravity))
    motion = ik.simulate(scene, given.q, given.v, duration=1.0, samples=50, rtol=1e-11)
    assert motion.status.finished, motion.detail
    assert np.abs(motion.q[:, 0]).max() < 1e-9
    # The lower rod, of length 1, begins with 5/2 of the speed and swings about its end:
    # θ̇²/2 − 3 g cos θ / 2 stays.
    energy = 0.5 * motion.v[:, 1] ** 2 - 1.5 * gravity * np.cos(motion.q[:, 1])
    np.testing.assert_allclose(energy, 0.5 * 2.5**2 - 1.5 * gravity, rtol=1e-8, atol=1e-8)
