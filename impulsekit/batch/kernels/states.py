"""States as they come: into the work array, and whether they are fit to be solved."""

from __future__ import annotations

import math

from .jit import inlined
from .lanes import width
from .memory import collect, collect_angle, load, store

__all__ = ["is_unit", "lead", "seen", "taken"]

UNIT_TOLERANCE = 1e-6


@inlined
def taken(source, base, step, columns, angles, work, to, bad, witness):
    """Bring columns of a flat array into the work array; ``bad`` becomes NaN in lanes that
    hold a NaN or an infinity."""
    w = width(witness)
    for k in range(len(columns)):
        at = base * step + columns[k]
        if angles[k]:
            value = collect_angle(source, at, step, witness)
        else:
            value = collect(source, at, step, witness)
        bad = bad + value * 0.0
        store(work, (to + k) * w, value)
    return bad


@inlined
def seen(source, base, step, columns, bad, witness):
    """``bad`` for columns of which nothing else is wanted."""
    if step > 0:
        for k in range(columns):
            bad = bad + collect(source, base * step + k, step, witness) * 0.0
    return bad


@inlined
def lead(ints, floats, work, q_at, v_at, witness):
    """Bring joints that follow others to where these want them."""
    w = width(witness)
    for k in range(len(ints) // 3):
        q, v = (q_at + ints[3 * k]) * w, (v_at + ints[3 * k + 1]) * w
        ratio, offset = floats[2 * k], floats[2 * k + 1]
        store(work, q, ratio * load(work, q, witness) + offset)
        store(work, v, ratio * load(work, v, witness))


@inlined
def is_unit(q, q_row, units):
    """Whether the unit vectors of one configuration are of unit length."""
    for k in range(0, len(units), 2):
        total = 0.0
        for entry in range(q_row + units[k], q_row + units[k] + units[k + 1]):
            total += q[entry] * q[entry]
        if not abs(math.sqrt(total) - 1.0) <= UNIT_TOLERANCE:
            return False
    return True
