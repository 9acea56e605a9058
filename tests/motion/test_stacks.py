"""Boxes on boxes: dropped, stacked, knocked off a stack, and edge on edge."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from benchmarks.motions import domino_row

from .models import MODELS

BOX = ik.Robot.from_urdf(MODELS / "box.urdf", root="freeflyer")
FLOOR = ik.Robot.from_urdf(MODELS / "floor.urdf")
HIGH = 0.1


def pose(x, y, z, rotation):
    return [x, y, z, *pin.Quaternion(rotation).coeffs()]


def stacked(poses, speeds=None, **law):
    """Boxes a, b, … on a floor, each of which may meet each other one."""
    names = "abcdefg"[: len(poses)]
    robot = ik.combine(floor=FLOOR, **dict.fromkeys(names, BOX))
    pairs = [(f"{name}/box", "floor/floor") for name in names]
    pairs += [(f"{b}/box", f"{a}/box") for i, a in enumerate(names) for b in names[i + 1 :]]
    scene = ik.Scene(robot, contacts=[ik.Collision(*pair, **law) for pair in pairs])
    q = {f"{name}/root_joint": place for name, place in zip(names, poses, strict=True)}
    v = {f"{name}/root_joint": speed for name, speed in (speeds or {}).items()}
    return scene, robot.configuration(q), robot.velocity(v)


def gaps(motion, every=1):
    """(T, m) of all contacts at the samples [m]."""
    at_rest = np.zeros(motion.scene.robot.nv)
    impacts = (ik.solve(motion.scene, q, at_rest) for q in motion.q[::every])
    return np.array([[contact.gap for contact in impact.contacts] for impact in impacts])


def check(motion):
    """It ends, nothing is penetrated, and no energy is made."""
    assert motion.status.finished, motion.detail
    assert gaps(motion, 4).min() > -1e-9
    energy = motion.energy()
    # Newton's law with friction may raise the energy, and says so.
    gains = [impact.energy.change for _, impact in motion.impacts]
    told = [impact.status is ik.Status.ENERGY_GAIN for _, impact in motion.impacts]
    assert all(gain < 1e-12 or says for gain, says in zip(gains, told, strict=True))
    if not any(told):
        assert np.diff(energy.total).max() < 1e-9 * max(energy.kinetic.max(), 1.0)


@pytest.mark.slow
@pytest.mark.parametrize("friction", [0.0, 0.5])
def test_three_boxes_on_each_other_stay_where_they_are(friction):
    turns = [pin.rpy.rpyToMatrix(0, 0, angle) for angle in (0.0, 0.3, -0.2)]
    poses = [pose(0.02 * i, 0.01 * i, 0.05 + HIGH * i, turn) for i, turn in enumerate(turns)]
    scene, q, v = stacked(poses, friction=friction)
    motion = ik.simulate(scene, q, v, duration=10.0, samples=21, accuracy="high")
    check(motion)
    assert not motion.impacts
    assert np.abs(motion.q - q).max() < 1e-9
    assert np.abs(gaps(motion)[:, [0, 3, 5]]).max() < 1e-9
    assert {rest.contact for rest in motion.rests} == {f"contacts[{i}]" for i in (0, 3, 5)}


def test_a_bullet_knocks_a_box_out_of_a_stack():
    names, ball = "abc", ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    robot = ik.combine(floor=FLOOR, **dict.fromkeys(names, BOX), bullet=ball)
    pairs = [("a/box", "floor/floor"), ("b/box", "a/box"), ("c/box", "b/box"), ("c/box", "a/box")]
    pairs.append(("bullet/ball", "b/box"))
    scene = ik.Scene(robot, contacts=[ik.Collision(*pair, friction=0.2) for pair in pairs])
    at = {
        f"{name}/root_joint": pose(0, 0, 0.05 + HIGH * i, np.eye(3)) for i, name in enumerate("abc")
    }
    q = robot.configuration(at | {"bullet/root_joint": pose(-0.23, 0, 0.15, np.eye(3))})
    motion = ik.simulate(
        scene,
        q,
        robot.velocity({"bullet/root_joint": [20, 0, 0, 0, 0, 0]}),
        duration=0.03,
        accuracy="high",
    )
    check(motion)
    x, z = (motion.q[-1][i:21:7] for i in (0, 2))
    assert x[1] > 0.03
    assert np.abs(x[[0, 2]]).max() < 0.01
    np.testing.assert_allclose(z, [0.05, 0.15, 0.25], atol=1e-3)


def crossed(seed):
    """A box dropped edge first on a fixed one, at a random angle."""
    rng = np.random.default_rng(seed)
    low = ik.Robot.from_urdf(MODELS / "box.urdf")
    robot = ik.combine(low=low, top=BOX)
    lean = pin.rpy.rpyToMatrix(np.pi / 4 + rng.uniform(-0.2, 0.2), rng.uniform(-0.3, 0.3), 0)
    turn = pin.rpy.rpyToMatrix(0, 0, rng.uniform(-3, 3)) @ lean
    law = ik.Collision("top/box", "low/box", friction=rng.uniform(0.1, 0.8))
    place = pose(*rng.uniform(-0.1, 0.1, 2), 0.27, turn)
    scene = ik.Scene(robot, contacts=[law])
    return scene, robot.configuration({"top/root_joint": place}), robot.velocity()


def test_a_box_dropped_edge_first_on_a_box_lies_or_falls_off():
    scene, q, v = crossed(0)
    motion = ik.simulate(scene, q, v, duration=1.0, samples=401, accuracy="high")
    check(motion)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [4, 10, 15])
def test_a_stack_that_tumbles_down_takes_no_more_steps_than_its_events_need(seed):
    """Boxes that parted by 1e-14 m were looked at every 1e-9 s, and steps cut there."""
    rng, count = np.random.default_rng(seed), 2 + seed % 4 // 2
    bodies = "".join(
        f'<body name="b{i}"><freejoint name="f{i}"/>'
        f'<geom name="b{i}" type="box" size=".1 .08 .05" mass="1"/></body>'
        for i in range(count)
    )
    text = f"<mujoco><worldbody>{bodies}</worldbody></mujoco>"
    robot, places = ik.Robot.from_mjcf(text).with_ground(0.0), {}
    for i in range(count):
        place = [*rng.uniform(-0.02, 0.02, 2), 0.06 + 0.12 * i + rng.uniform(0, 0.02)]
        tilt = rng.uniform(-0.05, 0.05, 2) if seed % 2 else (0.0, 0.0)
        places[f"f{i}"] = ik.pose(place, rpy=[*tilt, rng.uniform(-0.5, 0.5)])
    law = {"restitution": rng.choice([0, 0.2, 0.4]), "friction": rng.choice([0.3, 0.6, 1.0])}
    pairs = [(f"b{i}", "ground") for i in range(count)]
    pairs += [(f"b{i + 1}", f"b{i}") for i in range(count - 1)]
    scene = ik.Scene(robot, contacts=[ik.Collision(*pair, **law) for pair in pairs])
    q, v = robot.configuration(**places), robot.velocity()
    motion = ik.simulate(scene, q, v, duration=1.0, max_steps=1600)
    check(motion)
    assert np.abs(motion.v[-1]).max() < 1e-9


def test_dominoes_fall_in_their_plane():
    """Rounding must not choose between mirrored answers: 227 impacts to the side where it did."""
    scene, q, v = domino_row()
    motion = ik.simulate(scene, q, v, 0.3)
    assert motion.status is ik.MotionStatus.FINISHED
    assert len(motion.impacts) == 20
    aside = motion.v[:, [6 * i + k for i in range(5) for k in (1, 3, 5)]]
    assert np.abs(aside).max() < 1e-9
