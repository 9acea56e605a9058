"""Planes that turn between two convex pieces, and how long they surely keep them apart.

The bound is that of ``advancing``.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.support import Shape, furthest
from ...geometry.vectors import Vector, along, cross_of, dot, row_of
from ...laws.compiled import compiled

__all__ = ["BETWEEN", "Bound", "Look", "Pose", "look_at", "rate", "sure"]

# Accelerations are known at nodes; between them they are larger by no more than this part of how
# much they differ there, and all of them by this part of themselves.
BETWEEN, MORE = 0.5, 0.05
# The time that is sure is found to this part of itself.
SURE = 0.01
# A rate is told by a step that turns bodies so far [rad].
TURN = 1e-7
# Planes turn no further before the bodies are looked at again [rad].
TURN_OF_PLANE = 0.2
# Corners this near to a plane lie in it, as a part of how far they are from the centre.
IN_PLANE = 1e-7
# Edges that differ by less are one.
FLAT = 1e-9
# A zero is sought in so many steps at most.
MOST_STEPS = 120
# Planes that are tried: one that stays, one that follows edges, and one that turns with either.
PLANES = 4


class Pose(NamedTuple):
    """A body at one time, in the world.

    Attributes:
        turn: (3, 3). at: (3,) its origin [m], and (3,) that one's velocity [m/s]: linear.
        angular: (3,) [1/s].
    """

    turn: np.ndarray
    at: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


class Bound(NamedTuple):
    """Bounds on how two pieces accelerate in a window.

    Attributes:
        one, two: their shapes.
        acceleration: (k, 3) of the first centre against the second [m/s²].
        angular, spin_up: (2, k, 3) of both bodies [1/s, 1/s²]. fastest: (2,) [1/s].
        any_way: of any point in any direction [m/s²]. turning: |ω| r of both together [m/s].
    """

    one: Shape
    two: Shape
    acceleration: np.ndarray
    angular: np.ndarray
    spin_up: np.ndarray
    fastest: np.ndarray
    any_way: float
    turning: float


class _Side(NamedTuple):
    """One of two pieces: how far it reaches towards the plane between them.

    Attributes:
        sign: 1 for the first. shape: its own. turn: (3, 3) of its body.
        centre, velocity: (3,) of its centre. way: (3,) towards the plane, in its frame.
        before: how far it reaches [m]. slip: (3,) how the body turns beneath the plane [1/s].
    """

    sign: float
    shape: Shape
    turn: np.ndarray
    centre: np.ndarray
    velocity: np.ndarray
    way: np.ndarray
    before: float
    slip: np.ndarray


class Look(NamedTuple):
    """Two pieces at one time: their gap [m], its normal, and a bound on how fast it bends."""

    gap: float
    normal: np.ndarray
    acceleration: float
    one: _Side
    two: _Side


class _Plane(NamedTuple):
    """A plane between two pieces that turns; how wide the gap along its normal surely stays.

    Attributes:
        speed: at which centres part along it [m/s]. longest: it turns no longer [s].
        curve: how fast the gap may bend [m/s²].
        turning: (2, 3) how it turns, in the frames of both bodies [1/s].
    """

    speed: float
    longest: float
    curve: float
    turning: np.ndarray


@compiled
def longest_across(vectors: np.ndarray, normal: Vector) -> float:
    """The largest part of vectors (k, 3) across a normal."""
    square = 0.0
    for i in range(len(vectors)):
        vector = row_of(vectors, i)
        across = along(vector, -dot(vector, normal), normal)
        square = max(square, dot(across, across))
    return math.sqrt(square)


@compiled
def _moves(vector: np.ndarray) -> bool:
    """Whether it is not zero."""
    return vector[0] != 0.0 or vector[1] != 0.0 or vector[2] != 0.0


@compiled
def _along(bound: Bound, normal: Vector) -> float:
    """No point comes nearer along a normal with a larger acceleration [m/s²]."""
    high, low = -math.inf, math.inf
    for i in range(len(bound.acceleration)):
        towards = -dot(row_of(bound.acceleration, i), normal)
        high, low = max(high, towards), min(low, towards)
    total = max(0.0, high + BETWEEN * (high - low))
    for i in range(2):
        reach = bound.one.reach if i == 0 else bound.two.reach
        # n·(ω × (ω × r)) ≤ |n × ω| |ω| |r|, and n·(ω̇ × r) ≤ |n × ω̇| |r|.
        across = longest_across(bound.angular[i], normal)
        up = longest_across(bound.spin_up[i], normal)
        total += (1.0 + BETWEEN) * reach * (across * bound.fastest[i] + up)
    return (1.0 + MORE) * total


@compiled
def _side(sign: float, shape: Shape, pose: Pose, normal: np.ndarray) -> _Side:
    """One of two pieces with a plane between them."""
    arm = pose.turn.dot(shape.centre)
    way = -sign * normal.dot(pose.turn)
    return _Side(
        sign,
        shape,
        pose.turn,
        pose.at + arm,
        pose.linear + cross_of(pose.angular, arm),
        way,
        furthest(shape, way),
        cross_of(normal, pose.angular),
    )


@compiled
def look_at(bound: Bound, gap: float, normal: np.ndarray, one: Pose, two: Pose) -> Look:
    """Both pieces at a time."""
    sides = _side(1.0, bound.one, one, normal), _side(-1.0, bound.two, two, normal)
    bend = _along(bound, (normal[0], normal[1], normal[2]))
    return Look(gap, normal, bend, sides[0], sides[1])


@compiled
def _write_edges(
    side: _Side, normal: np.ndarray, rows: np.ndarray, wanted: np.ndarray, count: int
) -> int:
    """Write of what lies in the plane, from one of its corners to the others, what is across.

    And how fast it leaves the plane; gives how many rows are written by now.
    """
    points = side.shape.points
    heights = points.dot(side.way)
    least, first = heights.max() - IN_PLANE * side.shape.reach, -1
    for i in range(len(points)):
        if heights[i] >= least and first < 0:
            first = i
        elif heights[i] >= least:
            edge = side.turn.dot(points[i] - points[first])
            wanted[count] = -edge.dot(side.slip)
            rows[count] = edge - edge.dot(normal) * normal
            count += 1
    return count


@compiled
def _following(look: Look) -> np.ndarray:
    """(3,) m of a plane on which the edges in it stay: m·e = −(n × ω)·e of each."""
    most = len(look.one.shape.points) + len(look.two.shape.points)
    rows, wanted = np.empty((most, 3)), np.empty(most)
    count = _write_edges(look.one, look.normal, rows, wanted, 0)
    count = _write_edges(look.two, look.normal, rows, wanted, count)
    if count == 0:
        return np.zeros(3)
    return np.linalg.lstsq(rows[:count], wanted[:count], FLAT)[0]


@compiled
def _plane(bound: Bound, look: Look, m: np.ndarray) -> _Plane:
    """A plane that turns by m."""
    one, two, size = look.one, look.two, math.sqrt(m.dot(m))
    w = one.velocity - two.velocity
    speed = float(look.normal.dot(w) + m.dot(one.centre - two.centre))
    curve = 0.5 * look.acceleration
    if size > 0.0:
        curve += 0.5 * TURN_OF_PLANE * bound.any_way + size * bound.turning
        curve += max(0.0, -float(m.dot(w)))
    turning = np.empty((2, 3))
    turning[0] = (m + one.slip).dot(one.turn)
    turning[1] = (m + two.slip).dot(two.turn)
    return _Plane(speed, TURN_OF_PLANE / size if size > 0.0 else math.inf, curve, turning)


@compiled
def _turned(look: Look, plane: _Plane, time: float) -> float:
    """By how much both reach further along the normal after a time [m]."""
    total = 0.0
    for i in range(2):
        side, turning = look.one if i == 0 else look.two, plane.turning[i]
        if _moves(turning):
            total += furthest(side.shape, side.way - side.sign * time * turning) - side.before
    return total


@compiled
def _after(look: Look, plane: _Plane, gap: float, time: float) -> float:
    turned = _turned(look, plane, time)
    return gap + time * plane.speed - turned - plane.curve * time * time


@compiled
def _sure_of(look: Look, plane: _Plane, gap: float, longest: float) -> float:
    """A time [s], of at most ``longest``, for which the gap along a plane surely stays open."""
    longest = min(longest, plane.longest)
    if gap <= 0.0 or longest <= 0.0:
        return 0.0
    low, value_low, high, value_high = 0.0, gap, longest, _after(look, plane, gap, longest)
    if value_high >= 0.0:
        return longest
    for k in range(MOST_STEPS):
        # Of a concave function the chord lies below it, so its zero is sure;
        # halves let the other end follow.
        if k % 2 == 0:
            t = low + (high - low) * value_low / (value_low - value_high)
        else:
            t = min(0.5 * (low + high), 4.0 * low) if low > 0.0 else 0.5 * high
        value = _after(look, plane, gap, t)
        if value >= 0.0:
            low, value_low = t, value
        else:
            high, value_high = t, value
        if high - low <= SURE * low:
            break
    return low


@compiled
def _stays_endless(side: _Side) -> bool:
    """Whether it is a half-space that does not turn beneath the plane."""
    return len(side.shape.normal) > 0 and not _moves(side.slip)


@compiled
def _is_to_try(look: Look, k: int) -> bool:
    """Whether a plane is worth trying: where no body turns beneath it the one that stays will do.

    What is a ball about its centre does not turn. A plane that turns cuts a half-space that stays,
    by 1e-7 m below a box even where it counts as along its normal.
    """
    if k > 0 and (_stays_endless(look.one) or _stays_endless(look.two)):
        return False
    turns_one = look.one.shape.reach > 0.0
    turns_two = look.two.shape.reach > 0.0
    if k == 0:
        return True
    if not ((turns_one and _moves(look.one.slip)) or (turns_two and _moves(look.two.slip))):
        return False
    return k == 1 or (turns_one if k == 2 else turns_two)


@compiled
def _way(look: Look, k: int) -> np.ndarray:
    """(3,) how a plane turns [1/s]."""
    if k == 0:
        return np.zeros(3)
    if k == 1:
        return _following(look)
    return -look.one.slip if k == 2 else -look.two.slip


@compiled
def sure(bound: Bound, look: Look, gap: float, longest: float) -> float:
    """A time [s], of at most ``longest``, for which the gap surely stays open."""
    best = 0.0
    for k in range(PLANES):
        if best >= longest:
            break
        if _is_to_try(look, k):
            plane = _plane(bound, look, _way(look, k))
            best = max(best, _sure_of(look, plane, gap, longest))
    return best


@compiled
def rate(bound: Bound, look: Look) -> float:
    """How fast the gap opens [m/s]."""
    best = -math.inf
    for k in range(PLANES):
        if not _is_to_try(look, k):
            continue
        plane = _plane(bound, look, _way(look, k))
        rate, fastest = plane.speed, 0.0
        for i in range(2):
            for j in range(3):
                fastest = max(fastest, abs(plane.turning[i, j]))
        if fastest > 0.0:
            step = TURN / fastest
            rate -= _turned(look, plane, step) / step
        best = max(best, rate)
    return best
