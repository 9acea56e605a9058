"""The bilateral rows of one state: eliminated before the contacts, paid after them.

λ = W⁺ (u_wanted − u_free − W_bc P), W the Delassus matrix of the bilateral rows, scaled to
unit diagonal. Rows that depend on others are set aside and share as ``laws.bilateral`` has it.
Where rounding could have a say in which rows these are, or which move nothing, the state is left
to the solver of single states.
"""

from __future__ import annotations

import math

from ...laws.bilateral import find_rank, is_implied, spread
from ...laws.dense import cholesky, lower_solve, upper_solve
from ...laws.rank_tolerances import (
    COARSE,
    EXACT_NULL_ROW,
    GOOD_PIVOT,
    IDLE,
    LIVE_ROW,
    SHORT_ROW,
)
from .jit import uncounted
from .layout import DOF, INVERSE

__all__ = ["bear", "half_solve", "hold"]


@uncounted
def hold(lane, posed, lanes, space):
    """Factor the bilateral rows and half-solve what they want; how many count, -1 in doubt.

    Args:
        lane: of which state. posed, lanes: see ``given``.
        space: a ``problem.Room``. Its ``lower`` (L) and ``known`` (L⁻¹ r) of the rows that
            count, in their order, and ``scale_of`` every row are kept for ``bear``; so is in
            ``matrix`` from its second row on what a row that is set aside is of those. From
            ``few`` on ``row_of`` has the rows that count, dependent ones, null ones, and how
            many are not null.
    """
    live, short = _told_apart(lane, posed, lanes, space)
    if live < 0:
        return -1
    rank = _factored(live, short, lane, posed, lanes, space)
    if rank < 0 or not _can_have(rank, live, lane, posed, lanes, space):
        return -1
    lower_solve(space.lower, rank, space.known)
    space.row_of[space.few + len(posed.target)] = live
    return rank


@uncounted
def _told_apart(lane, posed, lanes, space):
    """How many rows are live, and whether one is short; -1 in doubt. Null ones come last."""
    lever, first, listed, work, w = posed.lever, posed.first, posed.listed, lanes.work, lanes.w
    scale_of, order, at, rows = space.scale_of, space.row_of, space.few, posed.rows
    count = len(posed.target)
    nv = len(lever) // rows
    live = 0
    short = False
    null = count
    for i in range(count):
        own = float(work[(lanes.delassus + i * rows + i) * w + lane])
        gross = 0.0
        for k in range(first[i], first[i + 1]):
            dof = listed[k]
            size = lever[i * nv + dof]
            gross += size * size * float(work[(lanes.dof + dof * DOF + INVERSE) * w + lane])
        if own > LIVE_ROW * gross:
            scale_of[i] = 1.0 / math.sqrt(own)
            order[at + live] = i
            live += 1
            short |= own < SHORT_ROW * gross
        elif lanes.digits == 53 and own <= EXACT_NULL_ROW * gross:
            scale_of[i] = 0.0
            null -= 1
            order[at + null] = i
        else:
            return -1, False
    return live, short


@uncounted
def _factored(live, short, lane, posed, lanes, space):
    """The rank of the live rows, with their L; -1 in doubt."""
    matrix, scale_of, order, at = space.matrix, space.scale_of, space.row_of, space.few
    work, rows = lanes.work, posed.rows
    for k in range(live):
        i = order[at + k]
        for j in range(k):
            other = order[at + j]
            value = float(work[(lanes.delassus + i * rows + other) * lanes.w + lane])
            matrix[k, j] = value * scale_of[i] * scale_of[other]
        matrix[k, k] = 1.0
    good = GOOD_PIVOT if lanes.digits == 53 else COARSE
    if cholesky(matrix, live, space.lower) > good:
        return live
    if lanes.digits < 53:
        return -1
    rank = _ranked(live, lane, posed, lanes, space)
    # Short rows bear by the length of their vectors, which is not known here.
    return -1 if short and rank < live else rank


@uncounted
def _can_have(rank, live, lane, posed, lanes, space):
    """Whether the rows can have what they want, which of those that count ``known`` gets."""
    target, keeps, work, w = posed.target, posed.keeps, lanes.work, lanes.w
    matrix, known, order, at = space.matrix, space.known, space.row_of, space.few
    scale_of, count = space.scale_of, len(target)
    speed = 0.0
    for i in range(count):
        before = float(work[(lanes.before + i) * w + lane])
        wanted = before if keeps[i] else target[i]
        free = float(work[(lanes.free + i) * w + lane])
        speed = max(speed, abs(wanted), abs(free), abs(before))
        # By row; in the order of the rows that count only from here on.
        matrix[0, i] = wanted - free
    for k in range(rank):
        known[k] = matrix[0, order[at + k]] * scale_of[order[at + k]]
    for k in range(live, count):
        # A row of no effect cannot change its velocity.
        if abs(matrix[0, order[at + k]]) > IDLE * speed:
            return False
    for k in range(rank, live):
        i = order[at + k]
        wanted, share = matrix[0, i] * scale_of[i], matrix[1 + k - rank]
        if not is_implied(wanted, share, known, rank, speed * scale_of[i]):
            return False
    return True


@uncounted
def _ranked(live, lane, posed, lanes, space):
    """As ``find_rank`` tells it: the rows that count come first, and the others' shares of them."""
    first, listed, work, w = posed.first, posed.listed, lanes.work, lanes.w
    order, at, scale_of = space.row_of, space.few, space.scale_of
    nv = len(posed.lever) // posed.rows
    half = space.half
    for k in range(live):
        row = order[at + k]
        for dof in range(nv):
            half[k, dof] = 0.0
        for m in range(first[row], first[row + 1]):
            dof = listed[m]
            inverse = float(work[(lanes.dof + dof * DOF + INVERSE) * w + lane])
            u = float(work[(lanes.reduced + row * nv + dof) * w + lane])
            half[k, dof] = scale_of[row] * math.sqrt(inverse) * u
    return find_rank(half[:live], order[at : at + live], space.lower, space.matrix[1:])


@uncounted
def half_solve(lane, row, rank, posed, lanes, space):
    """Write L⁻¹ W of the rows that count, for another row, into ``rest``."""
    order, scale_of, rest, at = space.row_of, space.scale_of, space.rest, space.few
    work, rows = lanes.work, posed.rows
    for k in range(rank):
        i = order[at + k]
        rest[k] = float(work[(lanes.delassus + i * rows + row) * lanes.w + lane]) * scale_of[i]
    lower_solve(space.lower, rank, rest)


@uncounted
def bear(lane, rank, count, lanes, space):
    """Write λ of all ``count`` bilateral rows; ``rest`` (rank,) is L⁻¹ W_bc P, used up."""
    across, known, matrix = space.rest, space.known, space.matrix
    order, scale_of, at, work = space.row_of, space.scale_of, space.few, lanes.work
    for k in range(rank):
        across[k] = known[k] - across[k]
    upper_solve(space.lower, rank, across)
    for i in range(count):
        work[(lanes.p + i) * lanes.w + lane] = 0.0
    live = order[at + count]
    if live > rank:
        spread(rank, matrix[1:], across, matrix[0, : live - rank], space.factor)
    for k in range(live):
        i = order[at + k]
        value = across[k] if k < rank else matrix[0, k - rank]
        work[(lanes.p + i) * lanes.w + lane] = scale_of[i] * value
