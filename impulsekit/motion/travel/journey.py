"""A motion over steps in one compiled call, as long as all is known to compiled code.

Steps as ``advance`` makes them. Where gaps close, or points stop or lift within a step, it is left
to ``run``: the step in which that happens is as if nothing had been done about it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import put_rows
from ..events.look import Watched
from ..steps.compiled import SOLVED, begin_steps
from ..steps.explicit import Tableau
from ..steps.system import System, Work
from .advance import CHANGED, Log, Track, advance, example_advance

__all__ = ["NEAR", "TRAVEL_EXACT", "Hold", "Ledger", "Trip", "travel"]

# Of steps with errors below this [of what is allowed] dense output is as good as they are allowed
# to be: it is of seventh order, its errors are a hundred times those of a step at its limit. For
# a time within a step, as ``explicit.inside`` has it.
TRAVEL_EXACT = 1e-4
# A gap closes elsewhere than dense output says by no more than this part of the step.
NEAR = 1e-3


class Hold(NamedTuple):
    """The points that rest, the first of (m,).

    Attributes:
        number: (1,) how many.
        gaps: (m,) which, in the order of their rows. since: (m,) when they came to rest [s].
        ways: (m, 3) what they do, as ``Sliding.ways`` has it; written.
        base: (m,) what counts as zero of each gap [m].
    """

    number: np.ndarray
    gaps: np.ndarray
    since: np.ndarray
    ways: np.ndarray
    base: np.ndarray


class Ledger(NamedTuple):
    """What rested in each step.

    Attributes:
        resting: (k,) how many points. gaps, since: (k, m) which, since when [s].
    """

    resting: np.ndarray
    gaps: np.ndarray
    since: np.ndarray


class Trip(NamedTuple):
    """All that ``travel`` works on.

    Attributes:
        watched: what is looked for.
        rtol, atol: tolerances of a step.
    """

    tableau: Tableau
    work: Work
    watched: Watched
    track: Track
    log: Log
    hold: Hold
    ledger: Ledger
    rtol: float
    atol: float


def _examples() -> tuple:
    system, tableau, work, watched, track, log, *tolerances = example_advance()
    none, no, whole = np.zeros(0), np.zeros((0, 0)), np.zeros(0, int)
    hold = Hold(whole, whole, none, no, none)
    ledger = Ledger(whole, np.zeros((0, 0), int), no)
    return system, Trip(tableau, work, watched, track, log, hold, ledger, *tolerances)


@entry(_examples, seconds=20.0)
def travel(system: System, trip: Trip) -> tuple[int, int, int, bool]:
    """Go on from the state of ``trip.track`` until something happens; as ``advance`` returns."""
    system, trip = borrowed(system), borrowed(trip)
    track, log, hold, ledger = trip.track, trip.log, trip.hold, trip.ledger
    clock, count, made = track.clock, 0, 0
    while True:
        n, room = hold.number[0], len(log.ends) - count
        _watch(trip.watched, hold)
        why, steps, tries, stops = advance(
            system,
            trip.tableau,
            trip.work,
            trip.watched,
            track,
            _from(log, count),
            trip.rtol,
            trip.atol,
        )
        made += tries
        put_rows(system.sliding.ways, hold.ways)
        for k in range(count, count + min(steps + 1, room)):
            ledger.resting[k] = n
            ledger.gaps[k, :n] = hold.gaps[:n]
            ledger.since[k, :n] = hold.since[:n]
        count += steps
        if why == CHANGED and count < len(log.ends) and clock[0] < clock[2]:
            tries = _begin(system, trip, math.inf)
            if tries == 0:
                return why, count, made, stops
            made += tries
            continue
        return why, count, made, stops


@compiled
def _from(log: Log, k: int) -> Log:
    """What is left of a log."""
    return Log(
        log.starts[k:],
        log.ends[k:],
        log.lengths[k:],
        log.references[k:],
        log.before[k:],
        log.powers[k:],
        log.slides[k:],
        log.rest,
    )


@borrowing
def _watch(watched: Watched, hold: Hold) -> None:
    """Look at the gaps of what does not rest."""
    for i in range(len(hold.base)):
        watched.base[i] = hold.base[i]
    for k in range(hold.number[0]):
        watched.base[hold.gaps[k]] = math.inf


@compiled
def _begin(system: System, trip: Trip, first: float) -> int:
    """Begin steps anew; how often accelerations were worked out, 0 where that can't be done here.

    They go on as long as they were about to be: what closes bounds them by itself. Without one
    before, the first is to be ``first`` long [s] if that is finite.
    """
    clock, work = trip.track.clock, trip.work
    span, last, known = clock[2] - clock[0], system.last.copy(), clock[5] > 0.0
    if not span > 0.0:
        return 0
    asked = 0.0 if known else span
    state, length = begin_steps(system, work, work.before, asked, trip.rtol, trip.atol)
    system.last[:] = last
    if state != SOLVED:
        return 0
    if not known:
        given = min(first, span) if first < math.inf else 0.0
        clock[1] = given if given > 0.0 else length
    clock[5], clock[6] = 0.0, 0.0
    return 1 if known else 2
