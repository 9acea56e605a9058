"""From states to answers, one block of states after the other.

Where ``touch``, ``law``, ``alone`` or ``again`` is None, numba prunes what needs it before
compilation: batches of known impulses compile no contacts, those of one contact on a plane no law
of several, and those of several not the short way of one, nor what bilateral rows alone take.
Where it is not None, numba compiles both sides.
"""

from __future__ import annotations

import math

import numpy as np

from ...laws.status import Status
from ...laws.words import NEWTON, SIMULTANEOUS
from .articulated import collected, press, respond, twists
from .blows import strike, work_of_blows
from .doubt import doubted, jump_of_row
from .given import Lanes, Posed
from .held_again import begin_again, end_again, lacking_rows
from .inertia import factor, weigh
from .jit import inlined, kernel
from .kinematics import place_bodies
from .lanes import digits, width
from .layout import DOF, INVERSE, TARGET, TWIST
from .lost_digits import MORE, contact_of, lacking, press_more
from .meetings import place_meetings
from .memory import load, put, same, store
from .one_contact import solve_alone
from .refining import refine
from .rows import add_row, clear, delassus, place_terms, reduce_rows, row_velocity
from .states import is_unit, lead, seen, taken
from .written import write_contacts, write_normals

__all__ = ["solve_blocks"]

_SOLVED, _NOT_FINITE = int(Status.SOLVED), int(Status.NOT_FINITE)
_OFF = int(Status.OFF_MANIFOLD)
# Behind the spare values that a second elimination of bilateral rows tells by.
_AGAIN = 3


@kernel
def solve_blocks(span, moving, touch, meet, law, alone, again, inputs, outputs, work, witness):
    """Solve blocks of states; the last one may reach back over the one before.

    The arguments are those of ``given``, and:

    Args:
        touch: None without constraints and contacts.
        meet: for the meetings of balls, see ``balls``.
        law: see ``lawful``; None for one contact on a plane alone under Newton's law.
        alone: 1 for one contact on a plane alone under Newton's law, else None.
        again: 1 where there are bilateral rows and no contacts, else None.
        work: see ``layout``.
    """
    w, code = width(witness), span.code
    sizes, sets, at = moving.sizes, moving.sets, moving.at
    for block in range(span.begin, span.end):
        base = min(block * w, span.states - w)
        _read(moving, inputs, base, work, code, witness)
        _place(moving, inputs, base, work, witness)
        wants_twists = len(outputs.energy) > 0
        if touch is not None:
            _place_rows(moving, touch, meet, work, witness)
            wants_twists = True
        if wants_twists:
            tree = moving.tree
            twists(tree.ints, tree.floats, tree.dofs, sets.twist_list, work, at.v, TWIST, witness)
        _strike(moving, inputs, base, work, witness)
        if touch is not None:
            _free_velocities(moving, touch, work, witness)
            if alone is not None:
                _alone(moving, touch, inputs, base, work, code, witness)
            if law is not None:
                _by_law(moving, touch, law, inputs, base, work, code, witness)
            _bear(moving, touch, work, witness)
        tree = moving.tree
        respond(
            tree.ints, tree.floats, tree.dofs, sizes.bodies, sets.loaded, work, at.dof, at.dv,
            witness,
        )  # fmt: skip
        if sizes.refines:
            _act(moving, touch, inputs, base, work, witness)
            refine(tree, sets, at, work, witness)
        if touch is not None:
            if alone is not None:
                _alone_again(moving, touch, inputs, base, work, code, witness)
            if again is not None:
                _held_again(moving, touch, law, inputs, base, work, code, witness)
            if law is not None:
                _look_for_doubt(moving, touch, work, code, witness)
        _write(moving, outputs, base, work, code, witness)
        if touch is not None:
            _write_rows(moving, touch, outputs, base, work, witness)
        if len(outputs.energy) > 0:
            _write_energy(moving, touch, inputs, outputs, base, work, witness)
        if len(outputs.sum) > 0:
            _act(moving, touch, inputs, base, work, witness)
            _write_sum(moving, outputs, base, work, witness)


