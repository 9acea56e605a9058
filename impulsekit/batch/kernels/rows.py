"""Rows: directions along which constraints and contacts act, as wrenches on bodies.

A row is a sum of terms: a force along a direction at a point of a body, a couple, or a
generalized force. Its transpose maps twists to the velocity of the row. With u the reduced
right side of a row alone (``articulated.press``), the Delassus matrix is
W_rs = Σ_k u_k^r u_k^s / D_k over degrees of freedom, since M⁻¹ = L⁻ᵀ D⁻¹ L⁻¹ with
L⁻¹ Jᵀ = u (Rodriguez, Jain & Kreutz-Delgado 1991).
"""

from __future__ import annotations

import numpy as np

from .algebra import add_triple, cross, dot, minus, plus, put_triple, times, triple
from .articulated import press
from .jit import built_in
from .lanes import width
from .layout import (
    ALONG_DOF,
    BODY,
    BODY_INTS,
    COUPLE,
    DOF,
    FORCE,
    INVERSE,
    MEETING,
    TARGET,
    TERM,
    TERM_FLOATS,
    TERM_INTS,
)
from .memory import load, same, store

__all__ = ["add_row", "clear", "delassus", "place_terms", "reduce_rows", "row_velocity", "turned"]


@built_in
def turned(work, row, w, x, y, z, witness):
    """A vector given in the axes that stand in the work array, in the world's."""
    first = triple(work, row, w, witness)
    second = triple(work, row + 3 * w, w, witness)
    third = triple(work, row + 6 * w, w, witness)
    return times(first + second + third, (x, y, z))


@built_in
def clear(ints, bodies, begin, end, work, dof_at, witness):
    """Set FORCE and TARGET of some of the bodies listed to zero."""
    w = width(witness)
    zero = same(0.0, witness)
    for k in range(begin, end):
        body = bodies[k]
        row = (body * BODY + FORCE) * w
        put_triple(work, row, w, (zero, zero, zero))
        put_triple(work, row + 3 * w, w, (zero, zero, zero))
        first = ints[body * BODY_INTS + 3]
        for dof in range(first, first + ints[body * BODY_INTS + 4]):
            store(work, (dof_at + dof * DOF + TARGET) * w, zero)


