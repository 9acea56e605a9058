"""Contacts between parts with one relative motion, struck in turn: rounding strikes nobody."""

import numpy as np
import pytest

from impulsekit import Status
from impulsekit.impact.contact_space import ContactProblem, solve_contacts
from impulsekit.impact.contact_space.others import find_others
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


def test_which_of_equally_fast_contacts_is_hit_first_knows_no_axes_units_or_order():
    # Of one motion all paces are the same: neither rounding nor the entries say which is hit.
    rng = np.random.default_rng(1)
    law = Law(restitution="newton", order="sequential")
    for _ in range(100):
        rows = rng.normal(size=(9, 1))
        W, u = rows @ rows.T, rows[:, 0] * rng.normal()
        e, mu = rng.choice([0.0, 0.5, 0.9], 3), rng.choice([0.0, 0.2, 0.6], 3)
        answers = []
        for scale in (1.0, 1e-3, 1e3):
            basis = np.eye(9) if not answers else turned(rng, 3)
            owner = basis[2::3, 2::3]
            problem = ContactProblem(
                scale * basis @ W @ basis.T, basis @ u, basis @ u, owner @ e, owner @ mu,
                np.zeros(3),
            )  # fmt: skip
            found = solve_contacts(problem, law)
            answers.append((found.status.valid, basis.T @ found.velocity_after))
        assert len({valid for valid, _ in answers}) == 1
        size = np.abs(u).max()
        for valid, after in answers[1:]:
            assert not valid or np.abs(after - answers[0][1]).max() < 1e-11 * size


@pytest.mark.parametrize("slip", ["end", "path"])
def test_a_sequence_ends_at_the_rounding_that_its_hits_hand_on(slip):
    # Two contacts of one motion that face each other, e² < 1: their speed dies out.
    law = Law(restitution="poisson", slip=slip, order="sequential")
    rng = np.random.default_rng(2)
    for _ in range(40):
        rows = rng.normal(size=(6, 1))
        rows[2::3] = np.abs(rows[2::3]) * [[1.0], [-1.0]]
        W, u = rows @ rows.T, rows[:, 0] * rng.normal()
        problem = ContactProblem(
            W, u, u, np.array([rng.choice([0.0, 0.7]), 1.0]), np.array([0.0, 0.2]), np.zeros(2)
        )
        found = solve_contacts(problem, law)
        if found.status.valid:
            assert np.abs(found.velocity_after).max() < 1e-11 * np.abs(u).max()
        assert found.status is not Status.SEQUENCE_TOO_LONG


def test_contacts_that_are_alike_are_hit_by_their_order_and_the_other_answer_is_told():
    # A rod of length 2 and inertia 1/3 falls flat on its ends; e = 1: one end, then the other.
    law = Law(order="sequential")
    W = np.zeros((6, 6))
    W[np.ix_([2, 5], [2, 5])] = [[4.0, -2.0], [-2.0, 4.0]]
    u = np.array([0, 0, -1.0, 0, 0, -1.0])
    fair = ContactProblem(W, u, u, np.full(2, 0.5), np.zeros(2), np.zeros(2))
    found = solve_contacts(fair, law)
    told = find_others(fair, law, found)
    assert found.status is Status.SOLVED and told.verdict == "several"
    other = W @ told.impulses[0] + u
    np.testing.assert_allclose(other[[2, 5]], found.velocity_after[[5, 2]], atol=1e-14)
    # Where the ends differ the entries do not matter, and v⁺ is the only one.
    for e in ([0.5, 0.4], [0.4, 0.5]):
        one = ContactProblem(W, u, u, np.array(e), np.zeros(2), np.zeros(2))
        answer = solve_contacts(one, law)
        assert find_others(one, law, answer).verdict == "proven"
        after = answer.velocity_after[[2, 5]] if e[0] > e[1] else answer.velocity_after[[5, 2]]
        # 0.5 first: it leaves with 0.5, the other end at -1 - 0.75; that is hit next, and so on.
        first = np.array([-1.0, -1.0])
        for _ in range(200):
            i = int(np.argmin(first))
            if first[i] >= -1e-16:
                break
            p = (1.0 + (0.5, 0.4)[i]) * -first[i] / 4.0
            first = first + p * np.array([[4.0, -2.0], [-2.0, 4.0]])[i]
        np.testing.assert_allclose(after, first, atol=1e-13)
