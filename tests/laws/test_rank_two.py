"""One contact of a body with two degrees of freedom: W = J M⁻¹ Jᵀ has rank 2.

Impulses along the null direction of W move nothing, so that a contact may be held still by a whole
line of impulses, of which only some lie in the cone. All answers are found here by a scan over
all directions of slip, and by the quadratic for where that line meets the cone.
"""

import numpy as np
import pytest

from impulsekit.laws.coulomb import coulomb
from impulsekit.laws.status import Status


def can_be_held(W, b, mu):
    """Whether an impulse within the cone brings the contact to rest."""
    P, null = -np.linalg.pinv(W, rcond=1e-10) @ b, np.linalg.eigh(W)[1][:, 0]
    # µ² P_n² − |P_t|² along the line, from its highest power on.
    metric = np.array([-1.0, -1.0, mu * mu])
    edges = np.roots([metric @ null**2, 2.0 * metric @ (null * P), metric @ P**2])
    edges = np.sort(edges[np.isreal(edges)].real)
    tried = [*edges, edges.mean(), edges[0] - 1.0, edges[-1] + 1.0] if len(edges) else [0.0]
    lines = P + np.outer(tried, null)
    slack = mu * lines[:, 2] - np.hypot(lines[:, 0], lines[:, 1])
    return bool((slack > 1e-9 * np.abs(lines).max(axis=1)).any())


def sliding_velocities(W, b, mu):
    """u⁺ of every direction of slip that comes back as itself."""

    def response(angle):
        way = np.array([-mu * np.cos(angle), -mu * np.sin(angle), np.ones_like(angle)])
        moved = W @ way
        P = -b[2] / moved[2]
        u = (moved * P).T + b
        return P, np.cos(angle) * u.T[1] - np.sin(angle) * u.T[0], u

    angles = np.linspace(-np.pi, np.pi, 8001)
    P, across, _ = response(angles)
    found = []
    crossings = (across[:-1] * across[1:] <= 0.0) & (P[:-1] > 0.0) & (P[1:] > 0.0)
    for k in np.flatnonzero(crossings):
        low, high, sign = angles[k], angles[k + 1], across[k]
        for _ in range(60):
            middle = 0.5 * (low + high)
            if response(np.array(middle))[1] * sign <= 0.0:
                high = middle
            else:
                low = middle
        u = response(np.array(low))[2]
        if u[0] * np.cos(low) + u[1] * np.sin(low) > 1e-6:
            found.append(u)
    return found


@pytest.mark.parametrize("seed", range(60))
def test_what_can_be_held_is_held_and_other_velocities_are_told(seed):
    rng = np.random.default_rng(seed)
    J = rng.normal(size=(3, 2)) * np.exp(0.5 * rng.normal(size=(3, 1)))
    W, b = J @ J.T, J @ rng.normal(size=2)
    b = b if b[2] < 0.0 else -b
    mu = float(rng.choice([0.3, 1.0, 3.0]))
    block = (W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2])
    P, code = coulomb(block, *b.tolist(), mu, np.abs(b).max())
    held, sliding = can_be_held(W, b, mu), sliding_velocities(W, b, mu)
    assert held + len(sliding) >= 1
    after = W @ np.array(P) + b
    assert np.hypot(P[0], P[1]) <= mu * P[2] * (1.0 + 1e-9)
    if held:
        np.testing.assert_allclose(after, 0.0, atol=1e-11 * np.abs(b).max())
        assert code == (Status.MANY_SOLUTIONS if sliding else Status.NOT_UNIQUE)
    else:
        assert min(np.abs(after - one).max() for one in sliding) < 1e-8
        assert code == (Status.MANY_SOLUTIONS if len(sliding) > 1 else Status.SOLVED)
