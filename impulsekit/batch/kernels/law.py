"""The contacts of one state: from its Delassus matrix to the impulses of all rows.

Newton's restitution with slip at the end. Bilateral rows come first and are eliminated:
λ = −W_bb⁻¹ (u_b − target + W_bc P), contacts see W_cc − W_cb W_bb⁻¹ W_bc.
"""

from __future__ import annotations

import math

import numpy as np
from numba import njit

from ..codes import AGAIN, RowStatus
from .coulomb import coulomb, gain
from .dense import cholesky, eliminate, lower_solve
from .layout import CONTACT_FLOATS, CONTACT_INTS
from .many import frictional, frictionless

__all__ = ["room", "solve_state"]

# As in ``impact``: q this near a limit is at it, and pivots above this are no rounding.
AT_STOP = 1e-9
SAFE_PIVOT = 1e-6
_SOLVED, _GAIN = int(RowStatus.SOLVED), int(RowStatus.ENERGY_GAIN)


@njit(cache=True, nogil=True)
def room(rows, contacts):
    """The arrays that ``solve_state`` works in."""
    size = max(3 * contacts, rows, 1)
    return (
        np.zeros((9, size, size)),
        np.zeros((14, size)),
        np.zeros((max(contacts, 1), 2)),
        np.zeros((4, 2)),
        np.zeros(4),
        np.zeros((2, max(contacts, 1)), dtype=np.int64),
    )


@njit(cache=True, nogil=True)
def _touching(contact_ints, contact_floats, q, q_row, contact):
    """0 where a stop is not reached, else the sign of its row; 2 where both ends are."""
    entry = contact_ints[contact * CONTACT_INTS + 2]
    if entry < 0:
        return 1
    at = contact * CONTACT_FLOATS
    lower, upper = contact_floats[at + 9], contact_floats[at + 10]
    x = q[q_row + entry]
    low = x - lower <= AT_STOP * max(1.0, abs(lower))
    high = upper - x <= AT_STOP * max(1.0, abs(upper))
    if low and high:
        return 2
    return 1 if low else (-1 if high else 0)


