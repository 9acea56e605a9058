"""Whether points that are held on bodies with corners have stopped, lifted or left, compiled.

It tells what ``stops.first_stop`` looks for at a time within a step.
"""

from __future__ import annotations

import math

import numpy as np

from ..geometry.features import inside_of
from ..geometry.vectors import along, dot
from ..laws.borrowed import borrowed
from ..laws.compiled import compiled, entry
from .compiled_look import Watched, see_state, write_signs
from .compiled_step import System, Work
from .pairs import NO_PAIRS, Held, Pairs, gap_of
from .points import CROSSING, Table, axis, back, crossing, origin, point_of, three, turned

__all__ = ["signs_at"]


@compiled
def _held_gap(table: Table, i: int, places: np.ndarray) -> float:
    """The gap of a corner on a face or of two edges [m]."""
    if table.whole[i, 0] == CROSSING:
        _, _, way, square, here, there, _, _ = crossing(table, i, places)
        return dot(way, along(here, -1.0, there)) / math.sqrt(square)
    two, numbers = table.whole[i, 2], table.numbers[i]
    ground = along(origin(places, two), 1.0, turned(places, two, three(numbers, 12)))
    over = along(point_of(table, i, places), -1.0, ground)
    return numbers[15] * dot(axis(table, i, 2, places), over)


@compiled
def _inside(table: Table, held: Held, i: int, places: np.ndarray) -> float:
    """How far a point is from where its face or edge ends [m]; infinite where it isn't held."""
    numbers = table.numbers[i]
    if table.whole[i, 0] == CROSSING:
        _, _, _, square, _, _, s, u = crossing(table, i, places)
        if square < numbers[15] ** 2:
            return -math.inf
        return min(min(s, numbers[12] - s), min(u, numbers[13] - u))
    two = table.whole[i, 2]
    at = back(places, two, along(point_of(table, i, places), -1.0, origin(places, two)))
    return inside_of(held.borders, held.spans[i, 0], held.spans[i, 1], at)


def _examples() -> tuple:
    from .compiled_look import example_look

    system, _, work, watched = example_look()
    held = Held(np.zeros((0, 6)), np.zeros((0, 2), np.int64), np.zeros((0, 3), np.int64))
    return system, work, watched, NO_PAIRS, held, 0.5


@entry(_examples, seconds=8.0)
def signs_at(
    system: System, work: Work, watched: Watched, pairs: Pairs, held: Held, part: float
) -> np.ndarray:
    """(5n + 1,) what ``first_stop`` asks, at a part of a step.

    Of the n points that rest slip along its first direction, −lift, how far slip is from grown
    [m/s], how far they are from where their faces and edges end [m], and their gap [m], infinite
    where they are not held; last, by how much the smallest gap of a body is below that of its
    points or zero [m].
    """
    found, signs = np.empty(5 * len(system.table.whole) + 1), np.empty((len(watched.ways), 3))
    _write(
        borrowed(system), borrowed(work), borrowed(watched), borrowed(pairs), borrowed(held),
        part, borrowed(signs), borrowed(found),
    )  # fmt: skip
    return found


@compiled
def _write(
    system: System,
    work: Work,
    watched: Watched,
    pairs: Pairs,
    held: Held,
    part: float,
    signs: np.ndarray,
    found: np.ndarray,
) -> None:
    see_state(system, work, part)
    table, places, n = system.table, system.room.kinematics.places, len(signs)
    write_signs(system, watched, work.trial[len(system.load) :], signs)
    for i in range(n):
        for k in range(3):
            found[k * n + i] = signs[i, k]
        found[3 * n + i] = _inside(table, held, i, places)
        is_held = table.whole[i, 0] == CROSSING or held.spans[i, 1] > held.spans[i, 0]
        found[4 * n + i] = _held_gap(table, i, places) if is_held else math.inf
    below = math.inf
    for k in range(len(held.pairs)):
        least = 0.0
        for i in range(held.pairs[k, 1], held.pairs[k, 2]):
            least = min(least, found[4 * n + i])
        below = min(below, gap_of(pairs, held.pairs[k, 0], places)[0] - least)
    found[5 * n] = below