@inlined
def _read(moving, inputs, base, work, code, witness):
    """States into the work array, their codes, and joints that follow others."""
    w = width(witness)
    tree, sizes, at = moving.tree, moving.sizes, moving.at
    bad = same(0.0, witness)
    bad = taken(inputs.q, base, inputs.q_step, tree.q_index, tree.angles, work, at.q, bad, witness)
    bad = taken(
        inputs.v, base, inputs.v_step, tree.v_index, tree.straight, work, at.v, bad, witness
    )
    if sizes.is_part:
        bad = seen(inputs.q, base, inputs.q_step, sizes.whole_q, bad, witness)
        bad = seen(inputs.v, base, inputs.v_step, sizes.whole_v, bad, witness)
    bad = seen(inputs.given, base, inputs.given_step, sizes.columns, bad, witness)
    bad = seen(inputs.m, base, inputs.m_step, sizes.factors, bad, witness)
    store(work, at.spare * w, bad)
    for lane in range(w):
        state = base + lane
        code[lane] = inputs.codes[state]
        if code[lane] == _SOLVED:
            if work[at.spare * w + lane] != 0.0:
                code[lane] = _NOT_FINITE
            elif not is_unit(inputs.q, state * inputs.q_step, tree.units):
                code[lane] = _OFF
    lead(tree.follow, tree.ratios, work, at.q, at.v, witness)


@inlined
def _place(moving, inputs, base, work, witness):
    """Bodies, and the factor of M."""
    tree, sizes, at, loads = moving.tree, moving.sizes, moving.at, moving.loads
    place_bodies(
        tree.ints, tree.floats, sizes.bodies, moving.sets.placed, work, at.q, at.spare, witness
    )
    if len(loads[0]) > 0:
        weigh(
            tree.ints, tree.floats, loads[0], loads[1], sizes.bodies, inputs.m,
            base * inputs.m_step, inputs.m_step, work, at.loads, witness,
        )  # fmt: skip
    factor(
        tree.ints, tree.floats, tree.dofs, tree.armature, sizes.bodies, work, at.dof, at.loads,
        witness,
    )  # fmt: skip


@inlined
def _place_rows(moving, touch, meet, work, witness):
    """Where things meet, the rows, and W."""
    tree, at, rows, nv = moving.tree, moving.at, touch.rows, moving.sizes.nv
    count, balls, meetings = len(rows.first) - 1, touch.balls, touch.meetings
    place_meetings(meetings[0], meetings[1], meetings[2], work, at.meeting, witness)
    if len(balls[0]) > 0:
        meet(balls[0], balls[1], work, at.meeting, at.p + count, width(witness))
    place_terms(rows.term_ints, rows.term_floats, work, at.meeting, at.term, witness)
    reduce_rows(tree, rows, work, at, nv, witness)
    delassus(
        rows.dof_list, rows.dof_first, rows.reach_dofs, work, at.dof, at.reduced, nv, at.delassus,
        witness,
    )  # fmt: skip


@inlined
def _strike(moving, inputs, base, work, witness):
    """Known impulses, gathered towards the root."""
    tree, known = moving.tree, moving.known
    _load(moving, inputs, base, work, witness)
    if len(known.ints) + len(known.kicks) > 0:
        press(
            tree.ints, tree.floats, tree.dofs, moving.sizes.bodies, moving.sets.known_mask,
            np.int64(0), work, moving.at.dof, witness,
        )  # fmt: skip


@inlined
def _load(moving, inputs, base, work, witness):
    """Overwrite FORCE and TARGET with the known impulses."""
    at, known, sets = moving.at, moving.known, moving.sets
    zero = np.int64(0)
    clear(moving.tree.ints, sets.loaded_list, zero, len(sets.loaded_list), work, at.dof, witness)
    if len(known.ints) + len(known.kicks) > 0:
        step = inputs.given_step
        strike(
            known.ints, known.floats, known.kicks, inputs.given, base * step, step, work, at.dof,
            witness,
        )  # fmt: skip


