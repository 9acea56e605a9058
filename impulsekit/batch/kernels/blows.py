"""Known impulses, each on a body or in a joint, one set of numbers for each state."""

from __future__ import annotations

from .algebra import add_triple, cross, dot, plus, times, triple
from .jit import inlined
from .lanes import width
from .layout import BLOW_FLOATS, BLOW_INTS, BODY, DOF, FORCE, JUMP, TARGET, TWIST
from .memory import collect, load, same, store
from .rows import in_body

__all__ = ["strike", "work_of_blows"]


@inlined
def _wrench(ints, floats, blow, given, at, stride, work, witness):
    """Force, couple and arm of a blow in the axes of its body."""
    first = at + ints[blow * BLOW_INTS + 2]
    force = _given(given, first, stride, witness)
    couple = _given(given, first + 3, stride, witness)
    body, f = ints[blow * BLOW_INTS], blow * BLOW_FLOATS
    arm = (same(floats[f], witness), same(floats[f + 1], witness), same(floats[f + 2], witness))
    if ints[blow * BLOW_INTS + 1]:
        axes = (
            floats[f + 3],
            floats[f + 4],
            floats[f + 5],
            floats[f + 6],
            floats[f + 7],
            floats[f + 8],
            floats[f + 9],
            floats[f + 10],
            floats[f + 11],
        )
        return times(axes, force), times(axes, couple), arm
    return in_body(work, body, force, witness), in_body(work, body, couple, witness), arm


@inlined
def _given(given, at, stride, witness):
    """Three numbers of each state, or the same three of all."""
    if stride == 0:
        return (
            same(given[at], witness),
            same(given[at + 1], witness),
            same(given[at + 2], witness),
        )
    return (
        collect(given, at, stride, witness),
        collect(given, at + 1, stride, witness),
        collect(given, at + 2, stride, witness),
    )


@inlined
def strike(ints, floats, kicks, given, at, stride, work, dof_at, witness):
    """Add all blows to FORCE (with its sign) and TARGET.

    Args:
        ints, floats: the tables of the blows.
        kicks: (2k,) of impulses in joints: degree of freedom, column of ``given``.
        given: flat; the numbers of the first state begin at ``at``, those of the next
            ``stride`` further on.
    """
    w = width(witness)
    for blow in range(len(ints) // BLOW_INTS):
        force, couple, arm = _wrench(ints, floats, blow, given, at, stride, work, witness)
        couple = plus(couple, cross(arm, force))
        row = (ints[blow * BLOW_INTS] * BODY + FORCE) * w
        add_triple(work, row, w, (-force[0], -force[1], -force[2]), witness)
        add_triple(work, row + 3 * w, w, (-couple[0], -couple[1], -couple[2]), witness)
    for k in range(0, len(kicks), 2):
        target = (dof_at + kicks[k] * DOF + TARGET) * w
        kick = collect(given, at + kicks[k + 1], stride, witness)
        store(work, target, load(work, target, witness) + kick)


@inlined
def work_of_blows(ints, floats, kicks, given, at, stride, work, v_at, dv_at, witness):
    """The work of all blows: impulse times the mean of the velocities before and after."""
    w = width(witness)
    total = same(0.0, witness)
    for blow in range(len(ints) // BLOW_INTS):
        force, couple, arm = _wrench(ints, floats, blow, given, at, stride, work, witness)
        couple = plus(couple, cross(arm, force))
        row = ints[blow * BLOW_INTS] * BODY
        before, after = (row + TWIST) * w, (row + JUMP) * w
        total = total + dot(force, triple(work, before, w, witness))
        total = total + dot(couple, triple(work, before + 3 * w, w, witness))
        total = total + 0.5 * dot(force, triple(work, after, w, witness))
        total = total + 0.5 * dot(couple, triple(work, after + 3 * w, w, witness))
    for k in range(0, len(kicks), 2):
        speed = load(work, (v_at + kicks[k]) * w, witness)
        change = load(work, (dv_at + kicks[k]) * w, witness)
        total = total + collect(given, at + kicks[k + 1], stride, witness) * (speed + 0.5 * change)
    return total
