"""The limit of a series of hits that follow each other ever more weakly without end.

Between two corners hits go to and fro, each smaller than the one before. In the limit none of
the contacts that are hit approaches. One that sticks does not slip either; one that slides
has been pushed along one ray. So what is still to come, x along these directions, solves
aimᵀ (u + W way x) = 0: linear equations, whatever the ratio of the series. Where contacts
are redundant these leave x open; then what is nearest to the geometric series of the last
periods is taken.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .problem import ContactProblem

__all__ = ["Jump", "find_limit", "is_at_rest"]

# Tolerances for a pull and for friction beyond its bound: shares of the largest impulse and of the
# bound.
OF_LARGEST, OF_BOUND = 1e-12, 1e-6
# An approach below this share of the velocities is rounding error.
ROUNDING = 1e-15
Hits = list[tuple[int, tuple[float, float, float]]]

# Of the velocities, what a jump may be off where slip turns on the way, or where redundant
# contacts share otherwise than they would; and for each period that the series goes on, as slip
# turns by rounding, too.
OFF, OFF_BY_PERIOD = 2e-14, 1e-15
# The same of impulses.
OFF_SHARES = 1e-9
# The rounding of the ratio of a series, which is what its sum is known to over 1 − ratio: shares of
# two contacts on bodies of one joint each were off by up to 1.3e-15.
RATIO = 1e-14
# An impulse this near the edge of its cone slides.
AT_EDGE = 1.0 - 1e-9
# Hits that shrink by less than this from one period to the next have no limit.
STEADY = 1.0 - 1e-10
# Singular values this small beside the largest are those of redundant contacts.
SERIES_REDUNDANT = 1e-11
# Solved, and again for what that has left: the slower a series, the worse are its equations.
REFINED = 3
# The longest period that is looked for, in hits of each contact.
LONGEST = 6
# What approaches after a jump more than this share of what was left did not come to its limit.
LEFT = 1e-6


class Jump(NamedTuple):
    """What is still to come of a series.

    Attributes:
        impulse: (3n,) P [N s].
        change: (3n,) of the velocities [m/s].
        off: by what u_n/√W_nn may be off, as slip turns by rounding on the way [√J].
    """

    impulse: np.ndarray
    change: np.ndarray
    off: float


def find_limit(problem: ContactProblem, velocity: np.ndarray, hits: Hits) -> Jump | None:
    """The sum of all hits to come, if they go on as the last ones; None where that is not clear.

    Args:
        problem: W and friction.
        velocity: (3n,) u now [m/s].
        hits: contact and impulse of each hit so far.
    """
    n = len(problem.friction)
    period = _period_of(hits, LONGEST * n)
    if period == 0:
        return None
    last, before = _summed(hits[-period:], n), _summed(hits[-2 * period : -period], n)
    ratio = last[2::3].sum() / before[2::3].sum() if before[2::3].sum() > 0.0 else 1.0
    if not 0.0 <= ratio < STEADY:
        return None
    modes = _modes_of(problem, hits[-2 * period :])
    if modes is None:
        return None
    way, aim, slides = modes
    matrix = aim.T @ problem.delassus @ way
    # Each row and column in its own unit.
    rows = 1.0 / np.sqrt(np.abs(np.einsum("ij,ij->j", aim, problem.delassus @ aim)))
    if not np.isfinite(rows).all():
        return None
    scaled = matrix * rows * rows[:, None]
    expected = ratio / (1.0 - ratio) * _along(way, last)
    values = np.linalg.svd(scaled, compute_uv=False)
    regular = values[-1] > SERIES_REDUNDANT * values[0]
    correction = np.zeros(len(rows))
    for _ in range(REFINED):
        missing = velocity + problem.delassus @ (way @ (expected + correction))
        correction -= (
            rows * np.linalg.lstsq(scaled, rows * (aim.T @ missing), rcond=SERIES_REDUNDANT)[0]
        )
    impulse = way @ (expected + correction)
    change = problem.delassus @ impulse
    roots = _roots(problem)
    size = float((roots * np.abs(velocity)).max())
    if not regular:
        # What the equations leave open is as the series has it, to first order.
        share = way @ correction
        if slides and (roots * np.abs(problem.delassus @ share)).max() > OFF * size:
            return None
        # A slow series is known only to the rounding of its ratio.
        to_come = RATIO / (1.0 - ratio) * np.abs(way @ expected).max()
        if np.abs(share).max() > max(OFF_SHARES * np.abs(_summed(hits, n)).max(), to_come):
            return None
    off = max(OFF, OFF_BY_PERIOD / (1.0 - ratio))
    if _turns(problem, slides, velocity, change, roots) > off * size:
        return None
    if not _holds(problem, impulse, velocity, change, roots):
        return None
    return Jump(impulse, change, off * size)


def is_at_rest(problem: ContactProblem, velocity: np.ndarray, off: float) -> bool:
    """Whether no contact approaches by more than a jump may be ``off`` [√J]: what then hits on is
    its rounding, which slow series keep and add up."""
    return bool((_roots(problem) * velocity)[2::3].min() >= -off)


def _period_of(hits: Hits, longest: int) -> int:
    """After how many hits the same contacts follow each other again, three times over; or 0."""
    order = [i for i, _ in hits[-3 * longest :]]
    for period in range(1, len(order) // 3 + 1):
        last = order[-period:]
        if last == order[-2 * period : -period] == order[-3 * period : -2 * period]:
            return period
    return 0


def _summed(hits: Hits, n: int) -> np.ndarray:
    total = np.zeros(3 * n)
    for i, impulse in hits:
        total[3 * i : 3 * i + 3] += impulse
    return total


def _modes_of(
    problem: ContactProblem, hits: Hits
) -> tuple[np.ndarray, np.ndarray, list[int]] | None:
    """Directions of P (3n, m), velocities brought to zero (3n, m), and which contacts slide."""
    size = 3 * len(problem.friction)
    way: list[np.ndarray] = []
    aim: list[np.ndarray] = []
    slides: list[int] = []
    unit = np.eye(size)
    for i in sorted({i for i, _ in hits}):
        mu = problem.friction[i].item()
        of_it = [impulse for j, impulse in hits if j == i]
        sliding = [mu and math.hypot(p1, p2) >= mu * pn * AT_EDGE for p1, p2, pn in of_it]
        if not mu:
            way.append(unit[3 * i + 2])
            aim.append(unit[3 * i + 2])
        elif all(sliding):
            p1, p2, pn = of_it[-1]
            if not pn > 0.0:
                return None
            direction = np.zeros(size)
            direction[3 * i : 3 * i + 3] = p1 / pn, p2 / pn, 1.0
            way.append(direction)
            aim.append(unit[3 * i + 2])
            slides.append(i)
        elif not any(sliding) and problem.tangential_restitution[i] > -1.0:
            rows = [k for k in range(3 * i, 3 * i + 3) if problem.delassus[k, k] > 0.0]
            way += [unit[k] for k in rows]
            aim += [unit[k] for k in rows]
        else:
            return None
    return np.array(way).T, np.array(aim).T, slides


def _along(way: np.ndarray, impulse: np.ndarray) -> np.ndarray:
    """(m,) the impulse as parts of the directions, which are orthogonal."""
    return (way.T @ impulse) / np.einsum("ij,ij->j", way, way)


def _roots(problem: ContactProblem) -> np.ndarray:
    """(3n,) 1/√W of each row that an impulse moves, which makes one unit of all velocities."""
    diagonal = problem.delassus.diagonal().copy()
    diagonal[0::3][problem.friction == 0.0] = 0.0
    diagonal[1::3][problem.friction == 0.0] = 0.0
    own = np.repeat(diagonal.reshape(-1, 3).max(axis=1), 3)
    return np.where(own > 0.0, 1.0 / np.sqrt(np.where(own > 0.0, own, 1.0)), 0.0)


def _turns(
    problem: ContactProblem,
    slides: list[int],
    velocity: np.ndarray,
    change: np.ndarray,
    roots: np.ndarray,
) -> float:
    """By what velocity the limit may be off, because slip turns on the way there [√J]."""
    worst = 0.0
    for i in slides:
        k = 3 * i
        u1, u2 = velocity[k], velocity[k + 1]
        speed = math.hypot(u1, u2)
        if not speed:
            return math.inf
        across = abs(u1 * change[k + 1] - u2 * change[k]) / speed
        worst = max(worst, across / speed)
    return worst * float((roots * np.abs(change)).max())


def _holds(
    problem: ContactProblem,
    impulse: np.ndarray,
    velocity: np.ndarray,
    change: np.ndarray,
    roots: np.ndarray,
) -> bool:
    """Whether the sum is one of hits that push, within their cones, and nothing approaches."""
    triples = impulse.reshape(-1, 3)
    tangents = np.hypot(triples[:, 0], triples[:, 1])
    size = np.abs(impulse).max(initial=0.0)
    if not np.isfinite(size) or (triples[:, 2] < -OF_LARGEST * size).any():
        return False
    if (tangents > problem.friction * triples[:, 2] * (1.0 + OF_BOUND) + OF_LARGEST * size).any():
        return False
    paces = (roots * velocity)[2::3]
    after = (roots * (velocity + change))[2::3]
    rounding = ROUNDING * float(np.abs(roots * velocity).max())
    return bool(after.min() >= LEFT * min(paces.min(), 0.0) - rounding)
