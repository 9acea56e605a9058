"""The bilateral rows of one state: eliminated before the contacts, paid after them.

λ = W⁺ (u_wanted − u_free − W_bc P), W the Delassus matrix of the bilateral rows, scaled to
unit diagonal. Rows that depend on others, or move nothing, are set aside by pivoted QR of the
half-solved rows C, W = Cᵀ C, as ``impact.elimination`` does by singular values; what these rows
bear is then the λ of least scaled norm. Where rounding could have a say in which rows these
are, the state is left to the solver of single states.
"""

from __future__ import annotations

import math

import numpy as np

from ...laws.dense import cholesky, lower_solve
from ...laws.rank_tolerances import (
    COARSE,
    EXACT_NULL_ROW,
    EXACT_RANK,
    GOOD_PIVOT,
    IDLE,
    LIVE_ROW,
    SHORT_ROW,
)
from ...laws.tolerances import CLEAR
from .jit import built_in, uncounted
from .layout import DOF, INVERSE

__all__ = ["bear", "half_solve", "hold"]


@built_in
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


@built_in
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
        left = matrix[0, i] * scale_of[i]
        for j in range(rank):
            left -= matrix[1 + k - rank, j] * known[j]
        if abs(left) > IDLE * speed * scale_of[i]:
            return False
    return True


@built_in
def _ranked(live, lane, posed, lanes, space):
    """The rank of the live rows, ``order`` with the rows that count first; -1 in doubt.

    C P = Q R by Gram and Schmidt, each column once more; L = Rᵀ. A row that is set aside is
    R₁⁻¹ R₂ of the others.
    """
    first, listed, work, w = posed.first, posed.listed, lanes.work, lanes.w
    matrix, lower, order, at = space.matrix, space.lower, space.row_of, space.few
    scale_of, nv = space.scale_of, len(posed.lever) // posed.rows
    half = np.zeros((live, nv))
    upper = np.zeros((live, live))
    for k in range(live):
        row = order[at + k]
        for m in range(first[row], first[row + 1]):
            dof = listed[m]
            inverse = float(work[(lanes.dof + dof * DOF + INVERSE) * w + lane])
            u = float(work[(lanes.reduced + row * nv + dof) * w + lane])
            half[k, dof] = scale_of[row] * math.sqrt(inverse) * u
    rank = live
    for k in range(live):
        best, longest = k, -1.0
        for i in range(k, live):
            size = 0.0
            for dof in range(nv):
                size += half[i, dof] * half[i, dof]
            if size > longest:
                best, longest = i, size
        length = math.sqrt(longest)
        if length <= EXACT_RANK:
            rank = k
            break
        if not length * length > CLEAR:
            return -1
        if best != k:
            order[at + k], order[at + best] = order[at + best], order[at + k]
            for dof in range(nv):
                half[k, dof], half[best, dof] = half[best, dof], half[k, dof]
            for j in range(k):
                upper[j, k], upper[j, best] = upper[j, best], upper[j, k]
        # Once more against those before, for what subtracting left of them.
        for j in range(k):
            along = 0.0
            for dof in range(nv):
                along += half[j, dof] * half[k, dof]
            upper[j, k] += along
            for dof in range(nv):
                half[k, dof] -= along * half[j, dof]
        size = 0.0
        for dof in range(nv):
            size += half[k, dof] * half[k, dof]
        length = math.sqrt(size)
        upper[k, k] = length
        for dof in range(nv):
            half[k, dof] /= length
        for i in range(k + 1, live):
            along = 0.0
            for dof in range(nv):
                along += half[k, dof] * half[i, dof]
            upper[k, i] = along
            for dof in range(nv):
                half[i, dof] -= along * half[k, dof]
    for k in range(rank):
        for j in range(k + 1):
            lower[k, j] = upper[j, k]
    for i in range(rank, live):
        for k in range(rank - 1, -1, -1):
            total = upper[k, i]
            for j in range(k + 1, rank):
                total -= upper[k, j] * matrix[1 + i - rank, j]
            matrix[1 + i - rank, k] = total / upper[k, k]
    return rank


@built_in
def half_solve(lane, row, rank, posed, lanes, space):
    """Write L⁻¹ W of the rows that count, for another row, into ``rest``."""
    order, scale_of, rest, at = space.row_of, space.scale_of, space.rest, space.few
    work, rows = lanes.work, posed.rows
    for k in range(rank):
        i = order[at + k]
        rest[k] = float(work[(lanes.delassus + i * rows + row) * lanes.w + lane]) * scale_of[i]
    lower_solve(space.lower, rank, rest)


@built_in
def bear(lane, rank, count, lanes, space):
    """Write λ of all ``count`` bilateral rows; ``rest`` (rank,) is L⁻¹ W_bc P, used up."""
    across, known, lower, matrix = space.rest, space.known, space.lower, space.matrix
    order, scale_of, at, work = space.row_of, space.scale_of, space.few, lanes.work
    for k in range(rank - 1, -1, -1):
        total = known[k] - across[k]
        for j in range(k + 1, rank):
            total -= lower[j, k] * across[j]
        across[k] = total / lower[k, k]
    for i in range(count):
        work[(lanes.p + i) * lanes.w + lane] = 0.0
    live = order[at + count]
    if live > rank:
        _spread(rank, live - rank, across, matrix)
    for k in range(live):
        i = order[at + k]
        value = across[k] if k < rank else matrix[0, k - rank]
        work[(lanes.p + i) * lanes.w + lane] = scale_of[i] * value


@built_in
def _spread(rank, others, x, matrix):
    """x (rank,) of the rows that count, and of the others in ``matrix[0]``, of least norm.

    (x, 0) less what lies in the null space, whose columns are (−Sᵀ, 1): with G = 1 + S Sᵀ
    the others get z = G⁻¹ S x, and x loses Sᵀ z.
    """
    gram = np.zeros((others, others))
    factor = np.zeros((others, others))
    z = np.zeros(others)
    for i in range(others):
        for j in range(i + 1):
            total = 1.0 if i == j else 0.0
            for k in range(rank):
                total += matrix[1 + i, k] * matrix[1 + j, k]
            gram[i, j] = total
        for k in range(rank):
            z[i] += matrix[1 + i, k] * x[k]
    cholesky(gram, others, factor)
    lower_solve(factor, others, z)
    for i in range(others - 1, -1, -1):
        total = z[i]
        for k in range(i + 1, others):
            total -= factor[k, i] * z[k]
        z[i] = total / factor[i, i]
    for k in range(rank):
        for i in range(others):
            x[k] -= matrix[1 + i, k] * z[i]
    for i in range(others):
        matrix[0, i] = z[i]
