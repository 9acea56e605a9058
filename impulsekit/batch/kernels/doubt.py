"""Answers that have lost digits on the way from the law to Δv."""

from __future__ import annotations

from ...laws.status import Status
from ...laws.tolerances import GAIN
from ..codes import AGAIN, OPEN
from .algebra import triple
from .jit import inlined
from .lanes import absolute, where_less, width
from .layout import ALONG_DOF, BODY, COUPLE, JUMP, TERM, TERM_FLOATS, TERM_INTS
from .memory import load, same, store
from .rows import row_velocity

__all__ = ["doubted", "jump_of_row", "size_of_terms"]

# By how much rounding alone may set J Δv and W p apart, relative to the velocities before and
# to the terms that J Δv is the sum of: with contacts, which are redundant in fours, and with
# constraints alone.
DOUBT, DOUBT_HELD = 1e-13, 2e-14
_SOLVED = int(Status.SOLVED)
_NOT_UNIQUE, _JAM = int(Status.NOT_UNIQUE), int(Status.PAINLEVE_JAM)


@inlined
def doubted(rows, held, aims, places, work, code, witness):
    """Leave states to the solver of single ones where Δv does not make the rows' velocities.

    The law was told W p; where light bodies are held, that has lost digits to J Δv.

    Args:
        aims: 0 where there are constraints alone, 1 with contacts, 2 where these aim at
            velocities of before the bilateral rows act, too: then both together may gain energy,
            which is left to the solver of single ones as well.
    """
    w = width(witness)
    count = len(rows.first) - 1
    target, keeps = held
    at_once = aims == 2
    doubt = DOUBT if aims > 0 else DOUBT_HELD
    scale = same(0.0, witness)
    worst = same(0.0, witness)
    gain, works = same(0.0, witness), same(0.0, witness)
    for r in range(count):
        before = load(work, (places.before + r) * w, witness)
        made = jump_of_row(rows, r, places, work, witness)
        free = load(work, (places.free + r) * w, witness)
        told = free - before
        for s in range(count):
            share = load(work, (places.delassus + r * count + s) * w, witness)
            told = told + share * load(work, (places.p + s) * w, witness)
        left = absolute(made - told)
        worst = where_less(worst, left, left, worst)
        size = size_of_terms(rows, r, places, work, witness)
        for speed in (absolute(before), size):
            scale = where_less(scale, speed, speed, scale)
        if at_once and not (r < len(target) and (keeps[r] or target[r] != 0.0)):
            impulse = load(work, (places.p + r) * w, witness)
            own = impulse * (before + 0.5 * made)
            gain = gain + own
            works = works + absolute(own) + absolute(impulse * before) + absolute(impulse * free)
    spare_at = places.spare
    store(work, spare_at * w, worst - doubt * scale)
    store(work, (spare_at + 1) * w, gain - GAIN * works)
    for lane in range(w):
        off = work[spare_at * w + lane] > 0.0
        gains = at_once and work[(spare_at + 1) * w + lane] > 0.0
        if (off or gains) and (
            code[lane] % OPEN == _SOLVED or code[lane] % OPEN == _NOT_UNIQUE or code[lane] == _JAM
        ):
            code[lane] = AGAIN


@inlined
def jump_of_row(rows, row, places, work, witness):
    """By how much Δv changes the velocity of a row."""
    return row_velocity(
        rows.term_ints, rows.term_floats, rows.first[row], rows.first[row + 1],
        JUMP, work, places.dv, places.term, witness,
    )  # fmt: skip


@inlined
def size_of_terms(rows, number, places, work, witness):
    """What ``jump_of_row`` would be if nothing cancelled."""
    w = width(witness)
    term_ints, term_floats, dv_at, term_at = (
        rows.term_ints, rows.term_floats, places.dv, places.term,
    )  # fmt: skip
    size = same(0.0, witness)
    for term in range(rows.first[number], rows.first[number + 1]):
        kind, body = term_ints[term * TERM_INTS], term_ints[term * TERM_INTS + 1]
        if kind == ALONG_DOF:
            own = load(work, (dv_at + term_ints[term * TERM_INTS + 3]) * w, witness)
            size = size + absolute(term_floats[term * TERM_FLOATS + 3] * own)
            continue
        at = (term_at + term * TERM) * w
        d0, d1, d2 = _absolutes(work, at, w, witness)
        row = (body * BODY + JUMP) * w
        t0, t1, t2 = _absolutes(work, row + 3 * w, w, witness)
        if kind == COUPLE:
            size = size + (d0 * t0 + d1 * t1 + d2 * t2)
            continue
        a0, a1, a2 = _absolutes(work, at + 3 * w, w, witness)
        m0, m1, m2 = _absolutes(work, row, w, witness)
        size = size + d0 * (m0 + t1 * a2 + t2 * a1)
        size = size + d1 * (m1 + t2 * a0 + t0 * a2)
        size = size + d2 * (m2 + t0 * a1 + t1 * a0)
    return size


@inlined
def _absolutes(work, at, step, witness):
    a = triple(work, at, step, witness)
    return absolute(a[0]), absolute(a[1]), absolute(a[2])
