"""When two bodies touch: conservative advancement with bounds of second order.

While some plane keeps two convex bodies apart they do not touch. At a time t it lies across their
shortest distance, its normal n from the second to the first; from there on it may turn, n + τ m.
A point x of a body that moves with its centre c at u, and turns with ω, is after a time τ

    x + τ (u + ω × (x − c)) + ∫∫ ẍ,

so the gap along n + τ m is, with h the support functions of both bodies about their centres, d
and w from the second centre to the first and how fast that grows, and bounds r on |x − c|,

    s(τ) ≥ gap + τ (n·w + m·d) − [h₁(−n − τ (m + n × ω₁)) − h₁(−n)]
               − [h₂(n + τ (m + n × ω₂)) − h₂(n)] − τ² (½ a + |m| (|ω₁| r₁ + |ω₂| r₂) − m·w).

The right side is concave: where it is not negative nothing has touched on the way. Time goes on
by that much, and again from there (Mirtich & Canny 1995, who bound speeds only and so need very
many steps where bodies move past each other). Of some m the one with the longest time is taken:
a plane that stays, one that turns with either body, and one on which the edges or faces in it
stay; with the last s falls as the gap itself does, be it of a corner over a face or of two edges.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from ...geometry.support import Shape
from ...geometry.vectors import cross, dot, row_of
from ...laws.borrowed import borrowing
from ...laws.compiled import compiled
from ...tolerances import EPS, NONZERO
from .turning_planes import BETWEEN, Bound, Look, Pose, look_at, rate, sure

__all__ = ["BodyMotion", "Pose", "bound_of", "may_meet", "motion_of", "slope_of", "touch_finder"]
# What parts is looked at again from this share of the distance up to which it touches.
PARTED_BY = 0.1
# The least step of a look, as a share of the time: a few roundings of it.
LEAST_STEP = 4.0 * EPS


class BodyMotion(NamedTuple):
    """How a body moves in a window of time.

    Attributes:
        times: (k,) [s].
        turn: (3k, 3) rotations, one below the other. at: (k, 3) [m].
        linear: (k, 3) of its origin [m/s]. angular: (k, 3) [1/s].
        slope: (k, k) from what is known at the nodes to its rates.
    """

    times: np.ndarray
    turn: np.ndarray
    at: np.ndarray
    linear: np.ndarray
    angular: np.ndarray
    slope: np.ndarray


def motion_of(times: np.ndarray, poses: Sequence[Pose]) -> BodyMotion:
    """The motion of a body whose poses at some times are known."""
    turn, at, linear, angular = map(np.array, zip(*poses, strict=True))
    return BodyMotion(times, turn.reshape(-1, 3), at, linear, angular, slope_of(times))


def slope_of(times: np.ndarray) -> np.ndarray:
    """(k, k) from values at even times to the slopes of their polynomial there."""
    return _slope(len(times)) / (times[-1] - times[0])


@cache
def _slope(count: int) -> np.ndarray:
    """The same of nodes in [0, 1]."""
    nodes = np.linspace(0.0, 1.0, count)
    powers = np.vander(nodes, increasing=True)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, count)
    return slopes.dot(np.linalg.inv(powers))


@borrowing
def _longest(vectors: np.ndarray) -> float:
    """The largest length of vectors (k, 3)."""
    square = 0.0
    for i in range(len(vectors)):
        square = max(square, dot(row_of(vectors, i), row_of(vectors, i)))
    return math.sqrt(square)


@compiled
def _centre(motion: BodyMotion, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(k, 3) places [m] and velocities [m/s] of a point of the body."""
    arms = motion.turn.dot(point).reshape(motion.at.shape)
    speeds = motion.linear.copy()
    for i in range(len(speeds)):
        turned = cross(row_of(motion.angular, i), row_of(arms, i))
        for k in range(3):
            speeds[i, k] += turned[k]
    return motion.at + arms, speeds


@compiled
def _least_above(ground: Shape, motion: BodyMotion, away: np.ndarray) -> float:
    """How far a centre stays above a half-space at least, −∞ of one that turns or is none [m].

    At the nodes of a window; ``away``: (k, 3) from the centre of the half-space [m].
    """
    least = math.inf if len(ground.normal) > 0 else -math.inf
    for i in range(len(away)):
        if (
            motion.angular[i, 0] != 0.0
            or motion.angular[i, 1] != 0.0
            or motion.angular[i, 2] != 0.0
        ):
            return -math.inf
        if len(ground.normal) > 0:
            normal = motion.turn[3 * i : 3 * i + 3].dot(ground.normal)
            least = min(least, normal.dot(away[i]))
    return least


