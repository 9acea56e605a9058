"""Vectors and inertias from a body's axes to its parent's, and back.

The rotation of a joint that turns about its own z alone is Rz(β) Rx(α) Rz(θ) with constant
β and α (after Denavit & Hartenberg 1955; θ holds the constant γ as well). The axes of bodies
are chosen such that most β are nothing, and many α: what is nothing is left out.
"""

from __future__ import annotations

from .algebra import nine, times, transposed_times
from .jit import inlined
from .layout import ABOUT_X, ABOUT_Z, CIRCLE, TURN
from .memory import load

__all__ = ["about_x", "about_z", "inwards", "outwards"]


@inlined
def about_z(a, c, s):
    """A vector turned about z by an angle of that cosine and sine."""
    return (c * a[0] - s * a[1], s * a[0] + c * a[1], a[2])


@inlined
def about_x(a, c, s):
    """A vector turned about x."""
    return (a[0], c * a[1] - s * a[2], s * a[1] + c * a[2])


@inlined
def inwards(kind, turns, floats, f, work, row, w, a, b, witness):
    """Two vectors in a body's axes in those of its parent.

    Args:
        kind, turns: the integers of the body that say so.
        f: where the floats of the body begin.
        row: where the body's row begins.
    """
    if kind > CIRCLE:
        rotation = nine(work, row + TURN * w, w, witness)
        return times(rotation, a), times(rotation, b)
    c, s = load(work, row + TURN * w, witness), load(work, row + (TURN + 1) * w, witness)
    a, b = about_z(a, c, s), about_z(b, c, s)
    if turns & ABOUT_X:
        a = about_x(a, floats[f + 2], floats[f + 3])
        b = about_x(b, floats[f + 2], floats[f + 3])
    if turns & ABOUT_Z:
        a = about_z(a, floats[f], floats[f + 1])
        b = about_z(b, floats[f], floats[f + 1])
    return a, b


@inlined
def outwards(kind, turns, floats, f, work, row, w, a, b, witness):
    """Two vectors in the axes of a body's parent in its own; as ``inwards``."""
    if kind > CIRCLE:
        rotation = nine(work, row + TURN * w, w, witness)
        return transposed_times(rotation, a), transposed_times(rotation, b)
    if turns & ABOUT_Z:
        a = about_z(a, floats[f], -floats[f + 1])
        b = about_z(b, floats[f], -floats[f + 1])
    if turns & ABOUT_X:
        a = about_x(a, floats[f + 2], -floats[f + 3])
        b = about_x(b, floats[f + 2], -floats[f + 3])
    c, s = load(work, row + TURN * w, witness), load(work, row + (TURN + 1) * w, witness)
    return about_z(a, c, -s), about_z(b, c, -s)
