"""All modes in a plane and the proof without them, against exact fractions."""

import numpy as np
import pytest

from impulsekit.laws.coupling import friction_feedback, is_monotone
from impulsekit.laws.others import MOST_ANSWERS, WEAK, find_answers
from impulsekit.laws.uniqueness import MOST_FOUND, NEAR, search_modes
from tests.truths.enumerated import PlaneProblem, all_after


def plane_problem(rng, n, frictions):
    """Contacts of one or two bodies with each other and the ground, tangents turned at random."""
    bodies = int(rng.integers(1, 3))
    masses = np.repeat(10 ** rng.uniform(-2, 0, bodies), 3)
    masses[2::3] *= rng.uniform(0.05, 1, bodies)
    rows = np.zeros((2 * n, 3 * bodies))
    for i in range(n):
        a = int(rng.integers(bodies))
        angle = rng.uniform(0, 2 * np.pi) if rng.random() < 0.6 else 0.0
        c, s = np.cos(angle), np.sin(angle)
        other = int(rng.integers(bodies)) if rng.random() < 0.5 else a
        for body, sign in ((a, 1.0), (other, -1.0)):
            if body == a and sign < 0:
                continue
            x, y = rng.uniform(-1, 1, 2)
            own = np.array([[c, s, x * s - y * c], [-s, c, x * c + y * s]])
            rows[2 * i : 2 * i + 2, 3 * body : 3 * body + 3] += sign * own
    friction, e = rng.choice(frictions, n), rng.choice([0.0, 0.5, 1.0], n)
    return PlaneProblem(rows, 1 / masses, rng.normal(size=3 * bodies), friction, e)


def in_space(problem, rng):
    """W, b (3n,) with a tangent out of the plane, both turned, and the turned (3n, 2n) basis."""
    rows, mu = np.array(problem.rows), np.array(problem.friction)
    n = len(mu)
    W = rows @ np.diag(problem.inverse_masses) @ rows.T
    b = rows @ problem.before
    b[1::2] += problem.restitution * np.minimum(b[1::2], 0.0)
    basis = np.zeros((3 * n, 2 * n))
    across = np.zeros((3 * n, n))
    for i in range(n):
        c, s = np.cos(turn := rng.uniform(0, 7)), np.sin(turn)
        basis[3 * i : 3 * i + 2, 2 * i], across[3 * i : 3 * i + 2, i] = (c, s), (-s, c)
        basis[3 * i + 2, 2 * i + 1] = 1.0
    # What moves out of the plane has nothing to do with what moves in it.
    beside = rng.uniform(0, 1) * np.eye(n)
    return basis @ W @ basis.T + across @ beside @ across.T, basis @ b, basis


@pytest.mark.parametrize(("n", "count"), [(1, 60), (2, 60), (3, 25), (4, 3)])
def test_all_solutions_in_a_plane_are_found_and_no_other(n, count):
    rng = np.random.default_rng(n)
    several = 0
    for _ in range(count):
        problem = plane_problem(rng, n, [0.0, 0.3, 1.0, 3.0])
        exact = all_after(problem)
        W, b, basis = in_space(problem, rng)
        scale = np.abs(b).max()
        found, none = np.empty((MOST_FOUND, 3 * n)), np.zeros(n)
        mu, outside = np.array(problem.friction), found[:0]
        _, known, _ = search_modes(W, b, mu, none, scale, NEAR, found, outside)
        rows = np.array(problem.rows)
        target = b @ basis - rows @ problem.before
        velocities = [rows @ after + target for after, _ in exact]
        seen = [(W @ P + b) @ basis for P in found[:known]]
        for one in seen:
            assert any(np.abs(one - other).max() < 1e-7 * scale for other in velocities)
        for one in velocities:
            assert any(np.abs(one - other).max() < 1e-7 * scale for other in seen)
        several += len(exact) > 1
    assert several or n in (1, 4)


@pytest.mark.parametrize(
    ("proof", "least"), [(is_monotone, 40), (lambda W, mu: friction_feedback(W, mu) < 1.0, 30)]
)
def test_where_friction_feeds_back_weakly_there_is_one_solution_for_every_velocity(proof, least):
    rng = np.random.default_rng(5)
    proven = 0
    for _ in range(300):
        problem = plane_problem(rng, int(rng.integers(2, 4)), [0.1, 0.3, 1.0])
        W, b, _ = in_space(problem, rng)
        if proof(W, np.array(problem.friction)):
            proven += 1
            assert len(all_after(problem)) == 1
            room, coefficients = np.empty((2, MOST_ANSWERS, len(b))), np.zeros((3, len(b) // 3))
            coefficients[0] = problem.friction
            assert find_answers(W, b, b, coefficients, 0, b, 1.0, room, NEAR)[0] == WEAK
    assert proven > least


@pytest.mark.parametrize("count", [1, 2, 3])
def test_the_proof_holds_where_the_inequality_does(count):
    """pᵀWp > Σ µ |(Wp)_t| |p_n| for all p: sampled, and not proven where a sample breaks it."""
    rng = np.random.default_rng(count)
    proven = broken = 0
    for _ in range(60):
        half = rng.normal(size=(3 * count + 3, 3 * count))
        W, mu = half.T @ half, rng.uniform(0, 1.5, count)
        p = rng.normal(size=(4000, count, 3))
        u = (p.reshape(-1, 3 * count) @ W).reshape(p.shape)
        rubbing = (mu * np.hypot(u[..., 0], u[..., 1]) * np.abs(p[..., 2])).sum(axis=1)
        holds = bool(((u * p).sum(axis=(1, 2)) > rubbing).all())
        proof = is_monotone(W, mu)
        proven += proof
        broken += not holds
        assert holds or not proof
    assert proven > 5
    assert broken > 5


@pytest.mark.parametrize("count", [2, 3, 4])
def test_the_feedback_is_that_of_the_formula_or_less_where_that_is_no_proof(count):
    rng = np.random.default_rng(count)
    weak = 0
    for k in range(60):
        # Regular, with redundant tangents, and redundant altogether.
        rank = 3 * count + (6, -1, -2 * count)[k % 3]
        half = rng.normal(size=(rank, 3 * count))
        W, mu = half.T @ half, 10.0 ** rng.uniform(-3, 0, count)
        n, t = np.arange(2, 3 * count, 3), np.flatnonzero(np.arange(3 * count) % 3 < 2)
        unit = 1.0 / np.sqrt(np.repeat(W.diagonal()[n], 3))
        scaled = W * unit * unit[:, None]
        tangent, cross = scaled[np.ix_(t, t)], scaled[np.ix_(n, t)]
        coupled = cross @ np.linalg.pinv(tangent, rcond=1e-11, hermitian=True) @ cross.T
        left = scaled[np.ix_(n, n)] - coupled
        least = np.linalg.eigvalsh(left)[0]
        found = friction_feedback(W, mu)
        if least <= 1e-9:
            assert found >= 1.0
            continue
        bound = np.linalg.eigvalsh(tangent * np.outer(np.repeat(mu, 2), np.repeat(mu, 2)))[-1]
        truth = np.sqrt(
            np.linalg.eigvals(np.linalg.solve(left, coupled)).real.max() * bound / least
        )
        weak += truth < 1.0
        assert (
            abs(found - truth) < 1e-8 * truth if truth < 1.0 else 1.0 <= found <= 1.00000001 * truth
        )
    assert weak > 5