@compiled
def may_meet(one: Shape, two: Shape, first: BodyMotion, other: BodyMotion) -> tuple[bool, float]:
    """Whether balls about two pieces meet in a window, and the largest closing speed [m/s].

    Of a half-space that does not turn, whether the ball comes down to it.
    """
    here, u = _centre(first, one.centre)
    there, w = _centre(other, two.centre)
    fastest, near, away = _longest(u - w), math.inf, here - there
    for i in range(len(away)):
        near = min(near, math.sqrt(dot(row_of(away, i), row_of(away, i))))
    # The next node is no further away in time than half of what is between two of them.
    way = (1.0 + BETWEEN) * fastest * 0.5 * (first.times[1] - first.times[0])
    turning = one.reach * _longest(first.angular) + two.reach * _longest(other.angular)
    meets = not near - way > one.radius + two.radius
    if _least_above(two, other, away) - way > one.radius:
        meets = False
    if _least_above(one, first, -away) - way > two.radius:
        meets = False
    return meets, fastest + turning


@compiled
def bound_of(one: Shape, two: Shape, first: BodyMotion, other: BodyMotion) -> Bound:
    """Bounds on how two pieces of two bodies accelerate."""
    acceleration = first.slope.dot(_centre(first, one.centre)[1] - _centre(other, two.centre)[1])
    count = len(first.times)
    angular, spin_up, fastest = np.empty((2, count, 3)), np.empty((2, count, 3)), np.empty(2)
    angular[0], angular[1] = first.angular, other.angular
    any_way, turning = _longest(acceleration), 0.0
    for i in range(2):
        reach = one.reach if i == 0 else two.reach
        spin_up[i] = first.slope.dot(angular[i])
        fastest[i] = _longest(angular[i])
        turning += (1.0 + BETWEEN) * reach * fastest[i]
        any_way += (1.0 + BETWEEN) * reach * (fastest[i] ** 2 + _longest(spin_up[i]))
    return Bound(one, two, acceleration, angular, spin_up, fastest, any_way, turning)


def touch_finder(
    see: Callable[[Any, float], tuple[float, np.ndarray, Pose, Pose]],
) -> Callable[..., float]:
    """The search for the first touch of two pieces that ``see(course, t)`` shows.

    Args:
        see: the gap of two pieces at a time [m], its normal (3,), and both bodies.

    Returns:
        ``first_touch(course, bound, start, end, base, touch, exact)``: when two pieces first
        touch in a window; infinity where they do not. Its arguments are the course; ``bound_of``
        both pieces in the window; from when to when [s]; what counts as no gap [m]; pieces how
        near to each other touch [m]; and whether gaps are told to rounding: else what has parted
        may seem to go deeper little by little. Compiled code may call it if it may call ``see``.
    """

    @compiled
    def seen(course: Any, bound: Bound, t: float) -> Look:
        gap, normal, one, two = see(course, t)
        return look_at(bound, gap, normal, one, two)

    @compiled
    def first_touch(
        course: Any, bound: Bound, start: float, end: float, base: float, touch: float, exact: bool
    ) -> float:
        t = start
        look = seen(course, bound, t)
        gap = look.gap - base
        # Pieces that touch at the start may part, and meet again.
        parting = gap <= touch
        below = touch if exact else 10.0 * touch
        floor = -below if parting else 0.0
        if parting and gap <= floor:
            if rate(bound, look) < 0.0:
                return t
            floor = gap - below
        while True:
            certain = sure(bound, look, gap - floor, end - t)
            if t + certain >= end:
                return math.inf
            t = min(end, t + max(certain, LEAST_STEP * abs(t), NONZERO))
            look = seen(course, bound, t)
            gap = look.gap - base
            if parting and gap > touch:
                parting, floor = False, 0.0
            if not parting and gap <= touch:
                return min(end, t + sure(bound, look, max(gap, 0.0), end - t))
            if parting and gap <= floor + PARTED_BY * touch:
                if exact or rate(bound, look) < 0.0:
                    return t
                floor = gap - below
            if t >= end:
                return math.inf

    return first_touch