@inlined
def _free_velocities(moving, touch, work, witness):
    """Velocities of the rows before the impact, and without impulses of their own."""
    w, at, rows, known = width(witness), moving.at, touch.rows, moving.known
    for r in range(len(rows.first) - 1):
        speed = row_velocity(
            rows.term_ints, rows.term_floats, rows.first[r], rows.first[r + 1],
            TWIST, work, at.v, at.term, witness,
        )  # fmt: skip
        store(work, (at.before + r) * w, speed)
        if len(known.ints) + len(known.kicks) > 0:
            for k in range(rows.dof_first[r], rows.dof_first[r + 1]):
                dof = (at.dof + rows.dof_list[k] * DOF) * w
                row = at.reduced + r * moving.sizes.nv + rows.dof_list[k]
                u = load(work, row * w, witness) * load(work, dof + INVERSE * w, witness)
                speed = speed + u * load(work, dof + TARGET * w, witness)
        store(work, (at.free + r) * w, speed)


@inlined
def _alone(moving, touch, inputs, base, work, code, witness):
    """One contact on a plane under Newton's law with slip at the end."""
    w, at = width(witness), moving.at
    count = len(touch.rows.first) - 1
    for lane in range(w):
        if code[lane] == _SOLVED:
            contact = contact_of(touch, inputs, base + lane)
            code[lane] = solve_alone(count, contact, at, work, w, lane, digits(witness))
        else:
            for r in range(count):
                work[(at.p + r) * w + lane] = math.nan


@inlined
def _by_law(moving, touch, law, inputs, base, work, code, witness):
    """The law of the scene on every lane."""
    at, rows, (target, keeps) = moving.at, touch.rows, touch.held
    posed = Posed(
        len(rows.first) - 1, target, keeps, rows.lever, rows.dof_first, rows.dof_list,
        touch.ints, touch.floats, inputs.q, inputs.q_step, inputs.e, inputs.e_step,
        inputs.mu, inputs.mu_step, touch.words,
    )  # fmt: skip
    lanes = Lanes(
        base, width(witness), digits(witness), work, code,
        at.delassus, at.before, at.free, at.p, at.dof, at.reduced,
    )  # fmt: skip
    law(posed, lanes)


@inlined
def _bear(moving, touch, work, witness):
    """What the rows' impulses add to what acts along each degree of freedom."""
    w, at, rows = width(witness), moving.at, touch.rows
    for r in range(len(rows.first) - 1):
        impulse = load(work, (at.p + r) * w, witness)
        for k in range(rows.dof_first[r], rows.dof_first[r + 1]):
            to = (at.dof + rows.dof_list[k] * DOF + TARGET) * w
            row = at.reduced + r * moving.sizes.nv + rows.dof_list[k]
            u = load(work, row * w, witness)
            store(work, to, load(work, to, witness) + impulse * u)


@inlined
def _act(moving, touch, inputs, base, work, witness):
    """All that acts, known impulses and those of rows, anew into FORCE and TARGET."""
    w, at = width(witness), moving.at
    _load(moving, inputs, base, work, witness)
    if touch is not None:
        rows = touch.rows
        for r in range(len(rows.first) - 1):
            add_row(
                rows.term_ints, rows.term_floats, rows.first[r], rows.first[r + 1],
                load(work, (at.p + r) * w, witness), work, at.dof, at.term, witness,
            )  # fmt: skip


@inlined
def _alone_again(moving, touch, inputs, base, work, code, witness):
    """What digits one contact has lost, where a blow alone would throw it."""
    at = moving.at
    if lacking(touch, inputs, base, at, work, code, witness):
        press_more(moving.tree, touch.rows, moving.sets, at, MORE, work, witness)


