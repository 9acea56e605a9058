"""Impacts along their path against closed planar solutions, quadrature and slip at the end."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from impulsekit.laws.status import Status
from impulsekit.scene.law import Law
from tests.truths.numbers import truth_numbers
from tests.truths.slip import followed

from .problems import block, planar_velocity, rod, solved

PATHS = [Law(restitution, "path") for restitution in ("newton", "poisson", "stronge")]
every_path = pytest.mark.parametrize("law", PATHS, ids=lambda law: law.restitution)


@given(st.integers(0, 10**6), st.floats(0.05, 1), st.floats(0.05, 2))
@settings(max_examples=150, deadline=None)
def test_closed_planar_solutions(seed, e, mu):
    rng = np.random.default_rng(seed)
    W = rod(rng.uniform(0.1, 1.5), rng.uniform(0.1, 5))
    u = np.array([rng.normal(), 0.0, -rng.uniform(0.1, 2)])
    plane = [0, 2]
    for law in PATHS:
        answer = solved(W, u, e, mu, law=law)
        truth = planar_velocity(W, u, e, mu, law.restitution)
        np.testing.assert_allclose(
            answer.velocity_after[plane], truth, atol=1e-10 * np.abs(u).max()
        )


@pytest.mark.slow
@pytest.mark.parametrize("seed", [3, 4, 7])
def test_turning_slip_against_quadrature(seed):
    rng, numbers = np.random.default_rng(seed), truth_numbers()
    while True:
        W, u = block(rng, 5), rng.normal(size=3)
        u[2] = -abs(u[2]) - 0.2
        mu, e = rng.uniform(0.3, 1.0), rng.uniform(0.2, 0.9)
        k = np.linalg.solve(W[:2, :2], W[:2, 2])
        if np.hypot(*k) < mu and np.linalg.cond(W) < 200:
            break
    exact = [numbers.array(W), numbers.array(u), numbers.number(e), numbers.number(mu)]
    for law in PATHS:
        answer = solved(W, u, e, mu, law=law)
        assert answer.status.valid or answer.status is Status.ENERGY_GAIN
        truth = followed(numbers, *exact, law.restitution).astype(float)
        np.testing.assert_allclose(answer.impulse, truth, atol=1e-12 * truth[2])


@given(st.integers(0, 10**6), st.floats(0, 1), st.floats(0.01, 2))
@settings(max_examples=200, deadline=None)
def test_both_slips_agree_where_the_direction_cannot_change(seed, e, mu):
    """Isotropic W_tt and w along the slip, which does not stop before the end."""
    rng = np.random.default_rng(seed)
    angle, w, t, nn = rng.uniform(0, 7), rng.uniform(-0.9, 0.9), rng.uniform(1, 4), 1.0
    s = np.array([np.cos(angle), np.sin(angle)])
    W = np.diag([t, t, nn])
    W[:2, 2] = W[2, :2] = w * s
    u = np.r_[rng.uniform(0.1, 9) * s, -1.0]
    end = solved(W, u, e, mu)
    if end.status is not Status.SOLVED or s @ end.velocity_after[:2] <= 1e-9:
        return
    path = solved(W, u, e, mu, law=PATHS[0])
    np.testing.assert_allclose(path.impulse, end.impulse, atol=1e-10 * end.impulse[2])


@every_path
def test_all_are_one_for_a_central_blow_without_friction(law):
    answer = solved(np.diag([1.0, 1, 0.5]), [3.0, -2, -1], 0.6, law=law)
    np.testing.assert_allclose(answer.impulse, [0, 0, 3.2], atol=1e-14)


@every_path
def test_slip_starts_again_in_the_direction_that_keeps(law):
    """W_tn too large for friction to hold: from rest, slip goes one way and stays there."""
    W = np.array([[1.0, 0.2, 0.5], [0.2, 2.0, -0.6], [0.5, -0.6, 1.0]])
    answer = solved(W, [0, 0, -1.0], 0.5, 0.05, law=law)
    slip, P = answer.velocity_after[:2], answer.impulse
    np.testing.assert_allclose(P[:2], -0.05 * P[2] * slip / np.hypot(*slip), atol=1e-12)
    # The same as at the end, as the direction never changed.
    if law.restitution == "newton":
        np.testing.assert_allclose(P, solved(W, [0, 0, -1.0], 0.5, 0.05).impulse, atol=1e-11)


@given(st.integers(0, 10**6), st.floats(0, 1), st.floats(0, 1.5))
@settings(max_examples=60, deadline=None)
def test_strongs_energy_never_rises(seed, e, mu):
    rng = np.random.default_rng(seed)
    W, u = block(rng, 6), rng.normal(size=3)
    u[2] = -abs(u[2]) - 1e-3
    answer = solved(W, u, e, mu, law=PATHS[2])
    assert answer.status.valid
    rounding = 1e-14 * np.abs(answer.impulse).max() * np.abs(u).max()
    assert answer.normal_work[0] <= rounding and answer.friction_work[0] <= rounding


@every_path
def test_one_after_the_other(law):
    """Two spheres that know nothing of each other, in sequence and each alone."""
    W = np.kron(np.eye(2), np.diag([3.5, 3.5, 1.0]))
    u = np.array([1.0, 0, -1, 0, 1, -2])
    both = solved(W, u, 0.2, 0.3, law=Law(law.restitution, "path", "sequential"))
    for i in (0, 1):
        own = slice(3 * i, 3 * i + 3)
        alone = solved(W[own, own], u[own], 0.2, 0.3, law=law)
        np.testing.assert_allclose(both.impulse[own], alone.impulse, atol=1e-15)
    assert both.iterations == 2 and both.status is Status.SOLVED


@every_path
@pytest.mark.parametrize("seed", range(20))
def test_what_friction_holds_wholly_has_no_work_to_give_back(law, seed):
    """With two degrees of freedom rest of the slip is rest of all: no impulse lifts it off."""
    rng = np.random.default_rng(seed)
    rows = rng.normal(size=(3, 2))
    W, u = rows @ rows.T, rows @ rng.normal(size=2)
    u *= -np.sign(u[2])
    answer = solved(W, u, 1.0, 20.0, law=law)
    assert answer.status in (Status.SOLVED, Status.SOLVED, Status.NO_SOLUTION) or (
        answer.status is Status.ENERGY_GAIN and law.restitution == "newton"
    )
    assert np.abs(W @ answer.impulse).max() < 50 * np.abs(u).max()
