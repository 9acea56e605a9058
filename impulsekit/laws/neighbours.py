"""Other answers beside a known one: a contact lifted off that presses, or held that parts.

The natural map of the law has degree 1, and an answer the index of its Newton system's determinant,
so that others come in pairs of +1 and −1 (Facchinei & Pang 2003, §2.1). Those found by trying all
modes of thousands of falls were neighbours: between an answer in which a contact presses and one in
which it parts stands a third in which it slides and jams. So it is asked, contact by contact and
with what the others do left as it is, whether one that presses would stay away once lifted off,

    ξ_n = −(Ŵ P)_n ≥ 0,    Ŵ being W of the contact with the answer of the others,

and whether one that parts could be held by what lies in its cone, P = −Ŵ⁻¹ ξ. Where that is so, or
nearly, Newton's method starts from there.
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import compiled, entry
from .dense import factorize, gauss, put, solve_factorized
from .found import keep_if_new
from .least_shares import least_holding
from .modes import (
    MOST_STEPS,
    PARTS,
    RIDGE,
    SLIDES,
    add_stiffness,
    assemble,
    polish,
    residual_of,
    sizes_of,
    write_onto_modes,
)
from .tolerances import BAR, SINGULAR, UNLOADED
from .workspace import Workspace, workspace

__all__ = ["add_neighbours", "find_neighbours"]

# Shares of W_nn P_n that a contact may come back with when it is lifted off, to be tried: of 1000
# falls of Solo12 with µ = 1 those with others were below 0.05, and 46 of the rest below 0.1. The
# second where another comes to touch meanwhile, or slip turns by more than this (the inverse of a
# cosine of 8 degrees): bodies that two contacts share had others at 0.25; of falls 13 % are below.
COMES_BACK, COMES_BACK_ELSE, TURNED = 0.1, 0.5, 1.01
# Friction that would hold a contact that parts, over its bound, to be tried: 1 in theory.
HELD_BY = 1.2
# What an answer beside the one shown may leave: one that nearly is one, where targets of redundant
# contacts contradict each other by little, is none.
NEIGHBOUR_FOUND = 1e-13
# Contacts of which neighbours are looked for: it takes 3 µs at four, and grows as their cube.
MOST = 8
# The friction by which a contact is held fast while the others come to rest.
FAST = 1e3
# [of all velocities] What keeps a contact off while the others come to rest.
OFF = 1e3


def _examples() -> tuple[object, ...]:
    return workspace(1), 1, np.ones(3), False, np.ones((2, 3)), 1


@entry(_examples, seconds=2.0, apart=True)
def add_neighbours(
    work: Workspace, n: int, shown: np.ndarray, releases: bool, found: np.ndarray, count: int
) -> int:
    """How many answers there are with those beside ``shown``, which are written to ``found``.

    Of more than MOST contacts, and where those that press are redundant, none is looked for.

    Args:
        work: W, b and friction of one phase without floors, tangents without friction cleared.
        n: how many contacts.
        shown: (3n,) P of an answer of it [N s].
        releases: whether e times P comes back. Contacts that cannot move every way are not held
            then: how they would share the load is open, and what they do a matter of rounding.
        found: (most, 3n) answers so far.
        count: how many these are.
    """
    if n > MOST:
        return count
    work = borrowed(work)
    size = 3 * n
    sizes = sizes_of(work, n, 0.0)
    put(shown, work.P)
    if not residual_of(work, n, sizes) <= BAR:
        return count
    for i in range(n):
        # What carries nothing parts, whatever the rounding of its velocity.
        if not work.W[3 * i + 2, 3 * i + 2] * work.P[3 * i + 2] > UNLOADED * sizes.scale:
            work.mode[i] = PARTS
    m = write_onto_modes(work, n)
    assemble(work, m)
    add_stiffness(work, n)
    order, starts = np.empty(size, np.int64), np.empty((n, size))
    block, p, column = np.empty((3, 3)), np.empty(3), np.empty(size)
    if not factorize(work.matrix, m, order) or _is_singular(work.matrix, m):
        return count
    tried, any_tried = np.zeros(n, np.bool_), False
    rigid = np.zeros(n, np.bool_)
    for i in range(n):
        if work.mode[i] == PARTS:
            k = 3 * i
            if max(work.W[k, k], work.W[k + 1, k + 1], work.W[k + 2, k + 2]) <= sizes.least:
                continue
            _answer_to(work, n, m, i, order, block, p, column)
            near, rigid[i] = _hold_one(block, work.mu[i], p)
            near = near and not (rigid[i] and releases)
        else:
            near = _comes_off(work, n, m, i, order, block, p, column)
        if near:
            tried[i], any_tried = True, True
            _write_start(work, n, m, i, order, p, column, starts[i])
    if not any_tried:
        return count
    for i in range(n):
        if not tried[i]:
            continue
        put(starts[i], work.P)
        k = 3 * i + 2
        b = work.b[k]
        if work.P[k] == 0.0:
            # The others come to rest without it.
            work.b[k] = b + OFF * sizes.scale
        if rigid[i]:
            # At the edge of its cone, where its share begins, rounding would decide what it does.
            mu, work.mu[i] = work.mu[i], FAST
            polish(work, n, sizes, MOST_STEPS, RIDGE)
            work.mu[i] = mu
            _share_one(work, n, i)
        else:
            polish(work, n, sizes, MOST_STEPS, RIDGE)
        work.b[k] = b
        if residual_of(work, n, sizes) <= NEIGHBOUR_FOUND:
            count = keep_if_new(work.W[:size, :size], work.P[:size], sizes.scale, found, count)
    return count


@compiled
def find_neighbours(
    work: Workspace,
    b: np.ndarray,
    n: int,
    shown: np.ndarray,
    e: np.ndarray,
    releases: bool,
    found: np.ndarray,
) -> int:
    """How many answers of the first phase there are with the one shown; 0 where none is beside it.

    Args:
        work: W, b and friction of that phase, tangents without friction cleared.
        b: (3n,) as in ``work`` [m/s].
        n: how many contacts.
        shown: (3n,) P of the whole impact [N s].
        e: (n,) restitution.
        releases: whether e times P comes back.
        found: (most, 3n), written: P [N s].
    """
    P = shown.copy()
    if releases:
        sizes = sizes_of(work, n, 0.0)
        for i in range(n):
            loaded = shown[3 * i + 2] > 0.0
            for k in range(3 * i, 3 * i + 3):
                work.P[k] = shown[k] / (1.0 + e[i])
            # What carries nothing in the end carried nothing at first.
            work.b[3 * i + 2] += 0.0 if loaded else OFF * sizes.scale
        polish(work, n, sizes, MOST_STEPS, RIDGE)
        put(b, work.b)
        put(work.P[: 3 * n], P)
    put(P, found[0])
    count = add_neighbours(work, n, P, releases, found, 1)
    return count if count > 1 else 0


@borrowing
def _is_singular(system: np.ndarray, m: int) -> bool:
    """Whether the pivots of a factorized system tell that it is."""
    least, most = math.inf, 0.0
    for k in range(m):
        least = min(least, abs(system[k, k]))
        most = max(most, abs(system[k, k]))
    return least <= SINGULAR * most


@borrowing
def _comes_off(
    work: Workspace,
    n: int,
    m: int,
    i: int,
    order: np.ndarray,
    block: np.ndarray,
    p: np.ndarray,
    column: np.ndarray,
) -> bool:
    """Whether contact i, which presses, may stay away once it is lifted off.

    By itself it comes back hardly or not at all, or another that parts comes to touch instead.
    """
    k = 3 * i
    first, own = 0, 0
    for r in range(m):
        if work.owner[r] == i:
            first = r if own == 0 else first
            own += 1
    if own == 0:
        return False
    # P_n is the first unknown of a contact that slides, and the last of others.
    normal = own - 1 if own != 2 else 0
    for c in range(own):
        for r in range(m):
            column[r] = 1.0 if r == first + c else 0.0
        solve_factorized(work.matrix, m, order, column)
        for r in range(own):
            block[r, c] = column[first + r]
        p[c] = work.P[k + c] if own == 3 else 0.0
    p[normal] = work.P[k + 2]
    alone = work.W[k + 2, k + 2] * work.P[k + 2]
    if not gauss(block, own, p):
        return False
    off = bool(p[normal] <= COMES_BACK * alone)
    if not off and p[normal] <= COMES_BACK_ELSE * alone:
        for r in range(m):
            column[r] = p[r - first] if first <= r < first + own else 0.0
        solve_factorized(work.matrix, m, order, column)
        off = _changes_others(work, n, m, i, column, p)
    p[0], p[1], p[2] = -work.P[k], -work.P[k + 1], -work.P[k + 2]
    return off


@borrowing
def _changes_others(
    work: Workspace, n: int, m: int, i: int, column: np.ndarray, p: np.ndarray
) -> bool:
    """Whether a contact beside i comes to touch, or slips another way, as the unknowns fall.

    Args:
        work: with P, modes and ways.
        n, m: how many contacts and unknowns.
        i: the contact that is lifted off.
        column: (m,) by how much the unknowns fall.
        p: (3,) buffer.
    """
    for j in range(n):
        k = 3 * j
        if j == i:
            continue
        if work.mode[j] == PARTS:
            rate = work.b[k + 2]
            for r in range(3 * n):
                rate += work.W[k + 2, r] * work.P[r]
            for u in range(m):
                for r in range(3 * work.owner[u], 3 * work.owner[u] + 3):
                    rate -= work.W[k + 2, r] * work.way[u, r] * column[u]
            if rate < 0.0:
                return True
            continue
        if work.mode[j] != SLIDES:
            continue
        p[0], p[1], p[2] = work.P[k], work.P[k + 1], work.P[k + 2]
        for u in range(m):
            if work.owner[u] == j:
                for r in range(3):
                    p[r] -= work.way[u, k + r] * column[u]
        if math.hypot(p[0], p[1]) > TURNED * work.mu[j] * p[2]:
            return True
    return False


@borrowing
def _answer_to(
    work: Workspace,
    n: int,
    m: int,
    i: int,
    order: np.ndarray,
    block: np.ndarray,
    p: np.ndarray,
    column: np.ndarray,
) -> None:
    """Write Ŵ of contact i, which parts, and the velocity that would hold it."""
    k = 3 * i
    for c in range(3):
        _yield_to(work, m, k + c, order, column)
        for r in range(3):
            total = work.W[k + r, k + c]
            for u in range(m):
                for j in range(3 * work.owner[u], 3 * work.owner[u] + 3):
                    total -= work.W[k + r, j] * work.way[u, j] * column[u]
            block[r, c] = total
        p[c] = -work.b[k + c]
        for j in range(3 * n):
            p[c] -= work.W[k + c, j] * work.P[j]


@borrowing
def _yield_to(work: Workspace, m: int, row: int, order: np.ndarray, column: np.ndarray) -> None:
    """Write by how much the unknowns fall where a unit impulse acts on this row."""
    for u in range(m):
        total = 0.0
        for j in range(3 * work.owner[u], 3 * work.owner[u] + 3):
            total += work.aim[u, j] * work.W[j, row]
        column[u] = total
    solve_factorized(work.matrix, m, order, column)


@borrowing
def _write_start(
    work: Workspace,
    n: int,
    m: int,
    i: int,
    order: np.ndarray,
    p: np.ndarray,
    column: np.ndarray,
    start: np.ndarray,
) -> None:
    """Write the impulses from which Newton starts, p (3,) being added to contact i."""
    for j in range(3 * n):
        start[j] = work.P[j]
    holds = work.mode[i] == PARTS
    for c in range(3):
        start[3 * i + c] += p[c]
        if holds:
            _yield_to(work, m, 3 * i + c, order, column)
            for u in range(m):
                for j in range(3 * work.owner[u], 3 * work.owner[u] + 3):
                    start[j] -= work.way[u, j] * column[u] * p[c]


@compiled
def _hold_one(block: np.ndarray, mu: float, p: np.ndarray) -> tuple[bool, bool]:
    """Whether a contact is held by what lies in its cone or nearly, and if it is rigid that way.

    Rigid is what cannot move every way: its impulse is not determined.

    Args:
        block: (3, 3) Ŵ.
        mu: friction.
        p: (3,) the velocity to be made [m/s]; what holds it [N s] is written.
    """
    if mu == 0.0:
        p[0], p[1] = 0.0, 0.0
        p[2] = p[2] / block[2, 2] if block[2, 2] != 0.0 else 0.0
        return bool(p[2] > 0.0), False
    own, order = block.copy(), np.empty(3, np.int64)
    if factorize(own, 3, order) and not _is_singular(own, 3):
        solve_factorized(own, 3, order, p)
        return bool(p[2] > 0.0 and math.hypot(p[0], p[1]) <= HELD_BY * mu * p[2]), False
    # What cannot move every way may be held by other shares of P, or where others let go.
    for r in range(3):
        for c in range(3):
            own[r, c] = 0.5 * (block[r, c] + block[c, r])
    _least_share(own, mu, p)
    return bool(p[2] > 0.0), True


@compiled
def _least_share(block: np.ndarray, mu: float, p: np.ndarray) -> None:
    """The impulse p (3,) [N s] within its cone that makes the velocity p [m/s], or nearly."""
    one = workspace(1)
    for r in range(3):
        for c in range(3):
            one.W[r, c] = block[r, c]
        one.b[r] = -p[r]
    one.mu[0] = mu
    least_holding(one, 1, sizes_of(one, 1, 0.0))
    put(one.P[:3], p)


@compiled
def _share_one(work: Workspace, n: int, i: int) -> None:
    """Bring the impulse of a contact that is held fast into its cone, if a share lies there."""
    k = 3 * i
    block, p = work.W[k : k + 3, k : k + 3].copy(), np.empty(3)
    for r in range(3):
        p[r] = -work.b[k + r]
        for j in range(3 * n):
            if j < k or j > k + 2:
                p[r] -= work.W[k + r, j] * work.P[j]
    _least_share(block, work.mu[i], p)
    for r in range(3):
        work.P[k + r] = p[r]
