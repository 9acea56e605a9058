"""Restitutions of contacts that oppose each other: where no impulse satisfies all, that is said."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.optimize import linprog

import impulsekit as ik
from impulsekit.impact.contact_law import ContactProblem, solve_contacts

BALL = ik.Robot.from_urdf("models/ball.urdf", root="freeflyer")


@pytest.mark.parametrize("friction", [0.0, 0.5])
@pytest.mark.parametrize(("e", "status"), [(0.0, "SOLVED"), (0.5, "NO_SOLUTION")])
def test_a_body_between_floor_and_ceiling(friction, e, status):
    """Up from the floor by e and not into the ceiling: only e = 0 agrees."""
    contacts = [
        ik.Contact("ball", normal=[0, 0, z], restitution=e, friction=friction) for z in (1, -1)
    ]
    scene = ik.Scene(BALL, contacts=contacts)
    v = BALL.velocity(root_joint=[0.2, 0, -1, 0, 0, 0])
    impact = ik.solve(scene, BALL.neutral(), v)
    assert impact.status is ik.Status[status]
    assert ik.solve_batch(scene, BALL.neutral()[None], v[None]).status[0] == impact.status


def opposed(seed):
    """Contacts above and below a body with random restitutions, and rows of their velocities."""
    rng = np.random.default_rng(seed)
    n, rows = int(rng.choice([3, 4, 5, 6])), []
    for i in range(n):
        place, sign = rng.uniform(-1.0, 1.0, 3), 1.0 if i % 2 == 0 else -1.0
        rows += [np.r_[axis, np.cross(place, axis)] for axis in np.diag([1.0, sign, sign])]
    J = np.array(rows)
    mobility = np.r_[np.ones(3), rng.uniform(1.0, 10.0, 3)]
    u = J @ rng.normal(size=6)
    e, mu = rng.choice([0, 0.3, 0.5, 0.8, 1], n), rng.choice([0, 0.2, 0.5, 1], n)
    return ContactProblem((J * mobility) @ J.T, u, u, e, mu.astype(float), np.zeros(n)), J


def test_it_is_said_exactly_where_normal_impulses_that_move_nothing_prove_it():
    """By Farkas: d >= 0 with J_nᵀ d = 0 and d·(u_n + e min(u_n, 0)) < 0."""
    proven = 0
    for seed in range(120):
        problem, J = opposed(seed)
        u = problem.velocity_free[2::3]
        wanted = u + problem.restitution * np.minimum(u, 0.0)
        least = linprog(wanted, A_eq=J[2::3].T, b_eq=np.zeros(6), bounds=(0.0, 1.0)).fun
        status = solve_contacts(problem, ik.Law()).status
        if status is ik.Status.NO_SOLUTION:
            assert least < -1e-9, seed
        elif least < -1e-2:
            raise AssertionError(f"seed {seed}: {status.name}, {least}")
        proven += status is ik.Status.NO_SOLUTION
    assert proven > 20
