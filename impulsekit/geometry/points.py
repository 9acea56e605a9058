"""Points that rest, as tables: their rows, rates, gaps and velocities in compiled code.

A point on a plane, be it a contact's own or a corner on a face, stays on its body at x and
moves over the plane in the other with ω_p, n and o:

    u = s Rᵀ (v_x − v_p),   u̇ = s Rᵀ (a_x − a_p − 2 ω_p × (v_x − v_p)),   g = n·(x − o),

with v_p, a_p of the point of the plane's body that coincides with it. Two edges that cross: see
``held_points``, tips of round bodies: ``held_tips``, which have the formulas. A
joint before its limit has a row of its own.
Two points x and y on a rope of length l pull along n = (x − y)/|x − y|:

    g = l − |x − y|,   u_n = −n·(v_x − v_y) = −n·w,   u̇_n = −n·(a_x − a_y) − (w² − (n·w)²)/|x − y|.
"""

from __future__ import annotations

import math

import numpy as np

from ..laws.borrowed import borrowed, borrowing
from ..laws.compiled import entry
from ..tolerances import NONZERO
from .lines import nearest
from .point_table import (
    ELLIPSOID,
    MOST,
    PLANE,
    ROPE,
    ROUNDED,
    STOP,
    TIP,
    Axes,
    Kinematics,
    Table,
    axis,
    back,
    moving,
    origin,
    point_of,
    three,
    turned,
)
from .tips import tip_of, write_bias_of_tip
from .vectors import Vector, along, cross, dot

__all__ = [
    "axes_of_crossing",
    "crossing",
    "gap_and_rate",
    "gaps_and_rates",
    "rope",
    "rounding_of",
    "write_bias",
    "write_rows",
]


@borrowing
def crossing(
    table: Table, i: int, places: np.ndarray
) -> tuple[Vector, Vector, Vector, float, Vector, Vector, float, float]:
    """Two edges: e, f, ±(e × f), its square, the nearest points, and the ways along the edges."""
    one, two, numbers = table.whole[i, 1], table.whole[i, 2], table.numbers[i]
    start = along(origin(places, one), 1.0, turned(places, one, three(numbers, 0)))
    e = turned(places, one, three(numbers, 3))
    there = along(origin(places, two), 1.0, turned(places, two, three(numbers, 6)))
    f = turned(places, two, three(numbers, 9))
    s, u, turn, square = nearest(start, e, there, f)
    sign = numbers[14]
    way = (sign * turn[0], sign * turn[1], sign * turn[2])
    return e, f, way, square, along(start, s, e), along(there, u, f), s, u


@borrowing
def rope(table: Table, i: int, places: np.ndarray) -> tuple[Vector, Vector, Vector, float]:
    """Both ends of a rope, the direction from the second to the first, and how far that is."""
    one, two, numbers = table.whole[i, 1], table.whole[i, 2], table.numbers[i]
    here = along(origin(places, one), 1.0, turned(places, one, three(numbers, 0)))
    there = along(origin(places, two), 1.0, turned(places, two, three(numbers, 3)))
    between = along(here, -1.0, there)
    # Ends that meet have no direction: a slack rope, nothing comes of it.
    length = max(math.sqrt(dot(between, between)), NONZERO)
    return here, there, (between[0] / length, between[1] / length, between[2] / length), length


@borrowing
def axes_of_crossing(e: Vector, turn: Vector, square: float) -> Axes:
    """(e, n × e, n)."""
    size = math.sqrt(square)
    n = (turn[0] / size, turn[1] / size, turn[2] / size)
    return e, cross(n, e), n


@borrowing
def _add_rows(
    kinematics: Kinematics, j: int, sign: float, point: Vector, axes: Axes, rows: np.ndarray
) -> None:
    """Add ±Rᵀ J of a joint's point to rows (3, nv)."""
    k = kinematics.last[j]
    jacobian = kinematics.jacobian
    while k >= 0:
        velocity = along(three(jacobian[k], 0), 1.0, cross(three(jacobian[k], 3), point))
        rows[0, k] += sign * dot(axes[0], velocity)
        rows[1, k] += sign * dot(axes[1], velocity)
        rows[2, k] += sign * dot(axes[2], velocity)
        k = kinematics.before[k]


