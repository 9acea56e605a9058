"""When a gap closes within a step, and whether a point that rests may stop, in one compiled call.

It asks what ``crossing.first_crossing`` and ``stops.first_stop`` ask, at the same times: when the
first gap comes to zero and which others close with it, and whether slip turns, has grown or a
point lifts between nodes; when that is ``first_stop`` finds out.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Table
from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import put, put_rows
from ...rows.point_rows import gap_and_rate, rounding_of, write_rows
from ..forces.laws import write_pushes
from ..rest.slip import write_signs
from ..steps.explicit import nested
from ..steps.system import System, Work
from ..tree.bodies import look_at, write_jacobian
from ..tree.coordinates import write_configuration
from ..zeros.closing import Node, error_of, lowest_of, zero_finder
from ..zeros.roots import PIECES
from ..zeros.windows import count_of_windows

__all__ = [
    "Watched",
    "count_windows",
    "example_look",
    "look",
    "look_through",
    "see_signs",
    "see_state",
    "write_dense",
]


class Watched(NamedTuple):
    """What is looked for.

    Attributes:
        rated: the gaps that come with a rate.
        base: (m,) what counts as zero of each of them [m]; infinity of one that is not watched.
        arms: (m,) the terms of which each is the sum, besides its place [m, rad].
        window: gaps that close this soon after the first close with it [s].
        met: (m,) written: whether a gap closes with the first.
        turning: (k, nv) how fast bodies turn, by speed.
        gaps: (2, m) room.
    """

    rated: Table
    base: np.ndarray
    arms: np.ndarray
    window: float
    met: np.ndarray
    turning: np.ndarray
    gaps: np.ndarray


class Made(NamedTuple):
    """A step that was made: what moved in it, what is looked for, its start and length [s]."""

    system: System
    work: Work
    watched: Watched
    start: float
    length: float


class Seen(NamedTuple):
    """What is seen of a step at the nodes of a window, and room.

    Attributes:
        times: (k,) [s]. values, rates: (k, m) of gaps. pushes: (k, d, 3) of springs.
        signs, before: (n, 3) of points that rest, at a node and the one before it.
        rows: (3n, nv), slip: (3n,) and fastest: (nv,) room.
    """

    times: np.ndarray
    values: np.ndarray
    rates: np.ndarray
    pushes: np.ndarray
    signs: np.ndarray
    before: np.ndarray
    rows: np.ndarray
    slip: np.ndarray
    fastest: np.ndarray


class Course(NamedTuple):
    """One of the gaps along a step."""

    step: Made
    gap: int


def example_look() -> tuple:
    """Arguments of ``look``, with those of a step."""
    from ..steps.tables import NO_POINTS, example_step

    system, tableau, work, *_ = example_step()
    none, no, never = np.zeros((2, 0)), np.zeros(0), np.zeros(0, np.bool_)
    watched = Watched(NO_POINTS, no, no, 0.0, never, np.zeros((1, 6)), none)
    return system, tableau, work, watched


def _examples() -> tuple:
    system, _, work, watched = example_look()
    return system, work, watched, 0.0, 1.0


@borrowing
def write_dense(work: Work, x: float) -> None:
    """Write y at a part of the step in ``trial``, as ``steps.explicit.Output`` has it."""
    powers, y = work.powers, work.trial
    for k in range(len(y)):
        a, b, c, d = powers[0, k], powers[1, k], powers[2, k], powers[3, k]
        y[k] = work.before[k] + nested(x, a, b, c, d, powers[4, k], powers[5, k], powers[6, k])


@compiled
def count_windows(system: System, work: Work, turning: np.ndarray, length: float) -> int:
    """How many windows a step is looked at in; see ``zeros.windows.Turning``."""
    return _count_windows(system, work, turning, length, np.zeros(len(system.load)))


@borrowing
def _count_windows(
    system: System, work: Work, turning: np.ndarray, length: float, fastest: np.ndarray
) -> int:
    """As ``count_windows``; ``fastest``: (nv,) zeros, written."""
    nv = len(fastest)
    for n in range(PIECES + 1):
        write_dense(work, n / PIECES)
        for k in range(nv):
            fastest[k] = max(fastest[k], abs(work.trial[nv + k]))
    turned = 0.0
    for j in range(len(turning)):
        total = 0.0
        for k in range(nv):
            total += turning[j, k] * fastest[k]
        turned = max(turned, total)
    return count_of_windows(turned * length)


@borrowing
def see_state(system: System, work: Work, part: float) -> None:
    """Leave the state at a part of the step in ``trial`` and ``system``."""
    write_dense(work, part)
    nv, y = len(system.load), work.trial
    write_configuration(system.tree, system.reference, y[:nv], system.q)
    look_at(system.tree, system.room, system.q, y[nv:])


@borrowing
def _gap(system: System, work: Work, watched: Watched, i: int) -> tuple[float, float]:
    """A gap and its rate, of the state that ``see_state`` left."""
    kinematics, v = system.room.kinematics, work.trial[len(system.load) :]
    return gap_and_rate(watched.rated, i, kinematics.places, kinematics.speeds, system.q, v)


@borrowing
def _node(course: Course, t: float) -> Node:
    """A gap at a time."""
    step, i = course.step, course.gap
    see_state(step.system, step.work, (t - step.start) / step.length)
    gap, rate = _gap(step.system, step.work, step.watched, i)
    return Node(t, gap - step.watched.base[i], rate)


_first_zero = zero_finder(_node)


@borrowing
def _rounding(system: System, watched: Watched, i: int, gap: float) -> float:
    """By how much a gap of this size is rounded [m, rad]."""
    return rounding_of(watched.rated, i, system.room.kinematics.places, watched.arms[i], gap)


@borrowing
def _may_bend(piece: float, pushes: np.ndarray) -> bool:
    """Whether a spring on one side may begin or cease to act; pushes at nodes (k, d, 3)."""
    for i in range(pushes.shape[1]):
        for k in range(PIECES):
            even = k - k % 2
            one, middle, two = pushes[even, i], pushes[even + 1, i], pushes[even + 2, i]
            error = error_of(2.0 * piece, one[0], middle[0], two[0], one[1], two[1])
            a, b = pushes[k, i], pushes[k + 1, i]
            # What is not a number is looked at as well.
            if not (lowest_of(piece, a[0], b[0], a[1], b[1], error) > 0.0 and b[2] > 0.0):
                return True
    return False


@borrowing
def _first_closing(
    step: Made, times: np.ndarray, values: np.ndarray, rates: np.ndarray
) -> tuple[float, int]:
    """The first closing between nodes, and which gap that is; see ``crossing``."""
    base, piece = step.watched.base, times[1] - times[0]
    best, found = math.inf, -1
    for k in range(PIECES):
        even = k - k % 2
        for i in range(len(base)):
            if not base[i] < math.inf:
                continue
            ends = values[even, i], values[even + 1, i], values[even + 2, i]
            first, last = rates[even, i], rates[even + 2, i]
            error = error_of(2.0 * piece, ends[0], ends[1], ends[2], first, last)
            a = Node(times[k], values[k, i] - base[i], rates[k, i])
            b = Node(times[k + 1], values[k + 1, i] - base[i], rates[k + 1, i])
            # What is not a number is looked at as well.
            if lowest_of(piece, a.gap, b.gap, a.rate, b.rate, error) > 0.0:
                continue
            size = max(abs(a.gap), abs(b.gap))
            rounding = _rounding(step.system, step.watched, i, size)
            t = _first_zero(Course(step, i), a, b, error, rounding)
            if t < best:
                best, found = t, i
        if found >= 0:
            break
    return best, found


@borrowing
def _note_met(step: Made, t: float, first: int) -> None:
    """Write which gaps close with the first."""
    watched = step.watched
    see_state(step.system, step.work, (t - step.start) / step.length)
    for i in range(len(watched.base)):
        gap, rate = _gap(step.system, step.work, watched, i)
        gap, speed = gap - watched.base[i], -rate
        near = watched.base[i] < math.inf and speed > 0.0 and gap <= speed * watched.window
        watched.met[i] = i == first or near


@compiled
def see_signs(system: System, v: np.ndarray, signs: np.ndarray) -> None:
    """Write (n, 3) the signs of points that rest, as ``slip.write_signs`` has them."""
    n = len(signs)
    _see_signs(system, v, np.empty((3 * n, len(v))), np.empty(3 * n), signs)


@borrowing
def _see_signs(
    system: System, v: np.ndarray, rows: np.ndarray, slip: np.ndarray, signs: np.ndarray
) -> None:
    """As ``see_signs``; ``rows``: (3n, nv) and ``slip``: (3n,) room."""
    n, nv = len(signs), len(v)
    if n == 0:
        return
    write_jacobian(system.tree, system.room)
    write_rows(system.table, system.room.kinematics, rows)
    for i in range(3 * n):
        slip[i] = 0.0
        for k in range(nv):
            slip[i] += rows[i, k] * v[k]
    write_signs(slip, system.sliding.ways, system.sliding.grown, signs)


@entry(_examples, seconds=9.0)
def look(
    system: System, work: Work, watched: Watched, start: float, length: float
) -> tuple[float, bool, bool]:
    """When a gap closes in the step [s], or infinity; whether a resting point may stop or lift.

    And whether a one-sided spring may begin or cease to act.

    Args:
        system, work: of the step, which was made.
        watched: what is looked for; which gaps close is written there.
        start, length: of the step [s].
    """
    return look_through(borrowed(system), borrowed(work), borrowed(watched), start, length)


@compiled
def look_through(
    system: System, work: Work, watched: Watched, start: float, length: float
) -> tuple[float, bool, bool]:
    """As ``look``."""
    nv, n, m = len(system.load), len(system.table.whole), len(watched.base)
    nodes = PIECES + 1
    seen = Seen(
        np.empty(nodes),
        np.empty((nodes, m)),
        np.empty((nodes, m)),
        np.empty((nodes, len(system.loads.kinks), 3)),
        np.empty((n, 3)),
        np.empty((n, 3)),
        np.empty((3 * n, nv)),
        np.empty(3 * n),
        np.zeros(nv),
    )
    return _look(Made(system, work, watched, start, length), seen)


@borrowing
def _look(step: Made, seen: Seen) -> tuple[float, bool, bool]:
    """As ``look``."""
    system, work, watched = step.system, step.work, step.watched
    nv, n, bends, stops = len(system.load), len(seen.signs), False, False
    times, values, rates, pushes = seen.times, seen.values, seen.rates, seen.pushes
    windows = _count_windows(system, work, watched.turning, step.length, seen.fastest)
    for window in range(windows):
        for node in range(PIECES + 1):
            part = (window + node / PIECES) / windows
            times[node] = step.start + part * step.length
            if window > 0 and node == 0:
                put(values[PIECES], values[0])
                put(rates[PIECES], rates[0])
                put_rows(pushes[PIECES], pushes[0])
                continue
            see_state(system, work, part)
            for i in range(len(watched.base)):
                values[node, i], rates[node, i] = _gap(system, work, watched, i)
            kinematics, v = system.room.kinematics, work.trial[nv:]
            write_pushes(system.loads, kinematics, system.q, v, pushes[node])
            _see_signs(system, v, seen.rows, seen.slip, seen.signs)
            if window > 0 or node > 0:
                for i in range(n):
                    for k in range(3):
                        stops |= seen.before[i, k] > 0.0 >= seen.signs[i, k]
            put_rows(seen.signs, seen.before)
        bends |= _may_bend(times[1] - times[0], pushes)
        t, gap = _first_closing(step, times, values, rates)
        if gap >= 0:
            _note_met(step, t, gap)
            return t, stops, bends
    return math.inf, stops, bends
