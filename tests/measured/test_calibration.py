"""Calibration: what was put into recordings in closed form comes out, with its uncertainty."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, RangeError
from impulsekit.measured import Recording, calibrate
from impulsekit.measured.calibration import _with_mass_centre
from tests.measured.bodies import ball_scene, bouncing_ball, flying_body

SCENE = ball_scene()


def throws(rng, count=8, **given):
    found = []
    for k in range(count):
        t, poses = flying_body(rng, **given)
        found.append(Recording(SCENE.robot, t, poses, name=f"throw {k}"))
    return found


def test_scale_tilt_and_mass_centre_of_throws():
    off = np.array([0.002, -0.004, 0.006])
    given = throws(np.random.default_rng(0), scale=0.97, offset=-off, tilt=(0.01, -0.02))
    found = calibrate(given, SCENE)
    assert found.length_scale == pytest.approx(0.97, abs=1e-4)
    assert found.gravity_tilt == pytest.approx([0.01, -0.02], abs=1e-3)
    assert found.mass_centre == pytest.approx(off, abs=1e-5)
    moved = found.scene(SCENE).robot.model.inertias[1].lever
    assert moved - SCENE.robot.model.inertias[1].lever == pytest.approx(off, abs=1e-5)


def test_the_lag_of_recorded_velocities():
    rng = np.random.default_rng(2)
    found = []
    for k in range(5):
        t, poses = flying_body(rng)
        v = Recording(SCENE.robot, t, poses).velocities(reach=2)
        turns = [pin.XYZQUATToSE3(pose).rotation for pose in poses]
        world = np.array([turn @ each[:3] for turn, each in zip(turns, v, strict=True)])
        late = np.stack([np.interp(t - 0.004, t, column) for column in world.T], axis=1)
        late = np.array([turn.T @ each for turn, each in zip(turns, late, strict=True)])
        late = np.hstack([late, v[:, 3:]])
        found.append(Recording(SCENE.robot, t[4:], poses[4:], v=late[4:], name=str(k)))
    calibration = calibrate(found, SCENE)
    assert calibration.velocity_lag == pytest.approx(0.004, abs=3e-4)
    # Taken off, velocities are nearer to those that were there.
    off = calibration.apply(found[-1]).v[:-4, :3] - v[4:-4, :3]
    assert np.abs(off).max() < 0.3 * np.abs(late[4:-4, :3] - v[4:-4, :3]).max()


@pytest.mark.slow
def test_the_floor_under_bodies_at_rest():
    recordings = []
    for k in range(3):
        recording, _ = bouncing_ball(SCENE, 0.3 + 0.02 * k, 0.35, 200, 1.4, name=str(k))
        q = recording.q.copy()
        q[:, 1] = 0.2 * np.cos(k)
        q[recording.t > 1.0, 0] = 0.3 * np.sin(k)
        q[recording.t > 1.0, 5:] = [0.0, 1.0]
        q[:, 2] += 0.004
        recordings.append(Recording(SCENE.robot, recording.t, q, name=str(k)))
    found = calibrate(recordings, SCENE)
    assert found.floor_height == pytest.approx(0.004, abs=5e-4)
    level = found.apply(recordings[0])
    assert level.q[-1, 2] == pytest.approx(0.05, abs=5e-4)


@pytest.mark.parametrize(
    ("factor", "words"),
    [((1.0, 1e3), 'length="mm"'), ((1e3, 1.0), 'time="ms"'), ((1e9, 1.0), 'time="ns"')],
    ids=["mm", "ms", "ns"],
)
def test_units_that_are_mistaken_are_named(factor, words):
    of_time, of_length = factor
    wrong = []
    for each in throws(np.random.default_rng(3), 3):
        q = each.q.copy()
        q[:, :3] *= of_length
        wrong.append(Recording(SCENE.robot, of_time * each.t, q))
    with pytest.raises(InputError, match=words):
        calibrate(wrong, SCENE)


def test_what_cannot_be_calibrated_is_said():
    still = Recording(SCENE.robot, np.arange(40) / 100, np.tile([0, 0, 1, 0, 0, 0, 1.0], (40, 1)))
    with pytest.raises(InputError, match="no free fall"):
        calibrate(still, SCENE)
    with pytest.raises(InputError, match="scene with gravity"):
        calibrate(still, ik.Scene(SCENE.robot, gravity=[0, 0, 0]))
    panda = ik.Robot.from_example("panda")
    recording = Recording(panda, np.arange(40) / 100, np.tile(panda.neutral(), (40, 1)))
    with pytest.raises(InputError, match="no free-flyer"):
        calibrate(recording, ik.Scene(panda, gravity=[0, 0, -9.81]))


def test_intervals_are_wider_for_few_recordings():
    found = calibrate(throws(np.random.default_rng(4), 5, sigma=1e-3), SCENE)
    low, high = found.intervals()["length_scale"]
    # Student's quantile of four degrees of freedom.
    assert high - low == pytest.approx(2 * 2.776445 * found.sigma["length_scale"])
    assert found.recordings == 5 and low < 1.0 < high
    ends = found.intervals(0.5)
    assert np.isnan(ends["floor_height"]).all() and ends["gravity_tilt"].shape == (2, 2)
    with pytest.raises(RangeError, match="level"):
        found.intervals(1.0)


def test_bodies_that_fall_another_way_are_told():
    turn = pin.SE3(pin.exp3(np.array([-np.pi / 2, 0, 0])), np.zeros(3))
    turned = []
    for each in throws(np.random.default_rng(5), 3):
        q = np.array([pin.SE3ToXYZQUAT(turn * pin.XYZQUATToSE3(np.array(row))) for row in each.q])
        turned.append(Recording(SCENE.robot, each.t, q))
    with pytest.raises(
        InputError, match=r"fall along -y of the recordings, .* \[0.0, 0.0, -9.81\]"
    ):
        calibrate(turned, SCENE)


def test_two_free_bodies_are_moved_alike_and_keep_their_geometry():
    ball = SCENE.robot
    two = ik.combine(a=ball, b=ball)
    hit = ik.Collision("a/ball", "b/ball", restitution=0.7, friction=0.1, name="hit")
    scene = ik.Scene(two, contacts=[hit], gravity=[0, 0, -9.81])
    rng, scale, several = np.random.default_rng(6), 0.97, []
    for _ in range(4):
        t, first = flying_body(rng, scale=scale)
        _, second = flying_body(rng, scale=scale)
        several.append(Recording(two, t, np.hstack([first, second])))
    found = calibrate(several, scene)
    assert found.length_scale == pytest.approx(scale, abs=1e-4)
    # Two offsets cannot be told from one mass centre of both.
    assert np.isinf(found.sigma["mass_centre"]).all()
    level, given = found.apply(several[0]).q, several[0].q
    for at in (slice(0, 3), slice(7, 10)):
        assert level[:, at] == pytest.approx(given[:, at] / found.length_scale)
    moved = _with_mass_centre(scene, np.array([1e-3, 0, 0]))
    assert len(moved.robot.collision_model.geometryObjects) == 2
    assert moved.robot.mass == pytest.approx(two.mass)
