"""Peak forces of many states: as those of single ones, which closed forms hold."""

import math

import numpy as np
import pytest

import impulsekit as ik
from impulsekit.compliance import Hertz, HuntCrossley, MeasuredCurve, force_history, peak_forces

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")
MASS = float(BALL.model.inertias[1].mass)
RUBBER = Hertz(E=1e7, nu=0.5, radius=0.1)
FLOOR = ik.Contact("ball", at=[0, 0, -0.1], restitution=0.7, friction=0.3, name="floor")


def scene_of(*contacts, **more):
    return ik.Scene(BALL, contacts=contacts, gap_bound=np.inf, **more)


@pytest.mark.parametrize(
    "curve", [RUBBER, HuntCrossley(2e6), MeasuredCurve([0, 1e-3, 4e-3, 0.04], [0, 90, 80, 6e4])]
)
def test_rows_are_those_of_single_states(curve):
    rng = np.random.default_rng(3)
    v = rng.normal(size=(12, 6))
    v[3] = 0.0
    scene = scene_of(FLOOR)
    found = peak_forces(scene, BALL.neutral(), v, curve)
    assert found.contact == "floor"
    struck = 0
    for i in range(12):
        impact = ik.solve(scene, BALL.neutral(), v[i])
        assert found.status[i] == impact.status
        names = ("peak_force", "indentation", "impulse", "stored", "lost")
        row = [getattr(found, name)[i] for name in names]
        if not impact.contacts[0].impulse.any():
            assert row == [0.0] * 5
            continue
        struck += 1
        one = force_history(impact, curve)
        assert row == pytest.approx([getattr(one, name) for name in names], rel=1e-11)
    assert 3 <= struck < 12


def test_a_ball_on_a_spring():
    """F = c √(k m) without losses, whatever the speed and its spin."""
    v = np.zeros((5, 6))
    v[:, 2], v[:, 3] = -np.arange(1.0, 6.0), 2.0
    line = MeasuredCurve([0, 10.0], [0, 4e6])
    contact = ik.Contact("ball", at=[0, 0, -0.1], restitution=1.0)
    found = peak_forces(scene_of(contact), BALL.neutral(), v, line)
    assert found.peak_force == pytest.approx(np.arange(1, 6) * math.sqrt(4e5 * MASS), rel=1e-12)
    assert np.abs(found.lost).max() < 1e-13
    assert not found.peak_force.flags.writeable
    e = np.array([[0.9], [0.5], [0.1], [0.0], [1.0]])
    lossy = peak_forces(scene_of(contact), BALL.neutral(), v, line, restitution=e)
    assert lossy.lost == pytest.approx((1 - e[:, 0] ** 2) * lossy.stored, rel=1e-9, abs=1e-12)


def test_a_bad_row_is_marked_and_stops_none():
    v = np.zeros((3, 6))
    v[:, 2] = -1.0
    v[1, 0] = np.nan
    found = peak_forces(scene_of(FLOOR), BALL.neutral(), v, RUBBER)
    assert np.isnan(found.peak_force).tolist() == [False, True, False]