@njit(cache=True, nogil=True)
def solve_state(
    rows, held, target, keeps, contact_ints, contact_floats, q, q_row,
    e, e_row, mu, mu_row, work, w_at, before_at, free_at, p_at, w, lane, space,
):  # fmt: skip
    """Write the impulses of all rows for one lane; the code.

    Args:
        rows, held: how many rows, and how many of them are bilateral.
        target, keeps: (held,) velocities they are brought to; True: they keep their own.
        q, q_row: flat q, and where that of this state begins.
        e, e_row, mu, mu_row: the same for the coefficients.
        w_at, before_at, free_at, p_at: where W, u⁻, u_free and P stand in ``work``.
    """
    matrices, vectors, slip, found, roots, flags = space
    W, lower, cross_held = matrices[0], matrices[1], matrices[2]
    before, free, b, P = vectors[0], vectors[1], vectors[2], vectors[3]
    mus, sign = vectors[4], vectors[5]
    known, rest, scale_of = vectors[6], vectors[7], vectors[8]
    row_of, mode = flags[0], flags[1]
    for r in range(rows):
        work[(p_at + r) * w + lane] = 0.0
    count = 0
    smooth = True
    for contact in range(len(contact_ints) // CONTACT_INTS):
        side = _touching(contact_ints, contact_floats, q, q_row, contact)
        if side == 2:
            return AGAIN
        if side != 0:
            row_of[count] = contact
            sign[count] = side
            mus[count] = 0.0
            if contact_ints[contact * CONTACT_INTS + 1] == 3:
                mus[count] = mu[mu_row + contact]
            smooth = smooth and mus[count] == 0.0
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
    code = _SOLVED
    if held > 0:
        for i in range(held):
            diagonal = work[(w_at + i * rows + i) * w + lane]
            if not diagonal > 0.0:
                return AGAIN
            scale_of[i] = 1.0 / math.sqrt(diagonal)
        matrix = matrices[3]
        for i in range(held):
            for j in range(i + 1):
                matrix[i, j] = work[(w_at + i * rows + j) * w + lane] * scale_of[i] * scale_of[j]
        if not cholesky(matrix, held, lower) > SAFE_PIVOT:
            return AGAIN
        for i in range(held):
            wanted = target[i]
            if keeps[i]:
                wanted = work[(before_at + i) * w + lane]
            known[i] = (wanted - work[(free_at + i) * w + lane]) * scale_of[i]
        eliminate(lower, held, known)
        # Half-solved columns of the contacts, for W and for what the rows bear.
        for j in range(size):
            c = _row(contact_ints, row_of, j)
            for i in range(held):
                rest[i] = 0.0
                if c >= 0:
                    value = work[(w_at + i * rows + c) * w + lane]
                    rest[i] = sign[j // 3] * value * scale_of[i]
                    free[j] += rest[i] * known[i]
            lower_solve(lower, held, rest)
            for i in range(held):
                cross_held[j, i] = rest[i]
        for i in range(size):
            for j in range(size):
                for k in range(held):
                    W[i, j] -= cross_held[i, k] * cross_held[j, k]
    if count > 0:
        scale = 0.0
        for i in range(size):
            b[i] = free[i]
        for k in range(count):
            at = row_of[k] * CONTACT_FLOATS
            un = before[3 * k + 2]
            if un < 0.0 and -un >= contact_floats[at + 12]:
                b[3 * k + 2] += e[e_row + row_of[k]] * un
            e_t = contact_floats[at + 11]
            if mus[k] > 0.0:
                b[3 * k] += e_t * before[3 * k]
                b[3 * k + 1] += e_t * before[3 * k + 1]
                for j in (3 * k, 3 * k + 1):
                    scale = max(scale, abs(free[j]), abs(e_t * before[j]))
            scale = max(scale, abs(un), abs(free[3 * k + 2]))
        if count == 1:
            p1, p2, pn, code = coulomb(
                W[0, 0], W[0, 1], W[1, 1], W[0, 2], W[1, 2], W[2, 2],
                b[0], b[1], b[2], mus[0], scale, found, roots,
            )  # fmt: skip
            P[0], P[1], P[2] = p1, p2, pn
        elif smooth:
            code = frictionless(W, b, count, scale, P)
        else:
            matrices[4][:size, :size] = W[:size, :size]
            code = frictional(
                matrices[4], b, mus, count, P, vectors[9], vectors[10], mode, slip,
                matrices[5], matrices[6], matrices[7], vectors[11], vectors[12], found, roots,
            )  # fmt: skip
        if code == AGAIN:
            return AGAIN
        after = vectors[13]
        for i in range(size):
            total = free[i]
            for j in range(size):
                total += W[i, j] * P[j]
            after[i] = total
        if gain(P, before, after, count):
            code = _GAIN
    if held > 0:
        for i in range(held):
            rest[i] = 0.0
            for j in range(size):
                rest[i] += cross_held[j, i] * P[j]
        # Only the second half of the solution is still to be done.
        for i in range(held - 1, -1, -1):
            total = rest[i]
            for k in range(i + 1, held):
                total -= lower[k, i] * rest[k]
            rest[i] = total / lower[i, i]
        for i in range(held):
            work[(p_at + i) * w + lane] = scale_of[i] * (known[i] - rest[i])
    for j in range(size):
        c = _row(contact_ints, row_of, j)
        if c >= 0:
            work[(p_at + c) * w + lane] = sign[j // 3] * P[j]
    return code


@njit(cache=True, nogil=True)
def _row(contact_ints, row_of, i):
    """The row behind entry i of the contacts' own vectors; -1 where there is none."""
    contact = row_of[i // 3] * CONTACT_INTS
    first = contact_ints[contact]
    if contact_ints[contact + 1] == 3:
        return first + i % 3
    return first if i % 3 == 2 else -1
