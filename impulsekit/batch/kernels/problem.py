"""The contacts of one state: from its Delassus matrix to the impulses of all rows.

Bilateral rows come first and are eliminated (``held``), contacts see what is left,
W_cc − W_cb W_bb⁺ W_bc. What they make of it is their law's.
"""

from __future__ import annotations

import functools
import math
from typing import NamedTuple

import numpy as np

from ...geometry.gaps import before_limit, is_closed
from ...laws.groups import few_of, find_groups, line_of, members_of, square_of, worse
from ...laws.rank_tolerances import WITH_FEW_DIGITS
from ...laws.status import Status
from ...laws.tolerances import NEGLIGIBLE
from ..codes import AGAIN, OPEN
from .held import bear, half_solve, hold
from .jit import built_in, uncounted
from .layout import CONTACT_FLOATS, CONTACT_INTS, FAINTEST
from .left import is_faint

__all__ = ["Room", "lanes_under", "problem_in"]

# A gap this near [m] to the one up to which balls touch may be on either side of it.
NEAR_MARGIN, NEAR_MARGIN32 = 1e-11, 1e-5
_SOLVED = int(Status.SOLVED)


class Room(NamedTuple):
    """The arrays that the contacts of one state take, made once for many states.

    Attributes:
        W: (3n, 3n) Delassus matrix of the contacts, bilateral rows eliminated [1/kg].
        lower, matrix: of the bilateral rows, see ``held.hold``.
        cross_held: (3n, rank) half-solved columns of the contacts.
        half, factor: of bilateral rows that depend on each other, see ``laws.bilateral``.
        before, free, P: (3n,) u⁻, u_free [m/s], and the impulses [N s].
        mu, e, e_t, sign: (n,) coefficients, and the signs of the contacts' rows.
        known, rest, scale_of: of the bilateral rows, see ``held.hold``.
        row_of: the contacts, then the bilateral rows in their order, how many of these are not
            null, and their rank.
        few: how many contacts and rows ``row_of`` has before the bilateral ones.
        group, queue, chosen: (contacts,) for ``laws.groups``.
    """

    W: np.ndarray
    lower: np.ndarray
    matrix: np.ndarray
    cross_held: np.ndarray
    half: np.ndarray
    factor: np.ndarray
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
    group: np.ndarray
    queue: np.ndarray
    chosen: np.ndarray


def lanes_under(memory, solved, is_held, in_turn):
    """The function that ``solve_blocks`` is handed: a law on every lane of a block.

    Args:
        memory: what the law works in besides a ``Room``, by the number of contacts.
        solved: the code, with P of the contacts that touch, of whom there is one at least, in
            ``space``, by their number, ``given.Posed``, digits, ``space`` and the memory.
        is_held: whether there are bilateral rows; where not, nothing of them is compiled.
        in_turn: whether contacts act one after the other; at once each group of contacts that
            ``laws.groups`` finds is solved by itself.
    """
    solve = solved if in_turn else _by_groups(solved)
    pose, put_back = _posing(is_held), _putting(is_held)

    def lanes_of_law(posed, lanes):
        contacts = len(posed.ints) // CONTACT_INTS
        rows, held = posed.rows, len(posed.target)
        nv = len(posed.lever) // max(rows, 1)
        space, own, code = _room(rows, contacts, held, nv), memory(contacts), lanes.code
        for lane in range(lanes.w):
            count = pose(lane, posed, lanes, space)
            if count > 0:
                code[lane] = solve(count, posed, lanes.digits, space, own)
            put_back(lane, count, posed, lanes, space)

    return lanes_of_law


@built_in
def problem_in(space):
    """W (3n, 3n), u⁻, u_free (3n,), µ, e, e_t (n,), and P (3n,), which the law writes."""
    return space.W, space.before, space.free, space.mu, space.e, space.e_t, space.P


