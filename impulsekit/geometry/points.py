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
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..laws.borrowed import borrowed, borrowing
from ..laws.compiled import entry
from ..tolerances import NONZERO
from .lines import nearest
from .vectors import Vector, along, cross, dot

__all__ = [
    "CROSSING",
    "MOST",
    "PLANE",
    "ROPE",
    "ROUNDED",
    "STOP",
    "TIP",
    "Kinematics",
    "Table",
    "TableRow",
    "gap_and_rate",
    "gaps_and_rates",
    "table_of",
    "write_bias",
    "write_rows",
]

# Kinds of points.
PLANE, CROSSING, STOP, TIP, ROPE = 0, 1, 2, 3, 4
# So many numbers say the most of a point.
MOST = 21
# Gaps are sums of some ten rounded terms, in units of the largest one's rounding error.
ROUNDED = 8.0 * float(np.finfo(float).eps)

# t₁, t₂ and n of a point.
Axes = tuple[Vector, Vector, Vector]
# Kind, two joints, and numbers, as a ``Table`` has them.
TableRow = tuple[int, int, int, np.ndarray]


class Kinematics(NamedTuple):
    """Of all joints at one state, as ``Memory`` shows it; ``rates`` without joint accelerations."""

    places: np.ndarray
    speeds: np.ndarray
    rates: np.ndarray
    jacobian: np.ndarray
    last: np.ndarray
    before: np.ndarray


class Table(NamedTuple):
    """Points that rest.

    Attributes:
        whole: (n, 3) kind; the joints of the point and of its plane, or of both edges; of a
            stop where its speed is in v and it in q; of a rope those of its ends.
        numbers: (n, 21) of a plane: the point (3) in its joint, R (9) in the plane's joint column
            by column, the origin (3) there, and s. Of a tip: the same of its middle, the radius of
            the ball around it, that of the rim, and the rim's axis (3). Of edges: a point (3) and
            the direction (3) of each in its joint, both lengths, the sign of n, and the least
            sine. Of a stop its row's entry, the sign, and the limit. Of a rope both ends in their
            joints, and how long it is.
    """

    whole: np.ndarray
    numbers: np.ndarray


def table_of(rows: Sequence[TableRow]) -> Table:
    """The table of points."""
    whole = np.array([row[:3] for row in rows], dtype=np.int64).reshape(-1, 3)
    numbers = np.zeros((len(rows), MOST))
    for own, row in zip(numbers, rows, strict=True):
        own[: len(row[3])] = row[3]
    return Table(whole, numbers)


@borrowing
def turned(places: np.ndarray, j: int, x: Vector) -> Vector:
    """A direction of a joint's frame, in the world."""
    return (
        places[j, 0] * x[0] + places[j, 3] * x[1] + places[j, 6] * x[2],
        places[j, 1] * x[0] + places[j, 4] * x[1] + places[j, 7] * x[2],
        places[j, 2] * x[0] + places[j, 5] * x[1] + places[j, 8] * x[2],
    )


@borrowing
def back(places: np.ndarray, j: int, x: Vector) -> Vector:
    """A direction of the world, in a joint's frame."""
    return (
        places[j, 0] * x[0] + places[j, 1] * x[1] + places[j, 2] * x[2],
        places[j, 3] * x[0] + places[j, 4] * x[1] + places[j, 5] * x[2],
        places[j, 6] * x[0] + places[j, 7] * x[1] + places[j, 8] * x[2],
    )


@borrowing
def origin(places: np.ndarray, j: int) -> Vector:
    """Of a joint's frame, in the world."""
    return places[j, 9], places[j, 10], places[j, 11]


@borrowing
def three(numbers: np.ndarray, at: int) -> Vector:
    """Three numbers of a row."""
    return numbers[at], numbers[at + 1], numbers[at + 2]


