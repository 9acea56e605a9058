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
from .jit import built_in
from .layout import DOF, INVERSE

__all__ = ["COARSE", "bear", "half_solved", "hold"]

# Pivots of W below the first lose digits that those of C keep, whose squares they are; below
# the second rounding could have a say in the rank, as in ``impact.elimination``.
GOOD_PIVOT, SAFE_PIVOT = 1e-2, 1e-6
# The same in single precision, whose doubts are solved again in double.
COARSE = 1e-4
# A row whose W is this share of that of its terms is live; a zero; all between is in doubt.
LIVE_ROW, NULL_ROW = 1e-12, 1e-28
# A live row this short may be one axis of a longer vector.
SHORT_ROW = 1e-4
# What stands out of the span of other rows by less is rounding; from 1e-3 on it is not.
IN_SPAN = 1e-14
# What rows that are set aside may want beside the others, over the speeds at hand.
IDLE = 2e-14


@built_in
def hold(
    rows, target, held, digits, work, w_at, before_at, free_at, w, lane,
    matrix, lower, known, scale_of, order, at,
):  # fmt: skip
    """Factor the bilateral rows and half-solve what they want; how many count, -1 in doubt.

    Args:
        rows: how many, the bilateral ones first.
        target: (count,) velocities that these are brought to.
        held: (count,) whether they keep their own; (rows · nv,) the size of the terms of each
            row by degree of freedom; where a row's part of a list begins, and that list, of
            the degrees of freedom it passes through; where in ``work`` these, and u, stand.
        matrix, lower, known, scale_of: room. ``lower`` (L) and ``known`` (L⁻¹ r) of the rows
            that count, in their order, and the scale of every row are kept for ``bear``; so is
            in ``matrix`` from its second row on what a row that is set aside is of those.
        order: from ``at`` on the rows that count, dependent ones, null ones, and how many
            are not null.
    """
    keeps, lever, first, listed, dof_at, _ = held
    count = len(target)
    nv = len(lever) // rows
    live = 0
    short = False
    null = count
    for i in range(count):
        own = float(work[(w_at + i * rows + i) * w + lane])
        gross = 0.0
        for k in range(first[i], first[i + 1]):
            dof = listed[k]
            size = lever[i * nv + dof]
            gross += size * size * float(work[(dof_at + dof * DOF + INVERSE) * w + lane])
        if own > LIVE_ROW * gross:
            scale_of[i] = 1.0 / math.sqrt(own)
            order[at + live] = i
            live += 1
            short |= own < SHORT_ROW * gross
        elif digits == 53 and own <= NULL_ROW * gross:
            scale_of[i] = 0.0
            null -= 1
            order[at + null] = i
        else:
            return -1
    for k in range(live):
        i = order[at + k]
        for j in range(k):
            other = order[at + j]
            value = float(work[(w_at + i * rows + other) * w + lane])
            matrix[k, j] = value * scale_of[i] * scale_of[other]
        matrix[k, k] = 1.0
    rank = live
    if not cholesky(matrix, live, lower) > (GOOD_PIVOT if digits == 53 else COARSE):
        if digits < 53:
            return -1
        rank = _ranked(live, nv, held, work, w, lane, matrix, lower, scale_of, order, at)
        # Short rows bear by the length of their vectors, which is not known here.
        if rank < 0 or (short and rank < live):
            return -1
    speed = 0.0
    for i in range(count):
        wanted = target[i]
        if keeps[i]:
            wanted = float(work[(before_at + i) * w + lane])
        free = float(work[(free_at + i) * w + lane])
        speed = max(speed, abs(wanted), abs(free), abs(float(work[(before_at + i) * w + lane])))
        # By row; in the order of the rows that count only from here on.
        matrix[0, i] = wanted - free
    for k in range(rank):
        known[k] = matrix[0, order[at + k]] * scale_of[order[at + k]]
    for k in range(live, count):
        # A row of no effect cannot change its velocity.
        if abs(matrix[0, order[at + k]]) > IDLE * speed:
            return -1
    for k in range(rank, live):
        i = order[at + k]
        left = matrix[0, i] * scale_of[i]
        for j in range(rank):
            left -= matrix[1 + k - rank, j] * known[j]
        if abs(left) > IDLE * speed * scale_of[i]:
            return -1
    lower_solve(lower, rank, known)
    order[at + count] = live
    return rank


@built_in
def _ranked(
    live, nv, held, work, w, lane, matrix, lower, scale_of, order, at
):  # fmt: skip
    """The rank of the live rows, ``order`` with the rows that count first; -1 in doubt.

    C P = Q R by Gram and Schmidt, each column once more; L = Rᵀ. A row that is set aside is
    R₁⁻¹ R₂ of the others.
    """
    _, _, first, listed, dof_at, reduced_at = held
    half = np.zeros((live, nv))
    upper = np.zeros((live, live))
    for k in range(live):
        row = order[at + k]
        for m in range(first[row], first[row + 1]):
            dof = listed[m]
            inverse = float(work[(dof_at + dof * DOF + INVERSE) * w + lane])
            u = float(work[(reduced_at + row * nv + dof) * w + lane])
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
        if length <= IN_SPAN:
            rank = k
            break
        if not length * length > SAFE_PIVOT:
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
def half_solved(rows, rank, row, work, w_at, w, lane, lower, scale_of, order, at, x):
    """L⁻¹ W of the rows that count, for another row, into ``x``."""
    for k in range(rank):
        x[k] = float(work[(w_at + order[at + k] * rows + row) * w + lane]) * scale_of[order[at + k]]
    lower_solve(lower, rank, x)


@built_in
def bear(count, rank, known, across, lower, scale_of, order, at, matrix, work, p_at, w, lane):
    """Write λ of all bilateral rows; ``across`` (rank,) is L⁻¹ W_bc P, used up."""
    for k in range(rank - 1, -1, -1):
        total = known[k] - across[k]
        for j in range(k + 1, rank):
            total -= lower[j, k] * across[j]
        across[k] = total / lower[k, k]
    for i in range(count):
        work[(p_at + i) * w + lane] = 0.0
    live = order[at + count]
    if live > rank:
        _spread(rank, live - rank, across, matrix)
    for k in range(live):
        value = across[k] if k < rank else matrix[0, k - rank]
        work[(p_at + order[at + k]) * w + lane] = scale_of[order[at + k]] * value


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
