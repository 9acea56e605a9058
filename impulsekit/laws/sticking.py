"""What would hold every contact still: the first guess at contacts with friction.

An answer in which nothing slips obeys the law without De Saxcé's correction, a convex problem
(Acary, Cadoux, Lemaréchal & Malick 2011). So its velocities are the only ones of such an answer,
and it is taken wherever there is one: where more than one answer obeys the law, what is tried
first decides. Where W is regular, Newton on the modes starts from here as well.
"""

from __future__ import annotations

from .borrowed import borrowing
from .dense import cholesky, eliminate
from .modes import RIDGE
from .tolerances import CLEAR
from .workspace import Sizes, Workspace

__all__ = ["held_still"]


@borrowing
def held_still(work: Workspace, n: int, sizes: Sizes) -> float:
    """Write P (3n,) with W P + b = 0, or as near as can be; the ridge, or -1 where W is singular.

    Of redundant contacts each gets its share as if it gave way in proportion to its own
    mobility, along the normal and across it. Rows that move nothing count as regular, get
    nothing, and want a ridge.
    """
    W, b, P, matrix, lower, x = work.W, work.b, work.P, work.matrix, work.way, work.x
    size = 3 * n
    ridge = 0.0
    for i in range(size):
        P[i] = 0.0
        for j in range(size):
            matrix[i, j] = W[i, j]
        if W[i, i] <= sizes.least:
            matrix[i, i] = sizes.largest
            ridge = RIDGE
    times = 2
    if not cholesky(matrix, size, lower) > CLEAR:
        for k in range(0, size, 3):
            # To both tangents alike, so that their directions decide nothing.
            across = 0.5 * (matrix[k, k] + matrix[k + 1, k + 1])
            matrix[k, k] += RIDGE * across
            matrix[k + 1, k + 1] += RIDGE * across
            matrix[k + 2, k + 2] *= 1.0 + RIDGE
        ridge = -1.0
        if not cholesky(matrix, size, lower) > 0.0:
            return ridge
        times = 3
    # Once, and again for what the ridge or rounding has left.
    for _ in range(times):
        for i in range(size):
            x[i] = -b[i]
        for j in range(size):
            for i in range(size):
                x[i] -= W[j, i] * P[j]
        eliminate(lower, size, x)
        for i in range(size):
            P[i] += x[i]
    return ridge
