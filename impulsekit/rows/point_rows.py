"""Rows, rates, gaps and velocities of the points of a table, in compiled code.

The formulas are those of ``frame_pair``. A point on a plane stays on its body, a tip of a round
body moves over both, and R turns with the plane or face; where two edges cross both places move
along them, and R = (e, n × e, n); both ends of a rope stay on their bodies, and only along it,
n·(x − y) = |x − y|, is there a row. The gap is g = n·(x − o) over a plane, l − |x − y| of a rope
of length l. A joint before its limit has a row of its own.
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.gaps import before_limit
from ..geometry.point_table import (
    CROSSING,
    ELLIPSOID,
    MOST,
    PLANE,
    ROPE,
    ROUNDED,
    STOP,
    Axes,
    Kinematics,
    Table,
    axes_of_crossing,
    axis,
    back,
    crossing,
    origin,
    over_face,
    point_of,
    rope,
    spot_of,
    stretched,
    three,
    tip_of,
    turned,
)
from ..geometry.vectors import Vector, along, cross, dot
from ..laws.borrowed import borrowed, borrowing
from ..laws.compiled import entry
from .frame_pair import (
    PointMotion,
    motion_at,
    passing,
    relative_rate,
    turning_of_line,
    velocity_at,
)

__all__ = ["gap_and_rate", "gaps_and_rates", "rounding_of", "write_bias", "write_rows"]


@borrowing
def _ends_and_axes(table: Table, i: int, places: np.ndarray) -> tuple[Vector, Vector, Axes, float]:
    """A point on both bodies and R, in the world, and ±1 for rows of the first or the second."""
    if table.whole[i, 0] == ROPE:
        here, there, n, _ = rope(table, i, places)
        nothing = (0.0, 0.0, 0.0)
        return here, there, (nothing, nothing, n), -1.0
    place, axes = spot_of(table, i, places)
    return place, place, axes, 1.0 if table.whole[i, 0] == CROSSING else table.numbers[i, 15]


@borrowing
def _add_rows(
    kinematics: Kinematics, j: int, sign: float, point: Vector, axes: Axes, rows: np.ndarray
) -> None:
    """Add ±Rᵀ J of a joint's point to rows (3, nv)."""
    k = kinematics.last[j]
    jacobian = kinematics.jacobian
    while k >= 0:
        velocity = velocity_at(three(jacobian[k], 0), three(jacobian[k], 3), point)
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
        one, two = table.whole[i, 1], table.whole[i, 2]
        own = rows[3 * i : 3 * i + 3]
        if table.whole[i, 0] == STOP:
            own[2, one] = table.numbers[i, 0]
        else:
            here, there, axes, sign = _ends_and_axes(table, i, places)
            _add_rows(kinematics, one, sign, here, axes, own)
            _add_rows(kinematics, two, -sign, there, axes, own)


@borrowing
def _motion_of(kinematics: Kinematics, j: int, point: Vector) -> PointMotion:
    """How a joint's point (in the world) moves, in the world."""
    places, speeds, rates = kinematics.places, kinematics.speeds[j], kinematics.rates[j]
    arm = back(places, j, along(point, -1.0, origin(places, j)))
    own = motion_at(three(speeds, 0), three(rates, 0), three(speeds, 3), three(rates, 3), arm)
    return PointMotion(
        turned(places, j, own.velocity), turned(places, j, own.rate), turned(places, j, own.spin)
    )


