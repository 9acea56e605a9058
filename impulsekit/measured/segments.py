"""Where in a recording the robot flies, and which samples stand apart."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

if TYPE_CHECKING:
    from .flight import Flight

__all__ = ["Segments", "estimated_sigma", "find_segments"]

# What the last samples count for, against one a sample later: flights are tracked over some
# ten samples, so that drag and a mass a few per cent off do not count as impacts.
FADING = 0.9
# Probability that noise alone is taken for the end of a flight.
FALSE_END = 1e-6
# A flight has so many samples: two tell its speed, the third confirms it.
FEWEST = 3
# Third differences of so many samples tell the noise.
FEWEST_FOR_NOISE = 8
# The median of χ² with one degree of freedom, as a ratio to sigma: |x| of half the samples.
MEDIAN_TO_SIGMA = 0.6744897501960817
# Noise is at least this [m, rad]: of recordings out of a simulator, what the rule that follows
# flights is off over ten samples; no sensor is better.
ROUNDING = 1e-6


@dataclass(frozen=True, eq=False)
class Segments:
    """Flights of one recording.

    Attributes:
        flights: index arrays of the samples of each, in order of time.
        speeds: (nv,) of each flight at its last sample, as tracked.
        outliers: indices of samples that stand apart.
        innovations: (N, nv) of samples within flights, over what noise of 1 leaves.
    """

    flights: list[np.ndarray]
    outliers: list[int]
    innovations: np.ndarray


def estimated_sigma(flight: Flight, t: np.ndarray, q: np.ndarray) -> np.ndarray:
    """(nv,) noise of samples: what they differ by from the mean of their neighbours.

    With the acceleration of free flight taken off; the median over all samples, so that impacts
    and rests do not count for much. Steps of unlike length are left out.
    """
    model, differences = flight.model, []
    for k in range(1, len(t) - 1):
        before, after = t[k] - t[k - 1], t[k + 1] - t[k]
        if abs(after - before) > 0.2 * before:
            continue
        back = pin.difference(model, q[k], q[k - 1])
        ahead = pin.difference(model, q[k], q[k + 1])
        rate = flight.acceleration(t[k], q[k], (ahead - back) / (after + before))
        differences.append(ahead + back - 0.5 * rate * (after**2 + before**2))
    if len(differences) < FEWEST_FOR_NOISE:
        return np.full(model.nv, np.nan)
    # x₋ − 2 x + x₊ of noise σ has √6 σ.
    middle = np.median(np.abs(differences), axis=0)
    return middle / (MEDIAN_TO_SIGMA * np.sqrt(6.0))


class _Track:
    """A flight followed sample by sample: Kalman's filter with fading memory.

    All coordinates share one covariance (2, 2) of position and speed, in units of their noise.
    """

    def __init__(self, flight: Flight, t: np.ndarray, q: np.ndarray, first: int) -> None:
        self._flight = flight
        dt = t[first + 1] - t[first]
        way = pin.difference(flight.model, q[first], q[first + 1])
        rate = flight.acceleration(t[first], q[first], way / dt)
        self.time, self.q, self.v = float(t[first + 1]), q[first + 1], way / dt + 0.5 * dt * rate
        self._spread = np.array([[1.0, 1.0 / dt], [1.0 / dt, 2.0 / dt**2]])

    def predicted(self, time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Configuration and velocity at a later time, and the covariance there."""
        dt = time - self.time
        q, v = self._flight.step(self.time, self.q, self.v, dt)
        move = np.array([[1.0, dt], [0.0, 1.0]])
        return q, v, move @ self._spread @ move.T / FADING

    def take(self, time: float, seen: np.ndarray, ahead: tuple) -> None:
        """Go on to a sample, from what was predicted for it."""
        q, v, spread = ahead
        gain = spread[:, 0] / (spread[0, 0] + 1.0)
        left = pin.difference(self._flight.model, q, seen)
        self.time, self.q, self.v = time, pin.integrate(self._flight.model, q, gain[0] * left), v
        self.v = v + gain[1] * left
        self._spread = spread - np.outer(gain, spread[0])


def find_segments(flight: Flight, t: np.ndarray, q: np.ndarray, sigma: np.ndarray) -> Segments:
    """Cut a recording into flights, sample by sample.

    A flight ends where two samples in a row are not where it leads; one alone is an outlier.
    """
    from scipy import stats

    model = flight.model
    limit = float(stats.chi2.isf(FALSE_END, model.nv))
    flights: list[np.ndarray] = []
    outliers: list[int] = []
    innovations: list[np.ndarray] = []
    first, count = 0, len(t)
    while first < count - 1:
        track = _Track(flight, t, q, first)
        own, k = [first, first + 1], first + 2
        apart: list[int] = []
        while k < count:
            ahead = track.predicted(float(t[k]))
            left = pin.difference(model, ahead[0], q[k]) / np.sqrt(ahead[2][0, 0] + 1.0)
            if float(np.sum((left / sigma) ** 2)) <= limit:
                innovations.append(left)
                track.take(float(t[k]), q[k], ahead)
                own.append(k)
                outliers += apart
                apart = []
            elif apart or len(own) == 2:
                break
            else:
                apart = [k]
            k += 1
        if len(own) >= FEWEST:
            flights.append(np.array(own))
            first = own[-1] + 1
        else:
            first += 1
    found = np.array(innovations).reshape(-1, model.nv)
    return Segments(flights, outliers, found)
