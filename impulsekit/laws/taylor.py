"""Slip that turns while the impact goes on, in 3-D.

In τ with dp = r dτ, r = |u_t|, the equations are smooth down to r = 0, at τ → ∞, and linear
but for r itself:

    du_t/dτ = w r − µ W_tt u_t,   du_n/dτ = W_nn r − µ w·u_t,   r² = u_t·u_t

So their Taylor coefficients follow one from the other, r's from those of its square (Jorba &
Zou 2005, "A software package for the numerical integration of ODEs by means of high-order
Taylor methods"). A step of such order is exact to rounding, and where in it a phase ends is
a root of a polynomial.
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .progress import (
    COMPRESSING,
    FALLS,
    FRICTION,
    ORDER,
    P1,
    P2,
    PRESSED,
    REGAINED,
    SPENT,
    U1,
    U2,
    UN,
    Block,
    P,
    PathMemory,
    is_over,
    left_to_go,
)
from .tolerances import ARRIVED
from .words import STRONGE

__all__ = ["STRAIGHT", "turn"]

# Slip that turns by less than this share of the first slip before it ends keeps its direction.
KEEPS = 1e-15
# An extreme this near the start of a step was found by the step before.
EXTREME_FOUND = 1e-8
Array = np.ndarray[tuple[int], np.dtype[np.float64]]
Matrix = np.ndarray[tuple[int, int], np.dtype[np.float64]]

# A direction that turns slower than this against its decay keeps.
STRAIGHT = 1e-13
# Slip this slow against where the stretch began has ended.
FAINT_SLIP = 1e-14
# What the last terms of a series may add.
CUT = 1e-17
LONGEST = 1e12
MOST_STEPS = 400
# 1/(k + 1): quotients take as long as many products.
INVERSE = np.array([1.0 / (k + 1) for k in range(ORDER + 1)])
# The series of u_1, u_2, u_n, |u_t|, |u_t|², |u_t| u_n; du_n/dτ; of what ends the phase.
_U1, _U2, _UN, _SPEED, _SQUARE, _POWER, _RISE, _END = range(8)


@borrowing
def turn(
    block: Block, memory: PathMemory, mu: float, law: int, e: float, target: float, scale: float
) -> bool:
    """Follow the slip to the end of the phase or of the slip, or until it keeps its direction.

    Returns:
        Whether the impact is over.
    """
    t11, t12, t22, n1, n2, nn = block
    now, series = memory.now, memory.series
    first = math.sqrt(now[U1] * now[U1] + now[U2] * now[U2])
    tangential = abs(n1) + abs(n2) + mu * (t11 + t22)
    # Per step: velocities in units of r, τ of 1/inertia, impulses of r/inertia.
    inertia = tangential + nn
    a11, a12, a22 = mu * t11 / inertia, mu * t12 / inertia, mu * t22 / inertia
    w1, w2, wn = n1 / inertia, n2 / inertia, nn / inertia
    rates = (a11, a12, a22, w1, w2, wn)
    straight = STRAIGHT * tangential / inertia
    if wn * first <= mu * (w1 * now[U1] + w2 * now[U2]):
        now[FALLS] = 1.0
    for _ in range(MOST_STEPS):
        r = math.sqrt(now[U1] * now[U1] + now[U2] * now[U2])
        if r <= FAINT_SLIP * first:
            now[U1], now[U2] = 0.0, 0.0
            return False
        s1, s2 = now[U1] / r, now[U2] / r
        turning = abs(s1 * (w2 - a12 * s1 - a22 * s2) - s2 * (w1 - a11 * s1 - a12 * s2))
        if turning <= straight and turning * r <= KEEPS * first:
            return False
        _expand(rates, now, mu, r, series)
        reached = _step(rates, memory, mu, law, e, target, r, inertia)
        if reached:
            return is_over(now, law, e, target, scale)
    return False


@borrowing
def _expand(rates: Block, now: Array, mu: float, r: float, series: Matrix) -> None:
    """Write the Taylor coefficients in τ, in units of r."""
    a11, a12, a22, w1, w2, wn = rates
    series[_U1, 0], series[_U2, 0], series[_UN, 0] = now[U1] / r, now[U2] / r, now[UN] / r
    series[_SPEED, 0], series[_SQUARE, 0] = 1.0, 1.0
    m1, m2 = mu * w1, mu * w2
    for k in range(ORDER):
        x, y, z = series[_U1, k], series[_U2, k], series[_SPEED, k]
        part = INVERSE[k]
        series[_U1, k + 1] = part * (w1 * z - a11 * x - a12 * y)
        series[_U2, k + 1] = part * (w2 * z - a12 * x - a22 * y)
        series[_UN, k + 1] = part * (wn * z - m1 * x - m2 * y)
        square = series[_U1, 0] * series[_U1, k + 1] + series[_U2, 0] * series[_U2, k + 1]
        own = 0.0
        # The products are the same from both ends; one may stand in the middle.
        for j in range(1, (k + 2) // 2):
            i = k + 1 - j
            square += series[_U1, j] * series[_U1, i] + series[_U2, j] * series[_U2, i]
            own += series[_SPEED, j] * series[_SPEED, i]
        if k % 2 == 1:
            i = (k + 1) // 2
            own += 0.5 * series[_SPEED, i] * series[_SPEED, i]
            square += 0.5 * (series[_U1, i] * series[_U1, i] + series[_U2, i] * series[_U2, i])
        series[_SQUARE, k + 1] = 2.0 * square
        series[_SPEED, k + 1] = square - own


@borrowing
def _multiply(series: Matrix) -> None:
    """Write the series of |u_t| u_n."""
    for k in range(ORDER + 1):
        total = 0.0
        for j in range(k + 1):
            total += series[_SPEED, j] * series[_UN, k - j]
        series[_POWER, k] = total


@borrowing
def _step(
    rates: Block,
    memory: PathMemory,
    mu: float,
    law: int,
    e: float,
    target: float,
    r: float,
    inertia: float,
) -> bool:
    """One step, cut where the phase ends; whether it does."""
    now, series = memory.now, memory.series
    w1, w2, wn = rates[3], rates[4], rates[5]
    h = LONGEST
    for k in range(ORDER - 1, ORDER + 1):
        size = max(abs(series[_U1, k]), abs(series[_U2, k]), abs(series[_SPEED, k]))
        if size > 0.0:
            h = min(h, (CUT / size) ** (1.0 / k))
    # On each step u_n shall rise or fall, not both.
    for k in range(ORDER):
        series[_RISE, k] = (k + 1) * series[_UN, k + 1]
    series[_RISE, ORDER] = 0.0
    if series[_RISE, 0] * _at(series, _RISE, h) < 0.0:
        lowest = _root(series, _RISE, 0.0, h)
        # Where the last step was cut there, rounding may tell so again.
        if lowest > EXTREME_FOUND * h:
            h = lowest
    fell = (
        now[COMPRESSING] == 0.0
        and series[_UN, 0] + _gain(series, _UN, h) < 0.0
        and _at(series, _RISE, h) < 0.0
    )
    if fell:
        if series[_UN, 0] > 0.0:
            _shift(series, _UN)
            h = _root(series, _END, -series[_UN, 0], h)
        else:
            h = 0.0
    in_velocity, in_impulse, in_work = left_to_go(now, law, e, target)
    if in_velocity < math.inf:
        _shift(series, _UN)
        goal = in_velocity / r
    elif in_impulse < math.inf:
        _integrate(series, _SPEED)
        goal = in_impulse * inertia / r
    else:
        _multiply(series)
        _integrate(series, _POWER)
        goal = in_work * inertia / (r * r)
    reached = _at(series, _END, h) >= goal
    if reached:
        h = _root(series, _END, goal, h)
    o1, o2 = series[_U1, 0], series[_U2, 0]
    s1, s2 = o1 + _gain(series, _U1, h), o2 + _gain(series, _U2, h)
    along = w1 * s1 + w2 * s2
    # Where slip turns past w, W_nn − µ w·s is least between the ends of the step.
    if wn * math.sqrt(s1 * s1 + s2 * s2) <= mu * along or (
        (w1 * o2 - w2 * o1) * (w1 * s2 - w2 * s1) < 0.0
        and along > 0.0
        and wn <= mu * math.sqrt(w1 * w1 + w2 * w2)
    ):
        now[FALLS] = 1.0
    unit = r / inertia
    p = unit * _total(series, _SPEED, h)
    now[P1] -= mu * unit * _total(series, _U1, h)
    now[P2] -= mu * unit * _total(series, _U2, h)
    now[P] += p
    now[FRICTION] -= mu * unit * r * _total(series, _SQUARE, h)
    if law == STRONGE:
        if now[COMPRESSING] > 0.0:
            _multiply(series)
        now[SPENT if now[COMPRESSING] > 0.0 else REGAINED] += unit * r * _total(series, _POWER, h)
    if now[COMPRESSING] > 0.0:
        now[PRESSED] += p
    now[U1], now[U2] = r * s1, r * s2
    now[UN] += r * _gain(series, _UN, h)
    if fell and not reached:
        now[UN], now[COMPRESSING] = 0.0, 1.0
    return reached


@borrowing
def _at(series: Matrix, row: int, x: float) -> float:
    total = 0.0
    for k in range(ORDER, -1, -1):
        total = total * x + series[row, k]
    return total


@borrowing
def _gain(series: Matrix, row: int, x: float) -> float:
    """By how much a series is more at x than at 0."""
    total = 0.0
    for k in range(ORDER, 0, -1):
        total = total * x + series[row, k]
    return x * total


@borrowing
def _total(series: Matrix, row: int, x: float) -> float:
    """The integral of a series from 0 to x."""
    total = 0.0
    for k in range(ORDER - 1, -1, -1):
        total = total * x + series[row, k] * INVERSE[k]
    return x * total


@borrowing
def _shift(series: Matrix, row: int) -> None:
    """A series less where it begins, as that of the end."""
    series[_END, 0] = 0.0
    for k in range(1, ORDER + 1):
        series[_END, k] = series[row, k]


@borrowing
def _integrate(series: Matrix, row: int) -> None:
    """The integral of a series, as that of the end."""
    series[_END, 0] = 0.0
    for k in range(ORDER):
        series[_END, k + 1] = series[row, k] * INVERSE[k]


@borrowing
def _root(series: Matrix, row: int, goal: float, high: float) -> float:
    """Where between 0 and ``high`` a series is ``goal``: Newton, kept in by bisection."""
    low, x = 0.0, high
    rising = _at(series, row, high) >= series[row, 0]
    for _ in range(100):
        value, slope = 0.0, 0.0
        for k in range(ORDER, -1, -1):
            slope = slope * x + value
            value = value * x + series[row, k]
        error = goal - value
        if error == 0.0:
            break
        if (error > 0.0) == rising:
            low = x
        else:
            high = x
        following = x + error / slope if slope != 0.0 else 0.5 * (low + high)
        if not (low <= following <= high):
            following = 0.5 * (low + high)
        if abs(following - x) <= ARRIVED * x:
            break
        x = following
    return x
