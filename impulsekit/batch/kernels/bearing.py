"""What joints bear: the impulse that each parent gives its child."""

from __future__ import annotations

from .algebra import add_triple, cross, minus, plus, put_triple, symmetric_times, triple
from .axes import inwards
from .inertia import weights_of
from .jit import inlined
from .kinematics import offset_of
from .lanes import width
from .layout import BODY, BODY_FLOATS, BODY_INTS, FORCE, JUMP

__all__ = ["bear"]


@inlined
def bear(ints, floats, count, work, loads_at, witness):
    """Turn FORCE of every body, minus its impulse from outside, into the reaction.

    The reaction is the jump of the momentum of the body and of all that hangs on it, less
    what acts on these from outside; about the origin of its joint, in the body's axes.
    """
    w = width(witness)
    for body in range(count, 0, -1):
        at = body * BODY_INTS
        row = body * BODY * w
        f = body * BODY_FLOATS
        move = triple(work, row + JUMP * w, w, witness)
        turn = triple(work, row + (JUMP + 3) * w, w, witness)
        mass, first, inertia = weights_of(ints, floats, body, work, loads_at, witness)
        linear = minus(cross(turn, first), -mass, move)
        angular = plus(symmetric_times(inertia, turn), cross(first, move))
        linear = plus(linear, triple(work, row + FORCE * w, w, witness))
        angular = plus(angular, triple(work, row + (FORCE + 3) * w, w, witness))
        put_triple(work, row + FORCE * w, w, linear)
        put_triple(work, row + (FORCE + 3) * w, w, angular)
        if ints[at] > 0:
            kind = ints[at + 1]
            linear, angular = inwards(
                kind, ints[at + 8], floats, f, work, row, w, linear, angular, witness
            )
            r = offset_of(kind, floats, f, work, row, w, witness)
            above = (ints[at] * BODY + FORCE) * w
            add_triple(work, above, w, linear, witness)
            add_triple(work, above + 3 * w, w, plus(angular, cross(r, linear)), witness)
