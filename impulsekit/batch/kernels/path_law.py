"""Slip along the path for the contacts of one state, of which one acts, for kernels.

As ``impact.contact_space.alone``: the others part or lie still, before and after.
"""

from __future__ import annotations

import numpy as np

from ...laws.alone import find_acting
from ...laws.path import follow
from ...laws.progress import P1, P2, P, path_memory
from ...laws.status import Status
from ...laws.tolerances import AT_REST_AMONG_OTHERS, NEGLIGIBLE
from ...laws.words import STRONGE
from ..codes import AGAIN
from .jit import built_in
from .problem import problem_in

__all__ = ["memory", "solved", "strike_along"]


# Shares of an impulse so many times the velocities leave too few digits of their sum.
MOST_SHARES = 1e4
# So many times smaller or larger, rounding may decide; and the same in single precision.
SURE, SURE_IN_SINGLE = 1e2, 1e8
_SOLVED, _JAM = int(Status.SOLVED), int(Status.PAINLEVE_JAM)
_REFUSED = int(Status.REFUSED)


@built_in
def memory(contacts):
    """What following one path takes."""
    return path_memory()


@built_in
def solved(count, posed, digits, space, memory):
    """The code, with P of the contacts that touch in ``space``."""
    law = posed.words[0]
    W, before, free, mus, es, ets, P_all = problem_in(space)
    sure = SURE if digits == 53 else SURE_IN_SINGLE
    for i in range(3 * count):
        P_all[i] = 0.0
    one = np.int64(0)
    scale = 0.0
    if count > 1:
        acting, one, scale = find_acting(before, free, es, count, law, sure)
        if acting < 0:
            return AGAIN
        if acting > 1:
            return _several(mus, count, law)
        if acting == 0:
            return _SOLVED
    at = 3 * one
    code = strike_along(W, at, before[at + 2], free, es[one], mus[one], ets[one], law, memory)
    if code == _REFUSED:
        return _REFUSED
    now = memory.now
    P_all[at], P_all[at + 1], P_all[at + 2] = now[P1], now[P2], now[P]
    if count > 1 and code in (_SOLVED, _JAM):
        lowest = 0.0
        for k in range(2, 3 * count, 3):
            if k != at + 2:
                after = free[k]
                for j in range(at, at + 3):
                    after += W[k, j] * P_all[j]
                lowest = min(lowest, after)
        if lowest < -AT_REST_AMONG_OTHERS * scale * sure:
            return _several(mus, count, law)
        if lowest < -AT_REST_AMONG_OTHERS * scale / sure:
            return AGAIN
    return code


@built_in
def strike_along(W, at, before, start, e, mu, e_t, law, memory):
    """``path.follow`` for the contact whose rows of W and of ``start`` [m/s] begin at ``at``."""
    e = e if e > NEGLIGIBLE else 0.0
    mu = mu if mu > NEGLIGIBLE else 0.0
    if mu > 0.0 and e_t != 0.0:
        return _REFUSED
    t11, t22, nn = W[at, at], W[at + 1, at + 1], W[at + 2, at + 2]
    block = (t11, W[at, at + 1], t22, W[at, at + 2], W[at + 1, at + 2], nn)
    free = (start[at], start[at + 1], start[at + 2])
    code = follow(block, before, free, e, mu, law, memory)
    if mu > 0.0:
        now = memory.now
        shares = t11 * abs(now[P1]) + t22 * abs(now[P2]) + nn * now[P]
        scale = max(abs(before), abs(free[0]), abs(free[1]), abs(free[2]))
        if not shares <= MOST_SHARES * scale:
            return AGAIN
    return code


@built_in
def _several(mus, count, law):
    """The code where more than one contact would take part."""
    if law == STRONGE:
        return _REFUSED
    for k in range(count):
        if mus[k] > 0.0:
            return _REFUSED
    return AGAIN
