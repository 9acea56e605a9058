"""Several contacts of one state at once: without friction, or with it, or redundant."""

from __future__ import annotations

import math

from ..codes import AGAIN
from .dense import rank_by_pivots
from .jit import built_in
from .many import frictional
from .problem import COARSE
from .smooth import frictionless

__all__ = ["DEPENDENT", "is_dependent", "several"]

# Two contacts with 1 − r² below this, r their correlation in W, all but coincide.
COINCIDENT = 1e-6
DEPENDENT = 1e-10


@built_in
def several(b, count, smooth, scale, digits, space):
    """The code, with P in ``space``: Coulomb's law with ξ = W P + b.

    Args:
        b: (3n,), used up.
        smooth: whether none has friction.
        scale: the size of the normal velocities.
    """
    square, line, (slip, found, roots), (_, mode) = space
    W, own, way, aim, newton = square[0], square[4], square[5], square[6], square[7]
    mus, P, nothing = line[2], line[9], line[18]
    best, xi, x, moved, _, split_y, split_z = line[11:18]
    size = 3 * count
    # What is left in doubt is solved again in double precision.
    dependent = DEPENDENT if digits == 53 else COARSE
    if smooth:
        code = frictionless(W, b, count, scale, max(dependent, 1e-9), P)
        if code != AGAIN or digits < 53 or not _are_apart(W, count):
            return code
    # Redundant contacts share by splitting, with or without friction.
    if digits < 53 and is_dependent(W, size, own, aim, COARSE):
        return AGAIN
    if digits == 53 and not smooth and not _are_apart(W, count):
        return AGAIN
    for i in range(size):
        for j in range(size):
            own[i, j] = W[i, j]
    code = frictional(
        own, b, mus, nothing, count, dependent, P, best, xi, mode, slip, way, aim, newton, x,
        moved, split_y, split_z, found, roots,
    )  # fmt: skip
    if smooth and code != AGAIN and _touches_idly(own, b, count, scale, P):
        return AGAIN
    return code


@built_in
def _are_apart(W, count):
    """Whether no two contacts all but coincide: rounding, or a hair, would share their load."""
    for i in range(count):
        for j in range(i):
            if not _is_along(W, 3 * i + 2, 3 * j + 2):
                continue
            # The tangents of planes that differ by a hair may stand in another order.
            for other in (3 * j, 3 * j + 1):
                if _is_along(W, 3 * i, other) and _is_along(W, 3 * i + 1, 6 * j + 1 - other):
                    return False
    return True


@built_in
def _is_along(W, a, b):
    """Whether two rows all but coincide."""
    own = W[a, a] * W[b, b]
    return not own - W[a, b] ** 2 > COINCIDENT * own


@built_in
def _touches_idly(W, b, count, scale, P):
    """Whether a contact that just touches bears nothing: it may share what others bear."""
    most = 0.0
    for i in range(count):
        most = max(most, P[3 * i + 2])
    for i in range(count):
        k = 3 * i + 2
        speed = b[k]
        for j in range(count):
            speed += W[k, 3 * j + 2] * P[3 * j + 2]
        if P[k] <= 1e-9 * most and speed <= 1e-9 * scale:
            return True
    return False


@built_in
def is_dependent(W, size, matrix, scale, bar):
    """Whether rows of contacts depend on each other, pivots below a bar being none."""
    for i in range(size):
        if not W[i, i] > 0.0:
            return True
        scale[0, i] = 1.0 / math.sqrt(W[i, i])
    for i in range(size):
        for j in range(size):
            matrix[i, j] = W[i, j] * scale[0, i] * scale[0, j]
    return rank_by_pivots(matrix, size, bar) < size
