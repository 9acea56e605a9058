"""From states to answers, one block of states after the other."""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..codes import RowStatus
from .algebra import times
from .articulated import collected, press, respond, twists
from .blows import strike, work_of_blows
from .inertia import factor
from .kinematics import place_bodies
from .lanes import collect, load, put, same, store, width
from .law import room, solve_alone, solve_state
from .layout import BODY, CONTACT_FLOATS, CONTACT_INTS, DOF, INVERSE, TARGET, TWIST
from .rows import add_row, clear, delassus, reduce_rows, row_velocity

__all__ = ["solve_blocks", "work_size"]

UNIT_TOLERANCE = 1e-6
_SOLVED, _NOT_FINITE = int(RowStatus.SOLVED), int(RowStatus.NOT_FINITE)
_OFF = int(RowStatus.OFF_MANIFOLD)


@njit(cache=True, nogil=True)
def _offsets(bodies, nq, nv, rows):
    """Where in the work array degrees of freedom, vectors and rows begin, in values."""
    dof_at = BODY * (bodies + 1)
    q_at = dof_at + DOF * nv
    v_at = q_at + nq
    dv_at = v_at + nv
    sum_at = dv_at + nv
    spare_at = sum_at + nv
    reduced_at = spare_at + 2
    w_at = reduced_at + rows * nv
    before_at = w_at + rows * rows
    free_at = before_at + rows
    p_at = free_at + rows
    return (
        dof_at, q_at, v_at, dv_at, sum_at, spare_at,
        reduced_at, w_at, before_at, free_at, p_at, p_at + rows,
    )  # fmt: skip


@njit(cache=True, nogil=True)
def work_size(bodies, nq, nv, rows, witness):
    """How many floats the work array needs."""
    return _offsets(bodies, nq, nv, rows)[11] * width(witness)


@njit(cache=True, nogil=True)
def _taken(source, base, step, columns, whole, work, to, bad, witness):
    """Bring columns of a flat array into the work array; ``bad`` becomes NaN in lanes that
    hold a NaN or an infinity, in any column of the whole row."""
    w = width(witness)
    for k in range(len(columns)):
        value = collect(source, base * step + columns[k], step, witness)
        bad = bad + value * 0.0
        store(work, (to + k) * w, value)
    if len(columns) < whole and step > 0:
        for k in range(whole):
            bad = bad + collect(source, base * step + k, step, witness) * 0.0
    return bad


@njit(cache=True, nogil=True)
def _is_unit(q, q_row, units):
    """Whether the unit vectors of one configuration are of unit length."""
    for k in range(0, len(units), 2):
        total = 0.0
        for entry in range(q_row + units[k], q_row + units[k] + units[k + 1]):
            total += q[entry] * q[entry]
        if not abs(math.sqrt(total) - 1.0) <= UNIT_TOLERANCE:
            return False
    return True