@borrowing
def write_rows(table: Table, kinematics: Kinematics, rows: np.ndarray) -> None:
    """Write the rows (3n, nv) of all points; ``kinematics`` with placements and Jacobians."""
    rows, places = borrowed(rows), kinematics.places
    rows[:] = 0.0
    for i in range(len(table.whole)):
        kind, one, two = table.whole[i, 0], table.whole[i, 1], table.whole[i, 2]
        own = rows[3 * i : 3 * i + 3]
        if kind == STOP:
            own[2, one] = table.numbers[i, 0]
        elif kind in (PLANE, TIP, ELLIPSOID):
            point, sign = point_of(table, i, places), table.numbers[i, 15]
            if kind != PLANE:
                point = tip_of(table, i, places)[0]
            axes = (axis(table, i, 0, places), axis(table, i, 1, places), axis(table, i, 2, places))
            _add_rows(kinematics, one, sign, point, axes, own)
            _add_rows(kinematics, two, -sign, point, axes, own)
        elif kind == ROPE:
            here, there, n, _ = rope(table, i, places)
            axes = ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), n)
            _add_rows(kinematics, one, -1.0, here, axes, own)
            _add_rows(kinematics, two, 1.0, there, axes, own)
        else:
            e, _, turn, square, here, there, _, _ = crossing(table, i, places)
            middle = along(here, 0.5, along(there, -1.0, here))
            axes = axes_of_crossing(e, turn, square)
            _add_rows(kinematics, one, 1.0, middle, axes, own)
            _add_rows(kinematics, two, -1.0, middle, axes, own)


@borrowing
def write_bias(table: Table, kinematics: Kinematics, bias: np.ndarray) -> None:
    """Write the rows' rates (3n,) where no joint accelerates."""
    places = kinematics.places
    for i in range(len(table.whole)):
        kind, one, two = table.whole[i, 0], table.whole[i, 1], table.whole[i, 2]
        at = 3 * i
        if kind == STOP:
            bias[at], bias[at + 1], bias[at + 2] = 0.0, 0.0, 0.0
        elif kind == ROPE:
            here, there, n, length = rope(table, i, places)
            velocity, rate = moving(kinematics, one, here)
            below, below_rate = moving(kinematics, two, there)
            w = along(velocity, -1.0, below)
            across = dot(w, w) - dot(n, w) ** 2
            bias[at], bias[at + 1] = 0.0, 0.0
            bias[at + 2] = -dot(n, along(rate, -1.0, below_rate)) - across / length
        elif kind == PLANE:
            point, sign = point_of(table, i, places), table.numbers[i, 15]
            velocity, rate = moving(kinematics, one, point)
            below, below_rate = moving(kinematics, two, point)
            turning = turned(places, two, three(kinematics.speeds[two], 3))
            # The coinciding point moves over its body at the velocity between the two.
            sliding = cross(turning, along(velocity, -1.0, below))
            rate = along(along(rate, -1.0, below_rate), -2.0, sliding)
            for k in range(3):
                bias[at + k] = sign * dot(axis(table, i, k, places), rate)
        elif kind in (TIP, ELLIPSOID):
            write_bias_of_tip(table, i, kinematics, bias)
        else:
            _write_bias_of_crossing(table, i, kinematics, bias)


