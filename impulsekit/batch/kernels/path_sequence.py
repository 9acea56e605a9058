"""Contacts one after the other, each followed along the path of its slip."""

from __future__ import annotations

from ...laws.progress import FRICTION, NORMAL, P1, P2, P, path_memory
from ...laws.status import Status
from ..codes import AGAIN
from .jit import built_in
from .layout import CONTACT_INTS
from .path_law import strike_along
from .problem import pose, problem_in, put_back, room
from .sequential import MOST_HITS, begin, book, next_hit, sequel

__all__ = ["path_sequence_lanes"]

_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_JAM, _TOO_LONG = int(Status.PAINLEVE_JAM), int(Status.SEQUENCE_TOO_LONG)
_REFUSED = int(Status.REFUSED)


def path_sequence_lanes(
    base, rows, target, keeps, contact_ints, contact_floats, given, words, digits,
    work, w_at, before_at, free_at, p_at, w, code,
):  # fmt: skip
    """Write the impulses of all rows, and the codes, for the states of a block from ``base`` on.

    The arguments are those of ``problem.pose``.
    """
    space = room(rows, len(contact_ints) // CONTACT_INTS)
    memory = path_memory()
    for lane in range(w):
        count = pose(
            base + lane, lane, rows, target, keeps, contact_ints, contact_floats, given, digits,
            work, w_at, before_at, free_at, w, code, space,
        )  # fmt: skip
        if count > 0:
            code[lane] = _solved(count, words[0], digits, space, memory)
        put_back(lane, count, rows, len(target), contact_ints, work, p_at, w, code, space)


@built_in
def _solved(count, law, digits, space, memory):
    """The code, with P of the contacts that touch in ``space``."""
    W, _, _, mus, es, ets, _ = problem_in(space)
    now = memory.now
    velocity, first = begin(count, space)
    code = _SOLVED
    works, spent = 0.0, 0.0
    for hits in range(MOST_HITS):
        i = next_hit(hits, velocity, count, first, digits, space)
        if i < 0:
            return sequel(i, code, works, spent)
        k = 3 * i
        one = strike_along(W, k, velocity[k + 2], velocity, es[i], mus[i], ets[i], law, memory)
        if one == _REFUSED:
            return _REFUSED
        if one not in (_SOLVED, _GAIN, _JAM):
            return AGAIN
        # What one hit gains others may lose.
        if one == _JAM:
            code = _JAM
        p1, p2, pn = now[P1], now[P2], now[P]
        works += now[NORMAL] + now[FRICTION]
        spent += abs(now[NORMAL]) + abs(now[FRICTION])
        spent += abs(p1 * velocity[k]) + abs(p2 * velocity[k + 1]) + abs(pn * velocity[k + 2])
        book(i, p1, p2, pn, count, space)
    return _TOO_LONG
