"""Tips in tables of points: where they are and how fast their velocity turns; see ``held_tips``."""

from __future__ import annotations

import math

import numpy as np

from ..laws.borrowed import borrowing
from .point_table import ELLIPSOID, Kinematics, Table, axis, back, moving, point_of, three, turned
from .vectors import Vector, along, cross, dot

__all__ = ["tip_of", "write_bias_of_tip"]


@borrowing
def _stretched(numbers: np.ndarray, m: Vector) -> Vector:
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
        out = _stretched(numbers, here)
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
def write_bias_of_tip(table: Table, i: int, kinematics: Kinematics, bias: np.ndarray) -> None:
    """Write what the accelerations at a tip have beside J v̇, in its axes, to bias (3n,)."""
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
    if table.whole[i, 0] == ELLIPSOID:
        here = back(places, one, n)
        out = _stretched(numbers, here)
        more = _stretched(numbers, back(places, one, along(n_rate, -1.0, cross(spin, n))))
        size = math.sqrt(dot(here, out))
        more = along(more, -dot(here, more) / size**2, out)
        more = along(turned(places, one, more), 1.0, cross(spin, turned(places, one, out)))
        moves = along(moves, -1.0 / size, more)
    elif sine > 0.0:
        a_rate = cross(spin, a)
        out = along(n_rate, -dot(n_rate, a) - dot(n, a_rate), a)
        out = along(out, -dot(n, a), a_rate)
        moves = along(moves, -numbers[17] / sine, along(out, -dot(d, out), d))
    change = along(rate, 1.0, cross(spin, along(moves, -1.0, v)))
    change = along(along(change, -1.0, below_rate), -1.0, cross(turning, along(moves, -1.0, below)))
    change = along(change, -1.0, cross(turning, along(v, -1.0, below)))
    for k in range(3):
        bias[3 * i + k] = sign * dot(axis(table, i, k, places), change)
