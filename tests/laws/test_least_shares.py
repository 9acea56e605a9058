"""Shares of redundant loads: found where there are any, given up early where there are none."""

import numpy as np
import pytest
from scipy.optimize import linprog

from impulsekit.laws import least_shares
from impulsekit.laws.least_shares import least_holding
from impulsekit.laws.modes import sizes_of
from impulsekit.laws.workspace import workspace

# What counts as held, and facets of a cone inside the true one and of one around it.
HELD, FACETS = 1e-13, 64


def _posed(W, b, mu):
    work = workspace(len(mu))
    work.W[:], work.b[:], work.mu[:] = W, b, mu
    return work


def _can_hold(J, b, mu, widened):
    """Whether cones of many facets, µ widened, hold P with J Jᵀ P = −b, by a linear programme."""
    angles = 2 * np.pi * np.arange(FACETS) / FACETS
    rows = np.zeros((FACETS * len(mu), 3 * len(mu)))
    for i, one in enumerate(mu):
        rows[FACETS * i : FACETS * (i + 1), 3 * i] = np.cos(angles)
        rows[FACETS * i : FACETS * (i + 1), 3 * i + 1] = np.sin(angles)
        rows[FACETS * i : FACETS * (i + 1), 3 * i + 2] = -one * widened
    wanted = -np.linalg.lstsq(J, b, rcond=None)[0]
    nothing = np.zeros(3 * len(mu))
    bounds = [(None, None), (None, None), (0, None)] * len(mu)
    return linprog(nothing, rows, np.zeros(len(rows)), J.T, wanted, bounds).status == 0


def test_what_can_be_held_is_held_and_nothing_else():
    rng = np.random.default_rng(5)
    held = let_go = 0
    for _ in range(60):
        n, m = int(rng.integers(3, 6)), int(rng.integers(2, 7))
        J = rng.normal(size=(3 * n, m))
        mu = rng.choice([0.1, 0.3, 0.6, 1.0], n)
        b = -J @ (J.T @ rng.normal(size=3 * n))
        work = _posed(J @ J.T, b, mu)
        residual = least_holding(work, n, sizes_of(work, n, 0.0))
        # Where all part the law is obeyed as well, with no impulse.
        is_held = residual <= HELD and np.abs(J @ (J.T @ work.P) + b).max() < 1e-9
        # Cones between which the true ones lie decide all but a few of them.
        if _can_hold(J, b, mu, np.cos(np.pi / FACETS)):
            assert is_held
            held += 1
        elif not _can_hold(J, b, mu, 1.0):
            assert not is_held
            let_go += 1
    assert held > 10 and let_go > 10


@pytest.mark.parametrize("friction", [0.1, 0.3])
def test_a_sole_that_slides_is_given_up_after_a_few_steps(friction, monkeypatch):
    # Four corners in a row of blocks, pressed at 1 and dragged at 3 m/s: no share holds them.
    corners = [(x, y, -0.05) for x in (-0.1, 0.1) for y in (-0.06, 0.06)]
    J = np.concatenate([np.c_[np.eye(3), -_cross(np.array(r))] for r in corners])
    W = J @ np.diag([1, 1, 1, 90, 80, 70]) @ J.T
    work = _posed(W, J @ np.array([3.0, 0, -1, 0, 0, 0]), np.full(4, friction))
    count = 0
    go = least_shares._go_to_nearest

    def counted(*args):
        nonlocal count
        count += 1
        go(*args)

    monkeypatch.setattr(least_shares, "_go_to_nearest", counted)
    assert least_holding.py_func(work, 4, sizes_of(work, 4, 0.0)) > HELD
    assert 0 < count < 40


def _cross(r):
    return np.array([[0, -r[2], r[1]], [r[2], 0, -r[0]], [-r[1], r[0], 0]])
