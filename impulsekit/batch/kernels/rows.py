"""Rows: directions along which constraints and contacts act, as wrenches on bodies.

A row is a sum of terms: a force along a direction at a point of a body, a couple, or a
generalized force. Its transpose maps twists to the velocity of the row. With u the reduced
right side of a row alone (``articulated.press``), the Delassus matrix is
W_rs = Σ_k u_k^r u_k^s / D_k over degrees of freedom, since M⁻¹ = L⁻ᵀ D⁻¹ L⁻¹ with
L⁻¹ Jᵀ = u (Rodriguez, Jain & Kreutz-Delgado 1991).
"""

from __future__ import annotations

import numpy as np

from ...rows import frame_pair
from .algebra import (
    add_triple,
    cross,
    dot,
    minus,
    nine,
    plus,
    put_triple,
    times,
    transposed_times,
    triple,
)
from .articulated import along, press
from .axes import inwards
from .jit import inlined
from .kinematics import offset_of
from .lanes import width
from .layout import (
    ALONG_DOF,
    BODY,
    BODY_FLOATS,
    BODY_INTS,
    COUPLE,
    DOF,
    DOF_INTS,
    FORCE,
    INVERSE,
    MEETING,
    ROTATION,
    TARGET,
    TERM,
    TERM_FLOATS,
    TERM_INTS,
)
from .memory import load, same, store

__all__ = [
    "add_row",
    "clear",
    "delassus",
    "in_body",
    "place_terms",
    "reduce_rows",
    "row_velocity",
    "turned",
    "velocity_at",
]

# The formula of all rows, on lanes.
velocity_at = inlined(frame_pair.velocity_at)


@inlined
def turned(work, row, w, x, y, z, witness):
    """A vector given in the axes that stand in the work array, in the world's."""
    return times(nine(work, row, w, witness), (x, y, z))


@inlined
def in_body(work, body, a, witness):
    """A vector given in world axes in those of a body."""
    w = width(witness)
    return transposed_times(nine(work, (body * BODY + ROTATION) * w, w, witness), a)


@inlined
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


