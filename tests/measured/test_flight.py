"""Flights: invariants of free bodies, order of the rule, fits with the covariance they say."""

import numpy as np
import pinocchio as pin
import pytest

import impulsekit as ik
from impulsekit.measured.flight import Flight

BOX = ik.Robot.from_urdf("models/box.urdf", root="freeflyer")
SCENE = ik.Scene(BOX, gravity=[0, 0, -9.81])


def state(seed):
    rng = np.random.default_rng(seed)
    q = np.r_[rng.normal(size=3), rng.normal(size=4)]
    q[3:] /= np.linalg.norm(q[3:])
    return q, np.r_[rng.normal(size=3), 5.0 * rng.normal(size=3)]


def invariants(q, v):
    """Angular momentum about the mass centre in the world, and what a throw keeps."""
    turn = pin.Quaternion(np.array(q[3:])).matrix()
    return turn @ (BOX.model.inertias[1].inertia @ v[3:]), turn @ v[:3]


def test_a_free_body_keeps_its_angular_momentum_and_falls_as_a_stone():
    flight, (q, v) = Flight(SCENE), state(0)
    before, speed = invariants(q, v)
    end, late = flight.step(0.0, q, v, 0.3)
    after, fast = invariants(end, late)
    assert np.abs(after - before).max() < 2e-6 * np.linalg.norm(before)
    assert fast == pytest.approx(speed - np.array([0, 0, 9.81 * 0.3]), abs=5e-6)
    fallen = q[:3] + 0.3 * speed + [0, 0, -0.5 * 9.81 * 0.09]
    assert end[:3] == pytest.approx(fallen, abs=1e-5)


def test_the_rule_has_order_four(monkeypatch):
    monkeypatch.setattr("impulsekit.measured.flight.LONGEST_TURN", np.inf)
    flight, (q, v) = Flight(SCENE), state(1)

    def followed(steps):
        here, speed = q, v
        for _ in range(steps):
            here, speed = flight.step(0.0, here, speed, 0.1 / steps)
        return here, speed

    truth = followed(160)
    errors = [
        np.abs(pin.difference(BOX.model, followed(n)[0], truth[0])).max() for n in (5, 10, 20)
    ]
    assert 3.7 < np.log2(errors[0] / errors[1]) < 4.5
    assert 3.7 < np.log2(errors[1] / errors[2]) < 4.5


def test_a_fit_is_as_far_off_as_its_covariance_says():
    flight, (q, v) = Flight(SCENE), state(2)
    t = np.arange(9) / 148
    path = flight.path(0.03, q, v, t)
    sigma = np.array([1e-3] * 3 + [5e-3] * 3)
    rng = np.random.default_rng(3)
    scores = []
    for _ in range(60):
        seen = np.array([pin.integrate(BOX.model, x, sigma * rng.normal(size=6)) for x in path])
        guess = pin.integrate(BOX.model, q, 0.02 * rng.normal(size=6))
        fit = flight.fit(t, seen, 0.03, guess, v + 0.3 * rng.normal(size=6), sigma)
        apart = np.r_[pin.difference(BOX.model, q, fit.q), fit.v - v]
        scores.append(apart / (np.repeat(np.sqrt(np.diag(fit.share)), 6) * np.tile(sigma, 2)))
    # 720 numbers of a normal distribution, but for a body's turn over the samples.
    assert np.mean(np.square(scores)) == pytest.approx(1.0, abs=0.2)
    assert np.abs(np.mean(scores)) < 0.15
