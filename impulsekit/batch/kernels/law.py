"""Newton's law with slip at the end, for the contacts of one state."""

from __future__ import annotations

from ...laws.single import strike_at_end
from ...laws.status import Status
from ...laws.words import NEWTON
from ..codes import AGAIN
from .coulomb import block_at, gain, is_left
from .jit import built_in
from .layout import CONTACT_INTS
from .problem import pose, problem_in, put_back, room
from .several import several
from .uniqueness import judge_others

__all__ = ["newton_lanes"]

_GAIN = int(Status.ENERGY_GAIN)


def newton_lanes(
    base, rows, target, keeping, contact_ints, contact_floats, given, words, digits,
    work, w_at, before_at, free_at, p_at, w, code,
):  # fmt: skip
    """Write the impulses of all rows, and the codes, for the states of a block from ``base`` on.

    The arguments are those of ``problem.pose``.
    """
    space = room(rows, len(contact_ints) // CONTACT_INTS)
    for lane in range(w):
        count = pose(
            base + lane, lane, rows, target, keeping, contact_ints, contact_floats, given, digits,
            work, w_at, before_at, free_at, w, code, space,
        )  # fmt: skip
        if count > 0:
            code[lane] = _solved(count, digits, space)
        put_back(lane, count, rows, len(target), contact_ints, work, p_at, w, code, space)


@built_in
def _solved(count, digits, space):
    """The code, with P of the contacts that touch in ``space``."""
    line = space[1]
    W, before, free, mus, es, ets, P = problem_in(space)
    if count == 1:
        block = block_at(W, 0)
        u, start = (before[0], before[1], before[2]), (free[0], free[1], free[2])
        hit = strike_at_end(block, u, start, es[0], mus[0], ets[0], NEWTON)
        P[0], P[1], P[2] = hit.impulse
        close = is_left(block, u, start, es[0], mus[0], ets[0], NEWTON, hit, digits)
        return AGAIN if close else hit.code
    b, after = line[10], line[15]
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
    code = several(b, count, smooth, scale, digits, space)
    if code == AGAIN:
        return AGAIN
    for i in range(size):
        total = free[i]
        for j in range(size):
            total += W[i, j] * P[j]
        after[i] = total
    if gain(P, before, after, count):
        return _GAIN
    if not smooth:
        return judge_others(code, W, before, free, after, mus, es, ets, count, P)
    return code
