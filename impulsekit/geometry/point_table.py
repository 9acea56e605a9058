"""Tables of points for compiled code, and where the joints are that they belong to."""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from ..laws.borrowed import borrowing
from .vectors import Vector, along, cross

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
    "axis",
    "back",
    "moving",
    "origin",
    "point_of",
    "table_of",
    "three",
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
