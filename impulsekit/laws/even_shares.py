"""Redundant contacts that slip: how they share their load.

Where normals of contacts that touch depend on each other, as at four corners of a face, load can
be shifted between them: W_nn z = 0. Where these contacts slip in ways of their own, friction
shifts with it, and every share has its own v⁺. As for what rests (``resting``) the share is the
one that equally stiff springs would make: each contact gives way by ε D P_n, D being the diagonal
of W_nn, so that zᵀ D P_n = 0 for every z as ε goes to 0, or as far that way as no contact pulls.

With Π onto these z in units of 1/√D, the law with W_nn + √D Π √D for W_nn has that share alone,
and solves the law itself: zᵀ ξ_n = zᵀ D P_n must vanish.
"""

from __future__ import annotations

import math

import numpy as np

from .approach import ALL_ROUNDS, NO_ROUND, approach_in_rounds
from .borrowed import borrowed, borrowing
from .compiled import compiled, entry
from .dense import take_off
from .least_shares import STILL
from .modes import (
    FINE,
    MOST_STEPS,
    RIDGE,
    SLIDES,
    SUMMED,
    largest_term,
    polish,
    residual_of,
    stepped,
)
from .rank import null_projector, pivoted_cholesky
from .redundant import NO_LOAD, is_redundant
from .tolerances import BAR, PART
from .words import NO
from .workspace import Sizes, Workspace, workspace

__all__ = ["can_shift", "share_evenly", "shifts_of"]

# Targets of redundant normals that are farther apart, relative to the velocities, contradict each
# other: then not all of them can bear load, and there is nothing to share.
TARGETS_APART = 1e-13
# Velocities that a shift of load makes, each contact's own mobility being 1: less is rounding.
MOVES = 1e-10
# How much contacts give way, of their own mobility, while it is looked for what has a load.
# Where that leads nowhere they give way much to begin with, and then ever less.
SOFT_BED, TENFOLD, MOST_STAGES = 1e-6, 10.0, 4
# Steps on a ridge from where no other step leads on; the first brings it to 1e-12.
MOST_RIDGED = 8
# The trace of Π counts the ways to shift load: between none and one, and one and two.
SOME_WAY, ONE_WAY = 0.5, 1.5


@compiled
def share_evenly(
    work: Workspace, n: int, sizes: Sizes, dependent: float, residual: float
) -> tuple[float, bool]:
    """Bring P to the even share of normals that depend on each other.

    Where nothing slips v⁺ does not depend on the shares, and P stays.

    Args:
        work: the problem, and P, a solution. Where load can be shifted ``unique`` is False after
            it for the contacts between which it can.
        n: how many contacts.
        sizes: what counts as nothing.
        dependent: pivots, the diagonal being 1, below which rows depend on each other.
        residual: that of P.

    Returns:
        The residual, and whether load can be shifted so that v⁺ changes.
    """
    residual_of(work, n, sizes)
    for i in range(n):
        work.unique[i] = True
    if not _depend(work, n, sizes, dependent):
        return residual, False
    return _share_dependent(work, n, sizes, dependent, residual)


