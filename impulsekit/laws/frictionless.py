"""Several contacts without friction: 0 ≤ P_n ⊥ W P_n + b ≥ 0, solved exactly.

First the contacts that would approach are taken to push, and those that come out wrong are
swapped, all at once (Júdice & Pires 1994, block principal pivoting). That may cycle, and says
nothing where contacts are redundant or just touch: these are pressed in one by one.
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .compiled import compiled, entry
from .dense import cholesky, eliminate
from .pressing import press, share
from .status import Status
from .tolerances import AT_REST_AMONG_OTHERS, RESIDUAL_LIMIT
from .words import AGAIN
from .workspace import Workspace, workspace

__all__ = ["frictionless"]

# Pivots over their diagonal below which contacts need a closer look.
LOOK_CLOSER = 1e-9
# What large impulses in balance may leave of the velocities that they share.
BALANCED_LOADS = 100.0
_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)
# It takes a closer look.
_LOOK = -2
_NONE, _NOT_CONVERGED = int(Status.NO_SOLUTION), int(Status.NOT_CONVERGED)


def _examples() -> tuple[object, ...]:
    return workspace(1), np.eye(3), np.ones(3), 1, 1.0, 0.0, 0.0, False


@entry(_examples, seconds=4.0, apart=True)
def frictionless(
    work: Workspace,
    W: np.ndarray,
    b: np.ndarray,
    n: int,
    scale: float,
    spread: float,
    dependent: float,
    regular: bool,
) -> tuple[int, float]:
    """P of n contacts that only push, tangents left out; the code, or AGAIN, and the residual.

    Args:
        work: room; P and ``unique`` are written.
        W, b: (3n, 3n) and (3n,), of which the normals are read.
        n: how many contacts.
        scale: the size of the normal velocities [m/s].
        spread: contacts of which one moves less than this share of another are left.
        dependent: pivots over their diagonal below which contacts are redundant.
        regular: whether such are left.
    """
    for i in range(n):
        work.unique[i] = True
    code = _exchange(work, W, b, n, scale, spread, max(dependent, LOOK_CLOSER))
    if code == _LOOK and regular:
        return AGAIN, 0.0
    if code == _LOOK:
        code = _press_in(work, W, b, n, scale)
    if code in (AGAIN, _NONE):
        return code, 1.0
    residual = _residual(work, W, b, n)
    if residual > RESIDUAL_LIMIT * scale:
        return _NOT_CONVERGED, residual / scale
    return code, residual / scale if scale > 0.0 else 0.0


@compiled
def _press_in(work: Workspace, W: np.ndarray, b: np.ndarray, n: int, scale: float) -> int:
    """P where contacts are redundant or just touch; the code."""
    A, c, p, u = np.empty((n, n)), np.empty(n), np.empty(n), np.empty(n)
    for i in range(n):
        c[i] = b[3 * i + 2]
        for k in range(n):
            A[i, k] = W[3 * i + 2, 3 * k + 2]
    tiny = AT_REST_AMONG_OTHERS * scale
    found = press(A, c, n, tiny, p, u)
    for i in range(n):
        work.P[3 * i], work.P[3 * i + 1], work.P[3 * i + 2] = 0.0, 0.0, p[i]
    if not found:
        return _NONE
    shared = share(A, n, tiny, p, u, work.unique)
    for i in range(n):
        work.x[i] = work.P[3 * i + 2]
        work.P[3 * i + 2] = p[i]
    if _residual(work, W, b, n) > BALANCED_LOADS * tiny:
        # Rows almost dependent: the pivots' answer is the better one.
        for i in range(n):
            work.P[3 * i + 2] = work.x[i]
    return _NOT_UNIQUE if shared else _SOLVED


@borrowing
def _exchange(
    work: Workspace,
    W: np.ndarray,
    b: np.ndarray,
    n: int,
    scale: float,
    spread: float,
    dependent: float,
) -> int:
    """P if swapping all wrong contacts at once finds it and it is clearly unique; the code."""
    P, block, lower, x = work.P, work.matrix, work.way, work.x
    pushing, wrong, chosen = work.y, work.z, work.mode
    tiny = AT_REST_AMONG_OTHERS * scale
    approaching = False
    for k in range(3 * n):
        P[k] = 0.0
    for i in range(n):
        pushing[i] = 1.0 if b[3 * i + 2] < -tiny else 0.0
        approaching = approaching or b[3 * i + 2] < -tiny
    if not approaching:
        return _SOLVED
    lightest, heaviest = 0.0, math.inf
    for k in range(2, 3 * n, 3):
        lightest, heaviest = max(lightest, W[k, k]), min(heaviest, W[k, k])
    if heaviest < spread * lightest:
        return AGAIN
    fewest = n + 1
    for _ in range(10):
        m = int(np.int64(0))
        for i in range(n):
            if pushing[i] > 0.0:
                chosen[m] = i
                m += 1
        for i in range(m):
            for j in range(m):
                block[i, j] = W[3 * chosen[i] + 2, 3 * chosen[j] + 2]
            x[i] = -b[3 * chosen[i] + 2]
        if not cholesky(block, m, lower) > dependent:
            return _LOOK
        eliminate(lower, m, x)
        for i in range(n):
            P[3 * i + 2] = 0.0
        for i in range(m):
            P[3 * chosen[i] + 2] = x[i]
        number = 0
        slowest = math.inf
        for i in range(n):
            if pushing[i] > 0.0:
                wrong[i] = 1.0 if P[3 * i + 2] < 0.0 else 0.0
            else:
                u = b[3 * i + 2]
                for j in range(m):
                    u += W[3 * i + 2, 3 * chosen[j] + 2] * x[j]
                wrong[i] = 1.0 if u < -tiny else 0.0
                slowest = min(slowest, u)
            number += 1 if wrong[i] > 0.0 else 0
        if number == 0:
            # Contacts that just touch may share the load.
            return _SOLVED if slowest > tiny else _LOOK
        if number >= fewest:
            return _LOOK
        fewest = number
        for i in range(n):
            pushing[i] = 1.0 if pushing[i] != wrong[i] else 0.0
    return _LOOK


@borrowing
def _residual(work: Workspace, W: np.ndarray, b: np.ndarray, n: int) -> float:
    """max |min(W P + b, W_kk P_k)| over the normals [m/s]."""
    P = work.P
    worst = 0.0
    for k in range(2, 3 * n, 3):
        speed = b[k]
        for j in range(2, 3 * n, 3):
            speed += W[k, j] * P[j]
        error = abs(min(speed, W[k, k] * P[k]))
        if not error <= worst:
            worst = error
    return worst
