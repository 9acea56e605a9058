"""Rows: directions along which constraints and contacts act, as wrenches on bodies.

A row is a sum of terms: a force along a direction at a point of a body, a couple, or a
generalized force. Its transpose maps twists to the velocity of the row. With u the reduced
right side of a row alone (``articulated.press``), the Delassus matrix is
W_rs = Σ_k u_k^r u_k^s / D_k over degrees of freedom, since M⁻¹ = L⁻ᵀ D⁻¹ L⁻¹ with
L⁻¹ Jᵀ = u (Rodriguez, Jain & Kreutz-Delgado 1991).
"""

from __future__ import annotations

from numba import njit

from .algebra import add_triple, cross, dot, minus, plus, put_triple, times, triple
from .articulated import press
from .lanes import load, same, store, width
from .layout import (
    BODY,
    BODY_INTS,
    COUPLE,
    DOF,
    FORCE,
    FORCE_AT,
    INVERSE,
    TARGET,
    TERM_FLOATS,
    TERM_INTS,
)

__all__ = ["add_row", "clear", "delassus", "reduce_rows", "row_velocity"]


@njit(cache=True, nogil=True)
def _turned(work, body, w, x, y, z, witness):
    """A vector given in a body's axes, in the world's."""
    row = body * BODY * w
    first = triple(work, row, w, witness)
    second = triple(work, row + 3 * w, w, witness)
    third = triple(work, row + 6 * w, w, witness)
    return times(first + second + third, (x, y, z))


@njit(cache=True, nogil=True)
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


@njit(cache=True, nogil=True)
def add_row(term_ints, term_floats, begin, end, factor, work, dof_at, witness):
    """Add ``factor`` times a row's wrenches to FORCE (with its sign) and TARGET."""
    w = width(witness)
    for term in range(begin, end):
        kind, body, axes, dof = (
            term_ints[term * TERM_INTS],
            term_ints[term * TERM_INTS + 1],
            term_ints[term * TERM_INTS + 2],
            term_ints[term * TERM_INTS + 3],
        )
        f = term * TERM_FLOATS
        if kind != FORCE_AT and kind != COUPLE:
            target = (dof_at + dof * DOF + TARGET) * w
            store(work, target, load(work, target, witness) + factor * term_floats[f + 3])
            continue
        direction = _turned(
            work, axes, w, term_floats[f + 3], term_floats[f + 4], term_floats[f + 5], witness
        )
        zero = same(0.0, witness)
        direction = minus((zero, zero, zero), factor, direction)
        row = (body * BODY + FORCE) * w
        if kind == COUPLE:
            add_triple(work, row + 3 * w, w, direction, witness)
            continue
        arm = _turned(
            work, body, w, term_floats[f], term_floats[f + 1], term_floats[f + 2], witness
        )
        add_triple(work, row, w, direction, witness)
        add_triple(work, row + 3 * w, w, cross(arm, direction), witness)


@njit(cache=True, nogil=True)
def row_velocity(term_ints, term_floats, begin, end, twist, work, v_at, witness):
    """The velocity of a row; ``twist`` says which twists of the bodies, ``v_at`` which v."""
    w = width(witness)
    speed = same(0.0, witness)
    for term in range(begin, end):
        kind, body, axes, dof = (
            term_ints[term * TERM_INTS],
            term_ints[term * TERM_INTS + 1],
            term_ints[term * TERM_INTS + 2],
            term_ints[term * TERM_INTS + 3],
        )
        f = term * TERM_FLOATS
        if kind != FORCE_AT and kind != COUPLE:
            speed = speed + term_floats[f + 3] * load(work, (v_at + dof) * w, witness)
            continue
        direction = _turned(
            work, axes, w, term_floats[f + 3], term_floats[f + 4], term_floats[f + 5], witness
        )
        row = (body * BODY + twist) * w
        turn = triple(work, row + 3 * w, w, witness)
        if kind == COUPLE:
            speed = speed + dot(direction, turn)
            continue
        arm = _turned(
            work, body, w, term_floats[f], term_floats[f + 1], term_floats[f + 2], witness
        )
        move = plus(triple(work, row, w, witness), cross(turn, arm))
        speed = speed + dot(direction, move)
    return speed


@njit(cache=True, nogil=True)
def reduce_rows(
    ints, dofs, count, term_ints, term_floats, row_first, reach, reach_first, reach_mask,
    dof_list, dof_first, work, dof_at, reduced_at, nv, witness,
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
            term_ints, term_floats, row_first[row], row_first[row + 1], one, work, dof_at, witness
        )
        last = 0
        for k in range(reach_first[row], reach_first[row + 1]):
            last = max(last, reach[k])
        press(
            ints, dofs, last, reach_mask, row * (count + 1), work, dof_at, witness
        )  # fmt: skip
        for k in range(dof_first[row], dof_first[row + 1]):
            dof = dof_list[k]
            u = load(work, (dof_at + dof * DOF + TARGET) * w, witness)
            store(work, (reduced_at + row * nv + dof) * w, u)


@njit(cache=True, nogil=True)
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
