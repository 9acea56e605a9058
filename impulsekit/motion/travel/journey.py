"""A motion over steps and impacts in one compiled call, as long as all is known to compiled code.

Steps as ``advance`` makes them; where gaps close, ``meet`` deals with that. What
it can't answer, and points that stop or lift within a step, are left to ``run``: the step in
which that happens is as if nothing had been done about it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...laws.borrowed import borrowed, borrowing
from ...laws.compiled import compiled, entry
from ...laws.dense import put_rows
from ...rows.point_rows import gaps_and_rates
from ..events.look import Watched, write_dense
from ..steps.compiled import SOLVED, attempt, begin_steps
from ..steps.explicit import Tableau, inside
from ..steps.system import System, Work
from ..tree.bodies import look_at
from ..tree.coordinates import centre, write_configuration
from .advance import (
    CHANGED,
    GOES_ON,
    HAPPENS,
    Log,
    Track,
    advance,
    example_advance,
    note,
    too_deep,
)
from .meet import Hold, Place, Rules, meet
from .strike import Blow

__all__ = ["NEAR", "TRAVEL_EXACT", "Ledger", "Trip", "travel"]

# Of steps with errors below this [of what is allowed] dense output is as good as they are allowed
# to be: it is of seventh order, its errors are a hundred times those of a step at its limit. For
# a time within a step, as ``explicit.inside`` has it.
TRAVEL_EXACT = 1e-4
# A gap closes elsewhere than dense output says by no more than this part of the step.
NEAR = 1e-3


class Ledger(NamedTuple):
    """What has happened, and what rested.

    Attributes:
        counts: (2,) how many impacts are in it, and of how many events on end none took time.
        times: (i,) [s]. q: (i, nq). v, dv: (i, nv).
        part: (i, m) which gaps took part. soft: (i,) whether without restitution.
        numbers: (i, 4), points: (i, 3, 3m) and works: (i, 3, m), as ``Blow`` has them.
        mass: (nv, nv) room.
        resting: (k,) how many points rested in a step. gaps, since: (k, m) which, since when [s].
    """

    counts: np.ndarray
    times: np.ndarray
    q: np.ndarray
    v: np.ndarray
    dv: np.ndarray
    part: np.ndarray
    soft: np.ndarray
    numbers: np.ndarray
    points: np.ndarray
    works: np.ndarray
    mass: np.ndarray
    resting: np.ndarray
    gaps: np.ndarray
    since: np.ndarray


class Trip(NamedTuple):
    """All that ``travel`` works on.

    Attributes:
        watched: what is looked for.
        still: so many events on end without any time between them are left to ``run``.
        rtol, atol: tolerances of a step.
    """

    tableau: Tableau
    work: Work
    watched: Watched
    track: Track
    log: Log
    rules: Rules
    hold: Hold
    ledger: Ledger
    still: int
    rtol: float
    atol: float


def _examples() -> tuple:
    system, tableau, work, watched, track, log, *tolerances = example_advance()
    none, no, never, whole = np.zeros(0), np.zeros((0, 0)), np.zeros(0, np.bool_), np.zeros(0, int)
    rules = Rules(never, no, none, 0, False, 0.0)
    hold = Hold(whole, whole, none, no, none, no, whole)
    many, ever = np.zeros((0, 0, 0)), np.zeros((0, 0), np.bool_)
    ids = np.zeros((0, 0), int)
    ledger = Ledger(
        whole, none, no, no, no, ever, never, no, many, many, no, whole, ids, no
    )  # fmt: skip
    return system, Trip(tableau, work, watched, track, log, rules, hold, ledger, 1, *tolerances), 1


@entry(_examples, seconds=32.0)
def travel(system: System, trip: Trip, most: int) -> tuple[int, int, int, bool]:
    """Go on from the state of ``trip.track`` with so many impacts at most.

    Returns:
        As ``advance``; an impact ends the last of the steps that are told.
    """
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
        if steps > 0:
            ledger.counts[1] = 0
        if why == CHANGED and count < len(log.ends) and clock[0] < clock[2]:
            tries = _begin(system, trip, math.inf)
            if tries == 0:
                return why, count, made, stops
            made += tries
            continue
        full = ledger.counts[0] >= most or ledger.counts[1] >= trip.still
        if why != HAPPENS or stops or full or hold.many[0] + 2 * len(hold.base) > len(hold.over):
            return why, count, made, stops
        good, system, tries = _close(system, trip, count)
        made += tries
        if not good:
            return why, count, made, stops
        put_rows(system.sliding.ways, hold.ways)
        count += 1
        if count == len(log.ends):
            return GOES_ON, count, made, False


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


@compiled
def _close(system: System, trip: Trip, k: int) -> tuple[bool, System, int]:
    """What closes in the last step, which is made up to there, meets.

    Returns:
        Whether that is done; if not, all is as before. What moves then, and what it cost.
    """
    work, track, nv = trip.work, trip.track, len(trip.track.v)
    clock, log = track.clock, trip.log
    kept = work.after.copy(), work.slopes.copy(), clock.copy()
    length, time, good = log.lengths[k], clock[4], True
    work.before[:], work.powers[:] = log.before[k], log.powers[k]
    q, v, made = np.empty(len(track.q)), np.empty(nv), 0
    part = (time - clock[0]) / length
    if inside(clock[6], part) >= TRAVEL_EXACT and clock[0] < time < log.ends[k]:
        good, shorter, time = _nearer(system, trip, time)
        length = shorter if shorter > 0.0 else length
        made += len(work.slopes) - 1
    if good and clock[0] <= time < clock[2]:
        write_dense(work, (time - clock[0]) / length)
        write_configuration(system.tree, system.reference, work.trial[:nv], q)
        v[:] = work.trial[nv:]
        good, after, tries = _meet(system, trip, (time, q, v))
        made += tries
        if good:
            log.ends[k], log.lengths[k] = time, length
            # Room of a step that is not kept has its powers already.
            log.powers[k] = work.powers
            trip.ledger.counts[1] = trip.ledger.counts[1] + 1 if time == kept[2][0] else 0
            return True, after, made
    work.after[:], work.slopes[:], clock[:] = kept
    work.before[:] = log.before[k]
    system.reference[:] = log.references[k]
    return False, system, made


@compiled
def _nearer(system: System, trip: Trip, time: float) -> tuple[bool, float, float]:
    """The last step made once more up to where its dense output closes a gap.

    As ``Flight.closing``: whether that is known here, the length of the step, negative where the
    longer one is kept, and when the first of the gaps that were met closes in it [s].
    """
    work, clock, watched = trip.work, trip.track.clock, trip.watched
    length = time - clock[0]
    powers = work.powers.copy()
    state, error = attempt(system, trip.tableau, work, length, trip.rtol, trip.atol)
    if state == SOLVED and not error < 1.0:
        return False, length, time
    if state == SOLVED:
        nv, gap = len(trip.track.v), np.flatnonzero(watched.met)[0]
        write_dense(work, 1.0)
        write_configuration(system.tree, system.reference, work.trial[:nv], system.q)
        look_at(system.tree, system.room, system.q, work.trial[nv:])
        kinematics = system.room.kinematics
        found = gaps_and_rates(
            watched.rated, kinematics.places, kinematics.speeds, system.q, work.trial[nv:]
        )
        left, rate = found[0, gap] - trip.hold.base[gap], found[1, gap]
        if rate < 0.0 and abs(left) <= NEAR * -rate * length:
            return True, length, time - left / rate
    work.powers[:] = powers
    return True, -1.0, time


@compiled
def _meet(
    system: System, trip: Trip, at: tuple[float, np.ndarray, np.ndarray]
) -> tuple[bool, System, int]:
    """What is met at a time in a state; steps begin anew there. As ``_close``."""
    track, work, log, ledger = trip.track, trip.work, trip.log, trip.ledger
    (time, q, v), nv, i = at, len(track.v), trip.ledger.counts[0]
    hold, rest = _copied(trip.hold), log.rest.copy()
    ledger.times[i], ledger.q[i], ledger.v[i] = time, q, v
    blow = Blow(
        ledger.dv[i], ledger.numbers[i], ledger.points[i], ledger.works[i], ledger.mass
    )  # fmt: skip
    place = Place(time, q, v, work.driven[0])
    good, after, part, (soft, first) = meet(system, trip.watched, trip.rules, hold, place, blow)
    if not good:
        return False, system, 4
    look_at(system.tree, system.room, q, v)
    if too_deep(system, track, q, v):
        return False, system, 4
    centre(system.tree, q, system.reference, work.before[:nv])
    work.before[nv:] = v
    note(after, log)
    track.clock[0] = time
    tries = _begin(after, trip, first)
    if tries == 0:
        log.rest[:] = rest
        return False, system, 6
    ledger.part[i], ledger.soft[i] = part, soft
    ledger.counts[0] += 1
    track.q[:], track.v[:] = q, v
    _keep(hold, trip.hold)
    return True, after, 4 + tries


@compiled
def _copied(hold: Hold) -> Hold:
    """The same, to be changed."""
    return Hold(
        hold.number.copy(),
        hold.gaps.copy(),
        hold.since.copy(),
        hold.ways,
        hold.base.copy(),
        hold.over,
        hold.many.copy(),
    )


@compiled
def _keep(own: Hold, hold: Hold) -> None:
    """Write what rests from now on."""
    hold.number[:], hold.gaps[:], hold.since[:] = own.number, own.gaps, own.since
    hold.base[:], hold.many[:] = own.base, own.many