@borrowing
def moving(kinematics: Kinematics, j: int, point: Vector) -> tuple[Vector, Vector]:
    """Velocity and acceleration of a joint's point (in the world), in the world."""
    places, speeds, rates = kinematics.places, kinematics.speeds, kinematics.rates
    at = back(places, j, along(point, -1.0, origin(places, j)))
    spin = three(speeds[j], 3)
    velocity = along(three(speeds[j], 0), 1.0, cross(spin, at))
    rate = along(three(rates[j], 0), 1.0, cross(three(rates[j], 3), at))
    rate = along(rate, 1.0, cross(spin, velocity))
    return turned(places, j, velocity), turned(places, j, rate)


@borrowing
def axis(table: Table, i: int, k: int, places: np.ndarray) -> Vector:
    """Column k of R of a point on a plane, in the world."""
    return turned(places, table.whole[i, 2], three(table.numbers[i], 3 + 3 * k))


@borrowing
def point_of(table: Table, i: int, places: np.ndarray) -> Vector:
    """A point on a plane, in the world."""
    j = table.whole[i, 1]
    return along(origin(places, j), 1.0, turned(places, j, three(table.numbers[i], 0)))


@borrowing
def tip_of(
    table: Table, i: int, places: np.ndarray
) -> tuple[Vector, Vector, Vector, Vector, float]:
    """A tip, in the world: x, n of the face, the axis a of its rim, d, and |n − (n·a) a|."""
    numbers, j = table.numbers[i], table.whole[i, 1]
    sign, ball, rim = numbers[15], numbers[16], numbers[17]
    up = axis(table, i, 2, places)
    n = (sign * up[0], sign * up[1], sign * up[2])
    x = along(point_of(table, i, places), -ball, n)
    if rim == 0.0:
        return x, n, n, n, 0.0
    a = turned(places, j, three(numbers, 18))
    out = along(n, -dot(n, a), a)
    sine = math.sqrt(dot(out, out))
    d = axis(table, i, 0, places)
    if sine > 0.0:
        d = (out[0] / sine, out[1] / sine, out[2] / sine)
    return along(x, -rim, d), n, a, d, sine


@borrowing
def _write_bias_of_tip(table: Table, i: int, kinematics: Kinematics, bias: np.ndarray) -> None:
    places, speeds, numbers = kinematics.places, kinematics.speeds, table.numbers[i]
    one, two, sign = table.whole[i, 1], table.whole[i, 2], numbers[15]
    x, n, a, d, sine = tip_of(table, i, places)
    v, rate = moving(kinematics, one, x)
    below, below_rate = moving(kinematics, two, x)
    spin = turned(places, one, three(speeds[one], 3))
    turning = turned(places, two, three(speeds[two], 3))
    # The material point of the middle, and how the way from there to the tip turns.
    n_rate = cross(turning, n)
    middle = along(point_of(table, i, places), -1.0, x)
    moves = along(along(v, 1.0, cross(spin, middle)), -numbers[16], n_rate)
    if sine > 0.0:
        a_rate = cross(spin, a)
        out = along(n_rate, -dot(n_rate, a) - dot(n, a_rate), a)
        out = along(out, -dot(n, a), a_rate)
        moves = along(moves, -numbers[17] / sine, along(out, -dot(d, out), d))
    change = along(rate, 1.0, cross(spin, along(moves, -1.0, v)))
    change = along(along(change, -1.0, below_rate), -1.0, cross(turning, along(moves, -1.0, below)))
    change = along(change, -1.0, cross(turning, along(v, -1.0, below)))
    for k in range(3):
        bias[3 * i + k] = sign * dot(axis(table, i, k, places), change)


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
        elif kind in (PLANE, TIP):
            point, sign = point_of(table, i, places), table.numbers[i, 15]
            if kind == TIP:
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
        elif kind == TIP:
            _write_bias_of_tip(table, i, kinematics, bias)
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
def _velocity(places: np.ndarray, speeds: np.ndarray, j: int, point: Vector) -> Vector:
    """Of a joint's point (in the world), in the world."""
    at = back(places, j, along(point, -1.0, origin(places, j)))
    return turned(places, j, along(three(speeds[j], 0), 1.0, cross(three(speeds[j], 3), at)))
