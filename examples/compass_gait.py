"""The passive gait of the simplest walker, and whether it is stable, by its monodromy.

Two massless legs, a mass at the hip and vanishing ones at the feet, on a slope (Garcia,
Chatterjee, Ruina & Coleman 1998). The stance leg is an inverted pendulum, the swing leg
hangs from the hip; at heel strike the legs change roles and the hip's speed shrinks by
cos 2θ. Time in √(l/g).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.optimize import root

from impulsekit.impact.saltation import saltation_matrix


@dataclass(frozen=True)
class Gait:
    """The state (θ, θ̇, φ, φ̇) after heel strike, the period, the multipliers of one step."""

    start: np.ndarray
    period: float
    multipliers: np.ndarray


def rates(x: np.ndarray, slope: float) -> np.ndarray:
    """ẋ of x = (θ, θ̇, φ, φ̇): stance leg from the slope's normal, angle between the legs."""
    theta, theta_rate, phi, phi_rate = x
    fall = math.sin(theta - slope)
    swing = fall + (theta_rate**2 - math.cos(theta - slope)) * math.sin(phi)
    return np.array([theta_rate, fall, phi_rate, swing])


def slopes(x: np.ndarray, slope: float) -> np.ndarray:
    """(4, 4) ∂ẋ/∂x."""
    theta, theta_rate, phi, _ = x
    s, c = math.sin(theta - slope), math.cos(theta - slope)
    across = s * math.sin(phi) + c
    along = (theta_rate**2 - c) * math.cos(phi)
    swing = [across, 2.0 * theta_rate * math.sin(phi), along, 0.0]
    return np.array([[0.0, 1.0, 0.0, 0.0], [c, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0, 1.0], swing])


def strike(x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The state after heel strike and its derivative (4, 4) by the state before."""
    theta, rate = x[0], x[1]
    c, s = math.cos(2.0 * theta), math.sin(2.0 * theta)
    after = np.array([-theta, c * rate, -2.0 * theta, c * (1.0 - c) * rate])
    jump = np.zeros((4, 4))
    jump[:, 0] = [-1.0, -2.0 * s * rate, -2.0, -2.0 * s * (1.0 - 2.0 * c) * rate]
    jump[:, 1] = [0.0, c, 0.0, c * (1.0 - c)]
    return after, jump


def step(start: np.ndarray, slope: float) -> tuple[np.ndarray, np.ndarray, float]:
    """From strike to strike: the state just before it, the flow's derivative, the time."""

    def field(_t: float, y: np.ndarray) -> np.ndarray:
        flow = slopes(y[:4], slope) @ y[4:].reshape(4, 4)
        return np.concatenate([rates(y[:4], slope), flow.ravel()])

    def heel(_t: float, y: np.ndarray) -> float:
        # The swing foot scuffs the slope before mid-stance; that is no strike.
        return y[2] - 2.0 * y[0] if y[0] < 0.0 else -1.0

    heel.terminal, heel.direction = True, 1.0
    y = np.concatenate([start, np.eye(4).ravel()])
    accuracy = {"method": "DOP853", "rtol": 1e-12, "atol": 1e-13}
    found = solve_ivp(field, (0.0, 10.0), y, events=heel, **accuracy)
    # Between its steps the integrator is less accurate: it is let end at the strike, and
    # the rest of the gap is taken by Newton.
    time = float(found.t_events[0][0])
    for _ in range(3):
        end = solve_ivp(field, (0.0, time), y, **accuracy).y[:, -1]
        time -= (end[2] - 2.0 * end[0]) / (end[3] - 2.0 * end[1])
    return end[:4], end[4:].reshape(4, 4), time


def gait(slope: float, guess: tuple[float, float] = (0.2, -0.2)) -> Gait:
    """The gait near a guess of (θ, θ̇) after heel strike, on a slope [rad]."""

    def full(short: np.ndarray) -> np.ndarray:
        theta, rate = short
        return np.array([theta, rate, 2.0 * theta, (1.0 - math.cos(2.0 * theta)) * rate])

    def gap(short: np.ndarray) -> np.ndarray:
        before, _, _ = step(full(short), slope)
        return strike(before)[0][:2] - short

    start = full(root(gap, guess, tol=1e-13).x)
    before, flow, period = step(start, slope)
    after, jump = strike(before)
    heel = [-2.0, 0.0, 1.0, 0.0]
    monodromy = saltation_matrix(jump, rates(before, slope), rates(after, slope), heel) @ flow
    return Gait(start, period, np.linalg.eigvals(monodromy))


def main() -> None:
    """Print the gait on a slope of 0.009."""
    found = gait(0.009)
    theta, rate = found.start[:2]
    print(f"after heel strike theta = {theta:.9f}, its rate = {rate:.9f}")
    print(f"a step takes {found.period:.6f} √(l/g)")
    # Along the gait itself the multiplier is 1, and the legs' strike leaves one at 0.
    for value in sorted(found.multipliers, key=abs, reverse=True):
        print(f"multiplier {value.real:+.6f} {value.imag:+.6f} i, size {abs(value):.6f}")


if __name__ == "__main__":
    main()
