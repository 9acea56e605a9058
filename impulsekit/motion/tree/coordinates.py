"""``Chart`` as compiled code: configurations from coordinates of a chart, and their rates."""

from __future__ import annotations

import math

import numpy as np

from ...geometry.point_table import three
from ...geometry.vectors import Vector, along, cross
from ...laws.borrowed import borrowing
from .bodies import BALL, CIRCLE, FREE, PLANAR, Tree
from .chart import SMALL, unrolled

__all__ = ["centre", "rotated", "rotated_by", "turn_by", "write_configuration", "write_rate"]


@borrowing
def write_configuration(tree: Tree, reference: np.ndarray, x: np.ndarray, q: np.ndarray) -> None:
    """Write q (nq,) of x (nv,), as ``Chart.configuration`` has it; not into ``reference``."""
    for j in range(1, len(tree.joints)):
        kind, at, row = tree.joints[j, 1], tree.joints[j, 2], tree.joints[j, 3]
        if kind == CIRCLE:
            c, s = math.cos(x[row]), math.sin(x[row])
            q[at] = c * reference[at] - s * reference[at + 1]
            q[at + 1] = s * reference[at] + c * reference[at + 1]
        elif kind == PLANAR:
            q[at], q[at + 1] = x[row], x[row + 1]
            q[at + 2], q[at + 3] = math.cos(x[row + 2]), math.sin(x[row + 2])
        elif kind == BALL:
            turn_by(reference, at, three(x, row), q)
        elif kind == FREE:
            turn_by(reference, at + 3, three(x, row + 3), q)
            moved = rotated(reference, at + 3, _screwed(three(x, row), three(x, row + 3)))
            q[at], q[at + 1], q[at + 2] = along(three(reference, at), 1.0, moved)
        else:
            for k in range(tree.joints[j, 4]):
                q[at + k] = x[row + k]


@borrowing
def write_rate(tree: Tree, x: np.ndarray, q: np.ndarray, v: np.ndarray, rate: np.ndarray) -> None:
    """Write ẋ (nv,), as ``Chart.rate`` has it."""
    for j in range(1, len(tree.joints)):
        kind, at, row = tree.joints[j, 1], tree.joints[j, 2], tree.joints[j, 3]
        if kind == PLANAR:
            c, s = q[at + 2], q[at + 3]
            rate[row], rate[row + 1] = c * v[row] - s * v[row + 1], s * v[row] + c * v[row + 1]
            rate[row + 2] = v[row + 2]
        elif kind == FREE:
            found = unrolled(_six(x, row), _six(v, row))
            for k in range(6):
                rate[row + k] = found[k]
        elif kind == BALL:
            found = unrolled(
                (0.0, 0.0, 0.0, x[row], x[row + 1], x[row + 2]),
                (0.0, 0.0, 0.0, v[row], v[row + 1], v[row + 2]),
            )
            for k in range(3):
                rate[row + k] = found[3 + k]
        else:
            for k in range(tree.joints[j, 4]):
                rate[row + k] = v[row + k]


@borrowing
def centre(tree: Tree, q: np.ndarray, reference: np.ndarray, x: np.ndarray) -> None:
    """Write the reference (nq,) of the chart around q, and x (nv,); see ``Chart.centred``."""
    for j in range(1, len(tree.joints)):
        kind, at, row = tree.joints[j, 1], tree.joints[j, 2], tree.joints[j, 3]
        if kind == PLANAR:
            x[row], x[row + 1], x[row + 2] = q[at], q[at + 1], math.atan2(q[at + 3], q[at + 2])
        elif kind in (CIRCLE, BALL, FREE):
            count = 2 if kind == CIRCLE else (4 if kind == BALL else 7)
            for k in range(count):
                reference[at + k] = q[at + k]
            for k in range(tree.joints[j, 4]):
                x[row + k] = 0.0
        else:
            for k in range(tree.joints[j, 4]):
                x[row + k] = q[at + k]


@borrowing
def _six(x: np.ndarray, at: int) -> tuple[float, float, float, float, float, float]:
    return x[at], x[at + 1], x[at + 2], x[at + 3], x[at + 4], x[at + 5]


@borrowing
def turn_by(reference: np.ndarray, at: int, x: Vector, q: np.ndarray) -> None:
    """Write the quaternion q_ref exp(x); ``q`` may be the reference."""
    square = x[0] * x[0] + x[1] * x[1] + x[2] * x[2]
    half = 0.5 * math.sqrt(square)
    part = 0.5 * math.sin(half) / half if half > 0.0 else 0.5
    i, j, k, w = part * x[0], part * x[1], part * x[2], math.cos(half)
    a, b, c, d = reference[at], reference[at + 1], reference[at + 2], reference[at + 3]
    q[at] = d * i + a * w + b * k - c * j
    q[at + 1] = d * j - a * k + b * w + c * i
    q[at + 2] = d * k + a * j - b * i + c * w
    q[at + 3] = d * w - a * i - b * j - c * k


@borrowing
def rotated(q: np.ndarray, at: int, x: Vector) -> Vector:
    """x turned by the unit quaternion at some place of a configuration."""
    return rotated_by(three(q, at), q[at + 3], x)


@borrowing
def rotated_by(u: Vector, w: float, x: Vector) -> Vector:
    """x turned by a unit quaternion, its vector u and its scalar w."""
    t = cross(u, x)
    t = (2.0 * t[0], 2.0 * t[1], 2.0 * t[2])
    return along(along(x, w, t), 1.0, cross(u, t))


@borrowing
def _screwed(x: Vector, w: Vector) -> Vector:
    """How far the origin goes in a screw: x + (1 − cos θ)/θ² w × x + (θ − sin θ)/θ³ w × (w × x)."""
    square = w[0] * w[0] + w[1] * w[1] + w[2] * w[2]
    if square < SMALL * SMALL:
        a = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0 * _less(square, 90)))
        b = 1 / 6 - square / 120.0 * (
            1.0 - square / 42.0 * (1.0 - square / 72.0 * _less(square, 110))
        )
    else:
        theta = math.sqrt(square)
        a = 2.0 * (math.sin(0.5 * theta) / theta) ** 2
        b = (theta - math.sin(theta)) / (theta * square)
    once = cross(w, x)
    return along(along(x, a, once), b, cross(w, once))


@borrowing
def _less(square: float, factor: float) -> float:
    """The last factors of a series that is cut there."""
    return 1.0 - square / factor
