"""Several contacts without friction: the ones that push, found by swapping all wrong at once.

The bars are those of ``impact.laws``, to whose solver of single states the code AGAIN leaves
what fails here.
"""

from __future__ import annotations

import math

import numpy as np

from ...laws.status import Status
from ..codes import AGAIN
from .dense import cholesky, eliminate
from .jit import built_in

__all__ = ["ALIKE", "FINE", "frictionless"]

# Residuals of rounding; what stays above is left to the solver of single states, which refines.
FINE = 4e-15
# So are contacts of which one is this much more mobile than another.
ALIKE = 1e-3
AT_REST = 1e-12
_SOLVED = int(Status.SOLVED)


@built_in
def frictionless(W, b, n, scale, dependent, P):
    """P (3n,) of n contacts that only push; the code."""
    tiny = AT_REST * scale
    pushing = np.zeros(n, dtype=np.bool_)
    wrong = np.zeros(n, dtype=np.bool_)
    approaching = False
    for k in range(3 * n):
        P[k] = 0.0
    for i in range(n):
        pushing[i] = b[3 * i + 2] < -tiny
        approaching = approaching or pushing[i]
    if not approaching:
        for i in range(n):
            if b[3 * i + 2] < -FINE * scale:
                return AGAIN
        return _SOLVED
    lightest, heaviest = 0.0, math.inf
    for i in range(n):
        lightest = max(lightest, W[3 * i + 2, 3 * i + 2])
        heaviest = min(heaviest, W[3 * i + 2, 3 * i + 2])
    if heaviest < ALIKE * lightest:
        return AGAIN
    block, lower = np.empty((n, n)), np.empty((n, n))
    x = np.empty(n)
    chosen = np.empty(n, dtype=np.int64)
    fewest = n + 1
    for _ in range(10):
        m = np.int64(0)
        for i in range(n):
            if pushing[i]:
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
            if pushing[i]:
                wrong[i] = P[3 * i + 2] < 0.0
            else:
                u = b[3 * i + 2]
                for j in range(m):
                    u += W[3 * i + 2, 3 * chosen[j] + 2] * x[j]
                wrong[i] = u < -tiny
                slowest = min(slowest, u)
            number += wrong[i]
        if number == 0:
            return _SOLVED if slowest > tiny else AGAIN
        if number >= fewest:
            return AGAIN
        fewest = number
        for i in range(n):
            pushing[i] = pushing[i] != wrong[i]
    return AGAIN
