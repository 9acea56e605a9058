"""Steps of a motion one after another in one compiled call, until something happens.

Each is made as ``steps.compiled`` makes it, looked at (``events.look``), and what rests is
settled (``rest.settle``), as ``run`` does it step by step. What is not plain sailing, such as
a point that lifts, is left to be done there: the last step is as if it had not been made.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Table
from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import entry
from ...laws.dense import put
from ...laws.words import NO
from ...rows.point_rows import gap_and_rate
from ..events.look import Watched, look_through
from ..rest.settle import settle
from ..rest.slowing import FURTHER, until_stopping
from ..steps.compiled import SOLVED, evaluate, try_step
from ..steps.explicit import LEAST, Tableau, length_after, shorter_length
from ..steps.system import TOLERANCES, System, Work
from ..tree.bodies import look_at
from ..tree.coordinates import centre, write_configuration, write_rate

__all__ = [
    "CHANGED", "GOES_ON", "HAPPENS", "LONGEST_TURN", "STUCK", "Log", "Track", "advance",
    "example_advance", "note", "too_deep", "until_closing",
]  # fmt: skip

# Why it came back: the log is full or the end reached, something happens in the last step, what
# rests has changed, or a step has to be made in another way.
GOES_ON, HAPPENS, CHANGED, STUCK = 0, 1, 2, 3
# A joint that turns goes no further than this in one step [rad].
LONGEST_TURN = 1.0
# Accelerations of gaps are those over this part of a step.
CLOSE_BY = 1e-4


class Track(NamedTuple):
    """Where a motion is, and how far it may go.

    Attributes:
        q, v: (nq,), (nv,) the state.
        clock: (7,) time, next length, latest end of a step, longest step, and of the last look
            the time at which a gap closes [s], infinity for none; length [s] and error of the
            last step, 0 without one.
        turning: (nv,) 1 for speeds of joints that turn without end.
        all_gaps: every gap. deepest: (m,) how deep each may be.
    """

    q: np.ndarray
    v: np.ndarray
    clock: np.ndarray
    turning: np.ndarray
    all_gaps: Table
    deepest: np.ndarray


class Log(NamedTuple):
    """The steps that were made, k at most.

    Attributes:
        starts, ends: (k,) [s]. lengths: (k,) of their dense output [s].
        references: (k, nq). before: (k, 2 nv). powers: (k, 7, 2 nv).
        slides: (k, m, 3) what the n points that rest did in the step, as ``Sliding.ways`` has it.
        rest: (3, 3m) forces, accelerations and velocities of what rests, after the last one.
    """

    starts: np.ndarray
    ends: np.ndarray
    lengths: np.ndarray
    references: np.ndarray
    before: np.ndarray
    powers: np.ndarray
    slides: np.ndarray
    rest: np.ndarray


def example_advance() -> tuple:
    """Arguments of ``advance``."""
    from ..events.look import example_look
    from ..steps.tables import NO_POINTS

    system, tableau, work, watched = example_look()
    none, no = np.zeros(0), np.zeros((0, 0))
    track = Track(none, none, none, none, NO_POINTS, none)
    more = np.zeros((0, 0, 0)), np.zeros((0, 0, 3)), no
    log = Log(none, none, none, no, no, *more)
    return system, tableau, work, watched, track, log, *TOLERANCES


@entry(example_advance, seconds=27.0, apart=True)
def advance(
    system: System,
    tableau: Tableau,
    work: Work,
    watched: Watched,
    track: Track,
    log: Log,
    rtol: float,
    atol: float,
) -> tuple[int, int, int, bool]:
    """Make steps from the state of ``track``, whose rates are the first slope of ``work``.

    Returns:
        Why it came back; how many steps are in ``log``; how often accelerations were worked out;
        and of ``HAPPENS`` whether a resting point may stop.
    """
    nv, clock, count, made = len(track.v), track.clock, 0, 0
    n, ways = len(system.table.whole), system.sliding.ways
    while count < len(log.ends) and clock[0] < clock[2]:
        log.before[count] = work.before
        log.references[count] = system.reference
        lengths = clock[1], clock[5], clock[6]
        soon = _until_closing(system, work, watched, clock[1])
        state, end, tries = _step(system, tableau, work, track, soon, rtol, atol)
        made += tries
        if state != SOLVED:
            clock[1], clock[5], clock[6] = lengths
            return STUCK, count, made, False
        clock[4], stops, bends = look_through(system, work, watched, clock[0], end - clock[0])
        if bends:
            clock[1], clock[5], clock[6] = lengths
            return STUCK, count, made, False
        log.starts[count], log.ends[count], log.lengths[count] = clock[0], end, end - clock[0]
        log.powers[count] = work.powers
        log.slides[count, :n] = ways
        if clock[4] < math.inf or stops:
            return HAPPENS, count, made, stops
        begin = clock[0]
        write_configuration(system.tree, system.reference, work.after[:nv], system.q)
        look_at(system.tree, system.room, system.q, work.after[nv:])
        q, v = system.q.copy(), work.after[nv:].copy()
        changed = False
        if n > 0:
            state, changed = settle(system, work.driven[0], q, v, NO, NO)
            made += 2
        if state != SOLVED or too_deep(system, track, q, v):
            ways[:] = log.slides[count, :n]
            clock[0], clock[1], clock[5], clock[6] = begin, *lengths
            return STUCK, count, made, False
        track.q[:] = q
        track.v[:] = v
        clock[0] = end
        count += 1
        centre(system.tree, q, system.reference, work.before[:nv])
        work.before[nv:] = v
        note(system, log)
        if changed:
            return CHANGED, count, made, False
        if n == 0:
            # The accelerations at the end of the step are those at the next one's start.
            work.slopes[0, nv:] = work.slopes[len(tableau.result), nv:]
            write_configuration(system.tree, system.reference, work.before[:nv], system.q)
            write_rate(system.tree, work.before[:nv], system.q, v, work.slopes[0, :nv])
            continue
        if evaluate(system, work.driven[0], work.before, work.slopes[0]) != SOLVED:
            return CHANGED, count, made, False
        note(system, log)
        made += 1
    return GOES_ON, count, made, False


@borrowing
def note(system: System, log: Log) -> None:
    """Keep what is known of the points that rest."""
    put(system.last, log.rest[0])
    put(system.accelerations, log.rest[1])
    put(system.slip, log.rest[2])


@borrowing
def _step(
    system: System,
    tableau: Tableau,
    work: Work,
    track: Track,
    soon: float,
    rtol: float,
    atol: float,
) -> tuple[int, float, int]:
    """One step, as ``ExplicitStepper.step`` makes it: what became of it, its end, its cost.

    ``soon``: how long it may be [s], which the next step knows nothing of.
    """
    clock, speed, made = track.clock, 0.0, 0
    for k in range(len(track.v)):
        speed = max(speed, track.turning[k] * abs(track.v[k]))
    longest = min(clock[3], LONGEST_TURN / speed) if speed > 0.0 else clock[3]
    t = clock[0]
    least = LEAST * (np.nextafter(t, math.inf) - t)
    length, rejected = max(min(clock[1], longest, soon), least), False
    allowed = clock[1] if soon < clock[1] else 0.0
    while True:
        if length < least:
            return -1, t, made
        end = min(t + length, clock[2])
        h = end - t
        length = h
        state, error = try_step(system, tableau, work, h, rtol, atol)
        made += len(work.slopes) - 1
        if state != SOLVED:
            return state, t, made
        if error < 1.0:
            clock[1] = length_after(length, error, rejected)
            if not rejected:
                clock[1] = max(clock[1], allowed)
            clock[5], clock[6] = length, error
            return SOLVED, end, made
        length = shorter_length(length, error)
        rejected = True


@entry(lambda: (*_example_closing(), 1.0), seconds=3.0)
def until_closing(system: System, work: Work, watched: Watched, length: float) -> float:
    """How long a step may be to end soon after a gap closes or slip stops [s], infinite for none.

    If accelerations stay as they are. Of the step ``work`` has the state and first slope.

    Args:
        length: that it would have [s].
    """
    return _until_closing(borrowed(system), borrowed(work), borrowed(watched), length)


def _example_closing() -> tuple:
    system, _, work, watched, *_ = example_advance()
    return system, work, watched


@borrowing
def _until_closing(system: System, work: Work, watched: Watched, length: float) -> float:
    """As ``until_closing``."""
    nv, base, soonest = len(system.load), watched.base, math.inf
    length *= CLOSE_BY
    kinematics, y = system.room.kinematics, work.trial
    for turn in range(2):
        for k in range(len(y)):
            y[k] = work.before[k] + turn * length * work.slopes[0, k]
        write_configuration(system.tree, system.reference, y[:nv], system.q)
        look_at(system.tree, system.room, system.q, y[nv:])
        for i in range(len(base)):
            if not base[i] < math.inf:
                continue
            gap, rate = gap_and_rate(
                watched.rated, i, kinematics.places, kinematics.speeds, system.q, y[nv:]
            )
            if turn == 0:
                watched.gaps[0, i], watched.gaps[1, i] = gap - base[i], rate
                continue
            gap, speed = watched.gaps[0, i], watched.gaps[1, i]
            soonest = min(soonest, _falls_in(gap, speed, (rate - speed) / length))
    # What closes within the window has closed with what did before.
    soonest *= 1.0 + FURTHER
    stopping = until_stopping(system.slip, system.accelerations, system.sliding.ways)
    return min(soonest if soonest > watched.window else math.inf, stopping)


@borrowing
def _falls_in(gap: float, speed: float, rate: float) -> float:
    """How soon a gap [m] that opens at a speed, which grows at a rate, falls below zero [s]."""
    square = speed * speed - 2.0 * rate * gap
    if not square > 0.0:
        return math.inf
    root = math.sqrt(square)
    if speed < 0.0:
        return max(0.0, 2.0 * gap / (root - speed))
    return (root + speed) / -rate if rate < 0.0 else math.inf


@borrowing
def too_deep(system: System, track: Track, q: np.ndarray, v: np.ndarray) -> bool:
    """Whether a gap is deeper than is credible; see ``Penetration``."""
    from_tree = system.room.kinematics
    # Placements at q are there: of the last look at it.
    for i in range(len(track.deepest)):
        gap, _ = gap_and_rate(track.all_gaps, i, from_tree.places, from_tree.speeds, q, v)
        if not gap >= track.deepest[i]:
            return True
    return False