@njit(cache=True, nogil=True)
def solve_blocks(
    begin, end, states, tree, sizes, sets, known, rows, held, contacts, inputs, outputs,
    work, witness,
):  # fmt: skip
    """Solve the blocks ``begin`` to ``end``; the last one may reach back over the one before.

    Args:
        states: how many there are in all, at least as many as go side by side.
        tree: ints, floats, dofs, entries of q and of v in the whole vectors, units.
        sizes: bodies, nq, nv of the tree; nq, nv of the whole robot; columns of ``given``.
        sets: mask and list of loaded bodies, mask of those that known impulses load,
            bodies whose twist before the impact is wanted.
        known: ints and floats of blows, kicks.
        rows: tables for ``rows.reduce_rows``.
        held: target velocities of the bilateral rows, and which keep their own.
        contacts: ints and floats.
        inputs: (array, stride) of q, v, given, restitution, friction, flat; a stride of 0
            gives all states the same. Codes to begin with.
        outputs: dv, v_after, generalized impulse, contact impulses, row impulses, energy
            change (each empty where it is not wanted), codes.
    """
    ints, floats, dofs, q_index, v_index, units = tree
    bodies, nq, nv, whole_q, whole_v, columns = sizes
    loaded, loaded_list, known_mask, twist_list = sets
    blow_ints, blow_floats, kicks = known
    term_ints, term_floats, row_first, reach, reach_first, reach_mask = rows[:6]
    dof_list, dof_first, reach_dofs = rows[6:]
    target, keeps = held
    contact_ints, contact_floats = contacts
    q, q_step, v, v_step, given, g_step, e, e_step, mu, mu_step, start_codes = inputs
    out_dv, out_v, out_sum, out_contacts, out_rows, out_energy, codes = outputs
    count = len(row_first) - 1
    contact_count = len(contact_ints) // CONTACT_INTS
    w = width(witness)
    (
        dof_at, q_at, v_at, dv_at, sum_at, spare_at,
        reduced_at, w_at, before_at, free_at, p_at, _,
    ) = _offsets(bodies, nq, nv, count)  # fmt: skip
    has_known = len(blow_ints) + len(kicks) > 0
    space = room(count, contact_count)
    found, roots = np.zeros((4, 2)), np.zeros(4)
    alone = contact_count == 1 and len(target) == 0 and contact_ints[2] < 0
    code = np.zeros(w, dtype=np.int8)
    for block in range(begin, end):
        base = min(block * w, states - w)
        bad = _taken(q, base, q_step, q_index, whole_q, work, q_at, same(0.0, witness), witness)
        bad = _taken(v, base, v_step, v_index, whole_v, work, v_at, bad, witness)
        if g_step > 0:
            for k in range(columns):
                bad = bad + collect(given, base * g_step + k, g_step, witness) * 0.0
        store(work, spare_at * w, bad)
        for lane in range(w):
            state = base + lane
            code[lane] = start_codes[state]
            if code[lane] == _SOLVED:
                if work[spare_at * w + lane] != 0.0:
                    code[lane] = _NOT_FINITE
                elif not _is_unit(q, state * q_step, units):
                    code[lane] = _OFF
        place_bodies(ints, floats, bodies, work, q_at, spare_at, witness)
        factor(ints, floats, dofs, bodies, work, dof_at, witness)
        if count > 0:
            reduce_rows(
                ints, dofs, bodies, term_ints, term_floats, row_first, reach, reach_first,
                reach_mask, dof_list, dof_first, work, dof_at, reduced_at, nv, witness,
            )  # fmt: skip
            delassus(dof_list, dof_first, reach_dofs, work, dof_at, reduced_at, nv, w_at, witness)
        if count > 0 or len(out_energy) > 0:
            twists(ints, dofs, twist_list, work, v_at, TWIST, witness)
        clear(ints, loaded_list, 0, len(loaded_list), work, dof_at, witness)
        if has_known:
            strike(
                blow_ints, blow_floats, kicks, given, base * g_step, g_step, work, dof_at, witness
            )
            press(ints, dofs, bodies, known_mask, 0, work, dof_at, witness)
        if count > 0:
            for r in range(count):
                speed = row_velocity(
                    term_ints, term_floats, row_first[r], row_first[r + 1],
                    TWIST, work, v_at, witness,
                )  # fmt: skip
                store(work, (before_at + r) * w, speed)
                if has_known:
                    for k in range(dof_first[r], dof_first[r + 1]):
                        dof = (dof_at + dof_list[k] * DOF) * w
                        u = load(work, (reduced_at + r * nv + dof_list[k]) * w, witness)
                        u = u * load(work, dof + INVERSE * w, witness)
                        speed = speed + u * load(work, dof + TARGET * w, witness)
                store(work, (free_at + r) * w, speed)
            for lane in range(w):
                state = base + lane
                if code[lane] == _SOLVED and alone:
                    code[lane] = solve_alone(
                        count, contact_floats[12], contact_floats[11], e[state * e_step],
                        mu[state * mu_step], work, w_at, before_at, free_at, p_at, w, lane,
                        found, roots,
                    )  # fmt: skip
                elif code[lane] == _SOLVED:
                    code[lane] = solve_state(
                        count, len(target), target, keeps, contact_ints, contact_floats,
                        q, state * q_step, e, state * e_step, mu, state * mu_step,
                        work, w_at, before_at, free_at, p_at, w, lane, space,
                    )  # fmt: skip
                else:
                    for r in range(count):
                        work[(p_at + r) * w + lane] = math.nan
            for r in range(count):
                impulse = load(work, (p_at + r) * w, witness)
                for k in range(dof_first[r], dof_first[r + 1]):
                    at = (dof_at + dof_list[k] * DOF + TARGET) * w
                    u = load(work, (reduced_at + r * nv + dof_list[k]) * w, witness)
                    store(work, at, load(work, at, witness) + impulse * u)
        for lane in range(w):
            codes[base + lane] = code[lane]
        respond(ints, dofs, bodies, loaded, work, dof_at, dv_at, witness)
        if len(out_dv) > 0:
            for k in range(nv):
                change = load(work, (dv_at + k) * w, witness)
                put(out_dv, base * whole_v + v_index[k], whole_v, change)
        if len(out_v) > 0:
            for k in range(nv):
                after = load(work, (dv_at + k) * w, witness) + load(work, (v_at + k) * w, witness)
                put(out_v, base * whole_v + v_index[k], whole_v, after)
        if len(out_rows) > 0:
            for r in range(count):
                put(out_rows, base * count + r, count, load(work, (p_at + r) * w, witness))
        if len(out_contacts) > 0:
            _write_contacts(
                contact_ints, contact_floats, q, base, q_step, p_at, work, out_contacts, witness
            )
        if len(out_energy) > 0:
            total = work_of_blows(
                blow_ints, blow_floats, kicks, given, base * g_step, g_step,
                work, v_at, dv_at, witness,
            )  # fmt: skip
            for r in range(count):
                mean = load(work, (before_at + r) * w, witness)
                mean = 0.5 * (mean + load(work, (free_at + r) * w, witness))
                for s in range(count):
                    share = load(work, (w_at + r * count + s) * w, witness)
                    mean = mean + 0.5 * share * load(work, (p_at + s) * w, witness)
                total = total + mean * load(work, (p_at + r) * w, witness)
            put(out_energy, base, 1, total)
        if len(out_sum) > 0:
            clear(ints, loaded_list, 0, len(loaded_list), work, dof_at, witness)
            if has_known:
                strike(
                    blow_ints, blow_floats, kicks, given, base * g_step, g_step,
                    work, dof_at, witness,
                )  # fmt: skip
            for r in range(count):
                add_row(
                    term_ints, term_floats, row_first[r], row_first[r + 1],
                    load(work, (p_at + r) * w, witness), work, dof_at, witness,
                )  # fmt: skip
            collected(ints, dofs, bodies, loaded, work, dof_at, sum_at, witness)
            for k in range(nv):
                share = load(work, (sum_at + k) * w, witness)
                put(out_sum, base * whole_v + v_index[k], whole_v, share)


