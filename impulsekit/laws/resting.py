"""Coulomb's law for forces and accelerations at points that rest, solved to rounding.

With accelerations for velocities it is the law of ``frictional``:
0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0, ξ = W P + b. W need
not be symmetric: a contact that slides is given as one without friction whose column of W
holds the friction that goes with its normal force. ``resting_newton`` solves it.

Where rows depend on each other (four corners on a floor) many P do, and with sliding each
moves the body otherwise. Every point then gives way a little, by ε D P with D the diagonal
of W, as if it stood on a stiff spring: that has one solution, which changes smoothly with
the state. The springs are taken out again by moving them towards the body: with
b − ε D P of the last round for b (Rockafellar 1976, the proximal point method) from P = 0
what remains is their load split, the accelerations are those of rigid points.

Two points that stick to a floor are rigid to each other only if the line between them does not
turn. Speeds that count as zero leave it turning a little, and what b asks at the two contradicts
itself by the square of that. Such a part of b, off the span of W, is left out.

Points with friction have three unknowns, two tangents and the normal; others the normal alone.

Dry friction of a joint is a row by itself with a bound that no normal force sets: |τ| ≤ τ_c, and
τ = −τ_c sign(ξ) where ξ ≠ 0. It is one problem with the points, for what they carry together.
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import compiled, entry
from .dense import cholesky
from .resting_newton import Points, Room, bounded, points_of, room_of, solve_points
from .tolerances import LEAST_PIVOT, RESIDUAL_LIMIT, SINGULAR

__all__ = ["find_forces", "forces_at_rest"]

# How much points give way where they depend on each other, relative to D. Rounding in W shows
# in the split of loads enlarged by 1/ε, and what b asks along rows of size ε takes its rounds.
GIVE = 1e-5
MOST_ROUNDS = 12
# The accelerations that springs may leave, relative to those without contact forces.
GIVEN = 1e-13
# What b may contradict itself by, relative: speeds of at most the capture speed, squared, over
# the size of a body and gravity. 1e-2 m/s at 0.1 m is 1e-4 of it.
CONTRADICTION = 1e-4
# Rounds that shrink what springs leave by less than this meet a contradiction, or points at the
# edge of their cones, which take up a load slowly.
STUCK = 0.5
# A row whose part across those before it is smaller, in squares, depends on them.
LEANS_ON = 1e-3


@entry(
    lambda: (np.eye(3), np.eye(3), np.zeros(3), np.zeros(1), np.zeros(3)),
    seconds=7.0,
)
def find_forces(
    coupled: np.ndarray,
    delassus: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    start: np.ndarray,
) -> tuple[np.ndarray, float]:
    """(m,) forces [N] and their residual, relative; above ``RESIDUAL_LIMIT`` they are none.

    Args:
        coupled: (m, m) W with the columns of what slides [1/kg].
        delassus: (m, m) W [1/kg].
        free: (m,) b, the accelerations without contact forces [m/s²].
        friction: (n,) µ; 0 for points of which the normal alone is told; −τ_c for a row whose
            force is at most τ_c, either way.
        start: (m,) the forces to start from.
    """
    return forces_at_rest(coupled, delassus, free, friction, start)


@compiled
def forces_at_rest(
    coupled: np.ndarray,
    delassus: np.ndarray,
    free: np.ndarray,
    friction: np.ndarray,
    start: np.ndarray,
) -> tuple[np.ndarray, float]:
    """As ``find_forces``."""
    coupled, delassus, free = borrowed(coupled), borrowed(delassus), borrowed(free)
    friction, start = borrowed(friction), borrowed(start)
    m = len(free)
    scale = 0.0
    for i in range(m):
        scale = max(scale, abs(free[i]))
    if not scale > 0.0:
        return np.zeros(m), 0.0
    if not abs(coupled.sum() + delassus.sum() + free.sum()) < math.inf:
        return np.zeros(m), math.inf
    if m == 1 and coupled[0, 0] > 0.0:
        # One row alone: a normal pushes, or parts; a bound keeps its own.
        alone = np.zeros(1)
        alone[0] = bounded(-free[0] / coupled[0, 0], friction[0])
        return alone, 0.0
    points = points_of(delassus, friction, scale)
    room = room_of(m, len(friction))
    if _depend(delassus, room.factor):
        found, state = _shared(coupled, delassus, free, points, start, room)
        if state == 2:
            return found, 0.0
        spanned, within, small = _spanned(delassus, coupled, free, scale)
        if small:
            begin = found if state > 0 else start
            found, state = _shared(spanned, delassus, within, points, begin, room)
            if state == 2:
                return found, 0.0
            if state == 1:
                # Near enough: from here to rigid points.
                room.did[0] = -1
                found, residual = solve_points(spanned, within, points, found, room)
                if residual <= RESIDUAL_LIMIT:
                    return found, residual
    room.did[0] = -1
    return solve_points(coupled, free, points, start, room)


@borrowing
def _depend(delassus: np.ndarray, room: np.ndarray) -> bool:
    """Whether rows depend on each other, or all but."""
    return not cholesky(delassus, len(delassus), room) >= LEANS_ON


@compiled
def _spanned(
    delassus: np.ndarray, coupled: np.ndarray, free: np.ndarray, scale: float
) -> tuple[np.ndarray, np.ndarray, bool]:
    """W and b without what lies off the span of W, and whether that is a small part of b."""
    m = len(free)
    values, vectors = np.linalg.eigh(delassus)
    matrix, within = coupled.copy(), free.copy()
    for v in range(m):
        if values[v] > SINGULAR * values[m - 1]:
            continue
        along = 0.0
        for i in range(m):
            along += vectors[i, v] * free[i]
        for i in range(m):
            within[i] -= along * vectors[i, v]
        for j in range(m):
            along = 0.0
            for i in range(m):
                along += vectors[i, v] * coupled[i, j]
            for i in range(m):
                matrix[i, j] -= along * vectors[i, v]
    off = 0.0
    for i in range(m):
        off = max(off, abs(free[i] - within[i]))
    return matrix, within, off <= CONTRADICTION * scale


@compiled
def _shared(
    coupled: np.ndarray,
    delassus: np.ndarray,
    free: np.ndarray,
    points: Points,
    start: np.ndarray,
    room: Room,
) -> tuple[np.ndarray, int]:
    """(m,) forces shared as by stiff springs; 0 where there are none, 1 near them, 2 settled."""
    points, room, start = borrowed(points), borrowed(room), borrowed(start)
    coupled, delassus, free = borrowed(coupled), borrowed(delassus), borrowed(free)
    m = len(free)
    largest = 0.0
    for i in range(m):
        largest = max(largest, delassus[i, i])
    soft, give, shifted = coupled.copy(), np.empty(m), np.empty(m)
    for i in range(m):
        give[i] = GIVE * max(delassus[i, i], LEAST_PIVOT * largest)
        soft[i, i] += give[i]
    forces, begin, left = np.zeros(m), start, math.inf
    room.did[0] = -1
    for _ in range(MOST_ROUNDS):
        last = left
        for i in range(m):
            shifted[i] = free[i] - give[i] * forces[i]
        # A residual that counts for rigid points as well.
        nearer, residual = solve_points(soft, shifted, points, begin, room)
        if not residual <= RESIDUAL_LIMIT:
            return forces, 0
        left = 0.0
        for i in range(m):
            left = max(left, abs(give[i] * (nearer[i] - forces[i])))
        forces = nearer
        if left <= GIVEN * points.scale:
            return forces, 2
        if left > STUCK * last:
            break
        begin = forces
    return forces, 2 if left <= RESIDUAL_LIMIT * points.scale else 1
