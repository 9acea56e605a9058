"""Implicit steps of a ``Wave`` whose friction is stiff: Radau IIA of order 5.

Two points that hold a body against turning slip slowly beside how fast friction changes them: it
takes the time |u|/(µ F W) for their slip to follow the rest, and explicit steps are no longer than
that. Hairer & Wanner, Solving Ordinary Differential Equations II, IV.8 (1996).
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import entry
from .dense import factorize, solve_factorized
from .wave import any_held, find_forces, rates, velocities
from .wave_holds import direction, hold
from .wave_state import FAINT, SLIPS, Array, Integers, Matrix, Wave, wave

__all__ = ["implicit_trial"]

_ROOT = math.sqrt(6.0)
# Of the stages: when they are, and how their rates make up the way to them.
NODES = np.array([(4.0 - _ROOT) / 10.0, (4.0 + _ROOT) / 10.0, 1.0])
FROM = np.array(
    [
        [(88 - 7 * _ROOT) / 360, (296 - 169 * _ROOT) / 1800, (-2 + 3 * _ROOT) / 225],
        [(296 + 169 * _ROOT) / 1800, (88 + 7 * _ROOT) / 360, (-2 - 3 * _ROOT) / 225],
        [(16 - _ROOT) / 36, (16 + _ROOT) / 36, 1 / 9],
    ]
)
# Of the error's estimate (IV.8.19): the ways to the stages, and the real eigenvalue.
ERROR = np.array([-13.0 - 7.0 * _ROOT, -13.0 + 7.0 * _ROOT, -1.0]) / 3.0
REAL = 3.0 + 3.0 ** (2.0 / 3.0) - 3.0 ** (1.0 / 3.0)
# The estimate is of order 3, the step of order 5: an estimate of this leaves errors below 1e-14.
STIFF_TOLERANCE = 1e-10
# Of the slowest slip, the step of differences: its square and rounding cost as many digits.
STEP = 1e-3
# Newton has arrived; it has gone as far as rounding lets it; and it is given up.
STAGES_ARRIVED, ROUNDED, MOST_TURNS = 1e-15, 1e-13, 20


def _examples() -> tuple[object, ...]:
    return wave(1, 3), 0.1


@entry(_examples, seconds=8.0, apart=True)
def implicit_trial(w: Wave, h: float) -> float:
    """A step of h, whose y is left in ``w.trial``.

    Returns:
        The error over what it may be, squared as if the estimate were of order 7; infinity
        where Newton does not arrive.
    """
    w = borrowed(w)
    m, r = len(w.y), len(w.free)
    slope, rate, ways = np.empty((r, r)), np.empty(m), np.empty((3, m))
    matrix, right, order = np.empty((3 * r, 3 * r)), np.empty(3 * r), np.empty(3 * r, np.int64)
    rates(w, w.y, rate)
    _find_slope(w, rate, slope)
    for i in range(3):
        for k in range(m):
            ways[i, k] = NODES[i] * h * rate[k]
    for i in range(3):
        for j in range(3):
            for a in range(r):
                for b in range(r):
                    one = 1.0 if i == j and a == b else 0.0
                    matrix[i * r + a, j * r + b] = one - h * FROM[i, j] * slope[a, b]
    if not factorize(matrix, 3 * r, order) or not _newton(w, h, ways, matrix, right, order):
        return math.inf
    for a in range(r):
        for b in range(r):
            matrix[a, b] = (REAL / h if a == b else 0.0) - slope[a, b]
    if not factorize(matrix, r, order):
        return math.inf
    error = _error(w, h, ways, rate, matrix, right, order)
    if error > 1.0:
        # What is stiff is filtered once more (IV.8.20).
        for k in range(m):
            w.trial[k] = w.y[k] + w.error[k]
        rates(w, w.trial, rate)
        error = _error(w, h, ways, rate, matrix, right, order)
    for k in range(m):
        w.trial[k] = w.y[k] + ways[2, k]
    rates(w, w.trial, w.error)
    return error * error


@borrowing
def _find_slope(w: Wave, rate: Array, slope: Matrix) -> None:
    """How the rates of the impulses change with the impulses (r, r).

    Friction µF against slip u turns with it: dF_t/du = -µF (1 - s sᵀ)/|u|, and what sticks answers
    linearly. Where contacts are held, which give friction its µF, by differences.
    """
    if any_held(w.mode):
        _by_differences(w, rate, slope)
        return
    r = len(w.free)
    for a in range(r):
        for b in range(r):
            slope[a, b] = 0.0
    for i in range(len(w.kappa)):
        t = w.tangent[i]
        if t < 0 or w.slip[i] != SLIPS:
            continue
        u1, u2 = float(w.u[t]), float(w.u[t + 1])
        speed = math.sqrt(u1 * u1 + u2 * u2)
        s1, s2 = direction(w, i)
        if speed <= FAINT or u1 * s1 + u2 * s2 <= 0.0:
            continue
        # All forces beside one across the slip.
        across = -w.mu[i] * rate[w.normal[i]] / speed
        for a in range(r):
            w.force[a] = 0.0
        w.force[t], w.force[t + 1] = -s2, s1
        hold(w)
        for b in range(r):
            turned = across * (s1 * w.W[t + 1, b] - s2 * w.W[t, b])
            for a in range(r):
                slope[a, b] += w.force[a] * turned
    velocities(w.W, w.reach, w.free, w.y, w.u)
    find_forces(w, w.y)


@borrowing
def _by_differences(w: Wave, rate: Array, slope: Matrix) -> None:
    """``_find_slope`` by differences."""
    r, slowest = len(w.free), math.inf
    for i in range(len(w.kappa)):
        t = w.tangent[i]
        if w.slip[i] == SLIPS:
            slowest = min(slowest, math.sqrt(w.u[t] ** 2 + w.u[t + 1] ** 2))
    slowest = 1.0 if slowest == math.inf else max(slowest, FAINT)
    for b in range(r):
        own = float(w.W[b, b])
        step = STEP * slowest / own if own > 0.0 else STEP
        for k in range(len(w.y)):
            w.trial[k] = w.y[k]
        w.trial[b] += step
        rates(w, w.trial, w.error)
        for a in range(r):
            slope[a, b] = (w.error[a] - rate[a]) / step


@borrowing
def _newton(w: Wave, h: float, ways: Matrix, matrix: Matrix, right: Array, order: Integers) -> bool:
    """The ways to the stages; indentations and works, which are not stiff, follow by themselves."""
    m, r, before = len(w.y), len(w.free), math.inf
    for _ in range(MOST_TURNS):
        for i in range(3):
            for k in range(m):
                w.trial[k] = w.y[k] + ways[i, k]
            rates(w, w.trial, w.stages[i])
        most = 0.0
        for i in range(3):
            for k in range(m):
                way = 0.0
                for j in range(3):
                    way += h * FROM[i, j] * w.stages[j, k]
                if k < r:
                    right[i * r + k] = way - ways[i, k]
                else:
                    most = max(most, abs(way - ways[i, k]) / (0.1 + abs(w.y[k])))
                    ways[i, k] = way
        solve_factorized(matrix, 3 * r, order, right)
        for i in range(3):
            most = max(most, _speed_of(w, right, i * r))
            for k in range(r):
                ways[i, k] += right[i * r + k]
        if not most < math.inf:
            return False
        if most <= STAGES_ARRIVED or (most <= ROUNDED and most >= 0.5 * before):
            return True
        before = most
    return before <= ROUNDED


@borrowing
def _error(
    w: Wave, h: float, ways: Matrix, rate: Array, matrix: Matrix, right: Array, order: Integers
) -> float:
    """The error over what it may be, and itself in ``w.error``."""
    m, r, total = len(w.y), len(w.free), 0.0
    for k in range(m):
        part = rate[k]
        for j in range(3):
            part += ERROR[j] * ways[j, k] / h
        if k < r:
            right[k] = part
        w.error[k] = part * h / REAL
    solve_factorized(matrix, r, order, right)
    for k in range(m):
        if k < r:
            w.error[k] = right[k]
        else:
            total += (w.error[k] / (STIFF_TOLERANCE * (0.1 + abs(w.y[k])))) ** 2
    total += r * (_speed_of(w, right, 0) / (0.1 * STIFF_TOLERANCE)) ** 2
    return math.sqrt(total / m)


@borrowing
def _speed_of(w: Wave, impulse: Array, first: int) -> float:
    """The largest velocity that impulses, from number ``first`` on, would give.

    What contacts that depend on each other share gives none, and is uncertain where slip is slow.
    """
    r, most = len(w.free), 0.0
    for a in range(r):
        speed = 0.0
        for b in range(r):
            speed += w.W[a, b] * impulse[first + b]
        most = max(most, abs(speed))
    return most
