"""The truths themselves: closed forms in fractions and 50 digits, and what is wrong is refused."""

from __future__ import annotations

from fractions import Fraction

import numpy as np
import pytest

from .end_laws import compression, left_of_coulomb, struck_once
from .path_laws import struck_along_path

# A rod of 1 kg and 1 m, 3 in 4 steep, on its end: W of x, y, z in units of 1/kg.
C, S = Fraction(4, 5), Fraction(3, 5)
ROD = [[1 + 3 * S * S, 0, -3 * S * C], [0, 4, 0], [-3 * S * C, 0, 1 + 3 * C * C]]
W = np.array(ROD, dtype=float)


def random_problem(rng, n=1):
    J = rng.normal(size=(3 * n, 3 * n + 2))
    b = rng.normal(size=3 * n)
    b[2::3] = -np.abs(b[2::3])
    return J @ J.T, b, rng.uniform(0.1, 0.8, n)


def test_a_rod_that_slides_in_fractions():
    """P_n = (1 + e) |u_n|/(W_nn − µ W_xn) where friction points along +x."""
    e, mu, u = Fraction(1, 2), Fraction(1, 10), (-3, 0, -2)
    nn = ROD[2][2] + mu * ROD[0][2]
    wanted = (1 + e) * 2 / nn
    for restitution in ("newton", "poisson"):
        P = struck_once(W, np.array(u, float), np.array(u, float), float(e), 0.1, restitution)
        assert pytest.approx([float(mu * wanted), 0.0, float(wanted)], rel=1e-14) == P
        assert struck_along_path(W, u, float(e), 0.1, restitution) == pytest.approx(P, rel=1e-12)


def test_a_slip_in_a_plane_that_passes_zero_in_fractions():
    """Routh's construction: it slips back, stops within the compression, and slips on or sticks."""
    mu, u = Fraction(1, 4), (Fraction(1, 10), 0, Fraction(-2))
    xx, xn, nn = ROD[0][0], ROD[0][2], ROD[2][2]
    stop = u[0] / (mu * xx - xn)
    after = u[2] + stop * (nn - mu * xn)
    assert stop > 0 > after
    # µ does not hold it: it starts again the other way.
    assert -xn / xx > mu
    more = -after / (nn + mu * xn)
    x, compressed = mu * (more - stop), stop + more
    P = struck_along_path(W, np.array(u, dtype=float), 0.0, float(mu), "newton")
    assert pytest.approx([float(x), 0.0, float(compressed)], rel=1e-12, abs=1e-13) == P


def test_several_contacts_obey_the_law_and_what_is_off_does_not():
    rng = np.random.default_rng(3)
    for _ in range(5):
        W, b, mu = random_problem(rng, 3)
        P = compression(W, b, mu)
        assert left_of_coulomb(W, b, mu, P) < 1e-13
        for i in np.flatnonzero(P):
            other = P.copy()
            other[i] *= 1.0 + 1e-8
            assert left_of_coulomb(W, b, mu, other) > 1e-11
        swapped = P.reshape(3, 3)[:, [1, 0, 2]].ravel()
        assert left_of_coulomb(W, b, mu, swapped) > 1e-6
        assert left_of_coulomb(W, b, 1.01 * mu, P) > 1e-6 or not P[0::3].any()
