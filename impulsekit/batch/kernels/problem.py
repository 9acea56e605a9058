"""The contacts of one state: from its Delassus matrix to the impulses of all rows.

Bilateral rows come first and are eliminated (``held``), contacts see what is left,
W_cc − W_cb W_bb⁺ W_bc. What they make of it is their law's.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np

from ...laws.status import Status
from ...laws.workspace import Workspace, workspace
from ..codes import AGAIN
from .held import COARSE, bear, half_solved, hold
from .jit import built_in
from .layout import CONTACT_FLOATS, CONTACT_INTS

__all__ = ["COARSE", "Room", "pose", "problem_in", "put_back", "room"]

# As in ``impact``: q this near a limit is at it.
AT_STOP = 1e-9
# A gap this near [m] to the one up to which balls touch may be on either side of it.
NEAR_MARGIN, NEAR_MARGIN32 = 1e-11, 1e-5
# Coefficients this small are none.
NEGLIGIBLE = 1e-150
# Share of its W that a contact row keeps beside bilateral ones; below, digits are lost.
HELD_STILL = 1e-6
_SOLVED = int(Status.SOLVED)


class Room(NamedTuple):
    """The arrays that the contacts of one state take, made once for many states.

    Attributes:
        W: (3n, 3n) Delassus matrix of the contacts, bilateral rows eliminated [1/kg].
        lower, matrix: of the bilateral rows, see ``held.hold``.
        cross_held: (3n, rank) half-solved columns of the contacts.
        before, free, P: (3n,) u⁻, u_free [m/s], and the impulses [N s].
        mu, e, e_t, sign: (n,) coefficients, and the signs of the contacts' rows.
        known, rest, scale_of: of the bilateral rows, see ``held.hold``.
        row_of: the contacts, then the bilateral rows in their order, how many of these are not
            null, and their rank.
        few: how many contacts and rows ``row_of`` has before the bilateral ones.
        law: what the law of several contacts works in.
    """

    W: np.ndarray
    lower: np.ndarray
    matrix: np.ndarray
    cross_held: np.ndarray
    before: np.ndarray
    free: np.ndarray
    P: np.ndarray
    mu: np.ndarray
    e: np.ndarray
    e_t: np.ndarray
    sign: np.ndarray
    known: np.ndarray
    rest: np.ndarray
    scale_of: np.ndarray
    row_of: np.ndarray
    few: int
    law: Workspace


@built_in
def problem_in(space):
    """W (3n, 3n), u⁻, u_free (3n,), µ, e, e_t (n,), and P (3n,), which the law writes."""
    return space.W, space.before, space.free, space.mu, space.e, space.e_t, space.P


@built_in
def room(rows, contacts):
    """Room for so many rows and contacts."""
    size = max(3 * contacts, rows, 1)
    few = max(contacts, 1)
    # One array each: a slice of a larger one would be counted at every use.
    return Room(
        np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size)),
        np.zeros((size, size)),
        np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(few + rows + 2, dtype=np.int64), few, workspace(few),
    )  # fmt: skip


@built_in
def _touching(contact_ints, contact_floats, q, q_row, contact, work, gap_at, w, lane, digits):
    """0 where a stop or a ball does not touch, else the sign of its row; 2 where in doubt."""
    entry = contact_ints[contact * CONTACT_INTS + 2]
    ball = contact_ints[contact * CONTACT_INTS + 6]
    at = contact * CONTACT_FLOATS
    if ball >= 0:
        over = float(work[(gap_at + ball) * w + lane]) - contact_floats[at + 9]
        if not abs(over) > (NEAR_MARGIN if digits == 53 else NEAR_MARGIN32):
            return 2
        return 1 if over < 0.0 else 0
    if entry < 0:
        return 1
    lower, upper = contact_floats[at + 9], contact_floats[at + 10]
    x = q[q_row + entry]
    low = x - lower <= AT_STOP * max(1.0, abs(lower))
    high = upper - x <= AT_STOP * max(1.0, abs(upper))
    if low and high:
        return 2
    return 1 if low else (-1 if high else 0)


@built_in
def _counted(coefficient):
    """The same, or 0 where it would only underflow."""
    return coefficient if coefficient > NEGLIGIBLE else 0.0


@built_in
def _coefficient(contact_ints, contact_floats, contact, given, approach):
    """e at an approach speed: what is given, 0 below the capture speed, or from a table."""
    first = contact_ints[contact * CONTACT_INTS + 4]
    last = first + contact_ints[contact * CONTACT_INTS + 5] - 1
    if last < first:
        return given if approach >= contact_floats[contact * CONTACT_FLOATS + 12] else 0.0
    values = last - first + 1
    if approach <= contact_floats[first]:
        return contact_floats[first + values]
    for k in range(first, last):
        if approach < contact_floats[k + 1]:
            low, high = contact_floats[k + values], contact_floats[k + 1 + values]
            slope = (high - low) / (contact_floats[k + 1] - contact_floats[k])
            return slope * (approach - contact_floats[k]) + low
    return contact_floats[last + values]


@built_in
def pose(
    state, lane, rows, target, keeping, contact_ints, contact_floats, given, digits,
    work, w_at, before_at, free_at, w, code, space,
):  # fmt: skip
    """Write the problem of one lane into ``space``; how many contacts touch.

    0 where the law has nothing to do, -1 where the state was bad before; ``code`` tells.

    Args:
        state: the state that stands in the lane.
        rows: how many.
        target, keeping: of the bilateral ones, velocities they are brought to, and what
            ``held.hold`` wants besides.
        given: (array, stride) of q, restitution and friction.
        digits: binary digits of the numbers in ``work``.
        w_at, before_at, free_at: where W, u⁻ and u_free stand in ``work``.
        w: how many lanes there are.
    """
    if code[lane] != _SOLVED:
        return np.int64(-1)
    (q, q_step), (e, e_step), (mu, mu_step) = given
    q_row, e_row, mu_row, held = state * q_step, state * e_step, state * mu_step, len(target)
    W, before, free, mus, es, ets, _ = problem_in(space)
    lower, cross_held, matrix, row_of = space.lower, space.cross_held, space.matrix, space.row_of
    sign, known, rest, scale_of = space.sign, space.known, space.rest, space.scale_of
    # np.int64(0), for with a 0 numba would compile all that takes it once more.
    count = np.int64(0)
    for contact in range(len(contact_ints) // CONTACT_INTS):
        # Behind the velocities stand the impulses, and behind these the gaps.
        side = _touching(
            contact_ints, contact_floats, q, q_row, contact, work, free_at + 2 * rows, w, lane,
            digits,
        )  # fmt: skip
        if side == 2:
            code[lane] = AGAIN
            return np.int64(0)
        if side != 0:
            row_of[count] = contact
            sign[count] = side
            mus[count] = 0.0
            if contact_ints[contact * CONTACT_INTS + 1] == 3:
                mus[count] = _counted(mu[mu_row + contact])
            count += 1
    # The rows of the contacts, three each, without friction the normal alone.
    size = 3 * count
    for i in range(size):
        r = _row(contact_ints, row_of, i)
        s = sign[i // 3]
        before[i] = 0.0 if r < 0 else s * work[(before_at + r) * w + lane]
        free[i] = 0.0 if r < 0 else s * work[(free_at + r) * w + lane]
        for j in range(i + 1):
            c = _row(contact_ints, row_of, j)
            value = 0.0
            if r >= 0 and c >= 0:
                value = s * sign[j // 3] * work[(w_at + r * rows + c) * w + lane]
            W[i, j] = value
            W[j, i] = value
    for k in range(count):
        contact = row_of[k]
        approach = max(-before[3 * k + 2], 0.0)
        given = e[e_row + contact]
        es[k] = _counted(_coefficient(contact_ints, contact_floats, contact, given, approach))
        ets[k] = contact_floats[contact * CONTACT_FLOATS + 11]
    if held == 0:
        return count
    at = space.few
    rank = hold(
        rows, target, keeping, digits, work, w_at, before_at, free_at, w, lane,
        matrix, lower, known, scale_of, row_of, at,
    )  # fmt: skip
    if rank < 0:
        code[lane] = AGAIN
        return np.int64(0)
    row_of[at + held + 1] = rank
    # Half-solved columns of the contacts, for W and for what the rows bear.
    for j in range(size):
        c = _row(contact_ints, row_of, j)
        for k in range(rank):
            cross_held[j, k] = 0.0
        if c >= 0:
            half_solved(rows, rank, c, work, w_at, w, lane, lower, scale_of, row_of, at, rest)
            for k in range(rank):
                cross_held[j, k] = sign[j // 3] * rest[k]
                free[j] += cross_held[j, k] * known[k]
    for i in range(size):
        alone = W[i, i]
        for j in range(size):
            for k in range(rank):
                W[i, j] -= cross_held[i, k] * cross_held[j, k]
        # What the bilateral rows nearly hold still is left with few digits.
        matters = i % 3 == 2 or mus[i // 3] > 0.0
        if matters and alone > 0.0 and not W[i, i] > HELD_STILL * alone:
            code[lane] = AGAIN
            return np.int64(0)
    return count


@built_in
def put_back(lane, count, rows, held, contact_ints, work, p_at, w, code, space):
    """Write the impulses of all rows of one lane, of which ``count`` contacts touch."""
    total = 0.0
    for k in range(3 * count):
        total += space.P[k]
    if not math.isfinite(total):
        code[lane] = AGAIN
    if count < 0 or code[lane] == AGAIN:
        for r in range(rows):
            work[(p_at + r) * w + lane] = math.nan if count < 0 else 0.0
        return
    lower, cross_held, matrix, row_of = space.lower, space.cross_held, space.matrix, space.row_of
    sign, known, rest, scale_of, P = (
        space.sign, space.known, space.rest, space.scale_of, space.P,
    )  # fmt: skip
    size = 3 * count
    for r in range(held, rows):
        work[(p_at + r) * w + lane] = 0.0
    if held > 0:
        at = space.few
        rank = row_of[at + held + 1]
        for k in range(rank):
            rest[k] = 0.0
            for j in range(size):
                rest[k] += cross_held[j, k] * P[j]
        bear(
            held, rank, known, rest, lower, scale_of, row_of, at, matrix, work, p_at, w, lane
        )  # fmt: skip
    for j in range(size):
        c = _row(contact_ints, row_of, j)
        if c >= 0:
            work[(p_at + c) * w + lane] = sign[j // 3] * P[j]


@built_in
def _row(contact_ints, row_of, i):
    """The row behind entry i of the contacts' own vectors; -1 where there is none."""
    contact = row_of[i // 3] * CONTACT_INTS
    first = contact_ints[contact]
    if contact_ints[contact + 1] == 3:
        return first + i % 3
    return first if i % 3 == 2 else -1
