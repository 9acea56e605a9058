"""Redundant contacts whose targets contradict each other: one of them bears nothing.

Where two corners of a face rest and the others strike, e·u_n⁻ is asked of the latter alone.
Four corners of a rigid face have only three velocities between them, so that all four targets
are met at once only up to rounding of u⁻, or not at all. Then Newton on the modes keeps all
four loaded and cannot get below what the targets contradict each other by. The law has its
answer where one corner parts a little faster than it has to, and carries no impulse.
"""

from __future__ import annotations

import math

import numpy as np

from .approach import ROUNDS, approach_in_rounds
from .compiled import compiled
from .modes import BAR, MOST_STEPS, RIDGE, polish, residual_of, sizes_of
from .sticking import held_still
from .workspace import Sizes, Workspace, workspace

__all__ = ["unload"]

# Residuals between these are looked at: below is rounding, above the modes are not yet known.
ROUNDING, FAR = 1e-13, 1e-4
# All rounds.
BEGIN, END = np.int64(0), np.int64(ROUNDS)


@compiled
def unload(work: Workspace, n: int, sizes: Sizes, residual: float) -> float:
    """Take load off one contact after the other, where that is nearer; the residual.

    Args:
        work: the problem, without a floor, and P as Newton leaves it.
        n: how many contacts.
        sizes: what counts as nothing.
        residual: that of P.
    """
    if not ROUNDING < residual < FAR:
        return residual
    size = 3 * n
    few = workspace(n)
    start, best = work.P[:size].copy(), work.P[:size].copy()
    loaded = np.empty(n, np.bool_)
    count = 0
    for i in range(n):
        loaded[i] = start[3 * i + 2] > 0.0
        count += 1 if loaded[i] else 0
    while ROUNDING < residual < FAR and count > 1:
        nearest, which = residual, -1
        # Mostly the others stay in their modes.
        for afresh in range(2):
            for i in range(n):
                if not loaded[i]:
                    continue
                loaded[i] = False
                _solve_few(work, n, few, loaded, start, afresh == 1)
                loaded[i] = True
                left = residual_of(work, n, sizes)
                if left < nearest:
                    nearest, which = left, i
                    for k in range(size):
                        best[k] = work.P[k]
            if nearest <= ROUNDING:
                break
        if which < 0:
            break
        residual = nearest
        loaded[which] = False
        count -= 1
        for k in range(size):
            start[k] = best[k]
    for k in range(size):
        work.P[k] = best[k]
    return residual


@compiled
def _solve_few(
    work: Workspace,
    n: int,
    few: Workspace,
    loaded: np.ndarray,
    start: np.ndarray,
    afresh: bool,
) -> None:
    """P of the loaded contacts alone, the others bearing nothing."""
    rows = np.empty(3 * n, np.int64)
    m = int(np.int64(0))
    for i in range(n):
        if loaded[i]:
            few.mu[m], few.floor[m] = work.mu[i], 0.0
            for k in range(3):
                rows[3 * m + k] = 3 * i + k
            m += 1
    for r in range(3 * m):
        few.b[r], few.P[r] = work.b[rows[r]], start[rows[r]]
        for c in range(3 * m):
            few.W[r, c] = work.W[rows[r], rows[c]]
    sizes = sizes_of(few, m, 0.0)
    for k in range(3 * n):
        work.P[k] = 0.0
    # Contacts that no impulse moves bear none.
    if not sizes.largest > 0.0:
        return
    residual = math.inf
    if not afresh:
        polish(few, m, sizes, MOST_STEPS, RIDGE)
    else:
        ridge = held_still(few, m, sizes)
        if ridge >= 0.0:
            residual = polish(few, m, sizes, MOST_STEPS, ridge)
        if residual > BAR:
            approach_in_rounds(few, m, sizes, BEGIN, END, BAR)
    for r in range(3 * m):
        work.P[rows[r]] = few.P[r]
