"""Corners of one face whose targets contradict each other: one of them bears nothing."""

import numpy as np
import pytest

from impulsekit.impact import Status

from .problems import box, solved


def lacks(W, u, e, mu, impulse):
    """What Coulomb's law with Newton's restitution lacks at each contact, by the definition."""
    xi = W @ impulse + u
    worst = 0.0
    for i in range(len(u) // 3):
        x1, x2, xn = xi[3 * i : 3 * i + 3]
        p1, p2, pn = impulse[3 * i : 3 * i + 3]
        xn += e * min(u[3 * i + 2], 0.0)
        rate = W[3 * i + 2, 3 * i + 2]
        worst = max(worst, abs(min(xn, rate * pn)))
        slip = np.hypot(x1, x2)
        worst = max(worst, rate * max(0.0, np.hypot(p1, p2) - mu * pn))
        if slip > 1e-12:
            worst = max(worst, rate * np.hypot(p1 + mu * pn * x1 / slip, p2 + mu * pn * x2 / slip))
    return worst


@pytest.mark.parametrize("contradiction", [1e-12, 1e-10, 1e-9, 1e-7, 1e-5])
@pytest.mark.parametrize("mu", [0.18, 0.9])
def test_a_face_that_slams_beside_two_corners_that_all_but_rest(contradiction, mu):
    J, inverse = box(half=(0.0524,) * 3, m=0.37)
    W = J @ inverse @ J.T
    rng = np.random.default_rng(11)
    for _ in range(12):
        # It turns about the edge on which two corners lie, and slides; these hardly part.
        v = np.r_[rng.normal(size=2), 0.0, 0.0, rng.uniform(1, 6), rng.normal()]
        v[2] = -0.0524 * abs(v[4])
        u = J @ v
        u[[2, 5, 8, 11]] += contradiction * rng.uniform(-1, 1, 4)
        e = rng.uniform(0.05, 0.6)
        solution = solved(W, u, e=e, mu=mu)
        assert solution.status in (Status.SOLVED, Status.SOLVED)
        assert lacks(W, u, e, mu, solution.impulse) < 1e-11 * np.abs(u).max()