@inlined
def _held_again(moving, touch, law, inputs, base, work, code, witness):
    """Bilateral rows once more where Δv does not make their velocities."""
    at, rows = moving.at, touch.rows
    if digits(witness) == 53 and lacking_rows(rows, touch.held, at, work, code, witness):
        begin_again(rows, at, work, code, witness)
        _by_law(moving, touch, law, inputs, base, work, code, witness)
        end_again(rows, at, work, code, witness)
        press_more(moving.tree, rows, moving.sets, at, at.spare + _AGAIN, work, witness)


@inlined
def _look_for_doubt(moving, touch, work, code, witness):
    """Leave to single states what Δv does not make of the rows' velocities."""
    restitution, _, order = touch.words
    aims = 0
    if len(touch.ints) > 0:
        at_once = restitution == NEWTON and order == SIMULTANEOUS
        aims = 2 if at_once and len(touch.held[0]) > 0 else 1
    if digits(witness) == 53:
        doubted(touch.rows, touch.held, aims, moving.at, work, code, witness)


@inlined
def _write(moving, outputs, base, work, code, witness):
    """Codes, Δv and v⁺."""
    w, at, v_out = width(witness), moving.at, moving.tree.v_out
    whole = moving.sizes.whole_v
    for lane in range(w):
        outputs.codes[base + lane] = code[lane]
    for k in range(moving.sizes.nv):
        if v_out[k] >= 0:
            change = load(work, (at.dv + k) * w, witness)
            if len(outputs.dv) > 0:
                put(outputs.dv, base * whole + v_out[k], whole, change)
            if len(outputs.v) > 0:
                after = change + load(work, (at.v + k) * w, witness)
                put(outputs.v, base * whole + v_out[k], whole, after)


@inlined
def _write_rows(moving, touch, outputs, base, work, witness):
    """Impulses of rows, and of contacts."""
    w, at = width(witness), moving.at
    count = len(touch.rows.first) - 1
    if len(outputs.rows) > 0:
        for r in range(count):
            put(outputs.rows, base * count + r, count, load(work, (at.p + r) * w, witness))
    if len(outputs.contacts) > 0:
        write_contacts(
            touch.ints, touch.floats, base, at.p, at.meeting, work, outputs.contacts, witness
        )
    if len(outputs.normals) > 0:
        write_normals(touch.ints, touch.rows, base, at, work, outputs.normals, witness)


@inlined
def _write_energy(moving, touch, inputs, outputs, base, work, witness):
    """Work of all impulses: each by the mean of its velocity before and after."""
    w, at, known, step = width(witness), moving.at, moving.known, inputs.given_step
    total = work_of_blows(
        known.ints, known.floats, known.kicks, inputs.given, base * step, step, work, at.v, at.dv,
        witness,
    )  # fmt: skip
    if touch is not None:
        rows = touch.rows
        for r in range(len(rows.first) - 1):
            jump = jump_of_row(rows, r, at, work, witness)
            mean = load(work, (at.before + r) * w, witness) + 0.5 * jump
            total = total + mean * load(work, (at.p + r) * w, witness)
    put(outputs.energy, base, 1, total)


@inlined
def _write_sum(moving, outputs, base, work, witness):
    """The generalized impulse of all that acts."""
    w, tree, sizes, at = width(witness), moving.tree, moving.sizes, moving.at
    collected(
        tree.ints, tree.floats, tree.dofs, sizes.bodies, moving.sets.loaded, work, at.dof, at.sum,
        witness,
    )  # fmt: skip
    for k in range(len(tree.follow) // 3):
        leader = (at.sum + tree.follow[3 * k + 2]) * w
        share = load(work, (at.sum + tree.follow[3 * k + 1]) * w, witness)
        store(work, leader, load(work, leader, witness) + tree.ratios[2 * k] * share)
    for k in range(sizes.nv):
        if tree.v_out[k] >= 0:
            share = load(work, (at.sum + k) * w, witness)
            put(outputs.sum, base * sizes.whole_v + tree.v_out[k], sizes.whole_v, share)
