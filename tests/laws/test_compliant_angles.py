"""The angle after an impact against that before it, of two uncoupled springs in a plane.

ψ = κ u_t/(µ |u_n⁻|) and χ = κ W_tt/(2 W_nn), as in Maw, Barber & Fawcett (1976); the springs are
linear (Stronge 2000, ch. 5), and time runs so that δ = |u_n⁻| sin t in compression.
"""

import numpy as np
import pytest
from scipy.optimize import brentq

from .test_compliant import struck


def angle_after(psi, chi, e):
    """ψ2 of ψ1: slip up to t_1, sticking, and slip from t_s to the end, each in closed form."""
    # κ/µ times the slip falls to ψ1 − 2 χ (1 + e) + 1/e, where u_n = e and δ' = −1/e.
    if psi >= max(1.0, 2.0 * chi, 2.0 * chi * (1.0 + e) - 1.0 / e):
        return psi - 2.0 * chi * (1.0 + e)
    half, start, P, load = np.pi / 2.0, 0.0, 0.0, 0.0
    if psi > 2.0 * chi:  # slip ends in restitution
        sine = (psi - 2.0 * chi) / (2.0 * chi * e - 1.0 / e)
        start, P = half + e * np.arcsin(sine), 1.0 + e * sine
        load = np.sqrt(1.0 - sine**2)
    elif psi > 1.0:  # slip ends in compression
        cosine = (2.0 * chi - psi) / (2.0 * chi - 1.0)
        start, P, load = np.arccos(cosine), 1.0 - cosine, np.sqrt(1.0 - cosine**2)
    omega, u = np.sqrt(2.0 * chi), psi - 2.0 * chi * P

    def spring(t):
        """κ ζ/µ and κ u_t/µ while it sticks."""
        s, c = np.sin(omega * (t - start)), np.cos(omega * (t - start))
        return load * c + u / omega * s, u * c - omega * load * s

    def left(t):
        return np.cos((t - half) / e) - abs(spring(t)[0])

    end = half * (1.0 + e)
    times = np.linspace(max(start, half), end, 2001)[1:]
    slips = next(i for i, t in enumerate(times) if left(t) < 0.0)
    slip = brentq(left, times[slips - 1], times[slips], xtol=1e-15)
    force, speed = spring(slip)
    return speed - 2.0 * chi * e * (1.0 - np.sin((slip - half) / e)) * np.sign(force)


def found_after(psi, chi, e, mu=0.5, ratio=0.8):
    """ψ2 as solved, along a direction askew in the tangent plane."""
    W_t, way = 2.0 * chi / ratio, np.array([0.6, -0.8])
    u = np.array([*(psi * mu / ratio * way), -1.0])
    after = struck(np.diag([W_t, W_t, 1.0]), u, e, mu, ratio).velocity_after
    assert after[2] == pytest.approx(e, abs=1e-9)
    assert after[:2] @ [0.8, 0.6] == pytest.approx(0.0, abs=1e-10)
    return after[:2] @ way * ratio / mu


@pytest.mark.parametrize("e", [1.0, 0.7])
@pytest.mark.parametrize("chi", [0.9, 1.2558, 1.4])
def test_the_curve_is_that_of_the_closed_form(chi, e):
    for psi in (0.05, 0.4, 0.8, 0.99, 1.2, 1.7, 2.2, 2.7, 3.3, 4.0, 5.0, 8.0):
        assert found_after(psi, chi, e) == pytest.approx(angle_after(psi, chi, e), abs=1e-8), psi


def test_limits_are_those_of_maw_barber_and_fawcett():
    """Gross slip ψ2 = ψ1 − 4 χ above ψ1 = 4 χ − 1, and below ψ1 = 1 it sticks from the start."""
    chi = 1.2558
    edge = 4.0 * chi - 1.0
    for psi in (edge + 1e-3, edge + 1.0, 10.0):
        assert found_after(psi, chi, 1.0) == pytest.approx(psi - 4.0 * chi, abs=1e-8)
    assert found_after(edge - 0.1, chi, 1.0) > edge - 0.1 - 4.0 * chi + 1e-4
    # Hertz's force turns the angle back from the smallest ψ1 on (their Figure 1); beside a linear
    # spring the tangential one swings further, and it comes back for ψ1 below 0.5.
    angles = [found_after(psi, chi, 1.0) for psi in (0.2, 0.7, 2.5, 4.0)]
    assert [angle < 0.0 for angle in angles] == [False, True, True, True]


@pytest.mark.parametrize("mu", [0.5, 3.0, 30.0, 1e3])
@pytest.mark.parametrize("ratio", [0.3, 0.8, 1.0, 1.4])
@pytest.mark.parametrize("e", [1.0, 0.7])
def test_springs_hold_until_the_load_is_less_than_they_need(e, ratio, mu):
    """However large µ is, a spring under tension slips in the last instant, as F_n goes to zero."""
    found = struck(np.diag([3.5, 3.5, 1.0]), np.array([0.03, -0.04, -1.0]), e, mu, ratio)
    after = angle_after(ratio * 0.05 / mu, 1.75 * ratio, e) * mu / ratio
    assert found.velocity_after == pytest.approx([0.6 * after, -0.8 * after, e], abs=1e-10)
