"""The truths themselves: closed forms in fractions and 50 digits, and what is wrong is refused."""

from __future__ import annotations

from fractions import Fraction

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from .end_laws import answers_of_one, compression, left_of_coulomb, struck_once
from .laws import in_sequence
from .path_laws import struck_along_path
from .waves import waves

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


@mpmath.workdps(50)
def quartic_roots(W, b, mu):
    """P_n of all slips of one contact, from the polynomial in tan θ/2, in 50 digits."""
    W, b, mu = mpmath.matrix(W.tolist()), mpmath.matrix(b.tolist()), mpmath.mpf(mu)
    found = []
    # ξ_t × s = 0 with P = −b_n/(W_nn − µ w·s) (−µ s, 1), s = (1 − z², 2z)/(1 + z²): degree 4 in z.
    values = []
    for z in range(-2, 3):
        s = mpmath.matrix([1 - mpmath.mpf(z) ** 2, 2 * z]) / (1 + mpmath.mpf(z) ** 2)
        left = W[2, 2] - mu * (W[0, 2] * s[0] + W[1, 2] * s[1])
        xi = [
            b[i] * left - b[2] * (W[i, 2] - mu * (W[i, 0] * s[0] + W[i, 1] * s[1])) for i in (0, 1)
        ]
        values.append((s[0] * xi[1] - s[1] * xi[0]) * (1 + mpmath.mpf(z) ** 2) ** 2)
    rows = mpmath.matrix([[mpmath.mpf(z) ** k for k in range(5)] for z in range(-2, 3)])
    coefficients = mpmath.lu_solve(rows, mpmath.matrix(values))
    for z in mpmath.polyroots(list(coefficients)[::-1], maxsteps=200, extraprec=200):
        if abs(mpmath.im(z)) > mpmath.mpf(10) ** -30:
            continue
        z = mpmath.re(z)
        s = mpmath.matrix([1 - z * z, 2 * z]) / (1 + z * z)
        p = -b[2] / (W[2, 2] - mu * (W[0, 2] * s[0] + W[1, 2] * s[1]))
        xi = [b[i] + p * (W[i, 2] - mu * (W[i, 0] * s[0] + W[i, 1] * s[1])) for i in (0, 1)]
        if p > 0 and xi[0] * s[0] + xi[1] * s[1] > 0:
            found.append(float(p))
    return sorted(found)


@pytest.mark.filterwarnings("ignore:Descending")
def test_all_slips_of_one_contact_in_50_digits():
    rng = np.random.default_rng(2)
    slips, several = 0, 0
    for _ in range(60):
        J = rng.normal(size=(3, 3))
        # Strong coupling and friction bring several answers.
        W, b, mu = J @ J.T, rng.normal(size=3), rng.uniform(0.2, 4.0)
        found = answers_of_one(W, b, mu)
        own = [P[2] for P in found if abs(np.hypot(*P[:2]) - mu * P[2]) < 1e-9 * P[2]]
        wanted = quartic_roots(W, b, mu)
        assert sorted(own) == pytest.approx(wanted, rel=1e-10)
        slips, several = slips + len(wanted), several + (len(found) > 1)
    assert slips > 20 and several > 0


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


@pytest.mark.parametrize("restitution", ["newton", "poisson", "stronge"])
def test_slip_in_space_as_a_plain_integration_has_it(restitution):
    """du/dP_n = W (−µ u_t/|u_t|, 1), where the slip does not end; and the work that is regained."""
    rng, followed = np.random.default_rng(4), 0
    for _ in range(12):
        W, u, (mu,) = random_problem(rng)
        u[:2] *= 4.0
        e = rng.uniform(0.2, 0.9)
        P = struck_along_path(W, u, e, mu, restitution)

        def rates(_, y, W=W, u=u, mu=mu):
            slip = (u + W @ y[:3])[:2]
            way = np.array([*(-mu * slip / np.hypot(*slip)), 1.0])
            return [*way, (u + W @ y[:3])[2]]

        plain = solve_ivp(rates, [0, P[2]], np.zeros(4), rtol=1e-11, atol=1e-13, dense_output=True)
        slips = [np.hypot(*(u + W @ plain.sol(p)[:3])[:2]) for p in np.linspace(0, P[2], 60)]
        if plain.status or min(slips) < 0.05 * slips[0]:
            continue
        followed += 1
        assert pytest.approx(plain.y[:3, -1], abs=1e-8 * P[2]) == P
        turn = np.linspace(0, P[2], 4001)
        rising = [(u + W @ plain.sol(p)[:3])[2] for p in turn]
        spent = plain.sol(turn[np.argmin(np.abs(rising))])[3]
        if restitution == "newton":
            assert rising[-1] == pytest.approx(-e * u[2], rel=1e-7)
        elif restitution == "poisson":
            assert P[2] == pytest.approx((1 + e) * turn[np.argmin(np.abs(rising))], rel=1e-3)
        else:
            assert plain.y[3, -1] == pytest.approx((1 - e * e) * spent, rel=1e-5)
    assert followed > 3


def row_of_balls(*masses):
    """W and velocities of a row along z, the first of which comes at 1 m/s."""
    n = len(masses) - 1
    J = np.zeros((3 * n, n + 1))
    for i in range(n):
        J[3 * i + 2, i : i + 2] = -1.0, 1.0
    v = np.eye(n + 1)[0]
    inverse = np.diag(1.0 / np.array(masses))
    return J @ inverse @ J.T, J @ v, lambda P: v + inverse @ J.T @ P


def test_three_balls_in_sequence_and_in_waves():
    """In sequence the last goes on alone; in waves they part as three masses on two springs do."""
    W, u, after = row_of_balls(1.0, 1.0, 1.0)
    ones, none = np.ones(2), np.zeros(2)

    def hit(i, own, _):
        return struck_once(W[:3, :3], own, own, 1.0, 0.0, "newton")

    assert after(in_sequence(W, u, hit)) == pytest.approx([0, 0, 1], abs=1e-14)
    found = after(waves(W, u, ones, none, ones, exponent=1.0))
    masses, springs = np.eye(3), np.array([[1.0, -1, 0], [0, 1, -1]])

    def rates(_, y):
        force = np.maximum(springs @ y[:3], 0.0)
        return np.concatenate([y[3:], -springs.T @ force])

    way = solve_ivp(rates, [0, 30], [0, 0, 0, 1, 0, 0], rtol=1e-10, atol=1e-12, max_step=0.01)
    assert found == pytest.approx(way.y[3:, -1], abs=1e-6)
    assert found @ masses @ found == pytest.approx(1.0, rel=1e-11)
