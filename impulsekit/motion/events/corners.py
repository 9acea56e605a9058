"""Whether points that are held on bodies with corners have stopped, lifted or left, compiled.

It tells what ``stops.first_stop`` looks for at a time within a step.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.held_points import held_gap, held_inside
from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import put
from ..gaps.pairs import NO_PAIRS, Held, Pairs, gap_of
from ..steps.system import System, Work
from ..zeros.closing import GAP, Node, root_finder
from .look import see_signs, see_state
from .stops import ELSEWHERE, LEFT

__all__ = ["crossings_of"]


class Course(NamedTuple):
    """The signs of a step, of which one is followed.

    Attributes:
        system, work: of the step. pairs, held: of the gaps, and of points that are held.
        start, length: of the step [s].
        which: (1,) which of (4n + 1,) signs; negative for all.
        lowest: of the last sign what counts as zero [m].
        signs: (n, 3) and found: (5n + 1,) room.
    """

    system: System
    work: Work
    pairs: Pairs
    held: Held
    start: float
    length: float
    which: np.ndarray
    lowest: np.ndarray
    signs: np.ndarray
    found: np.ndarray


@compiled
def _write(
    system: System,
    work: Work,
    pairs: Pairs,
    held: Held,
    part: float,
    signs: np.ndarray,
    found: np.ndarray,
    which: int,
) -> None:
    """Write (5n + 1,) what ``first_stop`` asks, at a part of a step.

    Of the n points that rest slip along its first direction, −lift, how far slip is from grown
    [m/s], how far they are from where their faces and edges end [m], and their gap [m], infinite
    where they are not held; last, by how much the smallest gap of a body is below that of its
    points or zero [m].

    Args:
        which: the only sign that is asked for: those of speeds leave out the places, which take
            most of the time; negative for all.
    """
    see_state(system, work, part)
    table, places, n = system.table, system.room.kinematics.places, len(signs)
    see_signs(system, work.trial[len(system.load) :], signs)
    for i in range(n):
        for k in range(3):
            found[k * n + i] = signs[i, k]
    if 0 <= which < 3 * n:
        return
    for i in range(n):
        found[3 * n + i] = held_inside(
            table, i, places, held.borders, held.spans[i, 0], held.spans[i, 1]
        )
        found[4 * n + i] = held_gap(table, i, places) if held.held[i] else math.inf
    if 0 <= which < 4 * n:
        return
    below = math.inf
    for k in range(len(held.pairs)):
        least = 0.0
        for i in range(held.pairs[k, 1], held.pairs[k, 2]):
            least = min(least, found[4 * n + i])
        below = min(below, gap_of(pairs, held.pairs[k, 0], places)[0] - least)
    found[5 * n] = below


@borrowing
def _see(course: Course, t: float) -> None:
    """See the step at a time [s], for the sign that is followed or all."""
    _write(
        course.system,
        course.work,
        course.pairs,
        course.held,
        (t - course.start) / course.length,
        course.signs,
        course.found,
        course.which[0],
    )


@borrowing
def _sign(course: Course, i: int) -> float:
    """One of (4n + 1,) signs of what ``_see`` wrote: below zero where that has happened."""
    n, found = len(course.signs), course.found
    if i < 3 * n:
        return found[i]
    return found[i] + LEFT if i < 4 * n else found[5 * n] - course.lowest[0]


@borrowing
def _node(course: Course, t: float) -> Node:
    """The sign that is followed; its rate is not known."""
    _see(course, t)
    return Node(t, _sign(course, course.which[0]), 0.0)


_root = root_finder(_node)


def _examples() -> tuple:
    from ..steps.tables import example_step

    system, _, work, *_ = example_step()
    ends = np.zeros((0, 6)), np.zeros((0, 2), np.int64), np.zeros((0, 3), np.int64)
    held = Held(*ends, np.zeros(0, np.bool_))
    return system, work, NO_PAIRS, held, 0.0, 1.0, np.zeros(2)


@entry(_examples, seconds=5.0)
def crossings_of(
    system: System,
    work: Work,
    pairs: Pairs,
    held: Held,
    start: float,
    length: float,
    times: np.ndarray,
) -> np.ndarray:
    """(k, 3) which signs fall to zero in which piece between times, and when [s].

    Signs as ``first_stop`` has them: 3n of speeds, n of places, and of the bodies' smallest gap.

    Args:
        start, length: of the step [s].
        times: ends of pieces, the first of which begins where the step does.
    """
    n, pieces = len(system.table.whole), len(times) - 1
    course = Course(
        borrowed(system), borrowed(work), borrowed(pairs), borrowed(held),
        start, length, np.zeros(1, np.int64), np.zeros(1), np.empty((n, 3)),
        np.empty(5 * len(system.table.whole) + 1),
    )  # fmt: skip
    crossed, count = np.empty((pieces * (4 * n + 1), 3)), 0
    before, after = np.empty(4 * n + 1), np.empty(4 * n + 1)
    course.which[0] = -1
    _see(course, times[0])
    course.lowest[0] = min(course.found[5 * n], 0.0) - ELSEWHERE
    for i in range(4 * n + 1):
        before[i] = _sign(course, i)
    for k in range(pieces):
        course.which[0] = -1
        _see(course, times[k + 1])
        for i in range(4 * n + 1):
            after[i] = _sign(course, i)
        for i in range(4 * n + 1):
            if math.inf > before[i] > 0.0 >= after[i]:
                course.which[0] = i
                crossed[count, 0], crossed[count, 1] = k, i
                crossed[count, 2] = _root(course, times[k], times[k + 1], GAP, 0.0)
                count += 1
        put(after, before)
    return crossed[:count].copy()
