"""Newton's law with slip at the end, for the contacts of one state."""

from __future__ import annotations

import math

from ..codes import AGAIN, RowStatus
from .coulomb import coulomb, gain
from .dense import rank_by_pivots
from .jit import built_in
from .layout import CONTACT_INTS
from .many import frictional
from .problem import COARSE, pose, problem_in, put_back, room
from .smooth import frictionless

__all__ = ["newton_lanes"]

# Two contacts with 1 − r² below this, r their correlation in W, all but coincide.
COINCIDENT = 1e-6
DEPENDENT = 1e-10
_SOLVED, _GAIN = int(RowStatus.SOLVED), int(RowStatus.ENERGY_GAIN)


def newton_lanes(
    base, rows, target, keeps, contact_ints, contact_floats, given, words, digits,
    work, w_at, before_at, free_at, p_at, w, code,
):  # fmt: skip
    """Write the impulses of all rows, and the codes, for the states of a block from ``base`` on.

    The arguments are those of ``problem.pose``.
    """
    space = room(rows, len(contact_ints) // CONTACT_INTS)
    for lane in range(w):
        count = pose(
            base + lane, lane, rows, target, keeps, contact_ints, contact_floats, given, digits,
            work, w_at, before_at, free_at, w, code, space,
        )  # fmt: skip
        if count > 0:
            code[lane] = _solved(count, digits, space)
        put_back(lane, count, rows, len(target), contact_ints, work, p_at, w, code, space)


@built_in
def _solved(count, digits, space):
    """The code, with P of the contacts that touch in ``space``."""
    square, line, short, (_, mode) = space
    W, before, free, mus, es, ets, P = problem_in(space)
    own, way, aim, newton = square[4:]
    b, best, xi, x, moved, after, split_y, split_z = line[10:]
    slip, found, roots = short
    # What is left in doubt is solved again in double precision.
    dependent = DEPENDENT if digits == 53 else COARSE
    code = _SOLVED
    size = 3 * count
    smooth = True
    scale = 0.0
    for i in range(size):
        b[i] = free[i]
    for k in range(count):
        un = before[3 * k + 2]
        if un < 0.0:
            b[3 * k + 2] += es[k] * un
        if mus[k] > 0.0:
            smooth = False
            b[3 * k] += ets[k] * before[3 * k]
            b[3 * k + 1] += ets[k] * before[3 * k + 1]
            for j in (3 * k, 3 * k + 1):
                scale = max(scale, abs(free[j]), abs(ets[k] * before[j]))
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
