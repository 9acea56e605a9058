"""From states to answers, one block of states after the other."""

from __future__ import annotations

import math

import numpy as np

from ...laws.status import Status
from ...laws.words import NEWTON, SIMULTANEOUS
from .articulated import collected, press, respond, twists
from .blows import strike, work_of_blows
from .doubt import doubted
from .held_again import begin_again, end_again, lacking_rows
from .inertia import factor, weigh
from .jit import inlined, kernel
from .kinematics import place_bodies
from .lanes import digits, width
from .layout import (
    BODY,
    CONTACT_INTS,
    DOF,
    FORCE,
    INVERSE,
    JUMP,
    TARGET,
    TWIST,
)
from .lost_digits import lacking, press_more
from .meetings import place_meetings
from .memory import load, put, same, store
from .one_contact import solve_alone
from .refining import refine
from .rows import add_row, clear, delassus, place_terms, reduce_rows, row_velocity
from .states import is_unit, lead, seen, taken
from .written import write_contacts

__all__ = ["solve_blocks"]

_SOLVED, _NOT_FINITE = int(Status.SOLVED), int(Status.NOT_FINITE)
_OFF = int(Status.OFF_MANIFOLD)


@kernel
def solve_blocks(
    begin, end, states, tree, sizes, places, sets, known, loads, rows, meetings, balls,
    meet, held, contacts, law, words, inputs, outputs, work, code, witness,
):  # fmt: skip
    """Solve the blocks ``begin`` to ``end``; the last one may reach back over the one before.

    Args:
        states: how many there are in all, at least as many as go side by side.
        tree: ints, floats, dofs, armature; entries of q and of v in the whole vectors, and of v
            where they are written (-1: nowhere); which entries of q and of v are angles; unit
            vectors in q; joints that follow others: entry of q, degree of freedom and that
            of the leader; their ratios and offsets.
        sizes: bodies, nq, nv of the tree; nq, nv of the whole robot; columns of ``given``
            and of the factors on masses; whether the tree is but a part of the robot; whether
            Δv is refined, for which all bodies have to count as loaded.
        places: see ``layout.places``.
        sets: mask and list of loaded bodies, mask of those that known impulses load,
            bodies whose twist before the impact is wanted, mask of those that have to do
            with the world's axes.
        known: ints and floats of blows, kicks.
        loads: ints and floats of the links whose masses vary.
        rows: tables for ``rows.reduce_rows``.
        meetings: tables for ``meetings.place_meetings``.
        balls: tables for ``meet``, see ``balls``.
        held: target velocities of the bilateral rows, and which keep their own.
        contacts: ints and floats.
        law: see ``lawful``; called unless there is one contact on a plane alone.
        words: of the law, see ``words``, and whether that is so.
        inputs: (array, stride) of q, v, given, restitution, friction, factors on masses,
            flat; a stride of 0 gives all states the same. Codes to begin with.
        outputs: dv, v_after, generalized impulse, contact impulses, row impulses, energy
            change (each empty where it is not wanted), codes.
        work: see ``layout``.
        code: (lanes,) those of a block, while it is solved.
    """
    (
        ints, floats, dofs, armature,
        q_index, v_index, v_out, angles, straight, units, follow, ratios,
    ) = tree  # fmt: skip
    bodies, _, nv, whole_q, whole_v, columns, factors, is_part, refines = sizes
    (
        dof_at, q_at, v_at, dv_at, sum_at, spare_at, reduced_at,
        w_at, before_at, free_at, p_at, loads_at, meeting_at, term_at, _,
    ) = places  # fmt: skip
    loaded, loaded_list, known_mask, twist_list, placed = sets
    blow_ints, blow_floats, kicks = known
    load_ints, load_floats = loads
    term_ints, term_floats, row_first, alike, reach, reach_first, reach_mask = rows[:7]
    dof_list, dof_first, reach_dofs, lever = rows[7:]
    meeting_ints, meeting_floats, ways = meetings
    ball_ints, ball_floats = balls
    target, keeps = held
    contact_ints, contact_floats = contacts
    q, q_step, v, v_step, given, g_step, e, e_step, mu, mu_step, m, m_step, start_codes = inputs
    out_dv, out_v, out_sum, out_contacts, out_rows, out_energy, codes = outputs
    count = len(row_first) - 1
    contact_count = len(contact_ints) // CONTACT_INTS
    w = width(witness)
    has_known = len(blow_ints) + len(kicks) > 0
    restitution, slip, order, alone = words
    at_once = contact_count > 0 and len(target) > 0
    at_once = at_once and restitution == NEWTON and order == SIMULTANEOUS
    zero = np.int64(0)
    for block in range(begin, end):
        base = min(block * w, states - w)
        bad = same(0.0, witness)
        bad = taken(q, base, q_step, q_index, angles, work, q_at, bad, witness)
        bad = taken(v, base, v_step, v_index, straight, work, v_at, bad, witness)
        if is_part:
            bad = seen(q, base, q_step, whole_q, bad, witness)
            bad = seen(v, base, v_step, whole_v, bad, witness)
        bad = seen(given, base, g_step, columns, bad, witness)
        bad = seen(m, base, m_step, factors, bad, witness)
        store(work, spare_at * w, bad)
        for lane in range(w):
            state = base + lane
            code[lane] = start_codes[state]
            if code[lane] == _SOLVED:
                if work[spare_at * w + lane] != 0.0:
                    code[lane] = _NOT_FINITE
                elif not is_unit(q, state * q_step, units):
                    code[lane] = _OFF
        lead(follow, ratios, work, q_at, v_at, witness)
        place_bodies(ints, floats, bodies, placed, work, q_at, spare_at, witness)
        if len(load_ints) > 0:
            weigh(
                ints, floats, load_ints, load_floats, bodies, m, base * m_step, m_step,
                work, loads_at, witness,
            )  # fmt: skip
        factor(ints, floats, dofs, armature, bodies, work, dof_at, loads_at, witness)
        if count > 0:
            place_meetings(meeting_ints, meeting_floats, ways, work, meeting_at, witness)
            if len(ball_ints) > 0:
                meet(ball_ints, ball_floats, work, meeting_at, p_at + count, w)
            place_terms(term_ints, term_floats, work, meeting_at, term_at, witness)
            reduce_rows(
                ints, floats, dofs, bodies, term_ints, term_floats, row_first, alike, reach,
                reach_first, reach_mask, dof_list, dof_first, work, dof_at, term_at, reduced_at,
                nv, witness,
            )  # fmt: skip
            delassus(dof_list, dof_first, reach_dofs, work, dof_at, reduced_at, nv, w_at, witness)
        if count > 0 or len(out_energy) > 0:
            twists(ints, floats, dofs, twist_list, work, v_at, TWIST, witness)
        clear(ints, loaded_list, zero, len(loaded_list), work, dof_at, witness)
        if has_known:
            strike(
                blow_ints, blow_floats, kicks, given, base * g_step, g_step, work, dof_at, witness
            )
            press(ints, floats, dofs, bodies, known_mask, zero, work, dof_at, witness)
        if count > 0:
            for r in range(count):
                speed = row_velocity(
                    term_ints, term_floats, row_first[r], row_first[r + 1],
                    TWIST, work, v_at, term_at, witness,
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
                if code[lane] == _SOLVED and alone == 1:
                    code[lane] = solve_alone(
                        count, contact_floats[12], contact_floats[11], e[state * e_step],
                        mu[state * mu_step], work, w_at, before_at, free_at, p_at, w, lane,
                        digits(witness),
                    )  # fmt: skip
                elif alone == 1:
                    for r in range(count):
                        work[(p_at + r) * w + lane] = math.nan
            if alone == 0:
                law(
                    base, count, target, (keeps, lever, dof_first, dof_list, dof_at, reduced_at),
                    contact_ints, contact_floats,
                    ((q, q_step), (e, e_step), (mu, mu_step)), (restitution, slip, order),
                    digits(witness),
                    work, w_at, before_at, free_at, p_at, w, code,
                )  # fmt: skip
            for r in range(count):
                impulse = load(work, (p_at + r) * w, witness)
                for k in range(dof_first[r], dof_first[r + 1]):
                    at = (dof_at + dof_list[k] * DOF + TARGET) * w
                    u = load(work, (reduced_at + r * nv + dof_list[k]) * w, witness)
                    store(work, at, load(work, at, witness) + impulse * u)
        respond(ints, floats, dofs, bodies, loaded, work, dof_at, dv_at, witness)
        if refines:
            clear(ints, loaded_list, zero, len(loaded_list), work, dof_at, witness)
            _act(
                known, rows, count, has_known, given, base * g_step, g_step, work, p_at, dof_at,
                term_at, witness,
            )  # fmt: skip
            refine(
                ints, floats, dofs, armature, bodies, loaded, loaded_list, work, dof_at, dv_at,
                sum_at, loads_at, witness,
            )  # fmt: skip
        more_at = BODY + FORCE
        if (
            count > 0 and alone == 1 and lacking(
                count, contact_floats[12], contact_floats[11], e, base * e_step, e_step,
                mu, base * mu_step, mu_step, term_ints, term_floats, row_first,
                work, w_at, before_at, free_at, p_at, dv_at, term_at, spare_at, more_at, w, code,
                witness,
            )
        ):  # fmt: skip
            press_more(
                ints, floats, dofs, bodies, loaded, count, dof_list, dof_first, work, dof_at,
                reduced_at, nv, p_at, more_at, dv_at, sum_at, witness,
            )  # fmt: skip
        if (
            count > 0 and contact_count == 0 and digits(witness) == 53 and lacking_rows(
                count, term_ints, term_floats, row_first, work, before_at, dv_at, term_at,
                spare_at, held, w, code, witness,
            )
        ):  # fmt: skip
            begin_again(
                count, term_ints, term_floats, row_first, work, before_at, free_at, p_at, dv_at,
                term_at, spare_at, w, code, witness,
            )  # fmt: skip
            law(
                base, count, target, (keeps, lever, dof_first, dof_list, dof_at, reduced_at),
                contact_ints, contact_floats,
                ((q, q_step), (e, e_step), (mu, mu_step)), (restitution, slip, order),
                digits(witness),
                work, w_at, before_at, free_at, p_at, w, code,
            )  # fmt: skip
            end_again(count, work, free_at, p_at, spare_at, w, code, witness)
            press_more(
                ints, floats, dofs, bodies, loaded, count, dof_list, dof_first, work, dof_at,
                reduced_at, nv, p_at, spare_at + 3, dv_at, sum_at, witness,
            )  # fmt: skip
        if count > 0 and alone == 0 and digits(witness) == 53:
            doubted(
                count, term_ints, term_floats, row_first, work, w_at, before_at, free_at, p_at,
                dv_at, term_at, spare_at, w, code, held, contact_count > 0, at_once, witness,
            )  # fmt: skip
        for lane in range(w):
            codes[base + lane] = code[lane]
        for k in range(nv):
            if v_out[k] >= 0:
                change = load(work, (dv_at + k) * w, witness)
                if len(out_dv) > 0:
                    put(out_dv, base * whole_v + v_out[k], whole_v, change)
                if len(out_v) > 0:
                    after = change + load(work, (v_at + k) * w, witness)
                    put(out_v, base * whole_v + v_out[k], whole_v, after)
        if len(out_rows) > 0:
            for r in range(count):
                put(out_rows, base * count + r, count, load(work, (p_at + r) * w, witness))
        if len(out_contacts) > 0:
            write_contacts(
                contact_ints, contact_floats, base, p_at, meeting_at, work, out_contacts, witness
            )
        if len(out_energy) > 0:
            total = work_of_blows(
                blow_ints, blow_floats, kicks, given, base * g_step, g_step,
                work, v_at, dv_at, witness,
            )  # fmt: skip
            for r in range(count):
                jump = row_velocity(
                    term_ints, term_floats, row_first[r], row_first[r + 1],
                    JUMP, work, dv_at, term_at, witness,
                )  # fmt: skip
                mean = load(work, (before_at + r) * w, witness) + 0.5 * jump
                total = total + mean * load(work, (p_at + r) * w, witness)
            put(out_energy, base, 1, total)
        if len(out_sum) > 0:
            clear(ints, loaded_list, zero, len(loaded_list), work, dof_at, witness)
            _act(
                known, rows, count, has_known, given, base * g_step, g_step, work, p_at, dof_at,
                term_at, witness,
            )  # fmt: skip
            collected(ints, floats, dofs, bodies, loaded, work, dof_at, sum_at, witness)
            for k in range(len(follow) // 3):
                leader = (sum_at + follow[3 * k + 2]) * w
                share = ratios[2 * k] * load(work, (sum_at + follow[3 * k + 1]) * w, witness)
                store(work, leader, load(work, leader, witness) + share)
            for k in range(nv):
                if v_out[k] >= 0:
                    share = load(work, (sum_at + k) * w, witness)
                    put(out_sum, base * whole_v + v_out[k], whole_v, share)


@inlined
def _act(
    known, rows, count, has_known, given, at, stride, work, p_at, dof_at, term_at, witness
):  # fmt: skip
    """Add all that acts, known impulses and those of rows, to FORCE and TARGET."""
    w = width(witness)
    blow_ints, blow_floats, kicks = known
    term_ints, term_floats, row_first = rows[:3]
    if has_known:
        strike(blow_ints, blow_floats, kicks, given, at, stride, work, dof_at, witness)
    for r in range(count):
        add_row(
            term_ints, term_floats, row_first[r], row_first[r + 1],
            load(work, (p_at + r) * w, witness), work, dof_at, term_at, witness,
        )  # fmt: skip
