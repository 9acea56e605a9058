"""Whether anything may happen within a step, in one compiled call.

It asks what ``crossing.first_crossing`` and ``stops.first_stop`` ask first, at the same times:
whether the cubics between the nodes of a gap may come to zero, and whether slip turns, has grown
or a point lifts between nodes. Where it may, these find out when.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ..laws.compiled import compiled, entry
from .closing import MARGIN
from .compiled_chart import write_configuration
from .compiled_step import System, Work
from .points import Table, gaps_and_rates, write_rows
from .roots import PIECES
from .stops import LIFTED
from .tree import look_at, write_jacobian
from .windows import TURN

__all__ = ["Watched", "look"]


class Watched(NamedTuple):
    """What is looked for.

    Attributes:
        rated: the gaps that come with a rate.
        base: (m,) what counts as zero of each of them [m]; infinity of one that is not watched.
        turning: (k, nv) how fast bodies turn, by speed.
        ways: (n, 3) of resting points the direction of slip, and 1 for those that slip.
        begins: (n,) whether their slip has just begun. grown: slip that has grown [m/s].
    """

    rated: Table
    base: np.ndarray
    turning: np.ndarray
    ways: np.ndarray
    begins: np.ndarray
    grown: float


def _examples() -> tuple:
    from .compiled_model import NO_POINTS, example_step

    system, _, work, *_ = example_step()
    none = np.zeros((0, 3))
    watched = Watched(NO_POINTS, np.zeros(0), np.zeros((1, 6)), none, np.zeros(0, np.bool_), 0.0)
    return system, work, watched, 0.0, 1.0


@compiled
def _dense(work: Work, x: float) -> None:
    """Write y at a part of the step in ``trial``, as ``explicit.Output`` has it."""
    powers, y = work.powers, work.trial
    for k in range(len(y)):
        total = powers[6, k] * x
        factor = 1.0 - x
        for i in range(5, -1, -1):
            total = (total + powers[i, k]) * factor
            factor = 1.0 - factor
        y[k] = total + work.before[k]


@compiled
def _windows(system: System, work: Work, turning: np.ndarray, length: float) -> int:
    """How many windows a step is looked at in; see ``windows.Turning``."""
    nv = len(system.load)
    fastest = np.zeros(nv)
    for n in range(PIECES + 1):
        _dense(work, n / PIECES)
        for k in range(nv):
            fastest[k] = max(fastest[k], abs(work.trial[nv + k]))
    turned = 0.0
    for j in range(len(turning)):
        total = 0.0
        for k in range(nv):
            total += turning[j, k] * fastest[k]
        turned = max(turned, total)
    turned *= length
    return max(1, math.ceil(turned / TURN)) if turned < math.inf else 1


@compiled
def _may_close(values: np.ndarray, rates: np.ndarray, base: np.ndarray, piece: float) -> bool:
    """Whether a cubic between nodes may come to zero; see ``closing.may_close``."""
    for i in range(len(base)):
        if not base[i] < math.inf:
            continue
        for k in range(0, PIECES, 2):
            middle = 0.5 * (values[k, i] + values[k + 2, i])
            middle += 2.0 * piece / 8.0 * (rates[k, i] - rates[k + 2, i])
            error = 0.25 * abs(values[k + 1, i] - middle)
            for n in (k, k + 1):
                left, right = values[n, i] - base[i], values[n + 1, i] - base[i]
                one = left + piece / 3.0 * rates[n, i]
                two = right - piece / 3.0 * rates[n + 1, i]
                lowest, highest = min(left, one, two, right), max(left, one, two, right)
                # What is not a number is looked at as well.
                if not lowest > MARGIN * (highest - lowest) + error:
                    return True
    return False


@compiled
def _write_signs(system: System, watched: Watched, v: np.ndarray, signs: np.ndarray) -> None:
    """Write (n, 3): slip along its first direction, −lift, and how far slip is from grown."""
    n, nv = len(signs), len(v)
    if n == 0:
        return
    write_jacobian(system.tree, system.room)
    rows = np.empty((3 * n, nv))
    write_rows(system.table, system.room.kinematics, rows)
    for i in range(n):
        one, two, normal = 0.0, 0.0, 0.0
        for k in range(nv):
            one += rows[3 * i, k] * v[k]
            two += rows[3 * i + 1, k] * v[k]
            normal += rows[3 * i + 2, k] * v[k]
        way = watched.ways[i]
        signs[i, 0] = one * way[0] + two * way[1] if way[2] != 0.0 else math.inf
        signs[i, 1] = LIFTED - normal
        grown = watched.grown - math.sqrt(one * one + two * two)
        signs[i, 2] = grown if watched.begins[i] else math.inf


@entry(_examples, seconds=25.0)
def look(
    system: System, work: Work, watched: Watched, start: float, length: float
) -> tuple[bool, bool]:
    """Whether a gap may close in the step, and whether a resting point may stop or lift.

    Args:
        system, work: of the step, which was made.
        watched: what is looked for.
        start, length: of the step [s].
    """
    nv, n, m = len(system.load), len(system.table.whole), len(watched.base)
    values, rates = np.empty((PIECES + 1, m)), np.empty((PIECES + 1, m))
    signs, before = np.empty((n, 3)), np.empty((n, 3))
    closes, stops = False, False
    windows = _windows(system, work, watched.turning, length)
    for window in range(windows):
        for node in range(PIECES + 1):
            if window > 0 and node == 0:
                values[0], rates[0] = values[PIECES], rates[PIECES]
                continue
            _dense(work, (window + node / PIECES) / windows)
            y = work.trial
            write_configuration(system.tree, system.reference, y[:nv], system.q)
            v = y[nv:]
            look_at(system.tree, system.room, system.q, v)
            if m:
                kinematics = system.room.kinematics
                found = gaps_and_rates(
                    watched.rated, kinematics.places, kinematics.speeds, system.q, v
                )
                values[node], rates[node] = found[0], found[1]
            _write_signs(system, watched, v, signs)
            if window > 0 or node > 0:
                for i in range(n):
                    for k in range(3):
                        stops |= before[i, k] > 0.0 >= signs[i, k]
            before[:] = signs
        closes = closes or _may_close(values, rates, watched.base, length / windows / PIECES)
        if closes and (stops or n == 0):
            return closes, stops
    return closes, stops
