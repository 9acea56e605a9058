"""Bilateral rows once more, on what they lack of the velocities that they are brought to.

Where light bodies are held, or rows have nearly lost their rank, Δv is the small rest of large
shares, with their rounding. What its rows lack is known to all its own digits: the same rows
are eliminated once more from there, as single states do in ``impact.constrained``.
"""

from __future__ import annotations

from ...laws.status import Status
from ...laws.tolerances import ROUNDING
from ..codes import AGAIN
from .doubt import jump_of_row, size_of_terms
from .jit import inlined
from .lanes import absolute, where_less, width
from .memory import load, same, store

__all__ = ["begin_again", "end_again", "lacking_rows"]

# [relative] What a row may lack of its velocity, over the terms that this row alone is the sum
# of: twice what single states refine above, and the stress test takes up to 1e-14.
LACKS = 2.0 * ROUNDING
_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)


@inlined
def lacking_rows(rows, held, places, work, code, witness):
    """Whether a row lacks more than rounding in some lane."""
    w = width(witness)
    target, keeps = held
    lacks = same(0.0, witness)
    for r in range(len(rows.first) - 1):
        before = load(work, (places.before + r) * w, witness)
        made = jump_of_row(rows, r, places, work, witness)
        size = size_of_terms(rows, r, places, work, witness)
        wanted = before if keeps[r] else same(target[r], witness)
        lack = absolute(made + before - wanted)
        lack = lack - LACKS * (size + absolute(before) + absolute(wanted))
        lacks = where_less(lacks, lack, lack, lacks)
    store(work, places.spare * w, lacks)
    some = False
    for lane in range(w):
        solved = code[lane] == _SOLVED or code[lane] == _NOT_UNIQUE
        if solved and work[places.spare * w + lane] > 0.0:
            some = True
    return some


@inlined
def begin_again(rows, places, work, code, witness):
    """Let the free velocities be those that Δv makes; what has been solved is to be once more.

    Codes, λ and the free velocities that were are kept behind two spare values.
    """
    w = width(witness)
    count = len(rows.first) - 1
    kept_at = places.spare + 3
    for r in range(count):
        store(work, (kept_at + r) * w, load(work, (places.p + r) * w, witness))
        free = load(work, (places.free + r) * w, witness)
        store(work, (kept_at + count + r) * w, free)
        made = jump_of_row(rows, r, places, work, witness)
        made = made + load(work, (places.before + r) * w, witness)
        store(work, (places.free + r) * w, made)
    for lane in range(w):
        work[(places.spare + 2) * w + lane] = code[lane]
        if code[lane] == _NOT_UNIQUE:
            code[lane] = _SOLVED


@inlined
def end_again(rows, places, work, code, witness):
    """Put back what was kept; what is to be added to λ stands where λ was kept."""
    w = width(witness)
    count = len(rows.first) - 1
    for lane in range(w):
        before = int(work[(places.spare + 2) * w + lane])
        solved = before in (_SOLVED, _NOT_UNIQUE)
        again = code[lane] != _SOLVED and code[lane] != _NOT_UNIQUE
        code[lane] = AGAIN if solved and again else before
        if again or not solved:
            for r in range(count):
                work[(places.p + r) * w + lane] = 0.0
    for r in range(count):
        kept = (places.spare + 3 + r) * w
        more = load(work, (places.p + r) * w, witness)
        store(work, (places.p + r) * w, load(work, kept, witness))
        store(work, kept, more)
        free = load(work, (places.spare + 3 + count + r) * w, witness)
        store(work, (places.free + r) * w, free)