@entry(lambda: (workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), 0.0, 0.0), seconds=3.0, apart=True)
def _share_dependent(
    work: Workspace, n: int, sizes: Sizes, dependent: float, residual: float
) -> tuple[float, bool]:
    """``share_evenly`` of normals that do depend on each other."""
    work = borrowed(work)
    touching = np.empty(n, np.int64)
    count = _touching(work, n, sizes, touching)
    shift = _shifts(work, touching, count, dependent)
    if _contradict(work, n, sizes, touching, count, shift):
        return residual, False
    allowed = residual + max(FINE, SUMMED * largest_term(work.W, work.P, 3 * n) / sizes.scale)
    start, mine = work.P[: 3 * n].copy(), touching.copy()
    unloaded = np.zeros(n, np.bool_)
    _polish_even(work, n, sizes, mine, count, shift, unloaded)
    kept = _loaded(work, n, mine, count)
    if kept < count:
        for k in range(count):
            mine[k] = touching[k]
        _polish_giving(work, n, sizes, touching, count)
        kept = _loaded(work, n, mine, count)
        for _ in range(n):
            if kept == 0:
                break
            for k in range(count):
                unloaded[touching[k]] = True
            for k in range(kept):
                unloaded[mine[k]] = False
            _polish_even(work, n, sizes, mine, kept, _shifts(work, mine, kept, dependent), unloaded)
            left = _loaded(work, n, mine, kept)
            if left == kept:
                break
            # What would pull gets no load, and the others share it.
            kept = left
    after = residual_of(work, n, sizes)
    if not after <= allowed:
        # Normals that nearly depend on each other are no redundant ones.
        for k in range(3 * n):
            work.P[k] = start[k]
        return residual_of(work, n, sizes), False
    moves = _moves(work, n, sizes, touching, count, shift)
    if moves:
        for k in range(count):
            work.unique[touching[k]] = shift[k, k] <= PART
    return after, moves


@compiled
def can_shift(work: Workspace, n: int, sizes: Sizes, dependent: float) -> bool:
    """Whether load can be shifted from P so that v⁺ changes. Arguments as ``share_evenly``'s."""
    residual_of(work, n, sizes)
    return _depend(work, n, sizes, dependent) and _shift_moves(work, n, sizes, dependent)


@entry(lambda: (workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), 0.0), seconds=1.0, apart=True)
def _shift_moves(work: Workspace, n: int, sizes: Sizes, dependent: float) -> bool:
    """``can_shift`` between normals that do depend on each other."""
    work = borrowed(work)
    touching = np.empty(n, np.int64)
    count = _touching(work, n, sizes, touching)
    shift = _shifts(work, touching, count, dependent)
    if _contradict(work, n, sizes, touching, count, shift):
        return False
    return _moves(work, n, sizes, touching, count, shift)


@compiled
def _depend(work: Workspace, n: int, sizes: Sizes, dependent: float) -> bool:
    """Whether contacts touch and slip whose normals depend on each other."""
    work = borrowed(work)
    touching = np.empty(n, np.int64)
    count = _touching(work, n, sizes, touching)
    return count > 0 and is_redundant(_normals(work, touching, count), count, dependent, 0.0)


@borrowing
def _touching(work: Workspace, n: int, sizes: Sizes, touching: np.ndarray) -> int:
    """Write the contacts that touch; how many, or 0 where none of them slips."""
    count, slides = int(np.int64(0)), 0
    for i in range(n):
        k = 3 * i + 2
        if work.xi[k] <= STILL * sizes.scale and work.W[k, k] > sizes.least:
            touching[count] = i
            count += 1
            slides += 1 if _slides(work, i, sizes) else 0
    return count if slides > 0 and count > 1 else 0


@compiled
def _shifts(work: Workspace, touching: np.ndarray, count: int, dependent: float) -> np.ndarray:
    """``shifts_of`` the contacts that touch."""
    return _shifts_between(_normals(work, touching, count), dependent)


@compiled
def _normals(work: Workspace, touching: np.ndarray, count: int) -> np.ndarray:
    """W_nn of the contacts that touch."""
    normal = np.empty((count, count))
    for r in range(count):
        for c in range(count):
            normal[r, c] = work.W[3 * touching[r] + 2, 3 * touching[c] + 2]
    return normal


@entry(lambda: (np.eye(2), 0.0), seconds=0.5)
def shifts_of(normal: np.ndarray, dependent: float) -> np.ndarray:
    """(k, k) Π onto the shifts of load that move no normal, in units of 1/√D.

    Args:
        normal: (k, k) W_nn, D its diagonal, above 0 [1/kg].
        dependent: pivots, the diagonal being 1, below which rows depend on each other.
    """
    return _shifts_between(normal, dependent)


