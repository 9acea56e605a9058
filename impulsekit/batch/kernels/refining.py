"""Δv once more, on what it leaves of the impulses.

Where a body is nearly a point away from its joint, nearly all of its articulated inertia is
taken out as the joint is freed, and the rest has lost digits. What M Δv leaves of the
impulses is told by the momenta of the bodies, where nothing is taken out.
"""

from __future__ import annotations

from .algebra import put_triple, triple
from .articulated import along, press, respond, twists
from .bearing import bear
from .jit import inlined
from .lanes import width
from .layout import BODY, BODY_INTS, DOF, DOF_INTS, FORCE, JUMP, TARGET
from .memory import load, same, store

__all__ = ["refine"]


@inlined
def refine(tree, sets, places, work, witness):
    """Correct Δv and the jumps of all bodies.

    On entry FORCE holds minus the impulse from outside of every body, and TARGET τ; where the
    generalized impulse stands there is room for another Δv.

    Args:
        sets: of which all bodies are loaded.
    """
    ints, floats, dofs, armature = tree.ints, tree.floats, tree.dofs, tree.armature
    count, everyone = len(ints) // BODY_INTS - 1, sets.loaded
    dof_at, dv_at, spare_at = places.dof, places.dv, places.sum
    w = width(witness)
    zero = same(0.0, witness)
    bear(ints, floats, count, work, places.loads, witness)
    for body in range(1, count + 1):
        row = (body * BODY + FORCE) * w
        p, m = triple(work, row, w, witness), triple(work, row + 3 * w, w, witness)
        first = ints[body * BODY_INTS + 3]
        for dof in range(first, first + ints[body * BODY_INTS + 4]):
            target = (dof_at + dof * DOF + TARGET) * w
            k = 3 * dofs[dof * DOF_INTS] + dofs[dof * DOF_INTS + 1]
            change = load(work, (dv_at + dof) * w, witness)
            own = along(p, m, k) + armature[dof] * change
            store(work, target, load(work, target, witness) - own)
            store(work, (spare_at + dof) * w, change)
        put_triple(work, row, w, (zero, zero, zero))
        put_triple(work, row + 3 * w, w, (zero, zero, zero))
    press(ints, floats, dofs, count, everyone, 0, work, dof_at, witness)
    respond(ints, floats, dofs, count, everyone, work, dof_at, dv_at, witness)
    last = ints[count * BODY_INTS + 3] + ints[count * BODY_INTS + 4]
    for dof in range(last):
        before = load(work, (spare_at + dof) * w, witness)
        store(work, (dv_at + dof) * w, before + load(work, (dv_at + dof) * w, witness))
    twists(ints, floats, dofs, sets.loaded_list, work, dv_at, JUMP, witness)
