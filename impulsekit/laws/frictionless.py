"""Several contacts without friction, 0 ≤ P_n ⊥ W P_n + b ≥ 0: the ones that push.

First the contacts that would approach are taken to push, and those that come out wrong are
swapped, all at once (Júdice & Pires 1994, block principal pivoting). That may cycle, and says
nothing where contacts are redundant or just touch: these it leaves, by the code AGAIN.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .dense import cholesky, eliminate
from .status import Status
from .words import AGAIN
from .workspace import Workspace

__all__ = ["frictionless", "residual_of_normals"]

# Velocities this small against the others are zero.
AT_REST = 1e-12
_SOLVED = int(Status.SOLVED)


@compiled
def frictionless(
    work: Workspace,
    W: np.ndarray,
    b: np.ndarray,
    n: int,
    scale: float,
    spread: float,
    dependent: float,
) -> int:
    """P of n contacts that only push, tangents left out; the code, or AGAIN.

    Args:
        work: room; P is written.
        W, b: (3n, 3n) and (3n,), of which the normals are read.
        n: how many contacts.
        scale: the size of the normal velocities [m/s].
        spread: contacts of which one moves less than this share of another are left.
        dependent: pivots over their diagonal below which contacts are redundant.
    """
    P, block, lower, x = work.P, work.matrix, work.way, work.x
    pushing, wrong, chosen = work.y, work.z, work.mode
    tiny = AT_REST * scale
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
            return AGAIN
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
            return _SOLVED if slowest > tiny else AGAIN
        if number >= fewest:
            return AGAIN
        fewest = number
        for i in range(n):
            pushing[i] = 1.0 if pushing[i] != wrong[i] else 0.0
    return AGAIN


@compiled
def residual_of_normals(work: Workspace, W: np.ndarray, b: np.ndarray, n: int) -> float:
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
