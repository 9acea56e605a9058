"""Forces at points that rest: Newton on the natural map, and contact after contact.

The law is that of ``resting``. Newton starts from the last solution (natural map: Alart & Curnier
1991); contact after contact is for where it does not get there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from .approach import block_at
from .borrowed import borrowed, borrowing
from .compiled import compiled
from .coulomb import coulomb
from .dense import factorize, put_rows, solve_factorized
from .tolerances import LEAST_PIVOT, RESIDUAL_LIMIT, SETTLED, SINGULAR

__all__ = ["Points", "Room", "bounded", "points_of", "room_of", "solve_points"]

MOST_STEPS = 25
# Rounds of contact after contact, and how often each goes over all of them.
MOST_ROUNDS_OF_SWEEPS, SWEEPS = 20, 50
# Newton stops below the first, and after a few steps below the second: rounding is all there is.
NOTHING, ENOUGH, FEW = 1e-14, 1e-12, 8
# A Newton step that is so large, or leaves so much, comes from a slope that is nearly singular:
# the shortest of those that leave the least is taken, of singular values down to SINGULAR.
HUGE, STEP_LEFT = 1e8, 1e-9
# What a point does: it sticks, parts or is at its own bound (1), carries no friction for it bears
# no load (2), slips (4).
_PARTS, _IDLE, _SLIPS = 1, 2, 4


class Room(NamedTuple):
    """What Newton works in, and the last slope with its factor.

    Attributes:
        slope, factor: (m, m). order: (m,) of the rows of the factor.
        doing, did: (n,) what the points do, and did when the slope was factorized; −1 for none.
        slip: (n, 3) of what slips the direction, and which part of what it aims at is its cone.
        value, step: (m,) F, and room.
    """

    slope: np.ndarray
    factor: np.ndarray
    order: np.ndarray
    doing: np.ndarray
    did: np.ndarray
    slip: np.ndarray
    value: np.ndarray
    step: np.ndarray


class Points(NamedTuple):
    """The points, and how their unknowns are laid out.

    Attributes:
        first: (n,) the first row of each.
        mu: (n,) µ; 0 for those with the normal alone, −τ_c for a row with a bound of its own.
        rate, tangential: (n,) rates of normal and tangents [1/kg].
        scale: the size of the accelerations [m/s²].
    """

    first: np.ndarray
    mu: np.ndarray
    rate: np.ndarray
    tangential: np.ndarray
    scale: float


@borrowing
def bounded(force: float, mu: float) -> float:
    """The force of a lone row, or what is nearest to it: no pull (mu = 0), no more than −mu."""
    return max(0.0, force) if mu == 0.0 else max(mu, min(force, -mu))


@compiled
def room_of(m: int, n: int) -> Room:
    """Room for m rows of n points."""
    return Room(
        np.empty((m, m)),
        np.empty((m, m)),
        np.empty(m, np.int64),
        np.zeros(n, np.int64),
        np.full(n, -1, np.int64),
        np.empty((n, 3)),
        np.empty(m),
        np.empty(m),
    )


@compiled
def points_of(delassus: np.ndarray, friction: np.ndarray, scale: float) -> Points:
    """The points with their rates: without friction's part, which may turn a diagonal's sign."""
    n = len(friction)
    first, rate, tangential = np.empty(n, np.int64), np.empty(n), np.empty(n)
    least = 0.0
    for i in range(len(delassus)):
        least = max(least, LEAST_PIVOT * abs(delassus[i, i]))
    least = least if least > 0.0 else 1.0
    at = 0
    for i in range(n):
        first[i] = at
        along = 0.0
        if friction[i] > 0.0:
            along = delassus[at, at] + delassus[at + 1, at + 1]
            at += 2
        rate[i] = max(delassus[at, at], least)
        tangential[i] = max(along, least)
        at += 1
    return Points(first, friction, rate, tangential, scale)


@compiled
def solve_points(
    coupled: np.ndarray, free: np.ndarray, points: Points, start: np.ndarray, room: Room
) -> tuple[np.ndarray, float]:
    """(m,) the best forces, and their residual relative to the accelerations."""
    best, residual = _newton(coupled, free, points, start, room)
    if residual > RESIDUAL_LIMIT and np.abs(start).max() > 0.0:
        other, error = _newton(coupled, free, points, np.zeros(len(start)), room)
        if error < residual:
            best, residual = other, error
    if not residual <= RESIDUAL_LIMIT:
        swept = np.zeros(len(start))
        for _ in range(MOST_ROUNDS_OF_SWEEPS):
            _sweep(coupled, free, points, swept)
            best, residual = _newton(coupled, free, points, swept, room)
            if residual <= RESIDUAL_LIMIT:
                break
    if residual <= RESIDUAL_LIMIT:
        _free(coupled, free, points, best)
    return best, residual


@borrowing
def _free(coupled: np.ndarray, free: np.ndarray, points: Points, P: np.ndarray) -> None:
    """Take loads of rounding off points that part: one that bears a load does not lift."""
    for i in range(len(points.mu)):
        mu, at = points.mu[i], points.first[i]
        n = at if mu <= 0.0 else at + 2
        load = points.rate[i] * P[n]
        if mu < 0.0 or abs(load) > RESIDUAL_LIMIT * points.scale:
            continue
        if load <= _by_others(coupled, free, P, n, n, 0):
            for k in range(at, n + 1):
                P[k] = 0.0


@borrowing
def _sweep(coupled: np.ndarray, free: np.ndarray, points: Points, P: np.ndarray) -> None:
    """Contact after contact in closed form (projected Gauss-Seidel): slow and hardy."""
    for _ in range(SWEEPS):
        largest = 0.0
        for i in range(len(points.mu)):
            k, mu = points.first[i], points.mu[i]
            if mu < 0.0:
                own = _by_others(coupled, free, P, k, k, 1)
                pn = bounded(-own / max(coupled[k, k], LEAST_PIVOT * points.rate[i]), mu)
                largest = max(largest, abs(coupled[k, k] * (pn - P[k])))
                P[k] = pn
                continue
            if mu == 0.0:
                block = (0.0, 0.0, 0.0, 0.0, 0.0, coupled[k, k])
                own = _by_others(coupled, free, P, k, k, 1)
                (_, _, pn), _ = coulomb(block, 0.0, 0.0, own, 0.0, points.scale)
                largest = max(largest, abs(coupled[k, k] * (pn - P[k])))
                P[k] = pn
                continue
            found, _ = coulomb(
                block_at(coupled, k),
                _by_others(coupled, free, P, k, k, 3),
                _by_others(coupled, free, P, k + 1, k, 3),
                _by_others(coupled, free, P, k + 2, k, 3),
                mu,
                points.scale,
            )
            for j in range(3):
                largest = max(largest, abs(coupled[k + j, k + j] * (found[j] - P[k + j])))
            P[k], P[k + 1], P[k + 2] = found
        if largest <= SETTLED * points.scale:
            return


@borrowing
def _by_others(
    coupled: np.ndarray, free: np.ndarray, P: np.ndarray, row: int, k: int, count: int
) -> float:
    """ξ of a row without what its own contact, of rows k to k + count, adds."""
    total = free[row]
    for j in range(len(P)):
        if j < k or j >= k + count:
            total += coupled[row, j] * P[j]
    return float(total)


@compiled
def _newton(
    coupled: np.ndarray, free: np.ndarray, points: Points, start: np.ndarray, room: Room
) -> tuple[np.ndarray, float]:
    """The best P found from a start, and its residual relative to the accelerations.

    The factor of the last slope serves again where the points do what they did.
    """
    coupled, free, start = borrowed(coupled), borrowed(free), borrowed(start)
    points, room = borrowed(points), borrowed(room)
    m = len(free)
    P, best, least = start.copy(), start.copy(), math.inf
    value, step = room.value, room.step
    for count in range(MOST_STEPS + 1):
        bends = _value(coupled, free, points, P, room)
        size = total = 0.0
        for i in range(m):
            size = max(size, abs(value[i]))
            total += abs(value[i])
        residual = size / points.scale
        # The sum tells of what is no number; the largest need not.
        if not total < math.inf:
            break
        if residual < least:
            least = residual
            best[:] = P
        if residual < NOTHING or count == MOST_STEPS or (count > FEW and least < ENOUGH):
            break
        if bends or not _as_before(room):
            _slope(coupled, points, room)
            put_rows(room.slope, room.factor)
            regular = factorize(room.factor, m, room.order)
            room.did[:] = room.doing
            if bends or not regular:
                room.did[0] = -1
        else:
            regular = True
        if regular:
            step[:] = value
            solve_factorized(room.factor, m, room.order, step)
            regular = _solves(room.slope, step, value, size)
        if not regular:
            step[:] = np.linalg.lstsq(room.slope, value, SINGULAR)[0]
        for i in range(m):
            P[i] -= step[i]
    return best, least


@borrowing
def _as_before(room: Room) -> bool:
    same = True
    for i in range(len(room.did)):
        same = same and room.did[i] == room.doing[i]
    return same


@borrowing
def _solves(slope: np.ndarray, step: np.ndarray, value: np.ndarray, size: float) -> bool:
    """Whether a Newton step is what a regular slope gives."""
    m = len(step)
    longest = largest = 0.0
    for i in range(m):
        off = -value[i]
        longest = max(longest, abs(step[i]))
        for j in range(m):
            off += slope[i, j] * step[j]
            largest = max(largest, abs(slope[i, j]))
        if not abs(off) <= STEP_LEFT * size:
            return False
    return longest * largest <= HUGE * size


@borrowing
def _value(
    coupled: np.ndarray, free: np.ndarray, points: Points, P: np.ndarray, room: Room
) -> bool:
    """Write F(P) [m/s²] and what the points do; whether some slip, so that F bends with P."""
    m, value, doing = len(free), room.value, room.doing
    for i in range(m):
        total = free[i]
        for j in range(m):
            total += coupled[i, j] * P[j]
        value[i] = total
    bends = False
    for i in range(len(points.mu)):
        at, mu, rate, tangential = points.first[i], points.mu[i], points.rate[i], 0.0
        if mu < 0.0:
            bound = bounded(P[at] - value[at] / rate, mu)
            doing[i] = _PARTS if abs(bound) == -mu else 0
            if doing[i]:
                value[at] = rate * (P[at] - bound)
            continue
        n = at if mu == 0.0 else at + 2
        doing[i] = _PARTS if rate * P[n] <= value[n] else 0
        if mu != 0.0:
            tangential = points.tangential[i]
            aim1 = P[at] - value[at] / tangential
            aim2 = P[at + 1] - value[at + 1] / tangential
            size, bound = math.sqrt(aim1 * aim1 + aim2 * aim2), mu * max(P[n], 0.0)
            if not size <= bound:
                if bound > 0.0:
                    doing[i] += _SLIPS
                    bends = True
                    room.slip[i, 0], room.slip[i, 1] = aim1 / size, aim2 / size
                    room.slip[i, 2] = bound / size
                    value[at] = tangential * (P[at] - bound * aim1 / size)
                    value[at + 1] = tangential * (P[at + 1] - bound * aim2 / size)
                else:
                    doing[i] += _IDLE
                    value[at] = tangential * P[at]
                    value[at + 1] = tangential * P[at + 1]
        if doing[i] & _PARTS:
            value[n] = rate * P[n]
    return bends


@borrowing
def _slope(coupled: np.ndarray, points: Points, room: Room) -> None:
    """Write the slope of F for what the points do."""
    m, slope = len(coupled), room.slope
    put_rows(coupled, slope)
    for i in range(len(points.mu)):
        at, mu, doing = points.first[i], points.mu[i], room.doing[i]
        n = at if mu <= 0.0 else at + 2
        rate = points.tangential[i]
        if doing & _IDLE:
            for k in (at, at + 1):
                slope[k] = 0.0
                slope[k, k] = rate
        elif doing & _SLIPS:
            # P_t = bound · aim/|aim|, and the bound goes with P_n.
            s1, s2, part = room.slip[i, 0], room.slip[i, 1], room.slip[i, 2]
            t11, t12, t22 = part * (1.0 - s1 * s1), -part * s1 * s2, part * (1.0 - s2 * s2)
            for j in range(m):
                one, two = coupled[at, j], coupled[at + 1, j]
                slope[at, j] = t11 * one + t12 * two
                slope[at + 1, j] = t12 * one + t22 * two
            slope[at, at] += rate * (1.0 - t11)
            slope[at, at + 1] -= rate * t12
            slope[at + 1, at] -= rate * t12
            slope[at + 1, at + 1] += rate * (1.0 - t22)
            slope[at, n] -= rate * mu * s1
            slope[at + 1, n] -= rate * mu * s2
        if doing & _PARTS:
            slope[n] = 0.0
            slope[n, n] = points.rate[i]
