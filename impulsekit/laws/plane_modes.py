"""Every mode of contacts in a plane, tried one by one.

A contact in a plane parts, sticks, or slides one way or the other; µ = 0 leaves two modes. In
each combination Coulomb's law is a linear system for the impulses and a list of inequalities.
Where the system is singular, contacts share a load; the extreme shares have a contact on the
edge of its cone or without load, so that other modes find them: the inequalities are closed.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from .borrowed import borrowing
from .compiled import compiled, entry
from .found import keep_if_new
from .tolerances import EDGE, LARGEST, ROUNDING_OF_TERMS

__all__ = ["most_modes", "plane_modes", "plane_of"]

# Modes of one contact. "Held" is P_n = f, the least normal impulse that is asked for.
PARTED, STICKS, SLIDES_UP, SLIDES_DOWN, SMOOTH = 0, 1, 2, 3, 4
HELD_STICKS, HELD_UP, HELD_DOWN, HELD_SMOOTH = 5, 6, 7, 8
# Couplings and velocities out of the plane below this share of the others are rounding, which
# leaves 1e-16 to 1e-13; what leaves a plane does so by far more.
FLAT = 1e-11
# A tangential velocity or coupling above this share tells a direction.
TOLD = 1e-7
# Pivots below this share of the entries (which are about 1): the system is singular.
NO_PIVOT = 1e-11
# A row whose largest entry is below this is taken for as large: it is what rounding has left.
LEAST_ROW = 1e-3


@entry(lambda: (np.eye(6), np.ones(6), np.ones(2), 1.0, np.ones((2, 2))), seconds=1.5)
def plane_of(
    W: np.ndarray, b: np.ndarray, mu: np.ndarray, scale: float, direction: np.ndarray
) -> bool:
    """Whether each contact with friction has a tangent that has nothing to do with all else.

    Such tangents t⊥ move by themselves alone: b = 0 there and W couples them to each other at
    most. Then Σ P⊥ ξ⊥ = P⊥ᵀ W⊥ P⊥ ≥ 0, friction asks for P⊥ ξ⊥ ≤ 0, and so ξ⊥ = 0.

    Args:
        W: (3n, 3n) Delassus matrix.
        b: (3n,) ξ without impulse.
        mu: (n,) friction.
        scale: the size of the velocities, beside which all of b may be rounding [m/s].
        direction: (n, 2), written: the other direction among the contact's two tangents.
    """
    n, speed = len(mu), scale
    for r in range(3 * n):
        speed = max(speed, abs(b[r]))
    for i in range(n):
        _main_direction(W, b, mu, speed, i, direction)
    for i in range(n):
        if not mu[i] > 0.0:
            continue
        k, c, s = 3 * i, direction[i, 0], direction[i, 1]
        if abs(c * b[k + 1] - s * b[k]) > FLAT * speed:
            return False
        own = c * c * W[k + 1, k + 1] - 2.0 * c * s * W[k, k + 1] + s * s * W[k, k]
        largest = max(W[k, k], W[k + 1, k + 1], W[k + 2, k + 2])
        for j in range(n):
            at, x, y = 3 * j, direction[j, 0], direction[j, 1]
            size = math.sqrt(largest * max(W[at, at], W[at + 1, at + 1], W[at + 2, at + 2]))
            along = c * W[k + 1, at] - s * W[k, at]
            across = c * W[k + 1, at + 1] - s * W[k, at + 1]
            coupled = abs(c * W[k + 1, at + 2] - s * W[k, at + 2])
            if mu[j] > 0.0:
                coupled = max(coupled, abs(x * along + y * across))
            if own > 0.0 and coupled > FLAT * size:
                return False
    return True


@borrowing
def _main_direction(
    W: np.ndarray, b: np.ndarray, mu: np.ndarray, speed: float, i: int, direction: np.ndarray
) -> None:
    """The tangent along which contact i slips, is coupled to a normal, or moves most."""
    k = 3 * i
    direction[i, 0], direction[i, 1] = 1.0, 0.0
    largest = max(W[k, k], W[k + 1, k + 1], W[k + 2, k + 2])
    most = TOLD
    if speed > 0.0:
        most = _longer(b[k] / speed, b[k + 1] / speed, most, i, direction)
    for j in range(len(mu)):
        at = 3 * j + 2
        size = math.sqrt(largest * W[at, at])
        if size > 0.0:
            most = _longer(W[k, at] / size, W[k + 1, at] / size, most, i, direction)
    if most == TOLD:
        half, cross = 0.5 * (W[k, k] - W[k + 1, k + 1]), W[k, k + 1]
        angle = 0.5 * math.atan2(cross, half)
        direction[i, 0], direction[i, 1] = math.cos(angle), math.sin(angle)


@borrowing
def _longer(x: float, y: float, most: float, i: int, direction: np.ndarray) -> float:
    """The length of (x, y) where it is larger than all before; then it is the direction."""
    length = math.sqrt(x * x + y * y)
    if length > most:
        direction[i, 0], direction[i, 1] = x / length, y / length
        return length
    return most


@borrowing
def most_modes(mu: np.ndarray, floor: np.ndarray) -> int:
    """How many combinations of modes there are."""
    count = 1
    for i in range(len(mu)):
        count *= _modes_of(mu[i], floor[i])
    return count


def _examples() -> tuple[Any, ...]:
    square, line, few = np.eye(4), np.ones(4), np.ones(2)
    return square, line, few, few, 1.0, square


@entry(_examples, seconds=2.0, apart=True)
def plane_modes(
    W: np.ndarray, b: np.ndarray, mu: np.ndarray, floor: np.ndarray, scale: float, found: np.ndarray
) -> int:
    """How many solutions there are in a plane; those that fit are written to ``found``.

    0 ≤ P_n − f ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n sign ξ_t where ξ_t ≠ 0, ξ = W P + b
    (Glocker & Pfeiffer 1995). Of solutions with the same P one is counted.

    Args:
        W: (2n, 2n) Delassus matrix, rows t, n of each contact.
        b: (2n,) ξ without impulse [m/s].
        mu, floor: (n,) friction, and the least normal impulses f [N s].
        scale: the size of the velocities [m/s].
        found: (most, 2n), written: P of the solutions [N s].
    """
    n = len(mu)
    unit = np.empty(n)
    for i in range(n):
        unit[i] = math.sqrt(max(W[2 * i, 2 * i], W[2 * i + 1, 2 * i + 1]))
        if not unit[i] > 0.0:
            unit[i] = 1.0
    # In units of each contact's own mobility all entries are below 1, and cones stay cones.
    own, start = np.empty((2 * n, 2 * n)), np.empty(2 * n)
    for r in range(2 * n):
        start[r] = b[r] / unit[r // 2]
        for c in range(2 * n):
            own[r, c] = W[r, c] / (unit[r // 2] * unit[c // 2])
    modes, P = np.zeros(n, dtype=np.int64), np.empty(2 * n)
    count = 0
    for number in range(most_modes(mu, floor)):
        rest = number
        for i in range(n):
            few = _modes_of(mu[i], floor[i])
            modes[i] = _mode(rest % few, mu[i], floor[i])
            rest //= few
        if not _solved(own, start, mu, floor, unit, modes, P):
            continue
        if not _obeys(own, start, mu, floor, unit, modes, P, scale):
            continue
        for i in range(n):
            P[2 * i], P[2 * i + 1] = P[2 * i] / unit[i], P[2 * i + 1] / unit[i]
        count = keep_if_new(W, P, scale, found, count)
    return count


@borrowing
def _modes_of(mu: float, floor: float) -> int:
    if mu > 0.0:
        return 6 if floor > 0.0 else 4
    return 2


@borrowing
def _mode(choice: int, mu: float, floor: float) -> int:
    """The mode behind the number of a choice."""
    if mu > 0.0:
        if choice > 0 and choice < 4:
            return choice
        if floor > 0.0:
            return HELD_STICKS if choice == 0 else choice + 2
        return PARTED
    if choice == 1:
        return SMOOTH
    return HELD_SMOOTH if floor > 0.0 else PARTED


@compiled
def _solved(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    floor: np.ndarray,
    unit: np.ndarray,
    modes: np.ndarray,
    P: np.ndarray,
) -> bool:
    """Whether the modes determine P, which is written, in units of the contacts."""
    size = len(b)
    columns, rows, ratio = np.empty(size, np.int64), np.empty(size, np.int64), np.zeros(size)
    m = 0
    for i in range(len(mu)):
        t, k = 2 * i, 2 * i + 1
        mode = modes[i]
        P[t], P[k] = 0.0, 0.0
        if mode >= HELD_STICKS:
            P[k] = floor[i] * unit[i]
            if mode in (HELD_UP, HELD_DOWN):
                P[t] = mu[i] * P[k] * (-1.0 if mode == HELD_UP else 1.0)
        elif mode != PARTED:
            columns[m], rows[m] = k, k
            if mode in (SLIDES_UP, SLIDES_DOWN):
                ratio[m] = -mu[i] if mode == SLIDES_UP else mu[i]
            m += 1
        if mode in (STICKS, HELD_STICKS):
            columns[m], rows[m] = t, t
            m += 1
    matrix, right = np.empty((m, m)), np.empty(m)
    for r in range(m):
        row = rows[r]
        total = -b[row]
        for c in range(size):
            if P[c] != 0.0:
                total -= W[row, c] * P[c]
        right[r] = total
        for c in range(m):
            at = columns[c]
            matrix[r, c] = W[row, at]
            if ratio[c] != 0.0:
                matrix[r, c] += ratio[c] * W[row, at - 1]
    if not eliminated(matrix, right):
        return False
    for c in range(m):
        at = columns[c]
        P[at] = right[c]
        if ratio[c] != 0.0:
            P[at - 1] = ratio[c] * right[c]
    return True


@borrowing
def eliminated(matrix: np.ndarray, right: np.ndarray) -> bool:
    """Whether a system is regular; then its solution stands in ``right``, by elimination."""
    m = len(right)
    for k in range(m):
        best = k
        for i in range(k + 1, m):
            if abs(matrix[i, k]) > abs(matrix[best, k]):
                best = i
        largest = 0.0
        for j in range(k, m):
            largest = max(largest, abs(matrix[best, j]))
        if not abs(matrix[best, k]) > NO_PIVOT * max(largest, LEAST_ROW):
            return False
        if best != k:
            for j in range(k, m):
                matrix[k, j], matrix[best, j] = matrix[best, j], matrix[k, j]
            right[k], right[best] = right[best], right[k]
        for i in range(k + 1, m):
            share = matrix[i, k] / matrix[k, k]
            if share != 0.0:
                for j in range(k + 1, m):
                    matrix[i, j] -= share * matrix[k, j]
                right[i] -= share * right[k]
    for k in range(m - 1, -1, -1):
        for j in range(k + 1, m):
            right[k] -= matrix[k, j] * right[j]
        right[k] /= matrix[k, k]
    return True


@compiled
def _obeys(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    floor: np.ndarray,
    unit: np.ndarray,
    modes: np.ndarray,
    P: np.ndarray,
    scale: float,
) -> bool:
    """Whether P obeys the inequalities of its modes, in units of the contacts."""
    size = len(b)
    if not np.abs(P).max() <= LARGEST * scale / unit.min():
        return False
    for i in range(len(mu)):
        t, k = 2 * i, 2 * i + 1
        mode = modes[i]
        along, across = b[t], b[k]
        terms = abs(b[t]) + abs(b[k])
        for c in range(size):
            if P[c] != 0.0:
                along += W[t, c] * P[c]
                across += W[k, c] * P[c]
                terms += (abs(W[t, c]) + abs(W[k, c])) * abs(P[c])
        near = EDGE * scale / unit[i] + ROUNDING_OF_TERMS * terms
        if mode == PARTED or mode >= HELD_STICKS:
            if across < -near:
                return False
        elif P[k] - floor[i] * unit[i] < -near:
            return False
        if mode in (STICKS, HELD_STICKS):
            if abs(P[t]) > mu[i] * P[k] + near:
                return False
        elif mode in (SLIDES_UP, HELD_UP):
            if along < -near:
                return False
        elif (mode in (SLIDES_DOWN, HELD_DOWN)) and along > near:
            return False
    return True
