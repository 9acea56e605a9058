"""Where the bodies stand: each to its parent, and those that are asked for in the world."""

from __future__ import annotations

from .algebra import nine, plus, product, put_nine, put_triple, times, triple
from .jit import inlined
from .lanes import width
from .layout import (
    ABOUT_X,
    ABOUT_Z,
    ANGLE,
    BODY,
    BODY_FLOATS,
    BODY_INTS,
    CIRCLE,
    FREE,
    GEARED_ANGLE,
    GEARED_CIRCLE,
    OFFSET,
    PLANAR,
    QUATERNION,
    ROTATION,
    SHIFT,
    SLIDE,
    TRANSLATION,
    TURN,
)
from .memory import load, same, store
from .trig import sine_cosine

__all__ = ["offset_of", "place_bodies"]


@inlined
def place_bodies(ints, floats, count, placed, work, q_at, spare_at, witness):
    """Write how every body stands to its parent, from the q in ``work``.

    ``placed`` is a mask of the bodies, with all between them and the world, whose rotation
    to world axes is wanted, and the offset from the parent's joint in these.
    """
    w = width(witness)
    one, zero = same(1.0, witness), same(0.0, witness)
    put_nine(work, ROTATION * w, w, (one, zero, zero, zero, one, zero, zero, zero, one))
    for body in range(1, count + 1):
        at = body * BODY_INTS
        kind = ints[at + 1]
        row = body * BODY * w
        q = (q_at + ints[at + 2]) * w
        f = body * BODY_FLOATS
        if kind <= CIRCLE:
            if kind == ANGLE:
                s, c = sine_cosine(load(work, q, witness), work, spare_at * w, witness)
            else:
                c, s = load(work, q, witness), load(work, q + w, witness)
            store(work, row + TURN * w, floats[f + 4] * c - floats[f + 5] * s)
            store(work, row + (TURN + 1) * w, floats[f + 5] * c + floats[f + 4] * s)
        else:
            _place_freely(kind, floats, f, work, row, q, spare_at, witness)
        if placed[body]:
            _place_in_world(ints, floats, body, work, witness)


@inlined
def offset_of(kind, floats, f, work, row, w, witness):
    """From the parent's joint to the body's, in the parent's axes."""
    if kind > CIRCLE:
        return triple(work, row + SHIFT * w, w, witness)
    return (
        same(floats[f + 9], witness),
        same(floats[f + 10], witness),
        same(floats[f + 11], witness),
    )


@inlined
def _place_freely(kind, floats, f, work, row, q, spare_at, witness):
    """Rotation to the parent's axes and offset of a body that does not turn about z alone."""
    w = width(witness)
    zero = same(0.0, witness)
    b = _constants(floats, f, witness)
    x = (
        same(floats[f + 9], witness),
        same(floats[f + 10], witness),
        same(floats[f + 11], witness),
    )
    if kind == SLIDE:
        x = plus(x, times(b, (zero, zero, load(work, q, witness))))
    elif kind == PLANAR:
        x = plus(x, times(b, (load(work, q, witness), load(work, q + w, witness), zero)))
        b = _about_z(b, load(work, q + 2 * w, witness), load(work, q + 3 * w, witness))
    elif kind == GEARED_ANGLE:
        s, c = sine_cosine(load(work, q, witness), work, spare_at * w, witness)
        b = _about_z(b, c, s)
    elif kind == GEARED_CIRCLE:
        b = _about_z(b, load(work, q, witness), load(work, q + w, witness))
    elif kind in (FREE, TRANSLATION):
        x = plus(x, times(b, triple(work, q, w, witness)))
    if kind in (FREE, QUATERNION):
        b = product(b, _of_quaternion(work, q + 3 * w if kind == FREE else q, w, witness))
    put_nine(work, row + TURN * w, w, b)
    put_triple(work, row + SHIFT * w, w, x)


@inlined
def _place_in_world(ints, floats, body, work, witness):
    w = width(witness)
    at = body * BODY_INTS
    parent, kind, turns = ints[at], ints[at + 1], ints[at + 8]
    row = body * BODY * w
    f = body * BODY_FLOATS
    b = nine(work, (parent * BODY + ROTATION) * w, w, witness)
    put_triple(
        work, row + OFFSET * w, w, times(b, offset_of(kind, floats, f, work, row, w, witness))
    )
    if kind > CIRCLE:
        b = product(b, nine(work, row + TURN * w, w, witness))
    else:
        if turns & ABOUT_Z:
            b = _about_z(b, floats[f], floats[f + 1])
        if turns & ABOUT_X:
            b = _about_x(b, floats[f + 2], floats[f + 3])
        turn = row + TURN * w
        b = _about_z(b, load(work, turn, witness), load(work, turn + w, witness))
    put_nine(work, row + ROTATION * w, w, b)


@inlined
def _constants(floats, at, witness):
    """The rotation of a joint in its parent's frame."""
    return (
        same(floats[at], witness),
        same(floats[at + 1], witness),
        same(floats[at + 2], witness),
        same(floats[at + 3], witness),
        same(floats[at + 4], witness),
        same(floats[at + 5], witness),
        same(floats[at + 6], witness),
        same(floats[at + 7], witness),
        same(floats[at + 8], witness),
    )


@inlined
def _about_z(b, c, s):
    """B times the rotation about z."""
    return (
        b[0] * c + b[1] * s,
        b[1] * c - b[0] * s,
        b[2],
        b[3] * c + b[4] * s,
        b[4] * c - b[3] * s,
        b[5],
        b[6] * c + b[7] * s,
        b[7] * c - b[6] * s,
        b[8],
    )


@inlined
def _about_x(b, c, s):
    """B times the rotation about x."""
    return (
        b[0],
        b[1] * c + b[2] * s,
        b[2] * c - b[1] * s,
        b[3],
        b[4] * c + b[5] * s,
        b[5] * c - b[4] * s,
        b[6],
        b[7] * c + b[8] * s,
        b[8] * c - b[7] * s,
    )


@inlined
def _of_quaternion(work, at, w, witness):
    """The rotation of a unit quaternion x, y, z, w."""
    i, j, k = triple(work, at, w, witness)
    u = load(work, at + 3 * w, witness)
    return (
        1.0 - 2.0 * (j * j + k * k),
        2.0 * (i * j - u * k),
        2.0 * (i * k + u * j),
        2.0 * (i * j + u * k),
        1.0 - 2.0 * (i * i + k * k),
        2.0 * (j * k - u * i),
        2.0 * (i * k - u * j),
        2.0 * (j * k + u * i),
        1.0 - 2.0 * (i * i + j * j),
    )
