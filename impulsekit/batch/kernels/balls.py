"""Where balls meet what may touch them: the normal, the arms on both bodies, and the gap.

A shape is a core and a radius around it: of a ball a point, of a capsule a segment, of a box
or a cylinder the whole. The normal goes from the nearest point of the core to the centre of
the ball; the point of contact lies halfway between the surfaces, as in ``geometry.collision``.
Handed over by its address, like the laws, it is compiled only for scenes that need it.
"""

from __future__ import annotations

import functools
import math
from typing import Any

from numba import types

from ...geometry.axes import rows_of_axes
from .handed import handed
from .jit import built_in
from .layout import BALL_FLOATS, BALL_INTS, BODY, BOX, CAPSULE, CYLINDER, MEETING, ROTATION

__all__ = ["balls_for"]


@functools.cache
def balls_for(number: str, needed: bool) -> Any:
    """What ``solve_blocks`` is to call for the meetings of balls.

    Args:
        number: of the work array, "float64" or "float32".
        needed: whether it will be called; else something of the same type that does nothing.
    """
    whole = types.int64
    signature = types.none(
        types.int64[::1], types.float64[::1], getattr(types, number)[::1], whole, whole, whole
    )
    return handed(signature, place_balls if needed else leave_balls)


def place_balls(ints, floats, work, meeting_at, gap_at, w):
    """Write axes and arms of every meeting, and the gaps.

    Args:
        ints, floats: see ``layout``; what ``place_meetings`` left as arm is that of the centre.
        work: the work array, with its ``meeting_at``; gaps go to ``gap_at``, ball by ball.
        w: how many states there are.
    """
    for ball in range(len(ints) // BALL_INTS):
        for lane in range(w):
            gap = _place(ints, floats, ball, work, meeting_at, w, lane)
            work[(gap_at + ball) * w + lane] = gap


@built_in
def _place(ints, floats, ball, work, meeting_at, w, lane):
    """The gap of one ball in one state; NaN where its centre lies within the core."""
    i, f = ball * BALL_INTS, ball * BALL_FLOATS
    first = (ints[i] * BODY + ROTATION) * w + lane
    other = (ints[i + 1] * BODY + ROTATION) * w + lane
    at = (meeting_at + ints[i + 2] * MEETING) * w + lane
    centre = _triple(work, at + 9 * w, w)
    radius = floats[f + 3]
    turn, shift = f + 4, f + 13
    x, y, z = _back(work, other, w, centre[0], centre[1], centre[2])
    x, y, z = x - floats[shift], y - floats[shift + 1], z - floats[shift + 2]
    x, y, z = _back(floats, turn, 1, x, y, z)
    p1, p2, p3, around = _core(ints[i + 3], floats, f + 16, x, y, z)
    d1, d2, d3 = x - p1, y - p2, z - p3
    length = math.sqrt(d1 * d1 + d2 * d2 + d3 * d3)
    gap = length - around - radius
    if length > 0.0:
        d1, d2, d3 = d1 / length, d2 / length, d3 / length
    else:
        d1, d2, d3, gap = 0.0, 0.0, 1.0, math.nan
    half = around + 0.5 * (gap if length > 0.0 else 0.0)
    p1, p2, p3 = _there(floats, turn, 1, p1 + half * d1, p2 + half * d2, p3 + half * d3)
    p1, p2, p3 = p1 + floats[shift], p2 + floats[shift + 1], p3 + floats[shift + 2]
    arm = _there(work, other, w, p1, p2, p3)
    own = _there(work, first, w, floats[f], floats[f + 1], floats[f + 2])
    for k in range(3):
        work[at + (9 + k) * w] = arm[k]
        work[at + (MEETING + 9 + k) * w] = arm[k] - centre[k] + own[k]
    d1, d2, d3 = _there(floats, turn, 1, d1, d2, d3)
    d1, d2, d3 = _there(work, other, w, d1, d2, d3)
    if ints[i + 4] < 0:
        d1, d2, d3 = -d1, -d2, -d3
    axes = rows_of_axes(d1, d2, d3)
    for k in range(3):
        work[at + k * w] = axes[0][k]
        work[at + (3 + k) * w] = axes[1][k]
        work[at + (6 + k) * w] = axes[2][k]
    return gap


@built_in
def _core(kind, floats, f, x, y, z):
    """The point of a shape's core nearest to one, all in the shape's axes, and its radius."""
    a, b, c = floats[f], floats[f + 1], floats[f + 2]
    if kind == BOX:
        return min(max(x, -a), a), min(max(y, -b), b), min(max(z, -c), c), 0.0
    if kind == CAPSULE:
        return 0.0, 0.0, min(max(z, -b), b), a
    if kind == CYLINDER:
        out = math.sqrt(x * x + y * y)
        share = a / out if out > a else 1.0
        return x * share, y * share, min(max(z, -b), b), 0.0
    return 0.0, 0.0, 0.0, a


@built_in
def _triple(array, at, step):
    return float(array[at]), float(array[at + step]), float(array[at + 2 * step])


@built_in
def _there(array, at, step, x, y, z):
    """R x, R by rows from ``at`` on."""
    a = _triple(array, at, step)
    b = _triple(array, at + 3 * step, step)
    c = _triple(array, at + 6 * step, step)
    return (
        a[0] * x + a[1] * y + a[2] * z,
        b[0] * x + b[1] * y + b[2] * z,
        c[0] * x + c[1] * y + c[2] * z,
    )


@built_in
def _back(array, at, step, x, y, z):
    """Rᵀ x."""
    a = _triple(array, at, step)
    b = _triple(array, at + 3 * step, step)
    c = _triple(array, at + 6 * step, step)
    return (
        a[0] * x + b[0] * y + c[0] * z,
        a[1] * x + b[1] * y + c[1] * z,
        a[2] * x + b[2] * y + c[2] * z,
    )


def leave_balls(ints, floats, work, meeting_at, gap_at, w):
    """Nothing."""
