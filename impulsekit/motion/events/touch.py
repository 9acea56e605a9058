"""When bodies with corners first touch within a step, all pairs in one compiled call.

It asks what ``crossing.first_crossing`` asks of colliding bodies, at the same times.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Kinematics, three, turned
from ...geometry.support import Shape
from ...laws.borrowed import borrowed
from ...laws.compiled import compiled, entry
from ..gaps.advancing import BodyMotion, bound_of, may_meet, touch_finder
from ..gaps.pairs import NO_PAIRS, Pairs, gap_of, shape_of
from ..gaps.turning_planes import Bound, Pose
from ..steps.system import System, Work
from ..zeros.roots import PIECES
from .look import count_windows, see_state

__all__ = ["TOUCH", "touch_pairs"]

# Colliding bodies this near touch [m], where their gap is told to rounding.
TOUCH = 1e-12


class Flown(NamedTuple):
    """A step that was made: what moved in it, its start and length [s], and the pairs watched."""

    system: System
    work: Work
    start: float
    length: float
    pairs: Pairs


class Approach(NamedTuple):
    """One of the pairs along a step."""

    step: Flown
    pair: int


class Poses(NamedTuple):
    """Of all joints at the nodes of a window: see ``BodyMotion``, with a first axis for joints."""

    turn: np.ndarray
    at: np.ndarray
    linear: np.ndarray
    angular: np.ndarray


@compiled
def _pose(kinematics: Kinematics, j: int) -> Pose:
    """A joint's frame, in the world."""
    places, turn = kinematics.places, np.empty((3, 3))
    for i in range(3):
        for k in range(3):
            turn[i, k] = places[j, 3 * k + i]
    at = np.array(three(places[j], 9))
    linear = np.array(turned(places, j, three(kinematics.speeds[j], 0)))
    return Pose(turn, at, linear, np.array(turned(places, j, three(kinematics.speeds[j], 3))))


@compiled
def _see_pair(approach: Approach, t: float) -> tuple[float, np.ndarray, Pose, Pose]:
    """A pair at a time: its gap, the normal, and both bodies."""
    step, whole = approach.step, approach.step.pairs.whole[approach.pair]
    see_state(step.system, step.work, (t - step.start) / step.length)
    kinematics = step.system.room.kinematics
    gap, normal = gap_of(step.pairs, approach.pair, kinematics.places)
    return gap, normal, _pose(kinematics, whole[1]), _pose(kinematics, whole[2])


_find_touch = touch_finder(_see_pair)


def _examples() -> tuple:
    from .look import example_look

    system, _, work, watched = example_look()
    none = np.zeros(0)
    more = np.zeros((PIECES + 1, PIECES + 1)), none, 0.0, 1.0, 1.0, none
    return system, work, NO_PAIRS, watched.turning, *more


def _examples_of_pair() -> tuple:
    system, work, pairs, *_ = _examples()
    none, rows = np.zeros(0), np.zeros((0, 3))
    shape = Shape(none, rows, none, none, rows, none, 0.0, 0.0, 0.0)
    both = np.zeros((2, 0, 3))
    bound = Bound(shape, shape, rows, both, both, none, 0.0, 0.0)
    return Approach(Flown(system, work, 0.0, 1.0, pairs), 0), bound, 0.0, 1.0, 0.0


@entry(_examples_of_pair, seconds=12.0, apart=True)
def first_touch_of(
    approach: Approach, bound: Bound, start: float, end: float, base: float
) -> float:
    """When a pair first touches between two times; see ``touch_finder``."""
    return _find_touch(borrowed(approach), borrowed(bound), start, end, base, TOUCH, True)


@compiled
def _motion(poses: Poses, j: int, times: np.ndarray, slope: np.ndarray) -> BodyMotion:
    return BodyMotion(times, poses.turn[j], poses.at[j], poses.linear[j], poses.angular[j], slope)


@compiled
def _first_in_window(
    step: Flown,
    poses: Poses,
    times: np.ndarray,
    slope: np.ndarray,
    until: float,
    base: np.ndarray,
    speeds: np.ndarray,
) -> tuple[float, int]:
    """The first touch in a window, and the gap; as ``touch_pairs``."""
    pairs, first, found = step.pairs, math.inf, -1
    start, end = times[0], min(times[-1], until)
    speeds[:] = 0.0
    for i in range(len(pairs.whole)):
        gap, j, k = pairs.whole[i, 0], pairs.whole[i, 1], pairs.whole[i, 2]
        if not base[gap] < math.inf:
            continue
        one, two = shape_of(pairs, pairs.whole[i, 3]), shape_of(pairs, pairs.whole[i, 4])
        here, there = _motion(poses, j, times, slope), _motion(poses, k, times, slope)
        meets, speed = may_meet(one, two, here, there)
        speeds[gap] = max(speeds[gap], speed)
        if meets:
            bound, last = bound_of(one, two, here, there), min(end, first)
            t = first_touch_of(Approach(step, i), bound, start, last, base[gap])
            if t < first:
                first, found = t, gap
    return first, found


@entry(_examples, seconds=21.0)
def touch_pairs(
    system: System,
    work: Work,
    pairs: Pairs,
    turning: np.ndarray,
    slope: np.ndarray,
    base: np.ndarray,
    start: float,
    length: float,
    until: float,
    speeds: np.ndarray,
) -> tuple[float, int]:
    """When the first pair touches in a step [s], and the number of its gap; infinity and -1.

    Args:
        system, work: of the step, which was made. pairs: of bodies with corners.
        turning: (k, nv) how fast bodies turn, by speed.
        slope: of nodes in [0, 1], as ``slope_of`` has it.
        base: (m,) by gap, what counts as zero of it [m]; infinity of one that is not watched.
        start, length: of the step [s]. until: nothing is looked for after it [s].
        speeds: (m,) written: by gap, the largest closing speed in the window of the touch [m/s].
    """
    step = borrowed(Flown(system, work, start, length, pairs))
    windows = count_windows(step.system, step.work, turning, length)
    count, kinematics = len(step.system.room.kinematics.places), step.system.room.kinematics
    times, n = np.empty(PIECES + 1), PIECES + 1
    poses = Poses(
        np.empty((count, 3 * n, 3)),
        np.empty((count, n, 3)),
        np.empty((count, n, 3)),
        np.empty((count, n, 3)),
    )
    slopes = slope / (length / windows)
    for window in range(windows):
        for node in range(n):
            part = (window + node / PIECES) / windows
            times[node] = start + part * length
            see_state(step.system, step.work, part)
            for j in range(count):
                pose = _pose(kinematics, j)
                poses.turn[j, 3 * node : 3 * node + 3] = pose.turn
                poses.at[j, node] = pose.at
                poses.linear[j, node] = pose.linear
                poses.angular[j, node] = pose.angular
        t, gap = _first_in_window(step, poses, times, slopes, until, base, speeds)
        if gap >= 0 or times[n - 1] >= until:
            return t, gap
    return math.inf, -1
