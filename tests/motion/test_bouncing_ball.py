"""A ball dropped from 1 m, e = 0.9: infinitely many bounces in 8.578949178729 s, then rest."""

import numpy as np
import pytest

import impulsekit as ik

from .models import MODELS

IMPACTS = [0.4515236409857, 1.2642661947600, 1.9957344931569, 2.6540559617141]
REST = 8.578949178729


@pytest.fixture(scope="module")
def motion():
    ball = ik.Robot.from_urdf(MODELS / "ball.urdf", root="freeflyer")
    scene = ik.Scene(ball, contacts=[ik.Contact("ball", restitution=0.9, name="floor")])
    q = ball.configuration(root_joint=[0, 0, 1, 0, 0, 0, 1])
    return ik.simulate(scene, q, ball.velocity(), duration=12.0, samples=2001)


def test_impacts_come_when_they_should(motion):
    times = [time for time, _ in motion.impacts]
    np.testing.assert_allclose(times[:4], IMPACTS, rtol=0, atol=1e-9)
    assert motion.status is ik.MotionStatus.FINISHED


def test_it_comes_to_rest_in_finite_time_and_for_ever(motion):
    (rest,) = motion.rests
    assert rest.contact == "floor"
    assert rest.start == pytest.approx(REST, abs=1e-6)
    assert rest.end == np.inf
    after = motion.t > REST + 1e-6
    assert after.sum() > 500
    assert np.abs(motion.v[after]).max() < 1e-13
    assert np.abs(motion.q[after][:, :3]).max() < 1e-13


def test_it_stays_above_the_floor(motion):
    for t in np.linspace(0.0, 12.0, 5003):
        assert motion.at(t)[0][2] >= -1e-13


def test_energy_falls_by_the_square_of_e_at_each_bounce_and_else_not(motion):
    energy = motion.energy().total
    bounce = np.searchsorted(IMPACTS, motion.t, side="right")
    weight = motion.scene.robot.mass * 9.81
    for k in range(4):
        np.testing.assert_allclose(energy[bounce == k], weight * 0.81**k, rtol=1e-9)


def test_every_impact_is_kept_whole(motion):
    for _, impact in motion.impacts[:20]:
        assert impact.is_valid()
        (contact,) = impact.contacts
        np.testing.assert_allclose(
            contact.velocity_after[2], -0.9 * contact.velocity_before[2], rtol=1e-12
        )
