"""The stable gait of a rimless wheel, by its monodromy.

A wheel of spokes without a rim rolls down a slope: an inverted pendulum about the foot
that stands, then an impact at which the next foot takes over. Every step the impact takes
the share 1 − cos 2α of the speed, and the slope gives back energy; the speed at which both
balance is a gait, and deviations from it shrink by cos² 2α a step (McGeer 1990).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp

from impulsekit.impact.saltation import saltation_matrix


@dataclass(frozen=True)
class Gait:
    """A periodic gait: ω after the strike [1/s], its period [s], multipliers of one step."""

    omega: float
    period: float
    multipliers: np.ndarray


def gait(alpha: float, slope: float, gravity_over_length: float) -> Gait:
    """The gait of a wheel with 2 alpha [rad] between spokes on a slope [rad]."""
    keep = math.cos(2.0 * alpha)
    # ω² grows by 2 (g/l)(cos(γ − α) − cos(γ + α)) over a step and shrinks by cos² 2α.
    gain = 2.0 * gravity_over_length * (math.cos(slope - alpha) - math.cos(slope + alpha))
    after = math.sqrt(gain * keep**2 / (1.0 - keep**2))

    def rates(_t: float, y: np.ndarray) -> np.ndarray:
        # The angle and speed, then what deviations become.
        theta, omega = y[:2]
        flow = np.array([[0.0, 1.0], [gravity_over_length * math.cos(theta), 0.0]])
        return np.concatenate(
            [[omega, gravity_over_length * math.sin(theta)], (flow @ y[2:].reshape(2, 2)).ravel()]
        )

    def strike(_t: float, y: np.ndarray) -> float:
        return y[0] - (slope + alpha)

    strike.terminal, strike.direction = True, 1.0
    start = np.array([slope - alpha, after, 1.0, 0.0, 0.0, 1.0])
    step = solve_ivp(rates, (0.0, 100.0), start, "DOP853", events=strike, rtol=1e-12, atol=1e-13)
    end = step.y_events[0][0]
    before = end[1]
    # The next spoke takes over: θ goes back by 2α, ω is multiplied by cos 2α.
    jump = saltation_matrix(
        [[1.0, 0.0], [0.0, keep]],
        [before, gravity_over_length * math.sin(slope + alpha)],
        [keep * before, gravity_over_length * math.sin(slope - alpha)],
        [1.0, 0.0],
    )
    monodromy = jump @ end[2:].reshape(2, 2)
    return Gait(after, float(step.t_events[0][0]), np.linalg.eigvals(monodromy))


def main() -> None:
    """Print the gait of a wheel with eight spokes."""
    alpha, slope = math.pi / 8, 0.08
    found = gait(alpha, slope, 9.81)
    print(f"after each strike {found.omega:.6f} rad/s, a step takes {found.period:.6f} s")
    # Along the gait itself the multiplier is 1: a deviation in time stays.
    across = min(abs(found.multipliers))
    print(f"multiplier {across:.9f}, cos² 2α = {math.cos(2 * alpha) ** 2:.9f}")


if __name__ == "__main__":
    main()
