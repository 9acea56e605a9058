"""An impact of points that close over planes, and what comes to rest after it, as compiled code.

What ``striking.on_the_way``, ``settling.come_to_rest`` and ``hops`` do, for points that come with
their rates. Where it is no plain matter nothing is changed, and it is left to them.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...geometry.point_table import Table
from ...laws.borrowed import borrowing
from ...laws.compiled import compiled
from ...laws.words import YES
from ...rows.point_rows import gaps_and_rates, rounding_of, write_bias, write_rows
from ..events.look import Watched
from ..rest.settle import settle_points
from ..steps.compiled import SOLVED, System, accelerations_at
from ..tree.bodies import look_at, write_jacobian
from ..tree.pressed import Sliding
from .strike import Blow, strike_alone, strike_together

__all__ = ["FAINT", "Hold", "Place", "Rules", "meet", "size_of_hop"]

# A share of the largest speed that counts as zero.
FAINT = 1e-12


class Rules(NamedTuple):
    """What is known of all gaps (m,), and how they meet.

    Attributes:
        plain: (m,) whether it is a point with numbers for coefficients.
        coefficients: (3, m) µ, e and tangential restitution of impacts.
        friction: (m,) µ at rest.
        restitution: the law's word. at_once: whether several meet at once.
        capture: slower approaches are met without restitution [m/s].
    """

    plain: np.ndarray
    coefficients: np.ndarray
    friction: np.ndarray
    restitution: int
    at_once: bool
    capture: float


class Hold(NamedTuple):
    """The points that rest, the first of (m,).

    Attributes:
        number: (1,) how many.
        gaps: (m,) which, in the order of their rows. since: (m,) when they came to rest [s].
        ways: (m, 3) what they do, as ``Sliding.ways`` has it; written.
        base: (m,) what counts as zero of each gap [m].
        over: (k, 3) gap, begin and end [s] of what rested before. many: (1,) how many.
    """

    number: np.ndarray
    gaps: np.ndarray
    since: np.ndarray
    ways: np.ndarray
    base: np.ndarray
    over: np.ndarray
    many: np.ndarray


class Place(NamedTuple):
    """Where points meet: the time [s], q and v, which are changed, and what is driven in time."""

    t: float
    q: np.ndarray
    v: np.ndarray
    driven: np.ndarray


@borrowing
def size_of_hop(speed: float, pull: float) -> tuple[float, float]:
    """How long [s] and how high [m] what opens at a speed hops, and is pulled back [m/s²]."""
    return 2.0 * speed / pull, 0.5 * speed * speed / pull


@compiled
def meet(
    system: System, watched: Watched, rules: Rules, hold: Hold, place: Place, blow: Blow
) -> tuple[bool, System, np.ndarray, tuple[bool, float]]:
    """What closes (``watched.met``) meets, with all that rests taking part.

    Returns:
        Whether that could be done here; if not, ``hold`` and ``place`` are of no use. What moves
        from then on; (m,) what took part; whether it was met without restitution, and how long the
        next hop lasts [s].
    """
    m = len(hold.base)
    look_at(system.tree, system.room, place.q, place.v)
    rates = _gaps(system, watched.rated, place)[1]
    approach, part = -math.inf, np.zeros(m, np.bool_)
    for i in range(m):
        if watched.met[i]:
            part[i] = True
            approach = max(approach, -rates[i])
    for k in range(hold.number[0]):
        part[hold.gaps[k]] = True
    soft = approach < rules.capture
    closing = np.flatnonzero(part)
    if not _strike(system, watched, rules, closing, soft, place, blow):
        return False, system, part, (soft, 0.0)
    place.v[:] += blow.dv
    low = np.zeros(m, np.bool_)
    good, system = _come_to_rest(system, watched, rules, hold, place, closing, low)
    if not good:
        return False, system, part, (soft, 0.0)
    good, again, first = _hops(system, watched, hold, place, part, low)
    if good and again:
        some = np.concatenate((hold.gaps[: hold.number[0]], np.flatnonzero(low)))
        good, system = _come_to_rest(system, watched, rules, hold, place, some, low)
        if good:
            low[:] = False
            good, _, first = _hops(system, watched, hold, place, part, low)
    return good, system, part, (soft, first)


@compiled
def _gaps(system: System, table: Table, place: Place) -> np.ndarray:
    """(2, m) gaps and rates, ``system`` with placements."""
    kinematics = system.room.kinematics
    return gaps_and_rates(table, kinematics.places, kinematics.speeds, place.q, place.v)


@compiled
def _chosen(table: Table, which: np.ndarray) -> Table:
    """Some rows of a table."""
    whole = np.empty((len(which), table.whole.shape[1]), np.int64)
    numbers = np.empty((len(which), table.numbers.shape[1]))
    for k in range(len(which)):
        whole[k] = table.whole[which[k]]
        numbers[k] = table.numbers[which[k]]
    return Table(whole, numbers)


@compiled
def _strike(
    system: System,
    watched: Watched,
    rules: Rules,
    closing: np.ndarray,
    soft: bool,
    place: Place,
    blow: Blow,
) -> bool:
    """Write what the impact does into ``blow``; whether it is known here."""
    for i in closing:
        if not rules.plain[i]:
            return False
    table, q, v, word = _chosen(watched.rated, closing), place.q, place.v, rules.restitution
    coefficients = np.empty((3, len(closing)))
    for k in range(len(closing)):
        for row in range(3):
            coefficients[row, k] = rules.coefficients[row, closing[k]]
        if soft:
            coefficients[1, k] = 0.0
    if len(closing) == 1:
        own = coefficients[1, 0], coefficients[0, 0], coefficients[2, 0]
        return strike_alone(system, table, q, v, own, word, blow)
    return rules.at_once and strike_together(system, table, q, v, coefficients, word, blow)


@compiled
def _come_to_rest(
    system: System,
    watched: Watched,
    rules: Rules,
    hold: Hold,
    place: Place,
    candidates: np.ndarray,
    low: np.ndarray,
) -> tuple[bool, System]:
    """What of the candidates stays, and how; whether that is known, and what moves then.

    ``low``: (m,) those that stay however fast they open.
    """
    look_at(system.tree, system.room, place.q, place.v)
    gaps, rates = _gaps(system, watched.rated, place)
    fastest = 0.0
    for k in range(len(place.v)):
        fastest = max(fastest, abs(place.v[k]))
    slow = max(rules.capture, FAINT * fastest)
    since = np.full(len(hold.base), place.t)
    before, count = hold.number[0], 0
    for k in range(before):
        since[hold.gaps[k]] = hold.since[k]
    stays = np.zeros(len(hold.base), np.bool_)
    for i in candidates:
        stays[i] = low[i] or rates[i] <= slow
    for k in range(before):
        if not stays[hold.gaps[k]]:
            row = hold.over[hold.many[0]]
            row[0], row[1], row[2] = hold.gaps[k], hold.since[k], place.t
            hold.many[0] += 1
    for i in candidates:
        if stays[i]:
            hold.gaps[count], hold.since[count] = i, since[i]
            count += 1
    hold.number[0] = count
    for i in range(len(hold.base)):
        hold.base[i] = min(gaps[i], 0.0)
    system = _resting_on(system, watched.rated, rules, hold)
    if count == 0:
        return True, system
    state, _ = settle_points(system, place.driven, place.q, place.v, YES, YES)
    return state == SOLVED, system


@compiled
def _resting_on(system: System, table: Table, rules: Rules, hold: Hold) -> System:
    """What moves where other points rest than before."""
    n = hold.number[0]
    which = hold.gaps[:n]
    friction = np.empty(n)
    for k in range(n):
        friction[k] = rules.friction[which[k]]
    last, rates, slip = system.last, system.accelerations, system.slip
    if len(last) != 3 * n:
        last, rates, slip = np.zeros(3 * n), np.zeros(3 * n), np.zeros(3 * n)
    sliding = system.sliding
    sliding = Sliding(friction, np.zeros((n, 3)), sliding.slow, sliding.grown, sliding.negligible)
    return System(
        system.tree,
        system.room,
        system.loads,
        _chosen(table, which),
        sliding,
        system.reference,
        system.q,
        system.load,
        last,
        rates,
        slip,
    )


@compiled
def _hops(
    system: System,
    watched: Watched,
    hold: Hold,
    place: Place,
    part: np.ndarray,
    low: np.ndarray,
) -> tuple[bool, bool, float]:
    """How what took part and does not rest is about to hop; see ``hops``.

    Returns:
        Whether that is known; whether hops too low to be told from rest were written to ``low``
        (m,), and how long the shortest lasts [s].
    """
    rises = part.copy()
    for k in range(hold.number[0]):
        rises[hold.gaps[k]] = False
    if not rises.any():
        return True, False, math.inf
    q, v, kinematics = place.q, place.v, system.room.kinematics
    rate = np.empty(len(v))
    system.q[:] = q
    if accelerations_at(system, place.driven, v, rate) != SOLVED:
        return False, False, math.inf
    gaps = _gaps(system, watched.rated, place)[0]
    write_jacobian(system.tree, system.room)
    which, again, first = np.flatnonzero(rises), False, math.inf
    table = _chosen(watched.rated, which)
    rows, bias = np.empty((3 * len(which), len(v))), np.empty(3 * len(which))
    write_rows(table, kinematics, rows)
    write_bias(table, kinematics, bias)
    for k in range(len(which)):
        speed, pull, i = 0.0, -bias[3 * k + 2], which[k]
        for j in range(len(v)):
            speed += rows[3 * k + 2, j] * v[j]
            pull -= rows[3 * k + 2, j] * rate[j]
        if not pull > 0.0 or not speed > 0.0:
            continue
        duration, height = size_of_hop(speed, pull)
        first = min(first, duration)
        rounding = rounding_of(watched.rated, i, kinematics.places, watched.arms[i], abs(gaps[i]))
        if height <= rounding or duration <= watched.window:
            low[i] = True
            again = True
    return True, again, first
