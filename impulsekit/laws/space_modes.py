"""Modes of contacts in space: who parts, sticks and slides, and which way.

In a mode the contacts that stick, and those without friction that are pressed, are eliminated.
Those that slide leave two equations each, ξ_n = 0 and s⊥·ξ_t = 0, for P_n and the angle of slip:
P = P_n (−µ s, 1). Newton's method solves these from directions all around at once. What it finds
are solutions; that there are no others is not proven by it.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..tolerances import NONZERO
from .compiled import compiled, entry
from .found import SAME, keep_if_new
from .tolerances import EDGE, LARGEST, LEAST_PIVOT, ROUNDING_OF_TERMS, SINGULAR

__all__ = ["space_modes"]

# Largest residual of Newton's method at a solution, near singular systems too.
MODE_LEFT = 1e-6
# Where Newton has arrived before the last round: the step after would be of no account.
MODE_ARRIVED = 1e-10
PARTED, STICKS, SLIDES = 0, 1, 2
# Directions to start from, by the number of contacts that slide with friction.
STARTS = (1, 16, 8, 6, 4)
# Steps of a round, after which those that arrived stop, and rounds. Half arrive in two rounds, of
# problems with strong friction eight of nine in six; 16 steps missed one answer of 300.
STEPS, ROUNDS = 4, 8
# The largest turn of a step [rad].
TURN = 0.6


def _examples() -> tuple[Any, ...]:
    return np.eye(6), np.ones(6), np.ones(2), 1.0, np.eye(6), np.eye(6)


@entry(_examples, seconds=6.0, apart=True)
def space_modes(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    scale: float,
    found: np.ndarray,
    outside: np.ndarray,
) -> tuple[int, int]:
    """How many solutions were found, and how many are none by cones of what sticks alone.

    Contacts that stick are given the shortest of the impulses that hold them. Where they are
    redundant, another share may lie in their cones.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg]; up to 4 contacts with friction.
        b: (3n,) ξ without impulse [m/s].
        mu: (n,) friction.
        scale: the size of the velocities [m/s].
        found: (most, 3n), written: P of the solutions [N s].
        outside: (any number, 3n), written: P of what leaves a cone of sticking, and obeys the rest.
    """
    n = len(mu)
    unit = np.ones(n)
    for i in range(n):
        most = max(W[3 * i, 3 * i], W[3 * i + 1, 3 * i + 1], W[3 * i + 2, 3 * i + 2])
        unit[i] = math.sqrt(most) if most > 0.0 else 1.0
    own, start, P = np.empty((3 * n, 3 * n)), np.empty(3 * n), np.zeros(3 * n)
    for r in range(3 * n):
        start[r] = b[r] / unit[r // 3]
        for c in range(3 * n):
            own[r, c] = W[r, c] / (unit[r // 3] * unit[c // 3])
    modes = np.zeros(n, dtype=np.int64)
    count, beyond = 0, 0
    for number in range(3**n):
        rest = number
        slow, held = False, False
        for i in range(n):
            modes[i] = rest % 3
            rest //= 3
            held = held or modes[i] == STICKS
            # Without friction a contact that is pressed "slides" in no direction.
            slow = slow or (modes[i] == STICKS and mu[i] == 0.0)
        if slow:
            continue
        candidates = _in_modes(own, start, mu, modes)
        for k in range(len(candidates)):
            for r in range(3 * n):
                P[r] = candidates[k, r]
            obeys = _obeys(own, start, mu, unit, modes, P, scale, True)
            if not obeys and not (held and _obeys(own, start, mu, unit, modes, P, scale, False)):
                continue
            for r in range(3 * n):
                P[r] /= unit[r // 3]
            if obeys:
                count = keep_if_new(W, P, scale, found, count)
            else:
                beyond = keep_if_new(W, P, scale, outside, beyond)
    return count, beyond


@compiled
def _in_modes(W: np.ndarray, b: np.ndarray, mu: np.ndarray, modes: np.ndarray) -> np.ndarray:
    """(k, 3n) the impulses that Newton finds in given modes, in units of the contacts."""
    n = len(mu)
    size = 3 * n
    still, moving = np.empty(size, np.int64), np.empty(n, np.int64)
    s, m = 0, 0
    for i in range(n):
        if modes[i] == STICKS or (modes[i] == SLIDES and mu[i] == 0.0):
            # Without friction the normal alone is held.
            for row in range(3 * i if modes[i] == STICKS else 3 * i + 2, 3 * i + 3):
                still[s] = row
                s += 1
        elif modes[i] == SLIDES:
            moving[m] = i
            m += 1
    # W and b of what slides, with what is held eliminated; P of that = held − share P of this.
    near, right = np.empty((3 * m, 3 * m)), np.empty(3 * m)
    share, held = np.zeros((s, 3 * m)), np.zeros(s)
    if s > 0:
        block = np.empty((s, s))
        for r in range(s):
            for c in range(s):
                block[r, c] = W[still[r], still[c]]
        inverse = _pseudo_inverse(block)
        for r in range(s):
            for k in range(s):
                held[r] -= inverse[r, k] * b[still[k]]
                for c in range(3 * m):
                    share[r, c] += inverse[r, k] * W[still[k], 3 * moving[c // 3] + c % 3]
    for r in range(3 * m):
        row = 3 * moving[r // 3] + r % 3
        right[r] = b[row]
        for k in range(s):
            right[r] += W[row, still[k]] * held[k]
        for c in range(3 * m):
            near[r, c] = W[row, 3 * moving[c // 3] + c % 3]
            for k in range(s):
                near[r, c] -= W[row, still[k]] * share[k, c]
    if m == 0:
        alone = np.zeros((1, size))
        for k in range(s):
            alone[0, still[k]] = held[k]
        return alone
    rubs = np.empty(m)
    for i in range(m):
        rubs[i] = mu[moving[i]]
    slid = _slides(near, right, rubs)
    found = np.zeros((len(slid), size))
    for k in range(len(slid)):
        for c in range(3 * m):
            found[k, 3 * moving[c // 3] + c % 3] = slid[k, c]
        for r in range(s):
            total = held[r]
            for c in range(3 * m):
                total -= share[r, c] * slid[k, c]
            found[k, still[r]] = total
    return found


@compiled
def _pseudo_inverse(block: np.ndarray) -> np.ndarray:
    """Of a symmetric matrix, without the directions that move nothing."""
    size = len(block)
    values, vectors = np.linalg.eigh(block)
    inverse = np.zeros((size, size))
    for k in range(size):
        if values[k] > SINGULAR * values[size - 1]:
            for r in range(size):
                for c in range(size):
                    inverse[r, c] += vectors[r, k] * vectors[c, k] / values[k]
    return inverse


@compiled
def _slides(W: np.ndarray, b: np.ndarray, mu: np.ndarray) -> np.ndarray:
    """(k, 3m) impulses with ξ_n = 0 and slip along −P_t, of m contacts that slide with friction."""
    m = len(mu)
    each = STARTS[m]
    lanes = each**m
    angle, load = np.empty((m, lanes)), np.zeros((m, lanes))
    number = np.arange(lanes)
    for i in range(m):
        # From the slip without impulse, to both sides alike: no axes decide what is found.
        first = math.atan2(b[3 * i + 1], b[3 * i])
        angle[i] = first + (number % each + 0.5) * (2.0 * math.pi / each)
        number = number // each
    found = np.empty((lanes, 3 * m))
    count = 0
    for turn in range(ROUNDS):
        rest = _steps(W, b, mu, angle, load, turn == 0)
        bar = MODE_LEFT if turn == ROUNDS - 1 else MODE_ARRIVED
        going = np.empty(len(rest), np.int64)
        more = 0
        for lane in range(len(rest)):
            if rest[lane] < bar:
                count = _keep(mu, angle, load, lane, found, count)
            elif rest[lane] < math.inf:
                # NaN goes nowhere.
                going[more] = lane
                more += 1
        if more == 0:
            break
        angle, load = angle[:, going[:more]], load[:, going[:more]]
    return found[:count]


@compiled
def _keep(
    mu: np.ndarray, angle: np.ndarray, load: np.ndarray, lane: int, found: np.ndarray, count: int
) -> int:
    """Write the impulses of a lane to ``found``, if they are not there; how many there are."""
    for i in range(len(mu)):
        k, a = load[i, lane], angle[i, lane]
        found[count, 3 * i] = -mu[i] * k * math.cos(a)
        found[count, 3 * i + 1] = -mu[i] * k * math.sin(a)
        found[count, 3 * i + 2] = k
    for other in range(count):
        apart = np.abs(found[other] - found[count]).max()
        if apart <= SAME * np.abs(found[count]).max():
            return count
    return count + 1


@compiled
def _steps(
    W: np.ndarray, b: np.ndarray, mu: np.ndarray, angle: np.ndarray, load: np.ndarray, begins: bool
) -> np.ndarray:
    """Newton's steps of a round in all lanes; how far the last one went.

    Args:
        W, b, mu: of m contacts that slide with friction.
        angle, load: (m, lanes) of slip, and P_n; changed.
        begins: whether loads are still to be found for the angles as they are.
    """
    m, lanes = angle.shape
    scale = max(np.abs(b).max(), NONZERO)
    system, miss = np.empty((2 * m, 2 * m, lanes)), np.empty((2 * m, lanes))
    xi, by_load, by_angle = (
        np.empty((3 * m, lanes)),
        np.empty((3 * m, m, lanes)),
        np.empty((3 * m, m, lanes)),
    )
    for step in range(STEPS):
        for r in range(3 * m):
            xi[r] = b[r]
        for j in range(m):
            c, s = mu[j] * np.cos(angle[j]), mu[j] * np.sin(angle[j])
            for r in range(3 * m):
                by_load[r, j] = W[r, 3 * j + 2] - W[r, 3 * j] * c - W[r, 3 * j + 1] * s
                by_angle[r, j] = (W[r, 3 * j] * s - W[r, 3 * j + 1] * c) * load[j]
                xi[r] += by_load[r, j] * load[j]
        for i in range(m):
            c, s = np.cos(angle[i]), np.sin(angle[i])
            miss[i] = -xi[3 * i + 2]
            miss[m + i] = s * xi[3 * i] - c * xi[3 * i + 1]
            for j in range(m):
                system[i, j], system[i, m + j] = by_load[3 * i + 2, j], by_angle[3 * i + 2, j]
                system[m + i, j] = c * by_load[3 * i + 1, j] - s * by_load[3 * i, j]
                system[m + i, m + j] = c * by_angle[3 * i + 1, j] - s * by_angle[3 * i, j]
            system[m + i, m + i] -= c * xi[3 * i] + s * xi[3 * i + 1]
        if begins and step == 0:
            for i in range(m):
                miss[m + i] = 0.0
                for j in range(m):
                    system[i, m + j] = 0.0
        _eliminate(system, miss)
        for i in range(m):
            load[i] = load[i] + miss[i]
            angle[i] = angle[i] + np.minimum(np.maximum(miss[m + i], -TURN), TURN)
    rest = np.zeros(lanes)
    for i in range(m):
        rest = np.maximum(rest, np.maximum(np.abs(miss[m + i]), np.abs(miss[i]) / scale))
    return rest


@compiled
def _eliminate(matrix: np.ndarray, right: np.ndarray) -> None:
    """Solve systems (m, m, lanes) with right sides (m, lanes), which hold the answer after it."""
    m = len(right)
    for k in range(m):
        pivot = matrix[k, k]
        safe = np.where(np.abs(pivot) > LEAST_PIVOT, pivot, LEAST_PIVOT)
        for i in range(k + 1, m):
            share = matrix[i, k] / safe
            for j in range(k + 1, m):
                matrix[i, j] = matrix[i, j] - share * matrix[k, j]
            right[i] = right[i] - share * right[k]
    for k in range(m - 1, -1, -1):
        pivot = matrix[k, k]
        safe = np.where(np.abs(pivot) > LEAST_PIVOT, pivot, LEAST_PIVOT)
        for j in range(k + 1, m):
            right[k] = right[k] - matrix[k, j] * right[j]
        right[k] = right[k] / safe


@compiled
def _obeys(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    unit: np.ndarray,
    modes: np.ndarray,
    P: np.ndarray,
    scale: float,
    cones: bool,
) -> bool:
    """Whether P obeys Coulomb's law in its modes, in units of the contacts.

    Without ``cones`` those of contacts that stick do not count.
    """
    size = len(b)
    if not np.abs(P).max() <= LARGEST * scale / unit.min():
        return False
    for i in range(len(mu)):
        k = 3 * i
        u1, u2, un = b[k], b[k + 1], b[k + 2]
        terms = 0.0
        for c in range(size):
            if P[c] != 0.0:
                u1 += W[k, c] * P[c]
                u2 += W[k + 1, c] * P[c]
                un += W[k + 2, c] * P[c]
                terms += abs(P[c])
        near = EDGE * scale / unit[i] + ROUNDING_OF_TERMS * terms
        if modes[i] == PARTED:
            if un < -near:
                return False
            continue
        if not abs(un) <= near:
            return False
        friction = math.sqrt(P[k] * P[k] + P[k + 1] * P[k + 1])
        in_cone = P[k + 2] >= -near and (mu[i] == 0.0 or friction <= mu[i] * P[k + 2] + near)
        if not in_cone and (cones or modes[i] != STICKS):
            return False
        if mu[i] == 0.0:
            continue
        speed = math.sqrt(u1 * u1 + u2 * u2)
        if modes[i] == STICKS:
            if speed > near:
                return False
        elif P[k] * u1 + P[k + 1] * u2 > friction * (near - (1.0 - SAME) * speed):
            return False
    return True
