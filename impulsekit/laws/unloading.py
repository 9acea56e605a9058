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

from .approach import ALL_ROUNDS, NO_ROUND, approach_in_rounds
from .borrowed import borrowing
from .compiled import compiled, entry
from .modes import MOST_STEPS, RIDGE, height_of, polish, residual_of, sizes_of
from .sticking import held_still
from .tolerances import BAR, ROUNDING_OF_TERMS
from .workspace import Sizes, Workspace, workspace

__all__ = ["may_unload", "unload"]

# Residuals above rounding and below this are looked at: above it the modes are not yet known.
UNKNOWN_MODES = 1e-4
# Rounds of sweeps and splitting that mostly do.
FEW_ROUNDS: int = np.int64(5)  # type: ignore[assignment]
# Times the residual: a contact that parts no faster may bear load.
MAY_TOUCH = 10.0


@borrowing
def may_unload(residual: float) -> bool:
    """Whether ``unload``, which takes seconds to compile, would do anything."""
    return ROUNDING_OF_TERMS < residual < UNKNOWN_MODES


@entry(lambda: (workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), 0.0), seconds=4.0, apart=True)
def unload(work: Workspace, n: int, sizes: Sizes, residual: float) -> float:
    """Take load off one contact after the other, where that is nearer; the residual.

    Args:
        work: the problem, without a floor, and P as Newton leaves it.
        n: how many contacts.
        sizes: what counts as nothing.
        residual: that of P.
    """
    if not may_unload(residual):
        return residual
    size = 3 * n
    few = workspace(n)
    start, best = work.P[:size].copy(), work.P[:size].copy()
    loaded = np.empty(n, np.bool_)
    count = 0
    touches = MAY_TOUCH * residual_of(work, n, sizes) * sizes.scale
    for i in range(n):
        # Newton may have let go of the wrong one, which then approaches by what is left.
        loaded[i] = start[3 * i + 2] > 0.0 or work.xi[3 * i + 2] < touches
        count += 1 if loaded[i] else 0
    while may_unload(residual) and count > 1:
        nearest, which, lowest = residual, -1, math.inf
        # Mostly a few rounds bring the others into their modes, where they are not yet.
        for last in (FEW_ROUNDS, ALL_ROUNDS):
            for i in range(n):
                if not loaded[i]:
                    continue
                loaded[i] = False
                left = _solve_few(work, n, few, sizes, loaded, start, last)
                loaded[i] = True
                # Of those that leave rounding the one nearest to sticking, as everywhere.
                height = height_of(work, n)
                if nearest <= ROUNDING_OF_TERMS:
                    nearer = left <= ROUNDING_OF_TERMS and height < lowest
                else:
                    nearer = left < nearest
                if nearer:
                    nearest, which, lowest = left, i, height
                    for k in range(size):
                        best[k] = work.P[k]
            if nearest <= ROUNDING_OF_TERMS:
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
    sizes: Sizes,
    loaded: np.ndarray,
    start: np.ndarray,
    last: int,
) -> float:
    """The residual with P of the loaded contacts alone, the others bearing nothing.

    From ``start``; where that does not lead to rounding level, from nothing in so many rounds.
    """
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
    own = sizes_of(few, m, 0.0)
    # Contacts that no impulse moves bear none.
    if not own.largest > 0.0:
        for k in range(3 * n):
            work.P[k] = 0.0
        return residual_of(work, n, sizes)
    polish(few, m, own, MOST_STEPS, RIDGE)
    left = _with_few(work, n, few, sizes, rows[: 3 * m])
    if left <= ROUNDING_OF_TERMS:
        return left
    residual, ridge = math.inf, held_still(few, m, own)
    if ridge >= 0.0:
        residual = polish(few, m, own, MOST_STEPS, ridge)
    if residual > BAR:
        approach_in_rounds(few, m, own, NO_ROUND, last, BAR)
    return _with_few(work, n, few, sizes, rows[: 3 * m])


@borrowing
def _with_few(work: Workspace, n: int, few: Workspace, sizes: Sizes, rows: np.ndarray) -> float:
    """The residual with P of a few contacts, of which ``rows`` are."""
    for k in range(3 * n):
        work.P[k] = 0.0
    for r in range(len(rows)):
        work.P[rows[r]] = few.P[r]
    return residual_of(work, n, sizes)
