"""The pendulum of n uniform rods by Kane's equations, with absolute angles; no Pinocchio here.

θ_i from the vertical, ω_i = θ̇_i. The partial velocities of rod j's centre are l (cos θ_i,
sin θ_i) for i < j and half of it for i = j, so the generalized masses are
a_ij cos(θ_i − θ_j) with a_ij = m l² (½ + n − 1 − j) for i < j, m l² (⅓ + n − 1 − i) for i = j.
"""

from __future__ import annotations

import numpy as np
from scipy.integrate import solve_ivp


def pins_after_blow(
    count: int, mass: float, length: float, blow: float, gravity: float, times: np.ndarray
) -> np.ndarray:
    """(T, n, 2) x and z of every rod's lower end, struck sideways at the lowest while hanging."""
    index = np.arange(count)
    below = count - 1 - np.maximum.outer(index, index)
    masses = mass * length**2 * (0.5 + below)
    np.fill_diagonal(masses, mass * length**2 * (1.0 / 3.0 + count - 1 - index))
    weights = mass * gravity * length * (0.5 + count - 1 - index)

    def rates(_, y):
        angle, speed = y[:count], y[count:]
        between = np.subtract.outer(angle, angle)
        active = -(masses * np.sin(between)) @ speed**2 - weights * np.sin(angle)
        return np.concatenate([speed, np.linalg.solve(masses * np.cos(between), active)])

    # P_l: every rod's turning carries the struck end along by l.
    start = np.linalg.solve(masses, np.full(count, blow * length))
    found = solve_ivp(
        rates,
        (0.0, times[-1]),
        np.concatenate([np.zeros(count), start]),
        method="DOP853",
        rtol=1e-13,
        atol=1e-13,
        t_eval=times,
    )
    angles = found.y[:count].T
    steps = length * np.stack([np.sin(angles), -np.cos(angles)], axis=-1)
    return np.cumsum(steps, axis=1)