@borrowing
def write_bias(table: Table, kinematics: Kinematics, bias: np.ndarray) -> None:
    """Write the rows' rates (3n,) where no joint accelerates."""
    places = kinematics.places
    for i in range(len(table.whole)):
        kind, at = table.whole[i, 0], 3 * i
        if kind == STOP:
            bias[at], bias[at + 1], bias[at + 2] = 0.0, 0.0, 0.0
            continue
        here, there, axes, sign = _ends_and_axes(table, i, places)
        first = _motion_of(kinematics, table.whole[i, 1], here)
        other = _motion_of(kinematics, table.whole[i, 2], there)
        turning = other.spin
        if kind == ROPE:
            _, _, n, length = rope(table, i, places)
            turning = turning_of_line(n, length, along(first.velocity, -1.0, other.velocity))
        elif kind == CROSSING:
            first, other, turning = _along_edges(table, i, places, first, other)
        else:
            place = first.velocity
            if kind != PLANE:
                place = _moves_of_tip(table, i, places, first, other)
            first, other = passing(first, place), passing(other, place)
        rate = relative_rate(first, other, turning)
        for k in range(3):
            bias[at + k] = sign * dot(axes[k], rate)


@borrowing
def _along_edges(
    table: Table, i: int, places: np.ndarray, first: PointMotion, other: PointMotion
) -> tuple[PointMotion, PointMotion, Vector]:
    """What a place that moves along two edges passes on both, and how (e, n × e, n) turns."""
    sign = table.numbers[i, 14]
    e, f, turn, square, _, _, _, _ = crossing(table, i, places)
    _, across, _ = axes_of_crossing(e, turn, square)
    w = along(first.velocity, -1.0, other.velocity)
    on_first = sign * dot(cross(f, w), turn) / square
    on_other = sign * dot(cross(e, w), turn) / square
    e_rate, f_rate = cross(first.spin, e), cross(other.spin, f)
    tilting = dot(across, along(cross(e_rate, f), 1.0, cross(e, f_rate)))
    # Of axes that turn with Ω: Ω·e = −ṅ·(n × e).
    turning = along(cross(e, e_rate), -sign * tilting / math.sqrt(square), e)
    first = passing(first, along(first.velocity, on_first, e))
    return first, passing(other, along(other.velocity, on_other, f)), turning


@borrowing
def _moves_of_tip(
    table: Table, i: int, places: np.ndarray, first: PointMotion, other: PointMotion
) -> Vector:
    """The velocity of a tip; see ``held_tips``."""
    one, numbers = table.whole[i, 1], table.numbers[i]
    x, n, a, d, sine = tip_of(table, i, places)
    spin = first.spin
    # The material point of the middle, and how the way from there to the tip turns.
    n_rate = cross(other.spin, n)
    middle = along(point_of(table, i, places), -1.0, x)
    moves = along(velocity_at(first.velocity, spin, middle), -numbers[16], n_rate)
    if table.whole[i, 0] == ELLIPSOID:
        here = back(places, one, n)
        out = stretched(numbers, here)
        more = stretched(numbers, back(places, one, along(n_rate, -1.0, cross(spin, n))))
        size = math.sqrt(dot(here, out))
        more = along(more, -dot(here, more) / size**2, out)
        more = velocity_at(turned(places, one, more), spin, turned(places, one, out))
        moves = along(moves, -1.0 / size, more)
    elif sine > 0.0:
        a_rate = cross(spin, a)
        out = along(n_rate, -dot(n_rate, a) - dot(n, a_rate), a)
        out = along(out, -dot(n, a), a_rate)
        moves = along(moves, -numbers[17] / sine, along(out, -dot(d, out), d))
    return moves


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
        return before_limit(q[two], numbers[2], numbers[1]), numbers[1] * v[one]
    if table.whole[i, 0] == ROPE:
        here, there, n, length = rope(table, i, places)
        gap, sign = numbers[6] - length, -1.0
    else:
        here = there = point_of(table, i, places)
        n, sign = axis(table, i, 2, places), numbers[15]
        gap = over_face(table, i, places, here)
    w = along(_velocity(places, speeds, one, here), -1.0, _velocity(places, speeds, two, there))
    return gap, sign * dot(n, w)


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
    arm = back(places, j, along(point, -1.0, origin(places, j)))
    return turned(places, j, velocity_at(three(speeds[j], 0), three(speeds[j], 3), arm))
