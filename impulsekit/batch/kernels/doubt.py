"""Answers that have lost digits on the way from the law to Δv."""

from __future__ import annotations

from ..codes import AGAIN, RowStatus
from .jit import built_in
from .lanes import absolute, where_less
from .layout import JUMP
from .memory import load, same, store
from .rows import row_velocity

__all__ = ["doubted"]

# By how much rounding alone may set J Δv and W p apart, relative to the velocities: with
# contacts, which are redundant in fours, and with constraints alone.
DOUBT, DOUBT_HELD = 1e-13, 2e-14
_SOLVED = int(RowStatus.SOLVED)
_NOT_UNIQUE, _JAM = int(RowStatus.NOT_UNIQUE), int(RowStatus.PAINLEVE_JAM)


@built_in
def doubted(
    count, term_ints, term_floats, row_first, work, w_at, before_at, free_at, p_at, dv_at,
    term_at, spare_at, w, code, has_contacts, witness,
):  # fmt: skip
    """Leave states to the solver of single ones where Δv does not make the rows' velocities.

    The law was told W p; where light bodies are held, that has lost digits to J Δv.
    """
    doubt = DOUBT if has_contacts else DOUBT_HELD
    scale = same(0.0, witness)
    worst = same(0.0, witness)
    for r in range(count):
        before = load(work, (before_at + r) * w, witness)
        made = row_velocity(
            term_ints, term_floats, row_first[r], row_first[r + 1],
            JUMP, work, dv_at, term_at, witness,
        )  # fmt: skip
        told = load(work, (free_at + r) * w, witness) - before
        for s in range(count):
            share = load(work, (w_at + r * count + s) * w, witness)
            told = told + share * load(work, (p_at + s) * w, witness)
        left = absolute(made - told)
        worst = where_less(worst, left, left, worst)
        for speed in (absolute(before), absolute(made)):
            scale = where_less(scale, speed, speed, scale)
    store(work, spare_at * w, worst)
    store(work, (spare_at + 1) * w, scale)
    for lane in range(w):
        if work[spare_at * w + lane] > doubt * work[(spare_at + 1) * w + lane] and (
            code[lane] == _SOLVED or code[lane] == _NOT_UNIQUE or code[lane] == _JAM
        ):
            code[lane] = AGAIN
