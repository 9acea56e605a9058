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

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property

import numpy as np
import pinocchio as pin

from ..geometry.axes import cross
from ..geometry.support import Support
from ..tolerances import EPS, NONZERO

__all__ = ["BodyMotion", "PairOfPieces", "Sight", "first_touch", "may_meet"]

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
_NOT_AT_ALL = np.zeros(3)
_NEXT, _LAST = [1, 2, 0], [2, 0, 1]


class BodyMotion:
    """How a body moves in a window of time.

    Attributes:
        times: (k,) [s].
        turn: (k, 3, 3). at: (k, 3) [m]. linear: (k, 3) of its origin [m/s]. angular: (k, 3) [1/s].
    """

    def __init__(self, times: np.ndarray, poses: Sequence[tuple[np.ndarray, ...]]) -> None:
        self.times = times
        self.turn, self.at, self.linear, self.angular = map(np.array, zip(*poses, strict=True))
        self._slope = _slope(len(times)) / (times[-1] - times[0])

    @cached_property
    def spin_up(self) -> np.ndarray:
        """(k, 3) the angular acceleration [1/s²]."""
        return self._slope.dot(self.angular)

    def centre(self, point: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """(k, 3) places [m] and velocities [m/s] of a point of the body."""
        arm = self.turn.dot(point)
        return self.at + arm, self.linear + _crosses(self.angular, arm)

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
    return not near - way > a.radius + b.radius, fastest + turning


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
        t = min(end, t + max(sure, 4.0 * EPS * abs(t), NONZERO))
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
        # Of any point in any direction; and of what |ω| r both have together.
        self.any_way = _largest(self._acceleration)
        self.turning = 0.0
        for reach, _, spin_up, fastest in self._turns:
            self.turning += (1.0 + BETWEEN) * reach * fastest
            self.any_way += (1.0 + BETWEEN) * reach * (fastest**2 + _largest(spin_up))

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


class _Side:
    """One of two pieces: how far it reaches towards the plane between them."""

    def __init__(
        self,
        sign: float,
        support: Support,
        place: pin.SE3,
        linear: np.ndarray,
        angular: np.ndarray,
        normal: np.ndarray,
    ) -> None:
        self.sign, self.support, self.turn, self.angular = sign, support, place.rotation, angular
        arm = self.turn.dot(support.centre)
        self.centre = place.translation + arm
        self.velocity = linear + cross(angular, arm)
        self.way = -sign * self.turn.T.dot(normal)
        self.before = support.about_centre(self.way)
        # How the body turns beneath the plane.
        self.slip = cross(normal, angular)

    def edges(self) -> np.ndarray:
        """(k, 3) of what lies in the plane: from one of its corners to the others, in the world."""
        points = self.support.points
        heights = points.dot(self.way)
        there = points[heights >= heights.max() - IN_PLANE * self.support.reach]
        return (there[1:] - there[0]).dot(self.turn.T)

    def further(self, time: float, turning: np.ndarray) -> float:
        """By how much it reaches further after a time when the plane turns by m + n × ω [m]."""
        way = self.way - self.sign * time * turning
        return self.support.about_centre(way) - self.before


class _Plane:
    """A plane between two pieces that turns; how wide the gap along its normal surely stays."""

    def __init__(self, look: _Look, m: np.ndarray) -> None:
        size = float(np.sqrt(m.dot(m)))
        one, two = look.sides
        w = one.velocity - two.velocity
        self.speed = float(look.normal.dot(w) + m.dot(one.centre - two.centre))
        self.longest = TURN_OF_PLANE / size if size > 0.0 else np.inf
        self._curve = 0.5 * look.acceleration
        if size > 0.0:
            bound = look.bound
            self._curve += 0.5 * TURN_OF_PLANE * bound.any_way + size * bound.turning
            self._curve += max(0.0, -float(m.dot(w)))
        turns = [(side, side.turn.T.dot(m + side.slip)) for side in look.sides]
        self._turns = [(side, turning) for side, turning in turns if turning.any()]

    def rate(self) -> float:
        """How fast the gap opens [m/s]."""
        if not self._turns:
            return self.speed
        step = TURN / max(float(np.abs(turning).max()) for _, turning in self._turns)
        return self.speed - self._turned(step) / step

    def sure(self, gap: float, longest: float) -> float:
        """A time [s], of at most ``longest``, for which the gap surely stays open."""
        longest = min(longest, self.longest)
        if gap <= 0.0 or longest <= 0.0:
            return 0.0
        low, value_low, high, value_high = 0.0, gap, longest, self._after(gap, longest)
        if value_high >= 0.0:
            return longest
        for k in range(120):
            # Of a concave function the chord lies below it, so its zero is sure;
            # halves let the other end follow.
            if k % 2 == 0:
                t = low + (high - low) * value_low / (value_low - value_high)
            else:
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
        """By how much both reach further along the normal [m]."""
        return sum(side.further(time, turning) for side, turning in self._turns)

    def _after(self, gap: float, time: float) -> float:
        return gap + time * self.speed - self._turned(time) - self._curve * time * time


class _Look:
    """Two pieces at one time, and a bound on their gap from then on."""

    def __init__(self, bound: _Bound, sight: Sight) -> None:
        self.bound = bound
        self.gap, self.normal = bound.pair.gap(sight.places)
        self.acceleration = bound.along(self.normal)
        supports = bound.pair.supports
        seen = zip(supports, sight.places, sight.linear, sight.angular, strict=True)
        self.sides = [
            _Side(sign, *own, self.normal) for sign, own in zip((1.0, -1.0), seen, strict=True)
        ]

    def rate(self) -> float:
        """How fast the gap opens [m/s]."""
        return max(plane.rate() for plane in self._planes)

    def sure(self, gap: float, longest: float) -> float:
        """A time [s], of at most ``longest``, for which the gap surely stays open."""
        best = 0.0
        for plane in self._planes:
            best = max(best, plane.sure(gap, longest))
            if best >= longest:
                break
        return best

    @cached_property
    def _planes(self) -> list[_Plane]:
        """Planes that stay or turn; the first does not."""
        still = _Plane(self, _NOT_AT_ALL)
        slips = [side.slip for side in self.sides if side.support.reach]
        if not any(slip.any() for slip in slips):
            return [still]
        return [still, _Plane(self, self._following()), *(_Plane(self, -slip) for slip in slips)]

    def _following(self) -> np.ndarray:
        """(3,) m of a plane on which the edges in it stay: m·e = −(n × ω)·e of each."""
        edges = [side.edges() for side in self.sides]
        rows = np.concatenate(edges)
        if not len(rows):
            return _NOT_AT_ALL
        wanted = [-own.dot(side.slip) for own, side in zip(edges, self.sides, strict=True)]
        # Across the normal only.
        rows = rows - np.outer(rows.dot(self.normal), self.normal)
        return np.linalg.lstsq(rows, np.concatenate(wanted), rcond=FLAT)[0]


def _largest(vectors: np.ndarray) -> float:
    return float(np.sqrt(np.einsum("ij,ij->i", vectors, vectors).max()))


def _largest_across(vectors: np.ndarray, normal: np.ndarray) -> float:
    """The largest part of vectors (k, 3) across a normal."""
    across = vectors - np.outer(vectors.dot(normal), normal)
    return _largest(across)


def _crosses(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """(k, 3) a × b, row by row."""
    return a[:, _NEXT] * b[:, _LAST] - a[:, _LAST] * b[:, _NEXT]


@cache
def _slope(count: int) -> np.ndarray:
    """(k, k) from values at even nodes in [0, 1] to the slopes of their polynomial there."""
    nodes = np.linspace(0.0, 1.0, count)
    powers = np.vander(nodes, increasing=True)
    slopes = np.zeros_like(powers)
    slopes[:, 1:] = powers[:, :-1] * np.arange(1, count)
    return slopes.dot(np.linalg.inv(powers))
