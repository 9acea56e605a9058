"""Whether other velocities obey Newton's law at several contacts, as ``solve`` finds out."""

from __future__ import annotations

import numpy as np

from ...laws.coupling import friction_is_weak
from ...laws.dense import rank_by_pivots
from ...laws.modes import DEPENDENT
from ...laws.plane_modes import plane_of
from ...laws.status import Status
from ...laws.uniqueness import (
    MOST_FOUND,
    MOST_IN_PLANE,
    MOST_IN_SPACE,
    TRIED_ALL,
    TRIED_SOME,
    is_another,
    search_modes,
)
from ..codes import AGAIN, OPEN
from .jit import built_in

__all__ = ["judge_feedback", "judge_others"]

_MANY = int(Status.MANY_SOLUTIONS)


@built_in
def judge_others(code, W, before, free, after, mus, es, ets, count, P):
    """The code of an answer: MANY_SOLUTIONS, or OPEN added where it is not proven the only one.

    Args:
        code: of an answer that is valid.
        W: (3n, 3n) and more; of the contacts that touch the first.
        before, free, after: (3n,) u⁻, u_free, u⁺ [m/s].
        mus, es, ets: (n,) friction and restitutions.
        count: n.
        P: (3n,) of the answer [N s].
    """
    size = 3 * count
    own, aim, mu = np.zeros((size, size)), np.zeros(size), np.empty(count)
    whole, shown, start, blown = (
        np.empty((size, size)), np.empty(size), np.empty(size), np.empty(size),
    )  # fmt: skip
    scale = 0.0
    for i in range(count):
        mu[i] = mus[i]
    for r in range(size):
        i = r // 3
        shown[r], start[r], blown[r] = P[r], before[r], free[r]
        scale = max(scale, abs(before[r]), abs(after[r]))
        if mu[i] > 0.0 or r % 3 == 2:
            aim[r] = free[r]
            if r % 3 < 2:
                aim[r] += ets[i] * before[r]
            elif before[r] < 0.0:
                aim[r] += es[i] * before[r]
        for c in range(size):
            whole[r, c] = W[r, c]
            if (mu[i] > 0.0 or r % 3 == 2) and (mu[c // 3] > 0.0 or c % 3 == 2):
                own[r, c] = W[r, c]
    if not scale > 0.0 or friction_is_weak(own, mu):
        return code
    found = np.empty((MOST_FOUND, size))
    how, known = search_modes(own, aim, mu, np.zeros(count), scale, False, found)
    for k in range(known):
        if is_another(whole, found[k], shown, start, blown, scale):
            return _MANY
    if how == TRIED_ALL:
        return code
    # Which loads redundant contacts can hold is for the solver of single states.
    return AGAIN if how == TRIED_SOME and _is_redundant(own, size) else code + OPEN


@built_in
def _is_redundant(own, size):
    """Whether rows that move anything depend on each other; ``own`` is used up."""
    most, kept = 0.0, 0
    for r in range(size):
        most = max(most, own[r, r])
    unit = np.empty(size)
    for r in range(size):
        moves = own[r, r] > DEPENDENT * most
        unit[r] = own[r, r] ** -0.5 if moves else 0.0
        kept += 1 if moves else 0
    for r in range(size):
        for c in range(size):
            own[r, c] *= unit[r] * unit[c]
    return rank_by_pivots(own, size, DEPENDENT) < kept


@built_in
def judge_feedback(code, W, aim, mus, count):
    """The code of an answer of Poisson's law: OPEN added where it is not proven the only one.

    In a plane all modes of both parts are for the solver of single states, and so are several
    compressions, or redundant ones, in space: AGAIN.
    """
    size = 3 * count
    own, b = np.zeros((size, size)), np.zeros(size)
    mu, direction = np.empty(count), np.empty((count, 2))
    for i in range(count):
        mu[i] = mus[i]
    for r in range(size):
        if mu[r // 3] > 0.0 or r % 3 == 2:
            b[r] = aim[r]
            for c in range(size):
                if mu[c // 3] > 0.0 or c % 3 == 2:
                    own[r, c] = W[r, c]
    if friction_is_weak(own, mu):
        return code
    if count <= MOST_IN_PLANE and plane_of(own, b, mu, direction):
        return AGAIN
    if count <= MOST_IN_SPACE:
        scale = 0.0
        for r in range(size):
            scale = max(scale, abs(aim[r]))
        found = np.empty((MOST_FOUND, size))
        _, known = search_modes(own, b, mu, np.zeros(count), scale, False, found)
        if known > 1 or _is_redundant(own, size):
            return AGAIN
    return code + OPEN
