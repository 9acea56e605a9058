"""What would hold every contact still (``impact.laws.sticking``), for kernels.

``solve`` tries it first: where more than one answer obeys the law, what is tried first decides.
"""

from __future__ import annotations

from .dense import cholesky, eliminate
from .jit import built_in

__all__ = ["held_still"]

# As in ``impact.laws``: pivots above which W is regular, and what stands in for those below.
REGULAR = 1e-6
RIDGE = 1e-9


@built_in
def held_still(W, b, size, largest, least, P, matrix, lower, x):
    """Write P (3n,) with W P + b = 0, or as near as can be; the ridge, or -1 where W is singular.

    Args:
        largest: the largest entry on the diagonal of W.
        least: what counts as a diagonal of nothing; such rows are regular, and want a ridge.
        matrix, lower: room, (3n, 3n).
        x: room, (3n,).
    """
    ridge = 0.0
    for i in range(size):
        P[i] = 0.0
        for j in range(size):
            matrix[i, j] = W[i, j]
        if W[i, i] <= least:
            matrix[i, i] = largest
            ridge = RIDGE
    times = 2
    if not cholesky(matrix, size, lower) > REGULAR:
        for i in range(size):
            matrix[i, i] *= 1.0 + RIDGE
        ridge = -1.0
        if not cholesky(matrix, size, lower) > 0.0:
            return ridge
        times = 3
    # Once, and again for what the ridge or rounding has left.
    for _ in range(times):
        for i in range(size):
            total = b[i]
            for j in range(size):
                total += W[i, j] * P[j]
            x[i] = -total
        eliminate(lower, size, x)
        for i in range(size):
            P[i] += x[i]
    return ridge