def _by_groups(solved):
    """``solved`` for each group of contacts by itself."""

    @built_in
    def solve(count, posed, digits, space, own):
        group, chosen, groups = space.group, space.chosen, np.int64(1)
        if count > 1:
            groups = find_groups(space.W, space.mu, count, group, space.queue)
        code = np.int64(_SOLVED)
        for number in range(groups):
            part, some = space, count
            if groups > 1:
                some = members_of(group, count, number, chosen)
                part = _part_of(space, chosen, some)
            code = _joined(code, solved(some, posed, digits, part, own))
            if code == AGAIN:
                break
            if groups > 1:
                for k in range(3 * some):
                    space.P[3 * chosen[k // 3] + k % 3] = part.P[k]
        return code

    return solve


@built_in
def _part_of(space, chosen, count):
    """The problem of the first ``count`` chosen contacts, in a room of its own."""
    few = np.empty(count, np.int64)
    for k in range(count):
        few[k] = space.row_of[chosen[k]]
    # Bilateral rows are eliminated by now.
    none, nothing = np.empty((0, 0)), np.empty(0)
    return Room(
        square_of(space.W, chosen, count), none, none, none, none, none,
        line_of(space.before, chosen, count), line_of(space.free, chosen, count),
        np.zeros(3 * count),
        few_of(space.mu, chosen, count), few_of(space.e, chosen, count),
        few_of(space.e_t, chosen, count), few_of(space.sign, chosen, count),
        nothing, nothing, nothing, few, count, few, few, few,
    )  # fmt: skip


@built_in
def _joined(code, other):
    """The worse of two codes, with the worse of what is open of them."""
    if code == AGAIN or other == AGAIN:
        return np.int64(AGAIN)
    return max(code // OPEN, other // OPEN) * OPEN + worse(code % OPEN, other % OPEN)


@built_in
def _room(rows, contacts, held, nv):
    """Room for so many rows, of which some are bilateral, and contacts, of so many speeds."""
    size = max(3 * contacts, rows, 1)
    few = max(contacts, 1)
    # One array each: a slice of a larger one would be counted at every use.
    return Room(
        np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size)),
        np.zeros((size, size)), np.empty((held, nv)), np.empty((held, held)),
        np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(few + rows + 2, dtype=np.int64), few,
        np.zeros(few, np.int64), np.zeros(few, np.int64), np.zeros(few, np.int64),
    )  # fmt: skip


@uncounted
def _touching(lane, contact, posed, lanes):
    """0 where a stop or a ball does not touch, else the sign of its row; 2 where in doubt."""
    entry = posed.ints[contact * CONTACT_INTS + 2]
    ball = posed.ints[contact * CONTACT_INTS + 6]
    floats, at = posed.floats, contact * CONTACT_FLOATS
    if ball >= 0:
        # Behind the free velocities stand the impulses, and behind these the gaps.
        gap = lanes.free + 2 * posed.rows + ball
        over = float(lanes.work[gap * lanes.w + lane]) - floats[at + 9]
        if not abs(over) > (NEAR_MARGIN if lanes.digits == 53 else NEAR_MARGIN32):
            return 2
        return 1 if over < 0.0 else 0
    if entry < 0:
        return 1
    lower, upper = floats[at + 9], floats[at + 10]
    x = posed.q[(lanes.base + lane) * posed.q_step + entry]
    low = is_closed(before_limit(x, lower, 1.0), lower)
    high = is_closed(before_limit(x, upper, -1.0), upper)
    if low and high:
        return 2
    return 1 if low else (-1 if high else 0)


@uncounted
def _counted(coefficient):
    """The same, or 0 where it would only underflow."""
    return coefficient if coefficient > NEGLIGIBLE else 0.0


@uncounted
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


@functools.cache
def _posing(is_held):
    """The function that writes the problem of one lane into ``space``; how many contacts touch.

    It gives 0 where the law has nothing to do, -1 where the state was bad before; the code tells.
    """

    @built_in
    def pose(lane, posed, lanes, space):
        if lanes.code[lane] != _SOLVED:
            return np.int64(-1)
        count = _gather(lane, posed, lanes, space)
        is_open = count < 0
        if is_held:
            is_open = is_open or not _eliminate(lane, count, posed, lanes, space)
        if is_open:
            lanes.code[lane] = AGAIN
            return np.int64(0)
        return count

    return pose


@uncounted
def _gather(lane, posed, lanes, space):
    """Who touches, how many, with W, velocities and coefficients; -1 in doubt."""
    ints, state, row_of, sign, mus = (
        posed.ints, lanes.base + lane, space.row_of, space.sign, space.mu,
    )  # fmt: skip
    W, before, free, work, w, rows = (
        space.W, space.before, space.free, lanes.work, lanes.w, posed.rows,
    )  # fmt: skip
    # np.int64(0), for with a 0 numba would compile all that takes it once more.
    count = np.int64(0)
    for contact in range(len(ints) // CONTACT_INTS):
        side = _touching(lane, contact, posed, lanes)
        if side == 2:
            return np.int64(-1)
        if side != 0:
            row_of[count] = contact
            sign[count] = side
            mus[count] = 0.0
            if ints[contact * CONTACT_INTS + 1] == 3:
                mus[count] = _counted(posed.mu[state * posed.mu_step + contact])
            count += 1
    # The rows of the contacts, three each, without friction the normal alone.
    for i in range(3 * count):
        r = _row(ints, row_of, i)
        s = sign[i // 3]
        before[i] = 0.0 if r < 0 else s * work[(lanes.before + r) * w + lane]
        free[i] = 0.0 if r < 0 else s * work[(lanes.free + r) * w + lane]
        for j in range(i + 1):
            c = _row(ints, row_of, j)
            value = 0.0
            if r >= 0 and c >= 0:
                value = s * sign[j // 3] * work[(lanes.delassus + r * rows + c) * w + lane]
            W[i, j] = value
            W[j, i] = value
    for k in range(count):
        contact = row_of[k]
        approach = max(-before[3 * k + 2], 0.0)
        given = posed.e[state * posed.e_step + contact]
        space.e[k] = _counted(_coefficient(ints, posed.floats, contact, given, approach))
        at = contact * CONTACT_FLOATS
        space.e_t[k] = posed.floats[at + 11]
        n = 3 * k + 2
        slip = W[n - 2, n - 2] + W[n - 1, n - 1] if mus[k] > 0.0 else 0.0
        if is_faint(W[n, n], slip, posed.floats[at + FAINTEST], lanes.digits):
            return np.int64(-1)
    return count


@built_in
def _eliminate(lane, count, posed, lanes, space):
    """Take the bilateral rows out of W and u_free; whether enough digits are left."""
    rank = hold(lane, posed, lanes, space)
    if rank < 0:
        return False
    W, free, sign, known, rest = space.W, space.free, space.sign, space.known, space.rest
    cross_held, row_of, mus, size = space.cross_held, space.row_of, space.mu, 3 * count
    row_of[space.few + len(posed.target) + 1] = rank
    # Half-solved columns of the contacts, for W and for what the rows bear.
    for j in range(size):
        c = _row(posed.ints, row_of, j)
        for k in range(rank):
            cross_held[j, k] = 0.0
        if c >= 0:
            half_solve(lane, c, rank, posed, lanes, space)
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
        if matters and alone > 0.0 and not W[i, i] > WITH_FEW_DIGITS * alone:
            return False
    return True


@functools.cache
def _putting(is_held):
    """The function that writes the impulses of all rows of one lane.

    Its arguments are those of ``pose``, and of how many contacts it told that they touch.
    """

    @built_in
    def put_back(lane, count, posed, lanes, space):
        code, work, w, P = lanes.code, lanes.work, lanes.w, space.P
        held, size = len(posed.target), 3 * count
        total = 0.0
        for k in range(size):
            total += P[k]
        if not math.isfinite(total):
            code[lane] = AGAIN
        if count < 0 or code[lane] == AGAIN:
            for r in range(posed.rows):
                work[(lanes.p + r) * w + lane] = math.nan if count < 0 else 0.0
            return
        for r in range(held, posed.rows):
            work[(lanes.p + r) * w + lane] = 0.0
        if is_held:
            cross_held, rest = space.cross_held, space.rest
            rank = space.row_of[space.few + held + 1]
            for k in range(rank):
                rest[k] = 0.0
                for j in range(size):
                    rest[k] += cross_held[j, k] * P[j]
            bear(lane, rank, held, lanes, space)
        for j in range(size):
            c = _row(posed.ints, space.row_of, j)
            if c >= 0:
                work[(lanes.p + c) * w + lane] = space.sign[j // 3] * P[j]

    return put_back


@uncounted
def _row(contact_ints, row_of, i):
    """The row behind entry i of the contacts' own vectors; -1 where there is none."""
    contact = row_of[i // 3] * CONTACT_INTS
    first = contact_ints[contact]
    if contact_ints[contact + 1] == 3:
        return first + i % 3
    return first if i % 3 == 2 else -1
