"""Friction that is stiff beside an impact: two points near each other, about which a body spins."""

import numpy as np
import pytest

from impulsekit.laws.lzb import STIFF, Waved, strike_by_energy
from tests.truths.space_paths import Spatial, space_error

MU, E = 0.7, 0.5


def pivot(apart, spin):
    """W and u_free of a body that falls on two points, so far apart, and spins about them."""
    points = [np.array([0.5 * apart, 0.0, -0.1]), np.array([-0.5 * apart, 0.0, -0.1])]
    rows = []
    for p in points:
        cross = np.array([[0, p[2], -p[1]], [-p[2], 0, p[0]], [p[1], -p[0], 0]])
        rows.append(np.hstack([np.eye(3), cross]))
    jacobian = np.vstack(rows)
    inverse = np.diag([1.0, 1.0, 1.0, 150.0, 120.0, 200.0])
    v = np.array([0.03, 0.01, -1.0, 0.1, -0.2, spin])
    return jacobian @ inverse @ jacobian.T, jacobian @ v


@pytest.mark.parametrize("apart", [1e-4, 1e-6])
def test_a_body_that_spins_about_two_near_points_is_followed_to_the_end(apart):
    W, free = pivot(apart, spin=5.0)
    two = np.ones(2)
    hit = Waved(*strike_by_energy(W, free, E * two, MU * two, two, 1.5))
    assert hit.status.valid
    assert hit.steps > STIFF
    assert hit.residual < 1e-10
    P = hit.impulse.reshape(2, 3)
    assert (np.hypot(P[:, 0], P[:, 1]) <= MU * P[:, 2] * (1 + 1e-12)).all()
    speed = np.abs(free).max()
    followed = Spatial(W / W.diagonal().max(), free / speed, E * two, two, MU * two, 1.5)
    assert space_error(followed, hit.after / speed) < 1e-8


# A capsule that comes to lie, as three pieces: both ends touch in two points some 1e-10 m apart.
ENDS = np.array(
    [
        [0.114552, 1.079873, 0.0, -2.265416, -1.022383],
        [-0.240068, 0.515276, 0.0, -1.080975, 2.142624],
        [0.615426, 0.0, -1.449209, 0.0, 1.026102],
        [0.114552, -1.079873, 0.0, -2.265416, -1.022383],
        [-0.240068, -0.515276, 0.0, -1.080975, 2.142624],
        [-0.615426, 0.0, -1.449209, 0.0, -1.026102],
    ]
)
ASIDE = 1e-10 * np.array(
    [
        [0.0, 12.8, 0.0, 0.0, 0.0],
        [0.0, 6.1, 0.0, 0.0, 0.0],
        [7.29, 0.0, 0.0, 0.0, 12.2],
        [1.98, 12.8, 0.0, 7.1, 3.3],
        [-4.15, 6.1, 0.0, 3.39, -6.91],
        [7.29, 0.0, 0.0, 0.0, 12.2],
    ]
)
FREE = np.array([-0.433909, -0.207046, -1.139312, 0.834e-10, -3.25e-10, 3.37e-10])
FASTER = 1e-10 * np.array([-2.57, -1.23, -6.75, -2.07, 3.72, -6.75])


def test_points_that_are_one_but_for_rounding_share_the_load_of_one():
    """Friction that turns the slip of both is stiffer than any step: 40 000 were not enough."""
    rows = np.vstack([ENDS, ENDS + ASIDE])
    W, free = rows @ rows.T, np.concatenate([FREE, FREE + FASTER])
    four, two = np.ones(4), np.ones(2)
    hit = Waved(*strike_by_energy(W, free, 0.63 * four, 0.91 * four, four, 1.5))
    assert hit.status.valid and hit.residual < 1e-12 and hit.steps < STIFF
    assert np.allclose(hit.after, free + W @ hit.impulse, atol=1e-14)
    # Each end as one point: what both springs at it make is twice as stiff.
    mean = ENDS + 0.5 * ASIDE
    ends = FREE + 0.5 * FASTER
    lone = Waved(*strike_by_energy(mean @ mean.T, ends, 0.63 * two, 0.91 * two, 2 * two, 1.5))
    assert np.allclose(np.tile(0.5 * lone.impulse, 2), hit.impulse, rtol=0, atol=1e-10)
    assert np.allclose(np.tile(0.5 * lone.normal_work, 2), hit.normal_work, rtol=0, atol=1e-10)
