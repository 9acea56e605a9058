"""Poisson's law where load can be shared in many ways: one split, whatever the axes."""

import numpy as np
import pytest

from impulsekit import Status
from impulsekit.impact.laws import ContactProblem, solve_contacts
from impulsekit.scene.law import Law

POISSON = Law(restitution="poisson")


def problem(rng):
    """One or two contacts between parts with fewer motions than contacts have rows."""
    n, dof = int(rng.integers(1, 3)), int(rng.integers(1, 4))
    J, v = rng.normal(size=(3 * n, dof)), rng.normal(size=dof)
    mu, e = rng.choice([0.2, 0.6, 1.0, 2.0], n), rng.choice([0.0, 0.3, 0.7, 1.0], n)
    return J @ J.T, J @ v, mu, e


def turned(rng, n):
    """(3n, 3n) tangents turned and mirrored, contacts in another order."""
    basis = np.zeros((3 * n, 3 * n))
    for place, i in enumerate(rng.permutation(n)):
        c, s = np.cos(angle := rng.uniform(0, 7)), np.sin(angle)
        basis[3 * place : 3 * place + 2, 3 * i : 3 * i + 2] = [[c, -s], [s, c]] @ np.diag(
            [1, rng.choice([-1, 1])]
        )
        basis[3 * place + 2, 3 * i + 2] = 1.0
    return basis


def solved(W, u, mu, e, law, basis, unit=1.0):
    owner = basis[2::3, 2::3]
    one = ContactProblem(
        basis @ W @ basis.T * unit, basis @ u, basis @ u, owner @ e, owner @ mu, 0 * mu
    )
    answer = solve_contacts(one, law)
    return answer.status, basis.T @ answer.velocity_after


@pytest.mark.parametrize("seed", range(8))
def test_poissons_answer_knows_no_axes_units_or_order(seed):
    rng = np.random.default_rng(seed)
    for _ in range(12):
        W, u, mu, e = problem(rng)
        status, after = solved(W, u, mu, e, POISSON, np.eye(len(u)))
        for unit in (1.0, 1e-3, 1e3):
            again, other = solved(W, u, mu, e, POISSON, turned(rng, len(mu)), unit)
            valid = (Status.SOLVED, Status.NOT_UNIQUE)
            if Status.MANY_SOLUTIONS in (again, status):
                # Several v⁺ of one phase: not what this is about.
                continue
            assert again is status or {again, status} == set(valid)
            if status in valid:
                assert np.abs(other - after).max() < 1e-6 * np.abs(u).max()


def test_where_a_release_sticks_it_has_an_answer_under_every_axes():
    # A rod on a hinge strikes a wall that holds it: one motion, three rows.
    rng = np.random.default_rng(0)
    for _ in range(100):
        row = rng.normal(size=(3, 1))
        W, u = row @ row.T, row[:, 0] * -np.sign(row[2, 0])
        mu, e = np.array([2.0 * np.hypot(*row[:2, 0]) / abs(row[2, 0])]), np.array([0.5])
        status, _ = solved(W, u, mu, e, POISSON, turned(rng, 1))
        assert status is not Status.NO_SOLUTION


def test_slip_in_a_plane_goes_one_way_or_the_other_under_every_axes():
    rng = np.random.default_rng(3)
    for _ in range(60):
        row = rng.normal(size=(3, 1))
        W, u = row @ row.T, row[:, 0] * rng.normal()
        mu, e = rng.choice([0.2, 0.6, 1.0, 2.0], 1), rng.choice([0.0, 0.7, 1.0], 1)
        first, _ = solved(W, u, mu, e, Law(), np.eye(3))
        for _ in range(3):
            assert solved(W, u, mu, e, Law(), turned(rng, 1))[0] is first
