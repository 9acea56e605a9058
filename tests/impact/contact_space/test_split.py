"""Where load can be shared in many ways: one split, whatever the axes."""

import numpy as np

from impulsekit import Status
from impulsekit.impact.contact_law import ContactProblem, solve_contacts
from impulsekit.laws.least_shares import least_holding, least_split
from impulsekit.laws.modes import residual_of
from impulsekit.scene.law import Law

from .posed import posed, solved_phase

POISSON = Law(restitution="poisson")


def problem(rng):
    """Contacts between parts with fewer motions than contacts have rows, all sizes of levers."""
    n = int(rng.integers(1, 6))
    dof = int(rng.integers(1, min(3 * n, 7)))
    J, v = rng.normal(size=(3 * n, dof)), rng.normal(size=dof)
    J *= np.repeat(10.0 ** rng.uniform(-1.5, 1.5, n), 3)[:, None]
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


def test_where_a_release_sticks_it_has_an_answer_under_every_axes():
    # A rod on a hinge strikes a wall that holds it: one motion, three rows.
    rng = np.random.default_rng(0)
    for _ in range(100):
        row = rng.normal(size=(3, 1))
        W, u = row @ row.T, row[:, 0] * -np.sign(row[2, 0])
        mu, e = np.array([2.0 * np.hypot(*row[:2, 0]) / abs(row[2, 0])]), np.array([0.5])
        status, _ = solved(W, u, mu, e, POISSON, turned(rng, 1))
        assert status is not Status.NO_SOLUTION


def test_one_contact_of_one_motion_rubs_no_more_than_it_must():
    # r·P = c, |P_t| ≤ µ P_n: the nearest P is along r, or on the edge of the cone beside it.
    rng = np.random.default_rng(4)
    for _ in range(50):
        row = rng.normal(size=3) * [1, 1, np.sign(rng.normal())]
        slope = np.hypot(*row[:2])
        mu = (slope / abs(row[2])) * rng.uniform(0.1, 3.0) + (row[2] < 0.0) * 2.0 * slope
        along = np.array([*(row[:2] / slope), 0.0])
        edge = mu * along + [0.0, 0.0, 1.0]
        if not row @ edge > 0.1:
            continue
        inside = slope <= mu * row[2]
        want = row / (row @ row) if inside else edge / (row @ edge)
        given = posed(np.outer(row, row), -row, mu)
        least_holding(*given)
        assert np.abs(given[0].P - want).max() < 1e-13 * np.abs(want).max()
        # Any other share within the cone leads there as well.
        given = posed(np.outer(row, row), -row, mu, edge / (row @ edge))
        least_split(*given)
        assert np.abs(given[0].P - want).max() < 1e-13 * np.abs(want).max()


def test_no_other_share_is_less():
    # Convex: from the least, no step towards another lawful share lessens Σ w |P|².
    rng = np.random.default_rng(5)
    compared = 0
    for _ in range(40):
        W, u, mu, _ = problem(rng)
        given = posed(W, u, mu)
        if least_holding(*given) > 1e-13:
            continue
        least = given[0].P
        null = np.linalg.svd(W)[2][np.linalg.matrix_rank(W, hermitian=True, tol=1e-9 * W.max()) :]
        w = np.repeat(W.diagonal().reshape(-1, 3).sum(axis=1), 3)
        for _ in range(200):
            other = least + 10.0 ** rng.uniform(-4, 1) * null.T @ rng.normal(size=len(null))
            share = other.reshape(-1, 3)
            if (np.hypot(share[:, 0], share[:, 1]) <= mu * share[:, 2]).all():
                compared += 1
                slope = (w * least) @ (other - least)
                assert slope > -1e-10 * ((w * least) @ least)
    assert compared > 100


def test_redundant_contacts_hold_wherever_one_share_of_the_load_can():
    # P within the cones, and a motion that it stops: what nothing needs to slip for stops.
    rng = np.random.default_rng(6)
    for _ in range(60):
        n = int(rng.integers(2, 6))
        J = rng.normal(size=(3 * n, int(rng.integers(1, 4))))
        mu = rng.uniform(0.3, 1.0, n)
        P = rng.normal(size=(n, 3))
        P[:, 2] = np.hypot(P[:, 0], P[:, 1]) / mu * rng.uniform(1.0, 2.0, n)
        W, u = J @ J.T, -J @ J.T @ P.ravel()
        basis = turned(rng, n)
        _, impulse = solved_phase(basis @ W @ basis.T, basis @ u, basis[2::3, 2::3] @ mu)
        after = W @ basis.T @ impulse + u
        assert np.abs(after).max() < 1e-12 * np.abs(u).max()


def test_contacts_that_nothing_moves_leave_nothing():
    # Compiled code does not warn of 0/0, nor does Python in its place.
    with np.errstate(all="ignore"):
        assert residual_of(*posed(np.zeros((3, 3)), np.zeros(3), 0.5, [0.1, 0.0, 1.0])) == 0.0
    for speed, status in ((0.0, Status.SOLVED), (-1.0, Status.NO_SOLUTION)):
        found, impulse = solved_phase(np.zeros((6, 6)), np.array([0, 1, speed] * 2), np.ones(2))
        assert found is status and not impulse.any()
