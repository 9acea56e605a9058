"""Contacts one after the other: the fastest approach first, until none approaches."""

from __future__ import annotations

import numpy as np

from ...laws.approach import block_at
from ...laws.order import pace_of
from ...laws.progress import path_memory
from ...laws.sequence import (
    COUNT,
    FIRST,
    GOES_ON,
    LAST,
    LONG,
    REFUSED,
    TIED,
    WORST,
    Contacts,
    advance_sequence,
    sequence_of,
)
from ...laws.status import Status
from ...laws.tolerances import RESIDUAL_LIMIT
from ...laws.words import END
from ..codes import AGAIN
from .jit import built_in
from .left import is_close_call
from .problem import problem_in

__all__ = ["memory", "solved"]

# In single precision approaches this even, against themselves and against the first velocities,
# may come in either order. Below SLOW the order is of no matter.
EVEN, EVEN_AT_FIRST, SLOW = 1e-4, 1e-6, 2e-13
# Hits shrink where they have come down to this share of the first.
SHRUNK = 0.5
# What ``solve`` has nothing to add to.
_FINAL = (
    int(Status.SOLVED), int(Status.NOT_UNIQUE), int(Status.PAINLEVE_JAM), int(Status.ENERGY_GAIN),
    int(Status.SEQUENCE_TOO_LONG),
)  # fmt: skip
_SOLVED, _REFUSED = int(Status.SOLVED), int(Status.REFUSED)


@built_in
def memory(contacts):
    """The sequence, who is hit, by what, and the path of one hit."""
    return sequence_of(contacts), np.empty(LONG, np.int64), np.empty((LONG, 3)), path_memory()


@built_in
def solved(count, posed, digits, space, memory):
    """The code, with P of the contacts that touch in ``space``."""
    words = posed.words
    W, before, free, mus, es, ets, P = problem_in(space)
    sequence, who, hits, path = memory
    contacts = Contacts(
        W, free[: 3 * count], es[:count], mus[:count], ets[:count], words[0], words[1]
    )
    now = sequence.now
    now[COUNT] = 0.0
    step, code = GOES_ON, AGAIN
    if digits == 53:
        until = LONG
        step, code = advance_sequence(
            sequence, contacts, before[: 3 * count], until, who, hits, path
        )
        # What has shrunk may have a limit, which is for ``solve``.
        while step == GOES_ON and now[LAST] > SHRUNK * now[FIRST]:
            until += LONG
            step, code = advance_sequence(
                sequence, contacts, before[: 3 * count], until, who, hits, path
            )
    else:
        for until in range(1, LONG):
            step, code = advance_sequence(
                sequence, contacts, before[: 3 * count], until, who, hits, path
            )
            if step != GOES_ON:
                break
            if _is_even(contacts, sequence, count) or _is_close(contacts, who, hits, digits):
                return AGAIN
    if step == REFUSED:
        return _REFUSED
    if step == GOES_ON or now[TIED] > 0.0 or now[WORST] > RESIDUAL_LIMIT or code not in _FINAL:
        return AGAIN
    for k in range(3 * count):
        P[k] = sequence.impulse[k]
    return code


@built_in
def _is_even(contacts, sequence, count):
    """Whether digits would decide which contact is hit next."""
    W, velocity, first = contacts.W, sequence.velocity, sequence.now[FIRST]
    most, second = 0.0, 0.0
    for i in range(count):
        n = 3 * i + 2
        if velocity[n] < 0.0 and W[n, n] > 0.0:
            pace = pace_of(velocity[n], W[n, n])
            if pace > most:
                most, second = pace, most
            else:
                second = max(second, pace)
    return most > SLOW * first and second > most - EVEN * most - EVEN_AT_FIRST * first


@built_in
def _is_close(contacts, who, hits, digits):
    """Whether the last hit is to be found anew with more digits."""
    if contacts.slip != END:
        return False
    block = block_at(contacts.W, 3 * who[0])
    impulse = (hits[0, 0], hits[0, 1], hits[0, 2])
    return is_close_call(block, contacts.mu[who[0]], impulse, _SOLVED, digits)
