"""Articulated bodies hit by known impulses: M Δv = τ + Jᵀp in O(n), without M or J.

p is the impulse that a joint needs to keep its body from jumping. Inwards, with U and D of
``inertia.factor``: u = τ − s·p, p ← p + U u/D. Then outwards: Δq̇ = (u − U·Δa)/D with
the jump Δa that the parent hands on, and Δa ← Δa + s Δq̇ (Featherstone 1983).
"""

from __future__ import annotations

from .algebra import add_triple, cross, dot, minus, plus, put_triple, triple
from .jit import built_in
from .lanes import width
from .layout import (
    BODY,
    BODY_INTS,
    DOF,
    DOF_INTS,
    FORCE,
    INVERSE,
    JUMP,
    OFFSET,
    TARGET,
)
from .memory import load, same, store

__all__ = ["collected", "press", "respond", "twists"]


@built_in
def press(ints, dofs, count, loaded, mask_at, work, dof_at, witness):
    """Bring bias impulses inwards: u of every loaded degree of freedom.

    ``loaded`` is a mask of the bodies, from ``mask_at`` on. On entry FORCE holds, for every
    loaded body, minus its impulse from outside, and TARGET of each of its degrees of
    freedom holds τ.
    """
    w = width(witness)
    for body in range(count, 0, -1):
        if not loaded[mask_at + body]:
            continue
        at = body * BODY_INTS
        parent, first, size = ints[at], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        p = triple(work, row + FORCE * w, w, witness)
        m = triple(work, row + (FORCE + 3) * w, w, witness)
        for dof in range(first + size - 1, first - 1, -1):
            d = (dof_at + dof * DOF) * w
            axis = triple(work, row + dofs[dof * DOF_INTS + 1] * w, 3 * w, witness)
            if dofs[dof * DOF_INTS] == 1:
                u = load(work, d + TARGET * w, witness) - dot(axis, m)
            else:
                u = load(work, d + TARGET * w, witness) - dot(axis, p)
            store(work, d + TARGET * w, u)
            share = -(u * load(work, d + INVERSE * w, witness))
            p = minus(p, share, triple(work, d, w, witness))
            m = minus(m, share, triple(work, d + 3 * w, w, witness))
        if parent > 0:
            r = triple(work, row + OFFSET * w, w, witness)
            f = (parent * BODY + FORCE) * w
            add_triple(work, f, w, p, witness)
            add_triple(work, f + 3 * w, w, plus(m, cross(r, p)), witness)


@built_in
def respond(ints, dofs, count, loaded, work, dof_at, dv_at, witness):
    """Write Δv, and the jump of every body's twist, outwards."""
    w = width(witness)
    zero = same(0.0, witness)
    for body in range(1, count + 1):
        at = body * BODY_INTS
        parent, first, size = ints[at], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        if parent > 0:
            above = (parent * BODY + JUMP) * w
            turn = triple(work, above + 3 * w, w, witness)
            r = triple(work, row + OFFSET * w, w, witness)
            jump = plus(triple(work, above, w, witness), cross(turn, r))
        else:
            jump, turn = (zero, zero, zero), (zero, zero, zero)
        for dof in range(first, first + size):
            d = (dof_at + dof * DOF) * w
            change = -(
                dot(triple(work, d, w, witness), jump)
                + dot(triple(work, d + 3 * w, w, witness), turn)
            )
            if loaded[body]:
                change = change + load(work, d + TARGET * w, witness)
            change = change * load(work, d + INVERSE * w, witness)
            store(work, (dv_at + dof) * w, change)
            axis = triple(work, row + dofs[dof * DOF_INTS + 1] * w, 3 * w, witness)
            if dofs[dof * DOF_INTS] == 1:
                turn = minus(turn, -change, axis)
            else:
                jump = minus(jump, -change, axis)
        put_triple(work, row + JUMP * w, w, jump)
        put_triple(work, row + (JUMP + 3) * w, w, turn)


@built_in
def twists(ints, dofs, wanted, work, v_at, to, witness):
    """Write at ``to`` of each row the twist of the bodies listed, parents first, given v."""
    w = width(witness)
    zero = same(0.0, witness)
    for k in range(len(wanted)):
        body = wanted[k]
        at = body * BODY_INTS
        parent, first, size = ints[at], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        if parent > 0:
            above = (parent * BODY + to) * w
            turn = triple(work, above + 3 * w, w, witness)
            r = triple(work, row + OFFSET * w, w, witness)
            move = plus(triple(work, above, w, witness), cross(turn, r))
        else:
            move, turn = (zero, zero, zero), (zero, zero, zero)
        for dof in range(first, first + size):
            speed = load(work, (v_at + dof) * w, witness)
            axis = triple(work, row + dofs[dof * DOF_INTS + 1] * w, 3 * w, witness)
            if dofs[dof * DOF_INTS] == 1:
                turn = minus(turn, -speed, axis)
            else:
                move = minus(move, -speed, axis)
        put_triple(work, row + to * w, w, move)
        put_triple(work, row + (to + 3) * w, w, turn)


@built_in
def collected(ints, dofs, count, loaded, work, dof_at, to, witness):
    """Write I = τ + Jᵀp from FORCE and TARGET as ``press`` finds them; FORCE is used up."""
    w = width(witness)
    zero = same(0.0, witness)
    for body in range(count, 0, -1):
        at = body * BODY_INTS
        parent, first, size = ints[at], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        if not loaded[body]:
            for dof in range(first, first + size):
                store(work, (to + dof) * w, zero)
            continue
        p = triple(work, row + FORCE * w, w, witness)
        m = triple(work, row + (FORCE + 3) * w, w, witness)
        for dof in range(first, first + size):
            axis = triple(work, row + dofs[dof * DOF_INTS + 1] * w, 3 * w, witness)
            share = dot(axis, m) if dofs[dof * DOF_INTS] == 1 else dot(axis, p)
            target = load(work, (dof_at + dof * DOF + TARGET) * w, witness)
            store(work, (to + dof) * w, target - share)
        if parent > 0:
            r = triple(work, row + OFFSET * w, w, witness)
            f = (parent * BODY + FORCE) * w
            add_triple(work, f, w, p, witness)
            add_triple(work, f + 3 * w, w, plus(m, cross(r, p)), witness)
