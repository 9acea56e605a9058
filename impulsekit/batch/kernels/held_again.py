"""Bilateral rows once more, on what they lack of the velocities that they are brought to.

Where light bodies are held, or rows have nearly lost their rank, Δv is the small rest of large
shares, with their rounding. What its rows lack is known to all its own digits: the same rows
are eliminated once more from there, as single states do in ``impact.constrained``.
"""

from __future__ import annotations

from ...laws.status import Status
from ..codes import AGAIN
from .doubt import size_of_terms
from .jit import inlined
from .lanes import absolute, where_less
from .layout import JUMP
from .memory import load, same, store
from .rows import row_velocity

__all__ = ["begin_again", "end_again", "lacking_rows"]

# [relative] What a row may lack of its velocity, over the terms that this row alone is the sum
# of: single states refine above 2e-15, and the stress test takes up to 1e-14.
LACKS = 4e-15
_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)


@inlined
def lacking_rows(
    count, term_ints, term_floats, row_first, work, before_at, dv_at, term_at, spare_at, held,
    w, code, witness,
):  # fmt: skip
    """Whether a row lacks more than rounding in some lane.

    Args:
        held: velocities that the rows are brought to, and whether they keep their own.
    """
    target, keeps = held
    lacks = same(0.0, witness)
    for r in range(count):
        begin, end = row_first[r], row_first[r + 1]
        before = load(work, (before_at + r) * w, witness)
        made = row_velocity(term_ints, term_floats, begin, end, JUMP, work, dv_at, term_at, witness)
        size = size_of_terms(term_ints, term_floats, begin, end, work, dv_at, term_at, witness)
        wanted = before if keeps[r] else same(target[r], witness)
        lack = absolute(made + before - wanted)
        lack = lack - LACKS * (size + absolute(before) + absolute(wanted))
        lacks = where_less(lacks, lack, lack, lacks)
    store(work, spare_at * w, lacks)
    some = False
    for lane in range(w):
        solved = code[lane] == _SOLVED or code[lane] == _NOT_UNIQUE
        if solved and work[spare_at * w + lane] > 0.0:
            some = True
    return some


@inlined
def begin_again(
    count, term_ints, term_floats, row_first, work, before_at, free_at, p_at, dv_at, term_at,
    spare_at, w, code, witness,
):  # fmt: skip
    """Let the free velocities be those that Δv makes; what has been solved is to be once more.

    Codes, λ and the free velocities that were are kept behind two spare values.
    """
    for r in range(count):
        begin, end = row_first[r], row_first[r + 1]
        store(work, (spare_at + 3 + r) * w, load(work, (p_at + r) * w, witness))
        free = load(work, (free_at + r) * w, witness)
        store(work, (spare_at + 3 + count + r) * w, free)
        made = row_velocity(term_ints, term_floats, begin, end, JUMP, work, dv_at, term_at, witness)
        store(work, (free_at + r) * w, made + load(work, (before_at + r) * w, witness))
    for lane in range(w):
        work[(spare_at + 2) * w + lane] = code[lane]
        if code[lane] == _NOT_UNIQUE:
            code[lane] = _SOLVED


@inlined
def end_again(count, work, free_at, p_at, spare_at, w, code, witness):
    """Put back what was kept; what is to be added to λ stands where λ was kept."""
    for lane in range(w):
        before = int(work[(spare_at + 2) * w + lane])
        solved = before in (_SOLVED, _NOT_UNIQUE)
        again = code[lane] != _SOLVED and code[lane] != _NOT_UNIQUE
        code[lane] = AGAIN if solved and again else before
        if again or not solved:
            for r in range(count):
                work[(p_at + r) * w + lane] = 0.0
    for r in range(count):
        kept = (spare_at + 3 + r) * w
        more = load(work, (p_at + r) * w, witness)
        store(work, (p_at + r) * w, load(work, kept, witness))
        store(work, kept, more)
        free = load(work, (spare_at + 3 + count + r) * w, witness)
        store(work, (free_at + r) * w, free)
