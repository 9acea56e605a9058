"""Several contacts at once: every answer of the law is held against enumeration or fractions."""

from fractions import Fraction

import numpy as np
import pytest

from impulsekit.laws.at_once import Struck, hit_contacts
from impulsekit.laws.status import Status
from impulsekit.laws.words import AGAIN, NEWTON, POISSON
from tests.lawful import enumerated_normals, left_of_coulomb


def strike(W, before, mu, e, restitution=NEWTON, e_t=0.0):
    n = len(before) // 3
    mu, e, e_t = (np.full(n, float(c)) for c in (mu, e, e_t))
    return Struck(*hit_contacts.py_func(W, before, before.copy(), mu, e, e_t, restitution))


def problem(rng, n, spare=3):
    """W of rows drawn at random, and velocities at which most contacts approach."""
    J = rng.normal(size=(3 * n, 3 * n + spare))
    before = rng.normal(size=3 * n)
    before[2::3] -= 1.0
    return J @ J.T, before


def exact_velocity(W, P, free):
    """W P + u in fractions, as floats."""
    P = [Fraction(x) for x in P.tolist()]
    return np.array(
        [
            float(sum(Fraction(w) * p for w, p in zip(row, P, strict=True)) + Fraction(u))
            for row, u in zip(W.tolist(), free.tolist(), strict=True)
        ]
    )


@pytest.mark.parametrize("seed", range(40))
def test_contacts_without_friction_push_as_the_one_set_that_can(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 6))
    W, before = problem(rng, n)
    code, residual, P, after, *_ = strike(W, before, 0.0, 0.3)
    assert residual < 1e-12
    assert code == Status.SOLVED
    b = before[2::3] + 0.3 * np.minimum(before[2::3], 0.0)
    pushing = enumerated_normals(W[2::3, 2::3], b)
    np.testing.assert_allclose(P[2::3], pushing, atol=1e-12 * (1.0 + pushing.max()))
    np.testing.assert_allclose(after, exact_velocity(W, P, before), atol=1e-12)


@pytest.mark.parametrize("seed", range(40))
def test_what_the_law_answers_obeys_coulomb_in_fractions(seed):
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, 5))
    mu, e = rng.choice([0.05, 0.3, 1.0]), rng.choice([0.0, 0.5])
    W, before = problem(rng, n)
    code, _, P, after, normal, friction, _ = strike(W, before, mu, e)
    assert code in (Status.SOLVED, Status.ENERGY_GAIN)
    xi = exact_velocity(W, P, before)
    np.testing.assert_allclose(after, xi, atol=1e-12 * np.abs(W).max())
    work = 0.5 * P * (before + xi)
    np.testing.assert_allclose(normal, work[2::3], atol=1e-12)
    np.testing.assert_allclose(friction, work[0::3] + work[1::3], atol=1e-12)
    xi[2::3] += e * np.minimum(before[2::3], 0.0)
    assert left_of_coulomb(xi, P, np.full(n, mu), np.abs(before).max()) < 1e-12


def test_regular_contacts_are_hardly_ever_left():
    rng = np.random.default_rng(1)
    codes = []
    for _ in range(60):
        W, before = problem(rng, 3)
        codes.append(strike(W, before, 0.5, 0.5, POISSON)[0])
        codes.append(strike(W, before, 0.5, 0.5)[0])
    assert codes.count(AGAIN) <= 3


def test_equal_balls_side_by_side_bounce_each_by_itself():
    """Nothing couples them: P_n = (1 + e) m |u_n| under either restitution."""
    W = np.kron(np.eye(2), np.diag([3.5, 3.5, 1.0]) / 2.0)
    before = np.array([0.1, 0.0, -1.0, 0.0, 0.2, -3.0])
    for restitution in (NEWTON, POISSON):
        code, _, P, after, *_ = strike(W, before, 2.0, 0.5, restitution)
        assert code == Status.SOLVED
        np.testing.assert_allclose(P[2::3], [3.0, 9.0], rtol=1e-14)
        np.testing.assert_allclose(after, [0, 0, 0.5, 0, 0, 1.5], atol=1e-14)


def test_impulses_beyond_what_doubles_hold_are_no_answer():
    """A W of all but nothing would need P that overflows."""
    W = np.kron(np.array([[1.0, 1.0], [1.0, 1.0]]), np.diag([1.0, 1.0, 1.0])) * 1e-308
    with np.errstate(all="ignore"):
        code, _, P, *_ = strike(W, np.array([0.0, 0.0, -1e10, 1.0, 0.0, -2e10]), 0.5, 0.0)
    assert code == AGAIN or np.isfinite(P).all()


def test_rounding_of_dependent_rows_does_not_choose_between_two_answers():
    """The last contact parts unless friction wedges it, and it has two motions for three rows.

    It is held still, as the rule says, whatever the last digits of W are.
    """
    J = np.zeros((9, 6))
    J[0, [0, 1, 3]] = -0.625, 0.281, 3.397
    J[1, [0, 1, 3, 4]] = -0.127, 0.811, 0.268, 2.579
    J[2, [0, 1, 3, 4, 5]] = 0.934, -1.333, -0.263, -0.906, 2.052
    J[5, [2, 5]] = -13.939, 1.0
    J[6:, :2] = (16.809, 0.0), (-4.65, 4.857), (6.413, -3.411)
    free = np.array([-0.005, 1.239, 1.89, 0.0, 0.0, -0.236, *(J[6:, :2] @ (0.0409, -0.0861))])
    mu, e = np.array([1.5, 0.0, 1.5]), np.array([1.0, 1.0, 0.0])
    rng = np.random.default_rng(84)
    W = J @ J.T
    wedged = None
    for _ in range(40):
        noise = rng.normal(size=W.shape)
        near = W * (1.0 + 2e-15 * (noise + noise.T))
        hit = Struck(*hit_contacts(near, free, free, mu, e, np.zeros(3), NEWTON))
        assert hit.impulse[8] > 0.0
        wedged = hit.after if wedged is None else wedged
        np.testing.assert_allclose(hit.after, wedged, atol=1e-13)
        np.testing.assert_allclose(hit.after[6:], 0.0, atol=1e-13)
