"""Two flights that meet: when, where, and how fast on both sides, with covariance."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pinocchio as pin

from ..tolerances import NONZERO
from .flight import left_by_parabolas

if TYPE_CHECKING:
    from .flight import Flight, FlightFit

__all__ = ["Kink", "is_smooth", "meeting_of"]

# χ² by which a kink must explain samples better than a smooth way with another acceleration, which
# has one unknown less: noise makes the kink that much better once in 10^4 times.
KINK_BETTER = 15.0

# The time of an impact is settled once it moves by less than this share of its deviation.
KINK_SETTLED = 0.02
# Eigenvalues of the information below this share of the largest are rounding.
RANK = 1e-15
MOST_ROUNDS = 8


@dataclass(frozen=True, eq=False)
class Kink:
    """Where two flights meet.

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
    """Where the flights through two runs of samples meet; and the samples of each side.

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
    """The state at a time from the first and last of some samples."""
    first, last = own[0], own[-1]
    middle = first if abs(t[first] - time) < abs(t[last] - time) else last
    v = np.zeros(flight.model.nv)
    span = float(t[last] - t[first])
    near = own[1] if middle == first else own[-2]
    v = pin.difference(flight.model, q[middle], q[near]) / float(t[near] - t[middle])
    rate = flight.acceleration(float(t[middle]), q[middle], v)
    v = v - 0.5 * rate * float(t[near] - t[middle])
    return flight.step(float(t[middle]), q[middle], v, time - float(t[middle])) if span else (q, v)


def _joined(
    flight: Flight,
    time: float,
    fits: list[FlightFit],
    states: list,
    apart: np.ndarray,
    sigma: np.ndarray,
) -> Kink:
    """Both flights with one configuration at their common time, by least squares.

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


def is_smooth(
    flight: Flight, t: np.ndarray, q: np.ndarray, own: np.ndarray, sigma: np.ndarray, cost: float
) -> bool:
    """Whether constant accelerations, of any size, explain samples as well as a kink does.

    A body that slides or rolls is no flight; cut into short pieces of flight it seems to bounce.

    Args:
        own: indices of the samples on both sides. cost: of the kink, see ``Kink``.
    """
    left = left_by_parabolas(flight.model, t, q, own) / sigma
    return float((left**2).sum()) < cost + KINK_BETTER