@built_in
def place_terms(term_ints, term_floats, work, meeting_at, term_at, witness):
    """Write direction and arm of every term, in world axes."""
    w = width(witness)
    for term in range(len(term_ints) // TERM_INTS):
        t = term * TERM_INTS
        kind, body, axes = term_ints[t], term_ints[t + 1], term_ints[t + 2]
        if kind == ALONG_DOF:
            continue
        f = term * TERM_FLOATS
        to = (term_at + term * TERM) * w
        source = axes * BODY
        if term_ints[t + 5] >= 0:
            source = meeting_at + term_ints[t + 5] * MEETING
        x, y, z = term_floats[f + 3], term_floats[f + 4], term_floats[f + 5]
        put_triple(work, to, w, turned(work, source * w, w, x, y, z, witness))
        if kind == COUPLE:
            continue
        if term_ints[t + 4] >= 0:
            arm = triple(work, (meeting_at + term_ints[t + 4] * MEETING + 9) * w, w, witness)
        else:
            x, y, z = term_floats[f], term_floats[f + 1], term_floats[f + 2]
            arm = turned(work, body * BODY * w, w, x, y, z, witness)
        put_triple(work, to + 3 * w, w, arm)


@built_in
def add_row(term_ints, term_floats, begin, end, factor, work, dof_at, term_at, witness):
    """Add ``factor`` times a row's wrenches to FORCE (with its sign) and TARGET."""
    w = width(witness)
    for term in range(begin, end):
        kind, body = term_ints[term * TERM_INTS], term_ints[term * TERM_INTS + 1]
        if kind == ALONG_DOF:
            target = (dof_at + term_ints[term * TERM_INTS + 3] * DOF + TARGET) * w
            share = factor * term_floats[term * TERM_FLOATS + 3]
            store(work, target, load(work, target, witness) + share)
            continue
        zero = same(0.0, witness)
        at = (term_at + term * TERM) * w
        direction = minus((zero, zero, zero), factor, triple(work, at, w, witness))
        row = (body * BODY + FORCE) * w
        if kind == COUPLE:
            add_triple(work, row + 3 * w, w, direction, witness)
            continue
        add_triple(work, row, w, direction, witness)
        arm = triple(work, at + 3 * w, w, witness)
        add_triple(work, row + 3 * w, w, cross(arm, direction), witness)


@built_in
def row_velocity(term_ints, term_floats, begin, end, twist, work, v_at, term_at, witness):
    """The velocity of a row; ``twist`` says which twists of the bodies, ``v_at`` which v."""
    w = width(witness)
    speed = same(0.0, witness)
    for term in range(begin, end):
        kind, body = term_ints[term * TERM_INTS], term_ints[term * TERM_INTS + 1]
        if kind == ALONG_DOF:
            own = load(work, (v_at + term_ints[term * TERM_INTS + 3]) * w, witness)
            speed = speed + term_floats[term * TERM_FLOATS + 3] * own
            continue
        at = (term_at + term * TERM) * w
        direction = triple(work, at, w, witness)
        row = (body * BODY + twist) * w
        turn = triple(work, row + 3 * w, w, witness)
        if kind == COUPLE:
            speed = speed + dot(direction, turn)
            continue
        arm = triple(work, at + 3 * w, w, witness)
        speed = speed + dot(direction, plus(triple(work, row, w, witness), cross(turn, arm)))
    return speed


@built_in
def reduce_rows(
    ints, dofs, count, term_ints, term_floats, row_first, reach, reach_first, reach_mask,
    dof_list, dof_first, work, dof_at, term_at, reduced_at, nv, witness,
):  # fmt: skip
    """Write u of every row: entry (row, dof) at ``reduced_at + row · nv + dof``.

    Args:
        row_first: where the terms of each row begin.
        reach, reach_first: the bodies that each row passes through.
        reach_mask: (rows · (bodies + 1),) the same as a mask.
        dof_list, dof_first: the degrees of freedom of those bodies, rising.
    """
    w = width(witness)
    one = same(1.0, witness)
    for row in range(len(row_first) - 1):
        clear(ints, reach, reach_first[row], reach_first[row + 1], work, dof_at, witness)
        add_row(
            term_ints, term_floats, row_first[row], row_first[row + 1], one,
            work, dof_at, term_at, witness,
        )  # fmt: skip
        last = np.int64(0)
        for k in range(reach_first[row], reach_first[row + 1]):
            last = max(last, reach[k])
        press(
            ints, dofs, last, reach_mask, row * (count + 1), work, dof_at, witness
        )  # fmt: skip
        for k in range(dof_first[row], dof_first[row + 1]):
            dof = dof_list[k]
            u = load(work, (dof_at + dof * DOF + TARGET) * w, witness)
            store(work, (reduced_at + row * nv + dof) * w, u)


@built_in
def delassus(dof_list, dof_first, reach_dofs, work, dof_at, reduced_at, nv, to, witness):
    """Write W (rows, rows), both halves; ``reach_dofs`` (rows · nv,) says where u is not 0."""
    w = width(witness)
    rows = len(dof_first) - 1
    for r in range(rows):
        for s in range(r + 1):
            total = same(0.0, witness)
            for k in range(dof_first[r], dof_first[r + 1]):
                dof = dof_list[k]
                if reach_dofs[s * nv + dof]:
                    total = total + load(work, (reduced_at + r * nv + dof) * w, witness) * load(
                        work, (dof_at + dof * DOF + INVERSE) * w, witness
                    ) * load(work, (reduced_at + s * nv + dof) * w, witness)
            store(work, (to + r * rows + s) * w, total)
            store(work, (to + s * rows + r) * w, total)
