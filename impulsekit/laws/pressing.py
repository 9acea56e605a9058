"""Contacts without friction that are redundant or just touch: 0 ≤ p ⊥ A p + c ≥ 0, exactly.

A is symmetric and positive semidefinite, of any rank. Principal pivoting goes to an answer in
finitely many steps (Keller 1973, "The general quadratic optimization problem"): one approaching
contact at a time is pressed until it approaches no more, contacts that would come to pull being
let go on the way. Where contacts are redundant, the p of least norm is taken, which does not
depend on their order.
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .compiled import compiled
from .dense import gauss
from .rank import null_rows, pivoted_cholesky
from .tolerances import AT_REST_AMONG_OTHERS, PART, ROUNDING_OF_TERMS, UNLOADED

__all__ = ["press", "share"]

# Squares of sines of angles between rows, below which they are dependent.
PARALLEL = 1e-12
# How far a contact is pulled into the load, against the largest, to see whether it can have any;
# and what it then has at least.
PULL, HAS = 1e6, 1e-6
# Rounding of sums over contacts that press, in that of one of them.
SUMS = 10.0


@compiled
def press(A: np.ndarray, c: np.ndarray, n: int, tiny: float, p: np.ndarray, u: np.ndarray) -> bool:
    """Write some p [N s] and its velocities u [m/s]; whether there is one.

    Args:
        A: (n, n) [1/kg].
        c: (n,) [m/s].
        n: how many contacts.
        tiny: velocities that count as none [m/s].
    """
    pushing, order = np.zeros(n, np.bool_), np.empty(n, np.int64)
    block, way, moved = np.empty((n, n)), np.empty(n), np.empty(n)
    for i in range(n):
        p[i], u[i] = 0.0, c[i]
    # Keller's method ends; the limit is for rounding in degenerate corners.
    for _ in range(20 * n + 20):
        entering = 0
        rest, slowest = tiny, math.inf
        for i in range(n):
            # Large impulses in balance leave their own rounding.
            rest = max(rest, SUMS * AT_REST_AMONG_OTHERS * A[i, i] * p[i])
            waits = 0.0 if pushing[i] else u[i]
            if waits < slowest:
                entering, slowest = i, waits
        if slowest >= -rest:
            return True
        while u[entering] < 0.0:
            m = _give_way(A, n, pushing, entering, order, block, way)
            for i in range(n):
                moved[i] = A[i, entering]
                for k in range(m):
                    moved[i] += A[i, order[k]] * way[k]
            step, leaving = math.inf, -1
            if moved[entering] > PARALLEL * A[entering, entering]:
                step = -u[entering] / moved[entering]
            for k in range(m):
                if way[k] < 0.0 and -p[order[k]] / way[k] < step:
                    step, leaving = -p[order[k]] / way[k], order[k]
            if not step < math.inf:
                return False
            p[entering] += step
            for k in range(m):
                p[order[k]] += step * way[k]
            if leaving >= 0:
                pushing[leaving] = False
                p[leaving] = 0.0
                _form(A, c, n, p, u)
                continue
            pushing[entering] = True
            _solve_pushing(A, c, n, pushing, order, block, p)
            _form(A, c, n, p, u)
            break
    return False


@borrowing
def _give_way(
    A: np.ndarray,
    n: int,
    pushing: np.ndarray,
    entering: int,
    order: np.ndarray,
    block: np.ndarray,
    way: np.ndarray,
) -> int:
    """How the impulses of those that push change per impulse of one more; how many push."""
    m = int(np.int64(0))
    for i in range(n):
        if pushing[i]:
            order[m] = i
            m += 1
    for r in range(m):
        way[r] = -A[order[r], entering]
        for k in range(m):
            block[r, k] = A[order[r], order[k]]
    gauss(block, m, way)
    return m


@compiled
def _solve_pushing(
    A: np.ndarray,
    c: np.ndarray,
    n: int,
    pushing: np.ndarray,
    order: np.ndarray,
    block: np.ndarray,
    p: np.ndarray,
) -> None:
    """p afresh, so that rounding does not pile up from pivot to pivot."""
    m = int(np.int64(0))
    right = np.empty(n)
    for i in range(n):
        p[i] = 0.0
        if pushing[i]:
            order[m] = i
            right[m] = -c[i]
            m += 1
    for r in range(m):
        for k in range(m):
            block[r, k] = A[order[r], order[k]]
    gauss(block, m, right)
    for r in range(m):
        p[order[r]] = max(right[r], 0.0)


@borrowing
def _form(A: np.ndarray, c: np.ndarray, n: int, p: np.ndarray, u: np.ndarray) -> None:
    """u = A p + c."""
    for i in range(n):
        u[i] = c[i]
        for k in range(n):
            u[i] += A[i, k] * p[k]


@compiled
def share(
    A: np.ndarray, n: int, tiny: float, p: np.ndarray, u: np.ndarray, unique: np.ndarray
) -> bool:
    """Bring p to the least norm among all that make the same velocities; whether it had a choice.

    Args:
        A: (n, n) [1/kg].
        n: how many contacts.
        tiny: velocities that count as none [m/s].
        p, u: (n,) an answer, and its velocities.
        unique: (n,) written: whether no other contact could carry what this one carries.
    """
    touching = np.empty(n, np.int64)
    m = int(np.int64(0))
    for i in range(n):
        # What pushes touches, whatever rounding leaves of its velocity.
        if u[i] <= SUMS * tiny or p[i] > 0.0:
            touching[m] = i
            m += 1
    null, free = _null(A, touching, m)
    if free == 0:
        return False
    own, least, pull = np.empty(m), np.empty(m), np.zeros(m)
    for j in range(m):
        own[j] = p[touching[j]]
    if not _nearest(null, free, m, own, pull, least):
        for j in range(m):
            least[j] = own[j]
    most = 0.0
    for j in range(m):
        most = max(most, least[j])
        p[touching[j]] = least[j]
    # What bears nothing can only gain: each is asked whether it can.
    left = int(np.int64(0))
    for j in range(m):
        can = least[j] > UNLOADED * most
        if not can:
            pull[j] = PULL * most
            can = _nearest(null, free, m, least, pull, own) and own[j] > HAS * most
            pull[j] = 0.0
        if can:
            touching[left] = touching[j]
            left += 1
    null, free = _null(A, touching, left)
    for j in range(left):
        part = 0.0
        for k in range(free):
            part += null[k, j] ** 2
        if part > PART:
            unique[touching[j]] = False
    return free > 0


@compiled
def _null(A: np.ndarray, rows: np.ndarray, m: int) -> tuple[np.ndarray, int]:
    """An orthonormal basis of what moves nothing among some rows of A, and how many there are."""
    block, order, null = np.empty((m, m)), np.empty(m, np.int64), np.empty((m, m))
    largest = 0.0
    for r in range(m):
        largest = max(largest, A[rows[r], rows[r]])
        for k in range(m):
            block[r, k] = A[rows[r], rows[k]]
    rank = pivoted_cholesky(block, m, PARALLEL * largest, m, order)
    null_rows(block, m, rank, order, null)
    return null, m - rank


@compiled
def _nearest(
    null: np.ndarray, free: int, m: int, given: np.ndarray, pull: np.ndarray, x: np.ndarray
) -> bool:
    """The x ≥ 0 nearest to ``pull`` among those that make what ``given`` makes; whether found.

    x = q + Π s with 0 ≤ s ⊥ x ≥ 0, Π being the projector on what moves nothing and q the nearest
    whatever its signs: a problem of the same form.
    """
    projector, q, s = np.zeros((m, m)), np.empty(m), np.empty(m)
    size = 0.0
    for i in range(m):
        q[i] = given[i]
        for j in range(m):
            for k in range(free):
                projector[i, j] += null[k, i] * null[k, j]
            q[i] += projector[i, j] * (pull[j] - given[j])
        size = max(size, abs(q[i]))
    found = press(projector, q, m, ROUNDING_OF_TERMS * size, s, x)
    for i in range(m):
        x[i] = max(x[i], 0.0) if s[i] == 0.0 else 0.0
    return found