@njit(cache=True, nogil=True)
def _write_contacts(ints, floats, q, base, q_step, p_at, work, out, witness):
    """Contact impulses in world axes; of a stop, along its coordinate, in the first entry."""
    w = width(witness)
    count = len(ints) // CONTACT_INTS
    zero = same(0.0, witness)
    for contact in range(count):
        first, size, entry = ints[3 * contact], ints[3 * contact + 1], ints[3 * contact + 2]
        at = base * 3 * count + 3 * contact
        if entry >= 0:
            put(out, at, 3 * count, load(work, (p_at + first) * w, witness))
            put(out, at + 1, 3 * count, zero)
            put(out, at + 2, 3 * count, zero)
            continue
        p1, p2 = zero, zero
        if size == 3:
            p1 = load(work, (p_at + first) * w, witness)
            p2 = load(work, (p_at + first + 1) * w, witness)
        f = contact * CONTACT_FLOATS
        axes = (
            floats[f], floats[f + 1], floats[f + 2], floats[f + 3], floats[f + 4],
            floats[f + 5], floats[f + 6], floats[f + 7], floats[f + 8],
        )  # fmt: skip
        impulse = times(axes, (p1, p2, load(work, (p_at + first + size - 1) * w, witness)))
        put(out, at, 3 * count, impulse[0])
        put(out, at + 1, 3 * count, impulse[1])
        put(out, at + 2, 3 * count, impulse[2])