@inlined
def place_terms(term_ints, term_floats, work, meeting_at, term_at, witness):
    """Write direction and arm of every term, in the axes of its body."""
    w = width(witness)
    for term in range(len(term_ints) // TERM_INTS):
        t = term * TERM_INTS
        kind, body, axes = term_ints[t], term_ints[t + 1], term_ints[t + 2]
        if kind == ALONG_DOF:
            continue
        f = term * TERM_FLOATS
        to = (term_at + term * TERM) * w
        x, y, z = term_floats[f + 3], term_floats[f + 4], term_floats[f + 5]
        if term_ints[t + 5] < 0 and axes == body:
            direction = (same(x, witness), same(y, witness), same(z, witness))
        else:
            source = axes * BODY + ROTATION
            if term_ints[t + 5] >= 0:
                source = meeting_at + term_ints[t + 5] * MEETING
            direction = in_body(work, body, turned(work, source * w, w, x, y, z, witness), witness)
        put_triple(work, to, w, direction)
        if kind == COUPLE:
            continue
        if term_ints[t + 4] >= 0:
            arm = triple(work, (meeting_at + term_ints[t + 4] * MEETING + 9) * w, w, witness)
            arm = in_body(work, body, arm, witness)
        else:
            x, y, z = term_floats[f], term_floats[f + 1], term_floats[f + 2]
            arm = (same(x, witness), same(y, witness), same(z, witness))
        put_triple(work, to + 3 * w, w, arm)


@inlined
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


@inlined
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
        speed = speed + dot(direction, velocity_at(triple(work, row, w, witness), turn, arm))
    return speed


@inlined
def reduce_rows(tree, rows, work, places, nv, witness):
    """Write u of every row: entry (row, dof) at ``places.reduced + row · nv + dof``."""
    w = width(witness)
    one = same(1.0, witness)
    ints, floats, dofs, dof_at = tree.ints, tree.floats, tree.dofs, places.dof
    # The world's row and those of all bodies.
    size = len(ints) // BODY_INTS
    for row in range(len(rows.first) - 1):
        begin, end = rows.first[row], rows.first[row + 1]
        if rows.alike[row] == 0:
            continue
        if rows.alike[row] == 3:
            body = rows.term_ints[begin * TERM_INTS + 1]
            at = (places.term + begin * TERM) * w
            to = places.reduced + row * nv
            _reduce_three(ints, floats, dofs, body, work, dof_at, at, to, nv, witness)
            continue
        first, last = rows.reach_first[row], rows.reach_first[row + 1]
        clear(ints, rows.reach, first, last, work, dof_at, witness)
        add_row(
            rows.term_ints, rows.term_floats, begin, end, one, work, dof_at, places.term, witness
        )
        most = np.int64(0)
        for k in range(first, last):
            most = max(most, rows.reach[k])
        press(ints, floats, dofs, most, rows.reach_mask, row * size, work, dof_at, witness)
        for k in range(rows.dof_first[row], rows.dof_first[row + 1]):
            dof = rows.dof_list[k]
            u = load(work, (dof_at + dof * DOF + TARGET) * w, witness)
            store(work, (places.reduced + row * nv + dof) * w, u)


@inlined
def _reduce_three(ints, floats, dofs, body, work, dof_at, at, to, nv, witness):
    """``reduce_rows`` for three forces at one point, inwards with nothing put down.

    Directions and arm stand from ``at`` on, term after term.
    """
    w = width(witness)
    zero = same(0.0, witness)
    nothing = (zero, zero, zero)
    arm = triple(work, at + 3 * w, w, witness)
    p0 = minus(nothing, 1.0, triple(work, at, w, witness))
    p1 = minus(nothing, 1.0, triple(work, at + TERM * w, w, witness))
    p2 = minus(nothing, 1.0, triple(work, at + 2 * TERM * w, w, witness))
    m0, m1, m2 = cross(arm, p0), cross(arm, p1), cross(arm, p2)
    while body > 0:
        i = body * BODY_INTS
        parent, kind, first, size = ints[i], ints[i + 1], ints[i + 3], ints[i + 4]
        row = body * BODY * w
        f = body * BODY_FLOATS
        for dof in range(first + size - 1, first - 1, -1):
            d = (dof_at + dof * DOF) * w
            k = 3 * dofs[dof * DOF_INTS] + dofs[dof * DOF_INTS + 1]
            u0, u1, u2 = -along(p0, m0, k), -along(p1, m1, k), -along(p2, m2, k)
            store(work, (to + dof) * w, u0)
            store(work, (to + nv + dof) * w, u1)
            store(work, (to + 2 * nv + dof) * w, u2)
            if parent == 0 and dof == first:
                break
            inverse = -load(work, d + INVERSE * w, witness)
            u0, u1, u2 = u0 * inverse, u1 * inverse, u2 * inverse
            linear, angular = triple(work, d, w, witness), triple(work, d + 3 * w, w, witness)
            p0, m0 = minus(p0, u0, linear), minus(m0, u0, angular)
            p1, m1 = minus(p1, u1, linear), minus(m1, u1, angular)
            p2, m2 = minus(p2, u2, linear), minus(m2, u2, angular)
        if parent > 0:
            turns = ints[i + 8]
            p0, m0 = inwards(kind, turns, floats, f, work, row, w, p0, m0, witness)
            p1, m1 = inwards(kind, turns, floats, f, work, row, w, p1, m1, witness)
            p2, m2 = inwards(kind, turns, floats, f, work, row, w, p2, m2, witness)
            r = offset_of(kind, floats, f, work, row, w, witness)
            m0, m1, m2 = plus(m0, cross(r, p0)), plus(m1, cross(r, p1)), plus(m2, cross(r, p2))
        body = parent


@inlined
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