@compiled
def _shifts_between(normal: np.ndarray, dependent: float) -> np.ndarray:
    """As ``shifts_of``."""
    count = len(normal)
    unit, factor, shift = np.empty(count), np.empty((count, count)), np.zeros((count, count))
    for r in range(count):
        unit[r] = 1.0 / math.sqrt(normal[r, r])
    for r in range(count):
        for c in range(count):
            factor[r, c] = normal[r, c] * unit[r] * unit[c]
    order = np.empty(count, np.int64)
    rank = pivoted_cholesky(factor, count, dependent, count, order)
    if rank < count:
        room = np.empty((count, count))
        null_projector(factor, count, rank, order, room, shift)
    return shift


@borrowing
def _loaded(work: Workspace, n: int, mine: np.ndarray, count: int) -> int:
    """Keep those of the contacts that have a load, in place; how many."""
    left, most = int(np.int64(0)), _largest_load(work, n)
    for k in range(count):
        i = mine[k]
        if work.P[3 * i + 2] - work.floor[i] > NO_LOAD * most:
            mine[left] = i
            left += 1
    return left


@compiled
def _polish_giving(work: Workspace, n: int, sizes: Sizes, touching: np.ndarray, count: int) -> None:
    """P where all that touches gives way a little, which tells what has a load."""
    if _polish_at(work, n, sizes, touching, count, SOFT_BED) <= BAR:
        return
    for k in range(MOST_STAGES, -1, -1):
        _polish_at(work, n, sizes, touching, count, SOFT_BED * TENFOLD**k)


@compiled
def _polish_at(
    work: Workspace, n: int, sizes: Sizes, touching: np.ndarray, count: int, give: float
) -> float:
    """P where contacts give way by a share of their own mobility; the residual."""
    saved = np.empty(count)
    for r in range(count):
        i = 3 * touching[r] + 2
        saved[r] = work.W[i, i]
        work.W[i, i] *= 1.0 + give
    if not polish(work, n, sizes, MOST_STEPS, RIDGE) <= BAR:
        approach_in_rounds(work, n, sizes, NO_ROUND, ALL_ROUNDS, BAR)
    _finish(work, n, sizes)
    residual = residual_of(work, n, sizes)
    for r in range(count):
        i = 3 * touching[r] + 2
        work.W[i, i] = saved[r]
    return residual


@compiled
def _polish_even(
    work: Workspace,
    n: int,
    sizes: Sizes,
    mine: np.ndarray,
    kept: int,
    among: np.ndarray,
    unloaded: np.ndarray,
) -> None:
    """P of the law in which shifts among ``mine`` are stiff; W and b are as before after it.

    ``unloaded`` (n,) tells others that touch and are to get no load: they are taken to part.
    """
    saved, unit = np.empty((kept, kept)), np.empty(kept)
    for r in range(kept):
        unit[r] = math.sqrt(work.W[3 * mine[r] + 2, 3 * mine[r] + 2])
    for r in range(kept):
        for c in range(kept):
            i, j = 3 * mine[r] + 2, 3 * mine[c] + 2
            saved[r, c] = work.W[i, j]
            work.W[i, j] += unit[r] * among[r, c] * unit[c]
    free = work.b[: 3 * n].copy()
    for i in range(n):
        if unloaded[i]:
            work.b[3 * i + 2] += sizes.scale
    left = polish(work, n, sizes, MOST_STEPS, RIDGE)
    if not left <= BAR:
        approach_in_rounds(work, n, sizes, NO_ROUND, ALL_ROUNDS, BAR)
    if not left <= FINE:
        _finish(work, n, sizes)
    for k in range(3 * n):
        work.b[k] = free[k]
    for r in range(kept):
        for c in range(kept):
            work.W[3 * mine[r] + 2, 3 * mine[c] + 2] = saved[r, c]


