"""Flights of a robot in a recording, outliers, and the meeting of two flights."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..tolerances import NONZERO
from .flight import parabola_residuals

if TYPE_CHECKING:
    from collections.abc import Sequence

    from .flight import Flight, FlightFit
    from .recording import Recording

# What the last samples count for, against one a sample later: flights are tracked over some
# ten samples, so that drag and a mass a few per cent off do not count as impacts.
FADING = 0.9
# Probability that noise alone is taken for the end of a flight.
FALSE_END = 1e-6
# A flight has so many samples: two determine its speed, the third confirms it.
FEWEST = 3
# Samples after which a flight that begins inside another must have saved half of what it costs.
YOUNG = 12
# Flights are cut with so many times the noise between neighbours, when the noise is looked for:
# small bounces then hide in flights, which the median over all does not mind.
PATIENCE = 10.0
# Pieces of flights that determine the noise have so many samples, as many as fits of impacts have
# on a side; so many pieces at least determine it.
PIECE, FEWEST_FITS = 10, 4
# What a flight leaves of a piece, over what accelerations of any size leave, from which on the body
# lies or rolls there; of flights the ratio is 1 but for noise, some 0.5.
NO_FLIGHT = 3.0
# Third differences of so many samples determine the noise.
FEWEST_FOR_NOISE = 8
# The median of χ² with one degree of freedom, as a ratio to sigma: |x| of half the samples.
MEDIAN_TO_SIGMA = 0.6744897501960817
# Samples and outliers of a flight, and how many of each count.
_Ending = tuple[list[int], int, list[int], int]
# Noise is at least this [m, rad]: of recordings out of a simulator, what the rule that follows
# flights is off over ten samples; no sensor is better.
ROUNDING = 1e-6
# Neighbouring steps of time that differ by more than this share are of a gap in the recording.
UNEVEN = 0.2


@dataclass(frozen=True, eq=False)
class Segments:
    """Flights of one recording.

    Attributes:
        flights: index arrays of the samples of each, in order of time.
        outliers: indices of samples that stand apart.
    """

    flights: list[np.ndarray]
    outliers: list[int]


def flights_with_noise(
    flight: Flight, recordings: Sequence[Recording], least: np.ndarray | float = ROUNDING
) -> tuple[np.ndarray, list[Segments]] | None:
    """Return (nv,) noise of the samples of recordings, and their flights, cut with some patience.

    Cameras are off by about the same from one sample to the next: differences of neighbours show
    less than what a flight through a dozen samples leaves. So flights are cut with far more noise
    than neighbours show, and the noise is what fits to these leave. None: too few samples.
    """
    found = np.array([_of_neighbours(flight, each.t, each.q) for each in recordings])
    found = found[np.isfinite(found).all(axis=1)]
    if not len(found):
        return None
    sigma = np.maximum(np.median(found, axis=0), least)
    cuts = [find_segments(flight, each.t, each.q, PATIENCE * sigma) for each in recordings]
    squares = [
        square
        for recording, cut in zip(recordings, cuts, strict=True)
        for own in cut.flights
        for square in _fit_residuals(flight, recording, own, sigma)
    ]
    if len(squares) >= FEWEST_FITS:
        sigma = np.maximum(np.sqrt(np.median(squares, axis=0)), least)
    return sigma, cuts


def _fit_residuals(
    flight: Flight, recording: Recording, own: np.ndarray, sigma: np.ndarray
) -> list[np.ndarray]:
    """Return (nv,) mean squares of the residuals of pieces of a flight."""
    t, q, found = recording.t, recording.q, []
    for begin in range(0, len(own) - len(own) % PIECE, PIECE):
        piece = own[begin : begin + PIECE]
        middle = piece[PIECE // 2]
        span = float(t[piece[-1]] - t[piece[0]])
        v = pin.difference(flight.model, q[piece[0]], q[piece[-1]]) / span
        fit = flight.fit(t[piece], q[piece], float(t[middle]), q[middle], v, sigma)
        squares = (fit.residuals**2).sum(axis=0) / (PIECE - 2)
        other = (parabola_residuals(flight.model, t, q, piece) ** 2).sum(axis=0) / (PIECE - 3)
        if (squares / np.maximum(other, NONZERO)).mean() < NO_FLIGHT:
            found.append(squares)
    return found


def _of_neighbours(flight: Flight, t: np.ndarray, q: np.ndarray) -> np.ndarray:
    """Return (nv,) noise of samples: what they differ by from the mean of their neighbours.

    With the acceleration of free flight taken off; the median over all samples, so that impacts
    and rests do not count for much. Steps of unlike length are left out.
    """
    model, differences = flight.model, []
    for k in range(1, len(t) - 1):
        before, after = t[k] - t[k - 1], t[k + 1] - t[k]
        if abs(after - before) > UNEVEN * before:
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


class _Candidates:
    """Flights that may have begun at a sample, each with the least χ² of all samples up to now.

    Each is followed from sample to sample by Kalman's filter with fading memory; its coordinates
    share one covariance of position and speed, in units of their noise.

    Attributes:
        cost: (n,) χ². samples, outliers: of each, the indices of what it took and left.
    """

    def __init__(self, flight: Flight, t: np.ndarray, q: np.ndarray, sigma: np.ndarray) -> None:
        self._flight, self._t, self._q, self._sigma = flight, t, q, sigma
        self._time = np.zeros(0)
        self._states = np.zeros((0, q.shape[1])), np.zeros((0, flight.model.nv))
        # Variance of the position, covariance, variance of the speed.
        self._spread = np.zeros((3, 0))
        self.cost = np.zeros(0)
        self.samples: list[list[int]] = []
        self.outliers: list[list[int]] = []

    def begin(self, k: int, cost: float) -> None:
        """Begin one more, through samples k and k + 1."""
        t, q, flight = self._t, self._q, self._flight
        dt = float(t[k + 1] - t[k])
        way = pin.difference(flight.model, q[k], q[k + 1])
        rate = flight.acceleration(float(t[k]), q[k], way / dt)
        v = way / dt + 0.5 * dt * rate
        self._time = np.append(self._time, t[k + 1])
        self._states = np.vstack([self._states[0], q[k + 1]]), np.vstack([self._states[1], v])
        own = np.array([[1.0], [1.0 / dt], [2.0 / dt**2]])
        self._spread = np.hstack([self._spread, own])
        self.cost = np.append(self.cost, cost)
        self.samples.append([k, k + 1])
        self.outliers.append([])

    def follow(self, k: int, apart: float) -> None:
        """Take a sample in: it lies where a flight leads, or stands apart from it."""
        model, seen = self._flight.model, self._q[k]
        dt = float(self._t[k]) - self._time
        q, v = self._flight.step_all(self._time, *self._states, dt)
        place, both, speed = self._spread
        place = (place + 2.0 * dt * both + dt * dt * speed) / FADING
        both, speed = (both + dt * speed) / FADING, speed / FADING
        left = np.array([pin.difference(model, each, seen) for each in q]).reshape(v.shape)
        off = np.sum((left / self._sigma) ** 2, axis=1) / (place + 1.0)
        self.cost += np.minimum(off, apart)
        to_place, to_speed = place / (place + 1.0), both / (place + 1.0)
        v += to_speed[:, None] * left
        left *= to_place[:, None]
        spread = np.array([place, both, speed]) - np.array(
            [to_place * place, to_place * both, to_speed * both]
        )
        for i, far in enumerate((off > apart).tolist()):
            if far:
                self.outliers[i].append(k)
                q[i], v[i] = self._states[0][i], self._states[1][i]
                spread[:, i] = self._spread[:, i]
                continue
            self.samples[i].append(k)
            self._time[i] = self._t[k]
            q[i] = pin.integrate(model, q[i], left[i])
        self._states, self._spread = (q, v), spread

    def keep(self, kept: np.ndarray) -> None:
        """Leave the others out."""
        if kept.all():
            return
        self._time, self.cost, self._spread = (
            self._time[kept],
            self.cost[kept],
            self._spread[:, kept],
        )
        self._states = self._states[0][kept], self._states[1][kept]
        self.samples = [each for each, stays in zip(self.samples, kept, strict=True) if stays]
        self.outliers = [each for each, stays in zip(self.outliers, kept, strict=True) if stays]


def find_segments(flight: Flight, t: np.ndarray, q: np.ndarray, sigma: np.ndarray) -> Segments:
    """Cut a recording into flights, so that what noise has to explain is least.

    Optimal partitioning (Jackson et al. 2005): a flight may begin at each sample; χ² of what
    its samples are off where it leads adds up, a new flight costs what noise may save by its own
    state, and a sample that is off by more than noise counts as an outlier or lies between flights.
    """
    from scipy import stats

    nv, count = flight.model.nv, len(t)
    apart = float(stats.chi2.isf(FALSE_END, nv))
    new = float(stats.chi2.isf(FALSE_END, 2 * nv))
    # By k: the least χ² of the first k samples; the flight that ends with the last of them there,
    # its samples and outliers, and how many of each it has by then.
    least = np.arange(count + 1) * apart
    ending: list[_Ending | None] = [None] * (count + 1)
    alive = _Candidates(flight, t, q, sigma)
    for k in range(1, count):
        alive.follow(k, apart)
        alive.begin(k - 1, least[k - 1] + new)
        least[k + 1] = least[k] + apart
        for cost, samples, off in zip(
            alive.cost.tolist(), alive.samples, alive.outliers, strict=True
        ):
            if samples[-1] == k and len(samples) >= FEWEST and cost < least[k + 1]:
                least[k + 1] = cost
                ending[k + 1] = samples, len(samples), off, len(off)
        young = np.array([k - samples[0] < YOUNG for samples in alive.samples])
        alive.keep(alive.cost <= least[k + 1] + np.where(young, new, 0.5 * new))
    return _chosen(ending)


def _chosen(ending: list[_Ending | None]) -> Segments:
    """Return the flights on the way back from the end."""
    found = Segments([], [])
    end = len(ending) - 1
    while end > 0:
        last = ending[end]
        if last is None:
            end -= 1
            continue
        samples, taken, outliers, off = last
        found.flights.insert(0, np.array(samples[:taken]))
        found.outliers[:0] = outliers[:off]
        end = samples[0]
    return found


# The time of an impact is settled once it moves by less than this share of its deviation.
KINK_SETTLED = 0.02
# Eigenvalues of the information below this share of the largest are rounding.
RANK = 1e-15
MOST_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class Kink:
    """The meeting of two flights.

    Attributes:
        time: [s]. time_sigma: its standard deviation.
        q: (nq,) common to both. before, after: (nv,) velocities.
        covariance: (3 nv, 3 nv) of (δq, before, after), the uncertain time included.
        jump: χ² of the jump of the velocity with nv degrees of freedom.
        opening: χ² of what the flights are apart where they come nearest, nv − 1 degrees.
        misfit: χ² of the residuals of each flight, and its degrees of freedom.
        cost: χ² of all that noise has to explain: residuals without weights, and the opening.
    """

    time: float
    time_sigma: float
    q: np.ndarray
    before: np.ndarray
    after: np.ndarray
    covariance: np.ndarray
    jump: float
    opening: float
    misfit: tuple[tuple[float, int], tuple[float, int]]
    cost: float


def meeting_of(
    flight: Flight,
    t: np.ndarray,
    q: np.ndarray,
    sides: tuple[np.ndarray, np.ndarray],
    sigma: np.ndarray,
) -> tuple[Kink, tuple[np.ndarray, np.ndarray]] | None:
    """Return the meeting of the flights through two runs of samples; and the samples of each side.

    Samples next to the impact go to the side on which the time found puts them. None if no
    two samples stay on one of the sides.
    """
    left, right = sides
    time = 0.5 * float(t[left[-1]] + t[right[0]])
    both = np.concatenate([left, right])
    states: list[tuple[np.ndarray, np.ndarray] | None] = [None, None]
    for _ in range(MOST_ROUNDS):
        left, right = both[t[both] <= time], both[t[both] > time]
        if min(len(left), len(right)) < 2:
            return None
        fits = []
        for side, own in enumerate((left, right)):
            start = states[side] or _first_guess(flight, t, q, own, time)
            fits.append(flight.fit(t[own], q[own], time, *start, sigma))
        apart = pin.difference(flight.model, fits[0].q, fits[1].q)
        jump = fits[1].v - fits[0].v
        weight = 1.0 / sigma**2 / (fits[0].share[0, 0] + fits[1].share[0, 0])
        stiff = float(jump @ (weight * jump))
        move = -float(jump @ (weight * apart)) / max(stiff, NONZERO)
        # No further than one sample a round: far off, the flights are no straight lines.
        reach = float(np.median(np.diff(t[both])))
        move = float(np.clip(move, -reach, reach))
        states = [
            flight.step(time, fit.q, fit.v, move) if abs(move) > 0.0 else (fit.q, fit.v)
            for fit in fits
        ]
        time += move
        if abs(move) <= KINK_SETTLED / np.sqrt(max(stiff, NONZERO)):
            break
    inside = t[left[-1]] <= time + reach and t[right[0]] >= time - reach
    if not inside:
        return None
    return _joined(flight, time, fits, states, apart + move * jump, sigma), (left, right)


def _first_guess(
    flight: Flight, t: np.ndarray, q: np.ndarray, own: np.ndarray, time: float
) -> tuple[np.ndarray, np.ndarray]:
    """Return the state at a time from the first and last of some samples."""
    first, last = own[0], own[-1]
    middle = first if abs(t[first] - time) < abs(t[last] - time) else last
    near = own[1] if middle == first else own[-2]
    start, span = float(t[middle]), float(t[near] - t[middle])
    v = pin.difference(flight.model, q[middle], q[near]) / span
    v = v - 0.5 * span * flight.acceleration(start, q[middle], v)
    return flight.step(start, q[middle], v, time - start)


def _joined(
    flight: Flight,
    time: float,
    fits: list[FlightFit],
    states: list,
    apart: np.ndarray,
    sigma: np.ndarray,
) -> Kink:
    """Join both flights with one configuration at their common time, by least squares.

    Unknowns: δq, v⁻ and v⁺, each with the information of its fit, and one time for all, which
    moves the samples against the states: δ(q − v⁻ t), δ(q − v⁺ t).
    """
    model, nv = flight.model, flight.model.nv
    (q_left, v_left), (_, v_right) = states
    # Local coordinates at the left end: the right one is ``apart`` away.
    count = 3 * nv + 1
    normal, right_side = np.zeros((count, count)), np.zeros(count)
    for side, (fit, v, at) in enumerate(
        ((fits[0], v_left, np.zeros(nv)), (fits[1], v_right, apart))
    ):
        rows = np.zeros((2 * nv, count))
        rows[:nv, :nv] = np.eye(nv)
        rows[:nv, -1] = -v
        rows[nv:, :nv] = -flight.bracket(v)
        rows[nv:, (1 + side) * nv : (2 + side) * nv] = np.eye(nv)
        weighed = rows.T @ np.kron(np.linalg.inv(fit.share), np.diag(1.0 / sigma**2))
        normal += weighed @ rows
        right_side += weighed @ np.concatenate([at, -flight.bracket(v) @ at])
    covariance = np.linalg.pinv(normal, hermitian=True, rcond=RANK)
    found = covariance @ right_side
    q = pin.integrate(model, q_left, found[:nv])
    jump = v_right - v_left
    spread = sigma**2 * (fits[0].share[1, 1] + fits[1].share[1, 1])
    open_by = sigma**2 * (fits[0].share[0, 0] + fits[1].share[0, 0])
    opening = float(apart @ (apart / open_by))
    return Kink(
        time + float(found[-1]),
        float(np.sqrt(covariance[-1, -1])),
        q,
        v_left + found[nv : 2 * nv],
        v_right + found[2 * nv : -1],
        covariance[:-1, :-1],
        float(jump @ (jump / spread)),
        opening,
        (_misfit(fits[0], sigma), _misfit(fits[1], sigma)),
        opening + sum(float(((fit.residuals / sigma) ** 2).sum()) for fit in fits),
    )


def _misfit(fit: FlightFit, sigma: np.ndarray) -> tuple[float, int]:
    squares = (fit.weights[:, None] * (fit.residuals / sigma) ** 2).sum()
    return float(squares), fit.residuals.size - 2 * fit.residuals.shape[1]
