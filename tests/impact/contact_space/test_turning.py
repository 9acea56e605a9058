"""Slip that turns, against the same path in 25 digits and other coordinates."""

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

from impulsekit.laws.status import Status
from impulsekit.scene.law import Law

from .problems import block, solved


def path_in_polar_coordinates(W, u, mu, e):
    """{restitution: u⁺} of slip that does not stop, by mpmath; θ and ln|u_t| over dτ = dp/|u_t|."""
    mp = mpmath.mp
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = [[mp.mpf(float(x)) for x in row] for row in W]
    u1, u2, un = (mp.mpf(float(x)) for x in u)
    mu, e = mp.mpf(mu), mp.mpf(e)

    def rates(_, y):
        angle, log, _, normal, _ = y
        s1, s2, r = mp.cos(angle), mp.sin(angle), mp.exp(log)
        g1, g2 = n1 - mu * (t11 * s1 + t12 * s2), n2 - mu * (t12 * s1 + t22 * s2)
        fall = nn - mu * (n1 * s1 + n2 * s2)
        return [s1 * g2 - s2 * g1, s1 * g1 + s2 * g2, r, r * fall, r * normal]

    path = mpmath.odefun(rates, 0, [mp.atan2(u2, u1), mp.log(mp.hypot(u1, u2)), 0, un, 0])

    def first(missing, low):
        high = low + mp.mpf("0.02")
        while missing(path(high)) < 0:
            high = low + (high - low) * mp.mpf("1.3")
        return mpmath.findroot(
            lambda t: missing(path(t)), (low, high), solver="anderson", tol=mp.mpf("1e-22")
        )

    middle = first(lambda y: y[3], mp.mpf(0))
    _, _, pressed, _, spent = path(middle)
    found = {}
    for name, missing in (
        ("newton", lambda y: y[3] + e * un),
        ("poisson", lambda y: y[2] - (1 + e) * pressed),
        ("stronge", lambda y: y[4] - (1 - e * e) * spent),
    ):
        angle, log, _, normal, _ = path(first(missing, middle))
        r = mp.exp(log)
        found[name] = [float(r * mp.cos(angle)), float(r * mp.sin(angle)), float(normal)]
    return found


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, 2, 3])
def test_turning_slip_is_exact_to_rounding(seed):
    rng = np.random.default_rng(seed)
    W, u = block(rng, 6), rng.normal(size=3)
    u[:2] *= 6
    u[2] = -abs(u[2])
    mu, e = rng.uniform(0.1, 0.4), rng.uniform(0.2, 0.9)
    with mpmath.workdps(25):
        truth = path_in_polar_coordinates(W, u, mu, e)
    for name, after in truth.items():
        answer = solved(W, u, e, mu, law=Law(name, "path"))
        assert answer.status is Status.SOLVED
        np.testing.assert_allclose(answer.velocity_after, after, atol=2e-15 * np.abs(u).max())


def test_slip_that_hardly_turns_and_slip_that_does_not_are_one():
    """A direction an ε off the one that keeps: the closed form and the series meet."""
    W = np.diag([2.0, 5.0, 1.0])
    ends = [
        solved(W, [1.0, off, -1.0], 0.5, 0.2, law=Law("stronge", "path")).velocity_after
        for off in (0.0, 1e-12, 1e-9)
    ]
    np.testing.assert_allclose(ends[1], ends[0], atol=1e-11)
    np.testing.assert_allclose(ends[2], ends[0], atol=1e-8)


def least_rise(W, u, mu, p_end):
    """The least W_nn − µ w·s while slip goes on, of finely sampled slip over p."""
    w = W[:2, 2]

    def rates(_, y):
        r = np.hypot(y[0], y[1])
        return [*(r * w - mu * W[:2, :2] @ y[:2]), r]

    def goes_on(_, y):
        return min(p_end - y[2], np.hypot(y[0], y[1]) - 1e-8)

    goes_on.terminal = True
    path = solve_ivp(
        rates, (0.0, 1e4), [u[0], u[1], 0.0], "DOP853", rtol=1e-10, atol=1e-13, dense_output=True,
        events=goes_on,
    )  # fmt: skip
    times = np.linspace(0.0, path.t[-1], 4000)
    slip = path.sol(times)[:2]
    return float((W[2, 2] - mu * w @ slip / np.hypot(*slip)).min())
