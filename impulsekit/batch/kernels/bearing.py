"""What joints bear: the impulse that each parent gives its child."""

from __future__ import annotations

from .algebra import (
    add_triple,
    cross,
    minus,
    nine,
    plus,
    put_triple,
    symmetric_times,
    times,
    transposed_times,
    triple,
)
from .jit import built_in
from .lanes import width
from .layout import BODY, BODY_FLOATS, BODY_INTS, FORCE, JUMP, OFFSET

__all__ = ["bear"]


@built_in
def bear(ints, floats, count, work, witness):
    """Turn FORCE of every body, minus its impulse from outside, into the reaction.

    The reaction is the jump of the momentum of the body and of all that hangs on it, less
    what acts on these from outside; about the origin of its joint, world axes.
    """
    w = width(witness)
    for body in range(count, 0, -1):
        at = body * BODY_INTS
        row = body * BODY * w
        f = body * BODY_FLOATS
        rotation = nine(work, row, w, witness)
        move = triple(work, row + JUMP * w, w, witness)
        turn = triple(work, row + (JUMP + 3) * w, w, witness)
        first = times(rotation, (floats[f + 13], floats[f + 14], floats[f + 15]))
        inertia = (
            floats[f + 16],
            floats[f + 17],
            floats[f + 18],
            floats[f + 19],
            floats[f + 20],
            floats[f + 21],
        )
        spin = times(rotation, symmetric_times(inertia, transposed_times(rotation, turn)))
        linear = minus(cross(turn, first), -floats[f + 12], move)
        angular = plus(spin, cross(first, move))
        linear = plus(linear, triple(work, row + FORCE * w, w, witness))
        angular = plus(angular, triple(work, row + (FORCE + 3) * w, w, witness))
        put_triple(work, row + FORCE * w, w, linear)
        put_triple(work, row + (FORCE + 3) * w, w, angular)
        if ints[at] > 0:
            r = triple(work, row + OFFSET * w, w, witness)
            above = (ints[at] * BODY + FORCE) * w
            add_triple(work, above, w, linear, witness)
            add_triple(work, above + 3 * w, w, plus(angular, cross(r, linear)), witness)
