"""Where the bodies stand: rotations and offsets, from the world outwards."""

from __future__ import annotations

from .algebra import nine, plus, product, put_nine, put_triple, times, triple
from .jit import built_in
from .lanes import width
from .layout import (
    ANGLE,
    BODY,
    BODY_FLOATS,
    BODY_INTS,
    CIRCLE,
    FREE,
    OFFSET,
    PLANAR,
    QUATERNION,
    SLIDE,
    TRANSLATION,
)
from .memory import load, same
from .trig import sine_cosine

__all__ = ["place_bodies"]


@built_in
def place_bodies(ints, floats, count, work, q_at, spare_at, witness):
    """Write rotation and offset of every body from the q in ``work``.

    Joint frames are such that a single axis is z. A rotation takes the body's frame to
    the world, an offset is from the parent's joint to its own in world axes.
    """
    w = width(witness)
    one, zero = same(1.0, witness), same(0.0, witness)
    put_nine(work, 0, w, (one, zero, zero, zero, one, zero, zero, zero, one))
    for body in range(1, count + 1):
        at = body * BODY_INTS
        parent, kind = ints[at], ints[at + 1]
        row = body * BODY * w
        q = (q_at + ints[at + 2]) * w
        f = body * BODY_FLOATS
        fixed = _constants(floats, f, witness)
        if parent > 0:
            above = nine(work, parent * BODY * w, w, witness)
            x = times(above, (floats[f + 9], floats[f + 10], floats[f + 11]))
            b = product(above, fixed)
        else:
            x = (
                same(floats[f + 9], witness),
                same(floats[f + 10], witness),
                same(floats[f + 11], witness),
            )
            b = fixed
        d = (zero, zero, zero)
        if kind == ANGLE:
            s, c = sine_cosine(load(work, q, witness), work, spare_at * w, witness)
            b = _about_z(b, c, s)
        elif kind == CIRCLE:
            b = _about_z(b, load(work, q, witness), load(work, q + w, witness))
        elif kind == SLIDE:
            d = (zero, zero, load(work, q, witness))
        elif kind == PLANAR:
            d = (load(work, q, witness), load(work, q + w, witness), zero)
        elif kind in (FREE, TRANSLATION):
            d = triple(work, q, w, witness)
        if kind >= SLIDE and kind != QUATERNION:
            x = plus(x, times(b, d))
        if kind == PLANAR:
            b = _about_z(b, load(work, q + 2 * w, witness), load(work, q + 3 * w, witness))
        elif kind in (FREE, QUATERNION):
            b = product(b, _of_quaternion(work, q + 3 * w if kind == FREE else q, w, witness))
        put_nine(work, row, w, b)
        put_triple(work, row + OFFSET * w, w, x)


@built_in
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


@built_in
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


@built_in
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
