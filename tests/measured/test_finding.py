"""Impacts found in recordings whose times, states and contacts are known."""

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.errors import InputError, RangeError, ShapeError
from impulsekit.measured import Recording, find_impacts
from tests.measured.bodies import G, ball_scene, bouncing_ball, noisy

SIGMA = np.array([3e-4] * 3 + [3e-3] * 3)


@pytest.fixture(scope="module")
def found():
    """Six balls that bounce, noisy, and all that was found."""
    scene, rng = ball_scene(0.7), np.random.default_rng(0)
    pairs = [
        bouncing_ball(scene, 0.3 + 0.05 * k, 0.7, 150, 0.85, SIGMA, rng, name=str(k))
        for k in range(6)
    ]
    return scene, pairs, find_impacts([recording for recording, _ in pairs], scene)


def test_states_and_times_are_as_far_off_as_the_covariance_says(found):
    _, pairs, impacts = found
    scores, of_time = [], []
    for each in impacts.impacts:
        truth = pairs[int(each.recording)][1]
        k = int(np.abs(truth - each.time).argmin())
        fall = np.sqrt(2 * G * (0.3 + 0.05 * int(each.recording)))
        of_time.append((each.time - truth[k]) / each.time_sigma)
        sigma = np.sqrt(np.diag(each.covariance))
        for value, deviation, true in (
            (each.v_before[2], sigma[8], -fall * 0.7**k),
            (each.v_after[2], sigma[14], fall * 0.7 ** (k + 1)),
        ):
            scores.append((value - true) / deviation)
    assert 0.6 < np.std(scores) < 1.5 and 0.5 < np.std(of_time) < 1.6


def test_contacts_noise_and_momentum(found):
    _, _, impacts = found
    assert all(each.contacts == ("floor",) for each in impacts.impacts)
    assert impacts.sigma == pytest.approx(SIGMA, rel=0.25)
    balances = np.array([each.balance for each in impacts.impacts])
    assert (balances > 0.05).mean() > 0.8 and len(impacts.balanced()) == len(impacts)


def test_a_jump_that_no_contact_explains_fails_the_balance(found):
    scene, _, _ = found
    recording, _ = bouncing_ball(scene, 0.4, 0.7, 150, 0.5, SIGMA, np.random.default_rng(1))
    # A floor to its side cannot turn a ball about the vertical through its contact point.
    q = recording.q.copy()
    angle = recording.t + 12.0 * np.clip(recording.t - np.sqrt(0.8 / G), 0.0, None)
    q[:, 3:] = np.stack([0 * angle, 0 * angle, np.sin(0.5 * angle), np.cos(0.5 * angle)], 1)
    q = noisy(scene.robot.model, q, 0.1 * SIGMA, np.random.default_rng(4))
    spun = find_impacts(Recording(scene.robot, recording.t, q), scene, sigma=SIGMA)
    assert spun.impacts[0].balance < 1e-6 and len(spun.balanced()) == 0


def test_samples_that_stand_apart_are_named_and_do_not_count(found):
    scene, _, _ = found
    recording, truth = bouncing_ball(scene, 0.5, 0.7, 150, 0.8, SIGMA, np.random.default_rng(2))
    q = recording.q.copy()
    wrong = [8, 30, 62, 90]
    q[wrong, 0] += 0.05
    impacts = find_impacts(Recording(scene.robot, recording.t, q), scene)
    times = [time for _, time in impacts.outliers]
    assert times == pytest.approx(recording.t[wrong])
    assert [i.time for i in impacts.impacts] == pytest.approx(truth[truth < 0.8], abs=0.5 / 150)


def test_rests_and_rolls_are_no_impacts():
    scene, rng = ball_scene(), np.random.default_rng(3)
    t = np.arange(120) / 150
    q = np.tile([0, 0, 0.05, 0, 0, 0, 1.0], (120, 1))
    q[:, 0] = 0.8 * t - 0.4 * t**2
    q = noisy(scene.robot.model, q, SIGMA, rng)
    assert len(find_impacts(Recording(scene.robot, t, q), scene, sigma=SIGMA)) == 0


def test_what_is_given_wrongly_is_said(found):
    scene, pairs, _ = found
    recording = pairs[0][0]
    with pytest.raises(InputError, match="no recordings"):
        find_impacts([], scene)
    with pytest.raises(InputError, match="another robot"):
        find_impacts(recording, ik.Scene(ik.Robot.from_example("panda")))
    with pytest.raises(RangeError, match="sigma"):
        find_impacts(recording, scene, sigma=-1.0)
    with pytest.raises(ShapeError, match="sigma"):
        find_impacts(recording, scene, sigma=[1.0, 2.0])
    with pytest.raises(InputError, match="too short"):
        find_impacts(recording.part(0.0, 0.02), scene)


@pytest.mark.parametrize("change", ["twice", "pause"])
def test_times_that_no_flight_can_be_followed_through_are_refused(change):
    t, q = np.arange(40) * 0.01, np.zeros((40, 7))
    q[:, 2], q[:, 6] = 0.5 + 0.2 * t - 0.5 * G * t**2, 1.0
    if change == "twice":
        t[20] = t[19]
    else:
        t[20:] += 1e4
    scene = ball_scene()
    with pytest.raises(RangeError, match=r"t\[\d+\] - t\[\d+\] must be"):
        find_impacts(Recording(scene.robot, t, q), scene, sigma=1e-4)


@pytest.mark.parametrize(("factor", "unit"), [(1e3, "ms"), (1e6, "us or ns"), (1e9, "ns")])
def test_times_in_another_unit_are_named(factor, unit):
    scene = ball_scene()
    ball, _ = bouncing_ball(scene, 0.5, 0.6, 100, 0.6)
    late = Recording(scene.robot, factor * ball.t, ball.q)
    with pytest.raises(RangeError, match=f"times look like {unit}; state time="):
        find_impacts(late, scene)
