"""Contacts between parts with one relative motion, struck in turn: rounding strikes nobody."""

import numpy as np
import pytest

from impulsekit import Status
from impulsekit.impact.contact_law import ContactProblem, solve_contacts
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
        assert found.status in (Status.SOLVED, Status.SOLVED)
        np.testing.assert_allclose(found.velocity_after, 0.0, atol=1e-12 * np.abs(u).max())
