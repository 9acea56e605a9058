"""What would hold every contact still: the first guess at contacts with friction.

An answer in which nothing slips obeys the law without De Saxcé's correction, a convex problem
(Acary, Cadoux, Lemaréchal & Malick 2011). So its velocities are the only ones of such an answer,
and it is taken wherever there is one. Where W is regular, Newton on the modes starts from here
as well.
"""

from __future__ import annotations

import numpy as np

from .. import lapack
from .modes import NULL, RIDGE, Modes

__all__ = ["held_still"]

# Pivots of W, its diagonal being 1, above which it is regular.
REGULAR = 1e-6


def held_still(modes: Modes) -> tuple[np.ndarray, bool, float]:
    """(3n,) P with W P + b = 0, or as near as can be; whether W is regular; its ridge if so.

    Of redundant contacts each gets its share as if it gave way in proportion to its own
    mobility. Rows that move nothing count as regular, and get nothing; Newton's steps need
    a ridge for them.
    """
    matrix = modes.delassus.copy()
    diagonal = matrix.reshape(-1)[:: len(matrix) + 1]
    squares = modes.diagonal
    least = NULL * modes.largest
    ridge = 0.0
    if min(squares) <= least:
        ridge = RIDGE
        still = [i for i, square in enumerate(squares) if square <= least]
        diagonal[still] = modes.largest
        squares = diagonal.tolist()
    # It is symmetric, and LAPACK reads it by columns.
    factor, failed = lapack.dpotrf(matrix.T, lower=1)
    regular = not failed
    if regular:
        roots = factor.diagonal().tolist()
        regular = all(r * r > REGULAR * s for r, s in zip(roots, squares, strict=True))
    if not regular:
        diagonal *= 1.0 + RIDGE
        factor, failed = lapack.dpotrf(matrix.T, lower=1, overwrite_a=1)
        if failed:
            return np.zeros_like(modes.shifted), False, RIDGE
    impulse, _ = lapack.dpotrs(factor, -modes.shifted, lower=1)
    # What the ridge or rounding has left.
    for _ in range(1 if regular else 2):
        left = modes.delassus.dot(impulse) + modes.shifted
        impulse -= lapack.dpotrs(factor, left, lower=1)[0]
    return impulse, regular, ridge
