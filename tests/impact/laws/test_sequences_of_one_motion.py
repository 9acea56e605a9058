"""Contacts between parts with one relative motion, struck in turn: rounding strikes nobody."""

import numpy as np
import pytest

from impulsekit import Status
from impulsekit.impact.laws import ContactProblem, solve_contacts
from impulsekit.scene.law import Law

from .test_split import turned


@pytest.mark.parametrize("restitution", ["newton", "poisson"])
def test_what_a_hit_leaves_is_no_approach_whatever_the_axes(restitution):
    # One contact sticks, as µ is large: after its only hit it stands still, or comes back.
    law = Law(restitution=restitution, order="sequential")
    rng = np.random.default_rng(0)
    for _ in range(400):
        row = rng.normal(size=3)
        W = np.outer(row, row) * 10.0 ** rng.uniform(-3, 3)
        u = row * -np.sign(row[2]) * 10.0 ** rng.uniform(-3, 3)
        mu = np.array([1.1 * np.hypot(row[0], row[1]) / abs(row[2])])
        basis = np.kron(np.eye(2), turned(rng, 1))
        # A second contact of the same parts, seen from the other side: it parts with the first.
        both = np.kron([[1.0, -1.0], [-1.0, 1.0]], W)
        before = np.concatenate([u, -u])
        problem = ContactProblem(
            basis @ both @ basis.T, basis @ before, basis @ before, np.zeros(2),
            np.repeat(mu, 2), np.zeros(2),
        )  # fmt: skip
        found = solve_contacts(problem, law)
        assert found.status in (Status.SOLVED, Status.NOT_UNIQUE)
        np.testing.assert_allclose(found.velocity_after, 0.0, atol=1e-12 * np.abs(u).max())


def test_equally_fast_contacts_are_hit_in_the_order_of_the_entries_whatever_the_axes():
    # Of one motion all paces are the same: rounding does not say which is hit.
    rng = np.random.default_rng(1)
    law = Law(restitution="newton", order="sequential")
    for _ in range(200):
        rows = rng.normal(size=(9, 1))
        W, u = rows @ rows.T, rows[:, 0] * rng.normal()
        e, mu = rng.uniform(0.0, 0.9, 3), np.zeros(3)
        answers = []
        for turn in (np.eye(9), *(np.kron(np.eye(3), np.eye(3)) for _ in range(3))):
            for i in range(3):
                turn[3 * i : 3 * i + 3, 3 * i : 3 * i + 3] = turned(rng, 1)
            scale = 10.0 ** rng.uniform(-3, 3)
            problem = ContactProblem(
                scale * turn @ W @ turn.T, turn @ u, turn @ u, e, mu, np.zeros(3)
            )
            answers.append(solve_contacts(problem, law).velocity_after[2::3])
        size = np.abs(u).max()
        np.testing.assert_allclose(answers[1:], [answers[0]] * 3, rtol=0, atol=1e-11 * size)
