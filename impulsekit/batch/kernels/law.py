"""The contacts of one state: from its Delassus matrix to the impulses of all rows.

Newton's restitution with slip at the end. Bilateral rows come first and are eliminated:
λ = −W_bb⁻¹ (u_b − target + W_bc P), contacts see W_cc − W_cb W_bb⁻¹ W_bc.
"""

from __future__ import annotations

import math

import numpy as np

from ..codes import AGAIN, RowStatus
from .coulomb import coulomb, gain
from .dense import cholesky, eliminate, lower_solve, rank_by_pivots
from .jit import built_in
from .layout import CONTACT_FLOATS, CONTACT_INTS
from .many import frictional
from .smooth import frictionless

__all__ = ["room", "solve_state"]

# As in ``impact``: q this near a limit is at it, and pivots above this are no rounding.
AT_STOP = 1e-9
SAFE_PIVOT = 1e-6
NULL_ROW = 1e-12
# Two contacts with 1 − r² below this, r their correlation in W, all but coincide.
COINCIDENT = 1e-6
DEPENDENT = 1e-10
# Pivots in single precision.
COARSE = 1e-4
_SOLVED, _GAIN = int(RowStatus.SOLVED), int(RowStatus.ENERGY_GAIN)


@built_in
def room(rows, contacts):
    """The arrays that ``solve_state`` works in."""
    size = max(3 * contacts, rows, 1)
    few = max(contacts, 1)
    # One array each: a slice of a larger one would be counted at every use.
    square = (
        np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size)),
        np.zeros((size, size)), np.zeros((size, size)), np.zeros((size, size)),
        np.zeros((size, size)), np.zeros((size, size)),
    )  # fmt: skip
    line = (
        np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size), np.zeros(size),
        np.zeros(size),
    )  # fmt: skip
    short = (np.zeros((few, 2)), np.zeros((4, 2)), np.zeros(4))
    return square, line, short, (np.zeros(few, dtype=np.int64), np.zeros(few, dtype=np.int64))


@built_in
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


@built_in
def solve_state(
    rows, held, target, keeps, contact_ints, contact_floats, q, q_row,
    e, e_row, mu, mu_row, digits, work, w_at, before_at, free_at, p_at, w, lane, space,
):  # fmt: skip
    """Write the impulses of all rows for one lane; the code.

    Args:
        rows, held: how many rows, and how many of them are bilateral.
        target, keeps: (held,) velocities they are brought to; True: they keep their own.
        q, q_row: flat q, and where that of this state begins.
        e, e_row, mu, mu_row: the same for the coefficients.
        digits: binary digits of the numbers in ``work``.
        w_at, before_at, free_at, p_at: where W, u⁻, u_free and P stand in ``work``.
    """
    square, line, short, whole = space
    W, lower, cross_held, matrix, own, way, aim, newton = square
    before, free, b, P, mus, sign, known, rest, scale_of, best, xi, x, moved, after = line[:14]
    split_y, split_z = line[14], line[15]
    slip, found, roots = short
    row_of, mode = whole
    for r in range(rows):
        work[(p_at + r) * w + lane] = 0.0
    # np.int64(0), for with a 0 numba would compile all that takes it once more.
    count = np.int64(0)
    smooth = True
    safe, dependent = SAFE_PIVOT, DEPENDENT
    if digits < 53:
        # What is left in doubt is solved again in double precision.
        safe, dependent = COARSE, COARSE
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
        largest = 0.0
        for i in range(held):
            largest = max(largest, float(work[(w_at + i * rows + i) * w + lane]))
        for i in range(held):
            diagonal = float(work[(w_at + i * rows + i) * w + lane])
            # A row that moves nothing, as across a planar loop, may be rounding.
            if not diagonal > NULL_ROW * largest:
                return AGAIN
            scale_of[i] = 1.0 / math.sqrt(diagonal)
        for i in range(held):
            for j in range(i + 1):
                matrix[i, j] = work[(w_at + i * rows + j) * w + lane] * scale_of[i] * scale_of[j]
        if not cholesky(matrix, held, lower) > safe:
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
            code = frictionless(W, b, count, scale, max(dependent, 1e-9), P)
        spread = code == AGAIN and digits == 53 and _are_apart(W, count)
        if count > 1 and (not smooth or spread):
            # Redundant contacts share by splitting, with or without friction.
            if digits < 53 and _is_dependent(W, size, own, aim):
                return AGAIN
            for i in range(size):
                for j in range(size):
                    own[i, j] = W[i, j]
            code = frictional(
                own, b, mus, count, dependent, P, best, xi, mode, slip, way, aim, newton, x, moved,
                split_y, split_z, found, roots,
            )  # fmt: skip
        if code == AGAIN:
            return AGAIN
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


@built_in
def _are_apart(W, count):
    """Whether no two contacts all but coincide: of such, rounding leaves few digits."""
    for i in range(count):
        for j in range(i):
            own = W[3 * i + 2, 3 * i + 2] * W[3 * j + 2, 3 * j + 2]
            if not own - W[3 * i + 2, 3 * j + 2] ** 2 > COINCIDENT * own:
                return False
    return True


@built_in
def _is_dependent(W, size, matrix, scale):
    """Whether rows of contacts may depend on each other, for all that few digits tell."""
    for i in range(size):
        if not W[i, i] > 0.0:
            return True
        scale[0, i] = 1.0 / math.sqrt(W[i, i])
    for i in range(size):
        for j in range(size):
            matrix[i, j] = W[i, j] * scale[0, i] * scale[0, j]
    return rank_by_pivots(matrix, size, COARSE) < size


@built_in
def _row(contact_ints, row_of, i):
    """The row behind entry i of the contacts' own vectors; -1 where there is none."""
    contact = row_of[i // 3] * CONTACT_INTS
    first = contact_ints[contact]
    if contact_ints[contact + 1] == 3:
        return first + i % 3
    return first if i % 3 == 2 else -1
