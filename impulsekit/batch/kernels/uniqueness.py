"""Whether other velocities obey the law at several contacts, as ``solve`` finds out."""

from __future__ import annotations

import numpy as np

from ...laws.others import ALL_TRIED, MOST_ANSWERS, SMOOTH, WEAK, find_answers
from ...laws.status import Status
from ...laws.uniqueness import NEAR
from ..codes import OPEN, SHARED
from .jit import built_in

__all__ = ["judge_others"]

_MANY, _NOT_UNIQUE = int(Status.MANY_SOLUTIONS), int(Status.NOT_UNIQUE)


@built_in
def judge_others(code, W, before, free, after, mus, es, ets, count, P, restitution):
    """The code of an answer: MANY_SOLUTIONS, or what is open of it added.

    Args:
        code: of an answer that is valid.
        W: (3n, 3n) and more; of the contacts that touch the first.
        before, free, after: (3n,) u⁻, u_free, u⁺ [m/s].
        mus, es, ets: (n,) friction and restitutions.
        count: n.
        P: (3n,) of the answer [N s].
        restitution: NEWTON or POISSON.
    """
    size = 3 * count
    scale = 0.0
    for r in range(size):
        scale = max(scale, abs(before[r]), abs(free[r]), abs(after[r]))
    if not scale > 0.0:
        return code
    coefficients, room = np.empty((3, count)), np.empty((2, MOST_ANSWERS, size))
    for i in range(count):
        coefficients[0, i], coefficients[1, i], coefficients[2, i] = mus[i], es[i], ets[i]
    how, known, others, split = find_answers(
        W[:size, :size].copy(), before[:size].copy(), free[:size].copy(), coefficients, restitution,
        P[:size].copy(), scale, room, NEAR,
    )  # fmt: skip
    if split and (others > 0 or code == _NOT_UNIQUE):
        return code + SHARED
    if others > 0:
        return _MANY
    if how in (SMOOTH, WEAK) or (how == ALL_TRIED and known > 0):
        return code
    return code + OPEN