@borrowing
def _finish(work: Workspace, n: int, sizes: Sizes) -> None:
    """Bring P near the even share to rounding.

    Where contacts are just without load, steps that leave out what seems to depend stay where they
    are; springs have made all of it regular.
    """
    best, bar = work.best, math.inf
    for _ in range(MOST_RIDGED):
        residual, fine = residual_of(work, n, sizes), bar <= FINE
        if residual < bar:
            bar = residual
            for k in range(3 * n):
                best[k] = work.P[k]
        # One step more is for the last digits.
        if fine or not stepped(work, n, sizes, RIDGE, bool(NO)):
            break
    for k in range(3 * n):
        work.P[k] = best[k]


@borrowing
def _contradict(
    work: Workspace, n: int, sizes: Sizes, touching: np.ndarray, count: int, shift: np.ndarray
) -> bool:
    """Whether normals that depend on each other are asked for velocities that do not."""
    apart = 0.0
    for r in range(count):
        i, along = 3 * touching[r] + 2, 0.0
        for c in range(count):
            j = 3 * touching[c] + 2
            along += shift[r, c] * work.xi[j] / math.sqrt(work.W[j, j])
        apart = max(apart, abs(along) * math.sqrt(work.W[i, i]))
    rounding = SUMMED * largest_term(work.W, work.P, 3 * n)
    return apart > max(TARGETS_APART * sizes.scale, rounding)


@borrowing
def _moves(
    work: Workspace, n: int, sizes: Sizes, touching: np.ndarray, count: int, shift: np.ndarray
) -> bool:
    """Whether load can be shifted, and friction that goes with it moves anything."""
    return _can_give(work, n, touching, count, shift) and _is_moved(
        work, n, sizes, touching, count, shift
    )


@borrowing
def _is_moved(
    work: Workspace, n: int, sizes: Sizes, touching: np.ndarray, count: int, shift: np.ndarray
) -> bool:
    """Whether friction that goes with a shift of load moves anything."""
    change = work.moved
    for r in range(3 * n):
        for c in range(count):
            change[c] = 0.0
        for k in range(count):
            i = touching[k]
            if not _slides(work, i, sizes):
                continue
            way = work.W[r, 3 * i] * work.slip[i, 0] + work.W[r, 3 * i + 1] * work.slip[i, 1]
            rubbed = work.mu[i] * way / math.sqrt(work.W[3 * i + 2, 3 * i + 2])
            take_off(change[:count], shift[k], -rubbed)
        for c in range(count):
            if abs(change[c]) > MOVES * math.sqrt(sizes.largest):
                return True
    return False


@borrowing
def _slides(work: Workspace, i: int, sizes: Sizes) -> bool:
    """Whether a contact slips by more than rounding."""
    speed = math.hypot(work.xi[3 * i], work.xi[3 * i + 1])
    return work.mu[i] > 0.0 and work.mode[i] >= SLIDES and speed > STILL * sizes.scale


@borrowing
def _can_give(work: Workspace, n: int, touching: np.ndarray, count: int, shift: np.ndarray) -> bool:
    """Whether load can be shifted where some of the contacts that touch have none to give.

    Known where there is one way to shift; of several ways one is taken to lead on.
    """
    most, ways, largest = _largest_load(work, n), 0.0, 0
    for k in range(count):
        ways += shift[k, k]
        largest = k if shift[k, k] > shift[largest, largest] else largest
    if not SOME_WAY < ways < ONE_WAY:
        return ways > SOME_WAY
    up, down = True, True
    for k in range(count):
        i = touching[k]
        if work.P[3 * i + 2] - work.floor[i] <= NO_LOAD * most and shift[k, k] > PART:
            up = up and shift[k, largest] > 0.0
            down = down and shift[k, largest] < 0.0
    return up or down


@borrowing
def _largest_load(work: Workspace, n: int) -> float:
    """The largest normal impulse [N s]."""
    most = 0.0
    for i in range(n):
        most = max(most, work.P[3 * i + 2])
    return most