@borrowing
def _write_bias_of_crossing(table: Table, i: int, kinematics: Kinematics, bias: np.ndarray) -> None:
    places, speeds = kinematics.places, kinematics.speeds
    one, two, sign = table.whole[i, 1], table.whole[i, 2], table.numbers[i, 14]
    e, f, turn, square, here, there, _, _ = crossing(table, i, places)
    point = along(here, 0.5, along(there, -1.0, here))
    _, across, n = axes_of_crossing(e, turn, square)
    velocity, rate = moving(kinematics, one, point)
    below, below_rate = moving(kinematics, two, point)
    w = along(velocity, -1.0, below)
    # How fast the place moves along both edges.
    on_first = sign * dot(cross(f, w), turn) / square
    on_other = sign * dot(cross(e, w), turn) / square
    e_rate = cross(turned(places, one, three(speeds[one], 3)), e)
    f_rate = cross(turned(places, two, three(speeds[two], 3)), f)
    turning, size = along(cross(e_rate, f), 1.0, cross(e, f_rate)), sign / math.sqrt(square)
    turning = along(turning, -dot(n, turning), n)
    n_rate = (size * turning[0], size * turning[1], size * turning[2])
    rate = along(along(along(rate, on_first, e_rate), -1.0, below_rate), -on_other, f_rate)
    across_rate = along(cross(n_rate, e), 1.0, cross(n, e_rate))
    bias[3 * i] = dot(e, rate) + dot(e_rate, w)
    bias[3 * i + 1] = dot(across, rate) + dot(across_rate, w)
    bias[3 * i + 2] = dot(n, rate) + dot(n_rate, w)


@entry(
    lambda: (
        Table(np.zeros((1, 3), np.int64), np.ones((1, MOST))),
        np.zeros((2, 12)),
        np.zeros((2, 6)),
        np.zeros(2),
        np.zeros(2),
    ),
    seconds=2.0,
)
def gaps_and_rates(
    table: Table, places: np.ndarray, speeds: np.ndarray, q: np.ndarray, v: np.ndarray
) -> np.ndarray:
    """(2, n) the gaps of points over planes and of stops [m, rad], and their rates.

    Args:
        places, speeds: of all joints, as ``Memory`` shows them.
        q, v: the state.
    """
    found = np.empty((2, len(table.whole)))
    for i in range(len(table.whole)):
        found[0, i], found[1, i] = gap_and_rate(table, i, places, speeds, q, v)
    return found


@borrowing
def gap_and_rate(
    table: Table, i: int, places: np.ndarray, speeds: np.ndarray, q: np.ndarray, v: np.ndarray
) -> tuple[float, float]:
    """Of one of them; see ``gaps_and_rates``."""
    one, two, numbers = table.whole[i, 1], table.whole[i, 2], table.numbers[i]
    if table.whole[i, 0] == STOP:
        return numbers[1] * (q[two] - numbers[2]), numbers[1] * v[one]
    if table.whole[i, 0] == ROPE:
        here, there, n, length = rope(table, i, places)
        apart = along(
            _velocity(places, speeds, one, here), -1.0, _velocity(places, speeds, two, there)
        )
        return numbers[6] - length, -dot(n, apart)
    point, normal = point_of(table, i, places), axis(table, i, 2, places)
    ground = along(origin(places, two), 1.0, turned(places, two, three(numbers, 12)))
    velocity = along(
        _velocity(places, speeds, one, point), -1.0, _velocity(places, speeds, two, point)
    )
    gap = numbers[15] * dot(normal, along(point, -1.0, ground))
    return gap, numbers[15] * dot(normal, velocity)


@borrowing
def rounding_of(table: Table, i: int, places: np.ndarray, arms: float, gap: float) -> float:
    """By how much a gap of this size is rounded [m, rad].

    ``arms``: of the terms whose sum it is, besides its place.
    """
    size = arms
    if table.whole[i, 0] == PLANE:
        x, y, z = point_of(table, i, places)
        size += max(abs(x), abs(y), abs(z))
    elif table.whole[i, 0] == ROPE:
        x, y, z = rope(table, i, places)[0]
        size += max(abs(x), abs(y), abs(z))
    return ROUNDED * (gap + size)


@borrowing
def _velocity(places: np.ndarray, speeds: np.ndarray, j: int, point: Vector) -> Vector:
    """Of a joint's point (in the world), in the world."""
    at = back(places, j, along(point, -1.0, origin(places, j)))
    return turned(places, j, along(three(speeds[j], 0), 1.0, cross(three(speeds[j], 3), at)))
