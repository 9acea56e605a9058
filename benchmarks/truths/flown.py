"""Bodies that go straight and turn steadily: exact motions, distances, and when they first meet.

Nothing of this knows a rigid-body program. The first zero of a gap that changes no faster than L
is found by going on in time by gap / L, which passes over none.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

# A gap below this [m] is closed; it was grazed where it opens again without coming to zero.
CLOSED = 1e-13
MOST_STEPS = 200_000
# A gap that has closed goes on closing over this way [m], at this speed or a faster one [m/s]; else
# it grazes.
PAST, SLOWEST = 1e-9, 1e-9
# Of the time of meeting [s; relative]: rounding.
XTOL, RTOL = 1e-16, 1e-15

Gap = Callable[[float], float]


@dataclass(frozen=True, eq=False)
class Flown:
    """A body whose centre flies freely and which turns steadily about a fixed direction.

    Attributes:
        at, velocity, weight: (3,) of its centre at t = 0, in world axes [m, m/s, m/s²].
        turn: (3, 3) its orientation then.
        spin: (3,) its angular velocity, in world axes [1/s].
    """

    at: np.ndarray
    velocity: np.ndarray
    turn: np.ndarray
    spin: np.ndarray
    weight: np.ndarray

    def centre(self, t: float) -> np.ndarray:
        """(3,) of it at a time [s]."""
        return self.at + t * self.velocity + 0.5 * t * t * self.weight

    def orientation(self, t: float) -> np.ndarray:
        """(3, 3) at a time [s]."""
        return turned(self.spin, t) @ self.turn

    def speed(self, t: float) -> float:
        """No faster does its centre move up to a time [m/s]."""
        return float(np.linalg.norm(self.velocity) + t * np.linalg.norm(self.weight))


def turned(spin: np.ndarray, t: float) -> np.ndarray:
    """(3, 3) by how much a steady spin turns in a time (Rodrigues)."""
    rate = float(np.linalg.norm(spin))
    if rate == 0.0:
        return np.eye(3)
    x, y, z = spin / rate
    k = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(rate * t) * k + 2.0 * math.sin(0.5 * rate * t) ** 2 * (k @ k)


def from_box(point: np.ndarray, half: np.ndarray) -> float:
    """The distance of a point from a box about the origin; negative inside, to the next face."""
    beside = np.abs(point) - half
    outside = np.maximum(beside, 0.0)
    return float(np.sqrt(outside @ outside) + min(float(beside.max()), 0.0))


def from_segment(point: np.ndarray, half: float, axis: np.ndarray) -> float:
    """The distance of a point from a segment about the origin."""
    along = min(max(float(point @ axis), -half), half)
    return float(np.linalg.norm(point - along * axis))


def first_meeting(gap: Gap, fastest: float, end: float) -> float | None:
    """When a gap first closes up to a time; infinity where it does not, None where it grazes.

    Args:
        fastest: no gap of these closes faster [m/s].
    """
    from scipy.optimize import brentq

    t, value = 0.0, gap(0.0)
    for _ in range(MOST_STEPS):
        if value <= CLOSED:
            later = t + PAST / max(fastest, SLOWEST) + 4.0 * math.ulp(t)
            if gap(later) >= 0.0:
                return None
            before = max(0.0, 2.0 * t - later)
            if gap(before) <= 0.0:
                return None
            return float(brentq(gap, before, later, xtol=XTOL, rtol=RTOL))
        t += value / fastest
        if t >= end:
            return math.inf
        value = gap(t)
    return None
