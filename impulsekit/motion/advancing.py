"""When two bodies touch: conservative advancement with bounds of second order.

While some plane keeps two convex bodies apart they do not touch. Take the plane across their
shortest distance at a time t, with its normal n from the second to the first fixed in the world.
A point x of a body that moves with its centre c at u, and turns with ω, is after a time τ

    x + τ (u + ω × (x − c)) + ∫∫ ẍ,    n·(x − c) + τ n·ω × (x − c) = (n + τ n × ω)·(x − c),

so the gap along n is, with the support functions h of both bodies and a bound on accelerations,

    s(τ) ≥ gap + τ n·(u₁ − u₂) − [h₁(−n − τ n × ω₁) − h₁(−n)] − [h₂(n + τ n × ω₂) − h₂(n)] − ½ a τ².

The right side is concave: where it is not negative nothing has touched on the way. Time goes on
by that much, and again from there (Mirtich & Canny 1995, who bound speeds only and so need very
many steps where bodies move past each other).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from ..geometry.support import Support

__all__ = ["BodyMotion", "PairOfPieces", "Sight", "first_touch", "may_meet"]

# Accelerations are known at nodes; between them they are larger by no more than this part of how
# much they differ there, and all of them by this part of themselves.
BETWEEN, MORE = 0.5, 0.05
# The time that is sure is found to this part of itself.
SURE = 0.01
# A rate is told by a step that turns bodies so far [rad].
TURN = 1e-7
EPS = float(np.finfo(float).eps)


class BodyMotion:
    """How a body moves in a window of time.

    Attributes:
        times: (k,) [s].
        turn: (k, 3, 3). at: (k, 3) [m]. linear: (k, 3) of its origin [m/s]. angular: (k, 3) [1/s].
        spin_up: (k, 3) the angular acceleration [1/s²].
    """

    def __init__(self, times: np.ndarray, poses: Sequence[tuple[np.ndarray, ...]]) -> None:
        self.times = times
        self.turn, self.at, self.linear, self.angular = map(np.array, zip(*poses, strict=True))
        self._slope = _slope(len(times)) / (times[-1] - times[0])
        self.spin_up = self._slope.dot(self.angular)

    def centre(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(k, 3) places [m] and velocities [m/s] of a point of the body."""
        arm = self.turn.dot(point)
        return self.at + arm, self.linear + np.cross(self.angular, arm)

    def rate(self, values: np.ndarray) -> np.ndarray:
        """(k, 3) the rates of what is known at the nodes."""
        return self._slope.dot(values)


@dataclass(frozen=True, eq=False)
class PairOfPieces:
    """Two convex pieces, one of each body.

    Attributes:
        gap: from the placements of both bodies to the gap [m] and its normal (3,).
        supports: of both, in the frames of their bodies.
    """

    gap: Callable[[Sequence[pin.SE3]], tuple[float, np.ndarray]]
    supports: tuple[Support, Support]


@dataclass(frozen=True, eq=False)
class Sight:
    """Both bodies at one time: placements, and angular velocities and those of their origins."""

    places: Sequence[pin.SE3]
    linear: Sequence[np.ndarray]
    angular: Sequence[np.ndarray]


def may_meet(pair: PairOfPieces, motions: tuple[BodyMotion, BodyMotion]) -> tuple[bool, float]:
    """Whether balls about two pieces meet in a window, and the largest closing speed [m/s]."""
    a, b = pair.supports
    (here, u), (there, w) = (
        motion.centre(support.centre)
        for motion, support in zip(motions, pair.supports, strict=True)
    )
    apart, speed = here - there, u - w
    fastest = float(np.sqrt(np.einsum("ij,ij->i", speed, speed).max()))
    times = motions[0].times
    near = float(np.sqrt(np.einsum("ij,ij->i", apart, apart).min()))
    # The next node is no further away in time than half of what is between two of them.
    way = (1.0 + BETWEEN) * fastest * 0.5 * float(times[1] - times[0])
    turning = sum(
        support.reach * float(np.sqrt(np.einsum("ij,ij->i", m.angular, m.angular).max()))
        for support, m in zip(pair.supports, motions, strict=True)
    )
    return near - way <= a.radius + b.radius, fastest + turning


def first_touch(
    pair: PairOfPieces,
    motions: tuple[BodyMotion, BodyMotion],
    sight: Callable[[float], Sight],
    span: tuple[float, float],
    base: float,
    touch: float,
    *,
    exact: bool,
) -> float:
    """When two pieces first touch in a window; infinity where they do not.

    Args:
        sight: of both bodies at a time.
        span: from when to when [s].
        base: what counts as no gap [m].
        touch: pieces this near to each other touch [m].
        exact: whether gaps are told to rounding; else what has parted may seem to go deeper
            little by little.
    """
    start, end = span
    bound = _Bound(pair, motions)
    t = start
    look = bound.look(sight(t))
    gap = look.gap - base
    # Pieces that touch at the start may part, and meet again.
    parting = gap <= touch
    below = 10.0 * touch if not exact else touch
    floor = -below if parting else 0.0
    if parting and gap <= floor:
        if look.rate() < 0.0:
            return t
        floor = gap - below
    while True:
        sure = look.sure(gap - floor, end - t)
        if t + sure >= end:
            return np.inf
        t = min(end, t + max(sure, 4.0 * EPS * abs(t), 1e-300))
        look = bound.look(sight(t))
        gap = look.gap - base
        if parting and gap > touch:
            parting, floor = False, 0.0
        if not parting and gap <= touch:
            return min(end, t + look.sure(max(gap, 0.0), end - t))
        if parting and gap <= floor + 0.1 * touch:
            if exact or look.rate() < 0.0:
                return t
            floor = gap - below
        if t >= end:
            return np.inf


