"""The search over modes in space against all roots of the angle of slip on a fine grid."""

import numpy as np
import pytest

from impulsekit.impact.contact_law import ContactProblem
from impulsekit.laws.space_modes import space_modes
from tests.lawful import left_of_coulomb


def one_that_slides(W, b, mu):
    """P of two contacts that are pressed and smooth, and one that slides, for every slip."""
    smooth, own = [2, 5], [6, 7, 8]
    inverse, across = np.linalg.inv(W[np.ix_(smooth, smooth)]), W[np.ix_(own, smooth)]
    V = W[np.ix_(own, own)] - across @ inverse @ across.T
    free = b[own] - across @ inverse @ b[smooth]

    def turning(angle):
        """s⊥·ξ_t times what the normal gives way, which has no pole."""
        c, s = np.cos(angle), np.sin(angle)
        way = np.array([-mu * c, -mu * s, np.ones_like(c)])
        xi = free[:, None] * (V[2] @ way) - (V @ way) * free[2]
        return c * xi[1] - s * xi[0]

    angles = np.linspace(0.0, 2.0 * np.pi, 10_001)
    values, found = turning(angles), []
    for k in np.flatnonzero(values[:-1] * values[1:] < 0.0):
        share = values[k] / (values[k] - values[k + 1])
        angle = angles[k] + share * (angles[k + 1] - angles[k])
        slip = np.array([np.cos(angle), np.sin(angle)])
        P = np.array([*(-mu * slip), 1.0])
        P *= -free[2] / (V[2] @ P)
        if P[2] > 0.0 and slip @ (free + V @ P)[:2] > 0.0:
            whole = np.zeros(9)
            whole[own], whole[smooth] = P, -inverse @ (b[smooth] + across.T @ P)
            found += [whole] if (whole[smooth] > 0.0).all() else []
    return found


# In the first no answer was found: contacts without friction took the directions to start from.
@pytest.mark.parametrize("seed", [986, 7, 9, 45])
def test_smooth_contacts_take_no_directions_from_one_that_slides(seed):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(9, 9))
    W, mu, b = root @ root.T, rng.uniform(0.5, 3.0), rng.normal(size=9)
    for k in (0, 1, 3, 4):
        W[k], W[:, k], b[k] = 0.0, 0.0, 0.0
    known = one_that_slides(W, b, mu)
    found, outside = np.empty((64, 9)), np.empty((64, 9))
    scale = np.abs(b).max()
    count, _ = space_modes(W, b, np.array([0.0, 0.0, mu]), scale, found, outside)
    for P in known:
        assert min(np.abs(P - one).max() for one in found[:count]) < 1e-5 * np.abs(P).max()
    assert known


def four(seed, mu):
    """The problem of four contacts on a few bodies, with these coefficients of friction."""
    rng = np.random.default_rng(seed)
    size = 10.0 ** rng.uniform(-0.5, 0.5, (12, 1))
    root = rng.normal(size=(12, int(rng.integers(6, 13)))) * size
    before = root @ rng.normal(size=root.shape[1])
    e, none = rng.choice([0.0, 0.5], 4), np.zeros(4)
    return ContactProblem(root @ root.T, before, before, e, np.array(mu), none)


def left_of(problem, P):
    """What is left of Newton's and Coulomb's laws."""
    after = problem.velocity_free + problem.delassus @ P
    after[2::3] += problem.restitution * np.minimum(problem.velocity_before[2::3], 0.0)
    return left_of_coulomb(after, P, problem.friction, np.abs(problem.velocity_free).max())
