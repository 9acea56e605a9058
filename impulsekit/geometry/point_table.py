"""Tables of points for compiled code, and where the joints and the points are.

How fast they move: ``rows.point_rows``.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..laws.borrowed import borrowing
from ..tolerances import NONZERO
from .lines import nearest
from .vectors import Vector, along, cross, dot

__all__ = [
    "CROSSING",
    "ELLIPSOID",
    "MOST",
    "PLANE",
    "ROPE",
    "ROUNDED",
    "STOP",
    "TIP",
    "Axes",
    "Kinematics",
    "Table",
    "TableRow",
    "axes_of_crossing",
    "axis",
    "back",
    "crossing",
    "origin",
    "over_face",
    "place_on_face",
    "point_of",
    "rope",
    "spot_of",
    "stretched",
    "table_of",
    "three",
    "tip_of",
    "turned",
]

# Kinds of points.
PLANE, CROSSING, STOP, TIP, ROPE, ELLIPSOID = 0, 1, 2, 3, 4, 5
# So many numbers say the most of a point.
MOST = 26
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
        numbers: (n, 26) of a plane: the point (3) in its joint, R (9) in the plane's joint column
            by column, the origin (3) there, and s. Of a tip: the same of its middle, the radius of
            the ball around it, that of the rim, and the rim's axis (3); of an ellipsoid's
            instead of the last two E (9), row by row, as ``Ellipsoid`` has it. Of edges: a
            point (3) and the direction (3) of each in its joint, both lengths, the sign of n, and
            the least sine. Of a stop its row's entry, the sign, and the limit. Of a rope both ends
            in their joints, and how long it is.
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
def axis(table: Table, i: int, k: int, places: np.ndarray) -> Vector:
    """Column k of R of a point on a plane, in the world."""
    return turned(places, table.whole[i, 2], three(table.numbers[i], 3 + 3 * k))


@borrowing
def point_of(table: Table, i: int, places: np.ndarray) -> Vector:
    """A point on a plane, in the world."""
    j = table.whole[i, 1]
    return along(origin(places, j), 1.0, turned(places, j, three(table.numbers[i], 0)))


@borrowing
def over_face(table: Table, i: int, places: np.ndarray, place: Vector) -> float:
    """n·(x − o): how far a place in the world is over the plane of a point [m], negative below."""
    two, numbers = table.whole[i, 2], table.numbers[i]
    ground = along(origin(places, two), 1.0, turned(places, two, three(numbers, 12)))
    return numbers[15] * dot(axis(table, i, 2, places), along(place, -1.0, ground))


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
def stretched(numbers: np.ndarray, m: Vector) -> Vector:
    """Eᵀ E m of an ellipsoid, in the frame of its joint."""
    found = (0.0, 0.0, 0.0)
    for k in (17, 20, 23):
        row = three(numbers, k)
        found = along(found, dot(row, m), row)
    return found


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
    if table.whole[i, 0] == ELLIPSOID:
        here = back(places, j, n)
        out = stretched(numbers, here)
        return along(x, -1.0 / math.sqrt(dot(here, out)), turned(places, j, out)), n, n, n, 0.0
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
def spot_of(table: Table, i: int, places: np.ndarray) -> tuple[Vector, Axes]:
    """A point on a plane or face or of two edges in the world, and its axes t₁, t₂, n."""
    if table.whole[i, 0] == CROSSING:
        e, _, turn, square, here, there, _, _ = crossing(table, i, places)
        return along(here, 0.5, along(there, -1.0, here)), axes_of_crossing(e, turn, square)
    axes = axis(table, i, 0, places), axis(table, i, 1, places), axis(table, i, 2, places)
    return place_on_face(table, i, places), axes


@borrowing
def place_on_face(table: Table, i: int, places: np.ndarray) -> Vector:
    """A point on a plane, or where a tip is, in the world."""
    if table.whole[i, 0] == PLANE:
        return point_of(table, i, places)
    return tip_of(table, i, places)[0]
