"""Articulated bodies hit by known impulses: M Δv = τ + Jᵀp in O(n), without M or J.

p is the impulse that a joint needs to keep its body from jumping. Inwards, with U and D of
``inertia.factor``: u = τ − s·p, p ← p + U u/D. Then outwards: Δq̇ = (u − U·Δa)/D with
the jump Δa that the parent hands on, and Δa ← Δa + s Δq̇ (Featherstone 1983). Since
D = s·U, the entries along s need no U: s·p becomes τ, and s·Δa what D would take from Δq̇.
"""

from __future__ import annotations

from .algebra import add_triple, cross, dot, minus, plus, put_triple, triple
from .axes import inwards, outwards
from .jit import inlined
from .kinematics import offset_of
from .lanes import width
from .layout import (
    BODY,
    BODY_FLOATS,
    BODY_INTS,
    CIRCLE,
    DOF,
    DOF_INTS,
    FORCE,
    INVERSE,
    JUMP,
    TARGET,
)
from .memory import load, same, store

__all__ = ["along", "collected", "press", "respond", "twists", "with_more"]


@inlined
def along(a, b, k):
    """Entry k of the vectors a (0 to 2) and b (3 to 5)."""
    if k == 0:
        return a[0]
    if k == 1:
        return a[1]
    if k == 2:
        return a[2]
    if k == 3:
        return b[0]
    if k == 4:
        return b[1]
    return b[2]


@inlined
def with_more(a, b, k, more):
    """The vectors a and b with ``more`` added to entry k."""
    if k == 0:
        return (a[0] + more, a[1], a[2]), b
    if k == 1:
        return (a[0], a[1] + more, a[2]), b
    if k == 2:
        return (a[0], a[1], a[2] + more), b
    if k == 3:
        return a, (b[0] + more, b[1], b[2])
    if k == 4:
        return a, (b[0], b[1] + more, b[2])
    return a, (b[0], b[1], b[2] + more)


@inlined
def press(ints, floats, dofs, count, loaded, mask_at, work, dof_at, witness):
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
        parent, kind, first, size = ints[at], ints[at + 1], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        f = body * BODY_FLOATS
        p = triple(work, row + FORCE * w, w, witness)
        m = triple(work, row + (FORCE + 3) * w, w, witness)
        d = (dof_at + first * DOF) * w
        if kind <= CIRCLE:
            target = load(work, d + TARGET * w, witness)
            u = target - m[2]
            store(work, d + TARGET * w, u)
            share = -(u * load(work, d + INVERSE * w, witness))
            p = minus(p, share, triple(work, d, w, witness))
            x = m[0] - share * load(work, d + 3 * w, witness)
            m = (x, m[1] - share * load(work, d + 4 * w, witness), target)
            size = 0
        for dof in range(first + size - 1, first - 1, -1):
            d = (dof_at + dof * DOF) * w
            k = 3 * dofs[dof * DOF_INTS] + dofs[dof * DOF_INTS + 1]
            u = load(work, d + TARGET * w, witness) - along(p, m, k)
            store(work, d + TARGET * w, u)
            share = -(u * load(work, d + INVERSE * w, witness))
            p = minus(p, share, triple(work, d, w, witness))
            m = minus(m, share, triple(work, d + 3 * w, w, witness))
        if parent > 0:
            p, m = inwards(kind, ints[at + 8], floats, f, work, row, w, p, m, witness)
            r = offset_of(kind, floats, f, work, row, w, witness)
            above = (parent * BODY + FORCE) * w
            add_triple(work, above, w, p, witness)
            add_triple(work, above + 3 * w, w, plus(m, cross(r, p)), witness)


