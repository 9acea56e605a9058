"""Known impulses, each on a body or in a joint, one set of numbers for each state."""

from __future__ import annotations

from .algebra import add_triple, cross, dot, nine, plus, times, triple
from .jit import built_in
from .lanes import width
from .layout import BLOW_FLOATS, BLOW_INTS, BODY, DOF, FORCE, JUMP, TARGET, TWIST
from .memory import collect, load, same, store

__all__ = ["strike", "work_of_blows"]


@built_in
def _wrench(ints, floats, blow, given, at, stride, work, witness):
    """Force, couple and arm of a blow in world axes."""
    w = width(witness)
    first = at + ints[blow * BLOW_INTS + 2]
    force = (
        collect(given, first, stride, witness),
        collect(given, first + 1, stride, witness),
        collect(given, first + 2, stride, witness),
    )
    couple = (
        collect(given, first + 3, stride, witness),
        collect(given, first + 4, stride, witness),
        collect(given, first + 5, stride, witness),
    )
    f = blow * BLOW_FLOATS
    turn = nine(work, ints[blow * BLOW_INTS] * BODY * w, w, witness)
    arm = times(turn, (floats[f], floats[f + 1], floats[f + 2]))
    if ints[blow * BLOW_INTS + 1]:
        axes = (
            same(floats[f + 3], witness),
            same(floats[f + 4], witness),
            same(floats[f + 5], witness),
            same(floats[f + 6], witness),
            same(floats[f + 7], witness),
            same(floats[f + 8], witness),
            same(floats[f + 9], witness),
            same(floats[f + 10], witness),
            same(floats[f + 11], witness),
        )
        force = times(turn, times(axes, force))
        couple = times(turn, times(axes, couple))
    return force, couple, arm


@built_in
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


@built_in
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