class _Bound:
    """Bounds on how two pieces accelerate in a window."""

    def __init__(self, pair: PairOfPieces, motions: tuple[BodyMotion, BodyMotion]) -> None:
        self.pair = pair
        velocities = [
            motion.centre(support.centre)[1]
            for motion, support in zip(motions, pair.supports, strict=True)
        ]
        self._acceleration = motions[0].rate(velocities[0] - velocities[1])
        self._turns = [
            (support.reach, motion.angular, motion.spin_up, _largest(motion.angular))
            for support, motion in zip(pair.supports, motions, strict=True)
            if support.reach and motion.angular.any()
        ]

    def look(self, sight: Sight) -> _Look:
        """Both pieces at a time."""
        return _Look(self, sight)

    def along(self, normal: np.ndarray) -> float:
        """No point comes nearer along a normal with a larger acceleration [m/s²]."""
        towards = -self._acceleration.dot(normal)
        high = float(towards.max())
        total = max(0.0, high + BETWEEN * (high - float(towards.min())))
        for reach, angular, spin_up, fastest in self._turns:
            # n·(ω × (ω × r)) ≤ |n × ω| |ω| |r|, and n·(ω̇ × r) ≤ |n × ω̇| |r|.
            across, up = _largest_across(angular, normal), _largest_across(spin_up, normal)
            total += (1.0 + BETWEEN) * reach * (across * fastest + up)
        return (1.0 + MORE) * total


class _Look:
    """Two pieces at one time, and a bound on their gap from then on."""

    def __init__(self, bound: _Bound, sight: Sight) -> None:
        self.gap, normal = bound.pair.gap(sight.places)
        self._speed = 0.0
        self._turns = []
        sides = zip(
            (1.0, -1.0),
            bound.pair.supports,
            sight.places,
            sight.linear,
            sight.angular,
            strict=True,
        )
        for sign, support, place, linear, angular in sides:
            turn = place.rotation
            arm = turn.dot(support.centre)
            self._speed += sign * float(normal.dot(linear + np.cross(angular, arm)))
            if support.reach and angular.any():
                way = -sign * turn.T.dot(normal)
                turning = -sign * turn.T.dot(np.cross(normal, angular))
                if turning.any():
                    self._turns.append((support, way, turning, support.about_centre(way)))
        self._curve = 0.5 * bound.along(normal)

    def rate(self) -> float:
        """How fast the gap opens [m/s]."""
        if not self._turns:
            return self._speed
        fastest = max(float(np.abs(turning).max()) for _, _, turning, _ in self._turns)
        step = TURN / fastest
        return self._speed - self._turned(step) / step

    def sure(self, gap: float, longest: float) -> float:
        """A time [s], of at most ``longest``, for which the gap surely stays open."""
        if gap <= 0.0 or longest <= 0.0:
            return 0.0
        if self._after(gap, longest) >= 0.0:
            return longest
        low, value_low, high = 0.0, gap, longest
        value_high = self._after(gap, high)
        for _ in range(60):
            # Of a concave function the chord lies below it, so its zero is sure;
            # halves let the other end follow.
            t = low + (high - low) * value_low / (value_low - value_high)
            value = self._after(gap, t)
            if value >= 0.0:
                low, value_low = t, value
            else:
                high, value_high = t, value
            if high - low <= SURE * low:
                break
            t = min(0.5 * (low + high), 4.0 * low) if low > 0.0 else 0.5 * high
            value = self._after(gap, t)
            if value >= 0.0:
                low, value_low = t, value
            else:
                high, value_high = t, value
            if high - low <= SURE * low:
                break
        return low

    def _turned(self, time: float) -> float:
        """By how much the bodies reach further along the normal as they turn [m]."""
        return sum(
            support.about_centre(way + time * turning) - before
            for support, way, turning, before in self._turns
        )

    def _after(self, gap: float, time: float) -> float:
        return gap + time * self._speed - self._turned(time) - self._curve * time * time


def _largest(vectors: np.ndarray) -> float:
    return float(np.sqrt(np.einsum("ij,ij->i", vectors, vectors).max()))


def _largest_across(vectors: np.ndarray, normal: np.ndarray) -> float:
    """The largest part of vectors (k, 3) across a normal."""
    across = vectors - np.outer(vectors.dot(normal), normal)
    return _largest(across)


def _slope(count: int) -> np.ndarray:
    """(k, k) from values at even nodes in [0, 1] to the slopes of their polynomial there."""
    nodes = np.linspace(0.0, 1.0, count)
    powers = np.vander(nodes, increasing=True)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, count)
    return slopes.dot(np.linalg.inv(powers))
