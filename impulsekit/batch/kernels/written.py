"""The impulses of contacts, as they are given out."""

from __future__ import annotations

from .algebra import nine, times
from .doubt import jump_of_row
from .jit import inlined
from .lanes import width
from .layout import CONTACT_FLOATS, CONTACT_INTS, MEETING
from .memory import load, put, same

__all__ = ["write_contacts", "write_normals"]


@inlined
def write_contacts(ints, floats, base, p_at, meeting_at, work, out, witness):
    """Contact impulses in world axes; of a stop, along its coordinate, in the first entry."""
    w = width(witness)
    count = len(ints) // CONTACT_INTS
    zero = same(0.0, witness)
    for contact in range(count):
        at = contact * CONTACT_INTS
        first, size, entry, meeting = ints[at], ints[at + 1], ints[at + 2], ints[at + 3]
        at = base * 3 * count + 3 * contact
        if entry >= 0:
            put(out, at, 3 * count, load(work, (p_at + first) * w, witness))
            put(out, at + 1, 3 * count, zero)
            put(out, at + 2, 3 * count, zero)
            continue
        p1, p2 = zero, zero
        if size == 3:
            p1 = load(work, (p_at + first) * w, witness)
            p2 = load(work, (p_at + first + 1) * w, witness)
        f = contact * CONTACT_FLOATS
        axes = (
            floats[f], floats[f + 1], floats[f + 2], floats[f + 3], floats[f + 4],
            floats[f + 5], floats[f + 6], floats[f + 7], floats[f + 8],
        )  # fmt: skip
        pn = load(work, (p_at + first + size - 1) * w, witness)
        if meeting >= 0:
            moving = nine(work, (meeting_at + meeting * MEETING) * w, w, witness)
            impulse = times(moving, (p1, p2, pn))
        else:
            impulse = times(axes, (p1, p2, pn))
        put(out, at, 3 * count, impulse[0])
        put(out, at + 1, 3 * count, impulse[1])
        put(out, at + 2, 3 * count, impulse[2])


@inlined
def write_normals(ints, rows, base, at, work, out, witness):
    """Write each contact's normal velocity before and after, and its normal impulse."""
    w = width(witness)
    count = len(ints) // CONTACT_INTS
    for contact in range(count):
        row = ints[contact * CONTACT_INTS] + ints[contact * CONTACT_INTS + 1] - 1
        to = base * 3 * count + 3 * contact
        before = load(work, (at.before + row) * w, witness)
        put(out, to, 3 * count, before)
        put(out, to + 1, 3 * count, before + jump_of_row(rows, row, at, work, witness))
        put(out, to + 2, 3 * count, load(work, (at.p + row) * w, witness))
