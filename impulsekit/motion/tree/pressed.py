"""The accelerations of a robot on which points rest, in one compiled call.

With M = U D Uᵀ and C = D^-½ U⁻¹ Jᵀ the Delassus matrix is W = Cᵀ C; what moves freely has
J a + J̇ v = b, Coulomb's law at rest gives P, and v̇ = U^-T D^-½ (D^-½ U⁻¹ τ + C P).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.point_table import MOST, Kinematics, Table
from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import put
from ...laws.half import Factor, from_half, halve, is_safe
from ...laws.resting import forces_at_rest
from ...laws.tolerances import RESIDUAL_LIMIT
from ...rows.point_rows import write_bias, write_rows

__all__ = [
    "BEGINS",
    "SLIDES",
    "STICKS",
    "Found",
    "Loaded",
    "Sliding",
    "direction_of",
    "press",
    "pressed",
    "rows_and_bias",
]

Pressed = tuple[float, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


# What a point that rests does: it sticks, slides, or has just begun to: friction opposes its
# acceleration.
STICKS, SLIDES, BEGINS = 0.0, 1.0, 2.0
# Of slip, and of the speed below which it keeps its direction: what is across is rounding.
STRAIGHT = 1e-6


class Sliding(NamedTuple):
    """What is known of the points that rest.

    Attributes:
        friction: (n,) µ.
        ways: (n, 3) the direction in which slip began (2), and what the point does.
        slow: slip below this keeps its direction [m/s].
        grown: slip that began has grown at this speed [m/s].
        negligible: accelerations that are nowhere above this are zero [m/s²].
    """

    friction: np.ndarray
    ways: np.ndarray
    slow: float
    grown: float
    negligible: float


class Loaded(NamedTuple):
    """A state at which points rest.

    Attributes:
        table, kinematics: of the points.
        factor: of M.
        sliding: what is known of the points.
        load: (nv,) τ − h, what acts besides contacts [N, N m].
        v: (nv,) the velocity.
    """

    table: Table
    kinematics: Kinematics
    factor: Factor
    sliding: Sliding
    load: np.ndarray
    v: np.ndarray


class Found(NamedTuple):
    """What ``press`` writes: v̇ (nv,), and of the points (3n,) as ``pressed`` tells it."""

    rate: np.ndarray
    forces: np.ndarray
    accelerations: np.ndarray
    slip: np.ndarray


def _table() -> Table:
    return Table(np.zeros((1, 3), np.int64), np.ones((1, MOST)))


def _kinematics() -> Kinematics:
    return Kinematics(
        np.zeros((2, 12)),
        np.zeros((2, 6)),
        np.zeros((2, 6)),
        np.zeros((2, 6)),
        np.zeros(2, np.int64),
        np.full(2, -1),
    )


def _examples() -> tuple[Loaded, np.ndarray]:
    factor = Factor(np.eye(2), np.ones(2), np.eye(2), np.zeros(2, np.int64), 0.0)
    sliding = Sliding(np.zeros(1), np.zeros((1, 3)), 0.0, 0.0, 0.0)
    vector = np.zeros(2)
    return Loaded(_table(), _kinematics(), factor, sliding, vector, vector), np.zeros(3)


@entry(lambda: (_table(), _kinematics()), seconds=2.0)
def rows_and_bias(table: Table, kinematics: Kinematics) -> tuple[np.ndarray, np.ndarray]:
    """(3n, nv) the rows of points that rest, and (3n,) their rates without joint acceleration."""
    count = 3 * len(table.whole)
    rows, bias = np.empty((count, len(kinematics.jacobian))), np.empty(count)
    write_rows(table, kinematics, rows)
    write_bias(table, kinematics, bias)
    return rows, bias


@entry(_examples, seconds=11.0)
def pressed(state: Loaded, last: np.ndarray) -> Pressed:
    """The accelerations with points that rest.

    Args:
        last: (3n,) forces to start from [N].

    Returns:
        The residual of the law, relative, or −1 where a pivot of M is rounding; (nv,) v̇; and of
        the points (3n,) forces (of what slides the normal alone), accelerations and velocities.
    """
    return _pressed(state, last)


@compiled
def press(state: Loaded, found: Found) -> float:
    """As ``pressed``, from and into arrays that are there; nothing is written without forces."""
    found = borrowed(found)
    residual, rate, forces, accelerations, slip = _pressed(state, found.forces)
    if 0.0 <= residual <= RESIDUAL_LIMIT:
        put(rate, found.rate)
        put(forces, found.forces)
        put(accelerations, found.accelerations)
        put(slip, found.slip)
    return residual


@compiled
def _pressed(state: Loaded, last: np.ndarray) -> Pressed:
    """As ``pressed``."""
    table, kinematics, factor, sliding, load, v = borrowed(state)
    nv, n = len(load), len(table.whole)
    if not is_safe(factor):
        nothing = np.empty(0)
        return -1.0, load.copy(), nothing, nothing, nothing
    rows, bias = np.empty((3 * n, nv)), np.empty(3 * n)
    write_rows(table, kinematics, rows)
    write_bias(table, kinematics, bias)
    slip = np.zeros(3 * n)
    for i in range(3 * n):
        for k in range(nv):
            slip[i] += rows[i, k] * v[k]
    start = load.copy()
    halve(factor, start)
    accelerations = bias
    _halve_rows(factor, sliding, rows, start, accelerations)
    largest = 0.0
    for i in range(3 * n):
        largest = max(largest, abs(accelerations[i]))
    if largest <= sliding.negligible:
        accelerations[:] = 0.0
    forces, residual, pushed = _by_law(rows, accelerations, sliding, slip, last)
    for i in range(3 * n):
        for k in range(nv):
            accelerations[i] += rows[i, k] * pushed[k]
    for k in range(nv):
        start[k] += pushed[k]
    from_half(factor, start)
    return residual, start, forces, accelerations, slip


@borrowing
def _halve_rows(
    factor: Factor,
    sliding: Sliding,
    rows: np.ndarray,
    start: np.ndarray,
    accelerations: np.ndarray,
) -> None:
    """C for J in place, and what moves freely: J̇ v and C times the halves of the load."""
    rows, start, accelerations = borrowed(rows), borrowed(start), borrowed(accelerations)
    for i in range(len(rows)):
        if i % 3 != 2 and sliding.friction[i // 3] == 0.0:
            # Tangents without friction carry nothing.
            rows[i] = 0.0
            continue
        halve(factor, rows[i])
        for k in range(len(start)):
            accelerations[i] += rows[i, k] * start[k]


@compiled
def _by_law(
    rows: np.ndarray, free: np.ndarray, sliding: Sliding, slip: np.ndarray, last: np.ndarray
) -> tuple[np.ndarray, float, np.ndarray]:
    """(3n,) forces, the residual, and (nv,) the halves that they push with.

    Args:
        rows: (3n, nv) Cᵀ.
        free: (3n,) b [m/s²].
        slip: (3n,) velocities [m/s].
        last: (3n,) forces to start from [N].
    """
    rows, free, slip, last = borrowed(rows), borrowed(free), borrowed(slip), borrowed(last)
    sliding = borrowed(sliding)
    n, nv = len(sliding.friction), rows.shape[1]
    # Which rows have unknowns, and what each pushes with: friction goes with what slides.
    own, mu = np.empty(3 * n, np.int64), np.zeros(n)
    pushing, m, slides = np.empty((3 * n, nv)), 0, False
    for i in range(n):
        at = 3 * i
        if sliding.ways[i, 2] != SLIDES and sliding.friction[i] > 0.0:
            mu[i] = sliding.friction[i]
            for k in range(2):
                own[m] = at + k
                pushing[m] = rows[at + k]
                m += 1
        own[m] = at + 2
        pushing[m] = rows[at + 2]
        if sliding.ways[i, 2] == SLIDES:
            slides = True
            s1, s2 = direction_of(slip[at], slip[at + 1], sliding.ways[i], sliding.slow)
            for k in range(nv):
                across = s1 * rows[at, k] + s2 * rows[at + 1, k]
                pushing[m, k] -= sliding.friction[i] * across
        m += 1
    delassus, b, start = np.empty((m, m)), np.empty(m), np.empty(m)
    for i in range(m):
        b[i], start[i] = free[own[i]], last[own[i]]
    _products(rows, own, rows, own, delassus)
    coupled = delassus
    if slides:
        coupled = np.empty((m, m))
        _products(rows, own, pushing, np.arange(m), coupled)
    found, residual = forces_at_rest(coupled, delassus, b, mu, start)
    forces, pushed = np.zeros(3 * n), np.zeros(nv)
    for i in range(m):
        forces[own[i]] = found[i]
        for k in range(nv):
            pushed[k] += found[i] * pushing[i, k]
    return forces, residual, pushed


@borrowing
def _products(
    rows: np.ndarray, own: np.ndarray, others: np.ndarray, which: np.ndarray, found: np.ndarray
) -> None:
    """Write (m, m) products of chosen rows, over what of each is not zero."""
    rows, own, others = borrowed(rows), borrowed(own), borrowed(others)
    which, found = borrowed(which), borrowed(found)
    m, nv = len(found), rows.shape[1]
    for i in range(m):
        row, low, high = rows[own[i]], 0, nv
        while low < high and row[low] == 0.0:
            low += 1
        while high > low and row[high - 1] == 0.0:
            high -= 1
        for j in range(m):
            other, total = others[which[j]], 0.0
            for k in range(low, high):
                total += row[k] * other[k]
            found[i, j] = total


@borrowing
def direction_of(s1: float, s2: float, way: np.ndarray, slow: float) -> tuple[float, float]:
    """The unit direction of slip; where it is slow, that in which it began."""
    # Past its stop, within a step that will be cut there, it goes on smoothly: a jump or a bend
    # there would have steps end next to it, each shorter than the one before.
    along = s1 * way[0] + s2 * way[1]
    square = s1 * s1 + s2 * s2
    kept = slow * math.exp(-square / slow**2)
    if along < 0.0:
        across = (s1 * way[1] - s2 * way[0]) ** 2
        if across <= STRAIGHT**2 * max(slow * slow, along * along):
            # Turned about: what there is across goes on in proportion, and does not grow.
            s1, s2, along = -s1, -s2, 0.0
    if along < 0.0:
        cube = (0.25 * (slow * slow * math.exp(-2.0 * across / slow**2) + across)) ** 1.5
        kept += 2.0 * along**4 / (cube - along**3)
    s1, s2 = s1 + kept * way[0], s2 + kept * way[1]
    size = math.sqrt(s1 * s1 + s2 * s2)
    return s1 / size, s2 / size