@inlined
def _handed_on(ints, floats, body, to, work, witness):
    """The twist that a body has from its parent's, in its own axes."""
    w = width(witness)
    at = body * BODY_INTS
    parent, kind = ints[at], ints[at + 1]
    row = body * BODY * w
    f = body * BODY_FLOATS
    zero = same(0.0, witness)
    if parent == 0:
        return (zero, zero, zero), (zero, zero, zero)
    above = (parent * BODY + to) * w
    turn = triple(work, above + 3 * w, w, witness)
    r = offset_of(kind, floats, f, work, row, w, witness)
    move = plus(triple(work, above, w, witness), cross(turn, r))
    return outwards(kind, ints[at + 8], floats, f, work, row, w, move, turn, witness)


@inlined
def respond(ints, floats, dofs, count, loaded, work, dof_at, dv_at, witness):
    """Write Δv, and the jump of every body's twist, outwards."""
    w = width(witness)
    for body in range(1, count + 1):
        at = body * BODY_INTS
        kind, first, size = ints[at + 1], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        jump, turn = _handed_on(ints, floats, body, JUMP, work, witness)
        if kind <= CIRCLE:
            d = (dof_at + first * DOF) * w
            speed = -dot(triple(work, d, w, witness), jump)
            speed = speed - load(work, d + 3 * w, witness) * turn[0]
            speed = speed - load(work, d + 4 * w, witness) * turn[1]
            if loaded[body]:
                speed = speed + load(work, d + TARGET * w, witness)
            speed = speed * load(work, d + INVERSE * w, witness)
            store(work, (dv_at + first) * w, speed - turn[2])
            turn = (turn[0], turn[1], speed)
            size = 0
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
            k = 3 * dofs[dof * DOF_INTS] + dofs[dof * DOF_INTS + 1]
            jump, turn = with_more(jump, turn, k, change)
        put_triple(work, row + JUMP * w, w, jump)
        put_triple(work, row + (JUMP + 3) * w, w, turn)


@inlined
def twists(ints, floats, dofs, wanted, work, v_at, to, witness):
    """Write at ``to`` of each row the twist of the bodies listed, parents first, given v."""
    w = width(witness)
    for n in range(len(wanted)):
        body = wanted[n]
        first, size = ints[body * BODY_INTS + 3], ints[body * BODY_INTS + 4]
        row = body * BODY * w
        move, turn = _handed_on(ints, floats, body, to, work, witness)
        for dof in range(first, first + size):
            k = 3 * dofs[dof * DOF_INTS] + dofs[dof * DOF_INTS + 1]
            move, turn = with_more(move, turn, k, load(work, (v_at + dof) * w, witness))
        put_triple(work, row + to * w, w, move)
        put_triple(work, row + (to + 3) * w, w, turn)


@inlined
def collected(ints, floats, dofs, count, loaded, work, dof_at, to, witness):
    """Write I = τ + Jᵀp from FORCE and TARGET as ``press`` finds them; FORCE is used up."""
    w = width(witness)
    zero = same(0.0, witness)
    for body in range(count, 0, -1):
        at = body * BODY_INTS
        parent, kind, first, size = ints[at], ints[at + 1], ints[at + 3], ints[at + 4]
        row = body * BODY * w
        f = body * BODY_FLOATS
        if not loaded[body]:
            for dof in range(first, first + size):
                store(work, (to + dof) * w, zero)
            continue
        p = triple(work, row + FORCE * w, w, witness)
        m = triple(work, row + (FORCE + 3) * w, w, witness)
        for dof in range(first, first + size):
            k = 3 * dofs[dof * DOF_INTS] + dofs[dof * DOF_INTS + 1]
            target = load(work, (dof_at + dof * DOF + TARGET) * w, witness)
            store(work, (to + dof) * w, target - along(p, m, k))
        if parent > 0:
            p, m = inwards(kind, ints[at + 8], floats, f, work, row, w, p, m, witness)
            r = offset_of(kind, floats, f, work, row, w, witness)
            above = (parent * BODY + FORCE) * w
            add_triple(work, above, w, p, witness)
            add_triple(work, above + 3 * w, w, plus(m, cross(r, p)), witness)
