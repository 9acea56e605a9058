"""Contact after contact in closed form, until all agree (projected Gauss-Seidel)."""

from __future__ import annotations

import numpy as np

from ...laws.coulomb import released
from .single import block_of

__all__ = ["sweep"]

SWEEPS = 50


def sweep(
    delassus: np.ndarray,
    shifted: np.ndarray,
    friction: np.ndarray,
    floor: np.ndarray | None,
    start: np.ndarray,
    scale: float,
) -> tuple[np.ndarray, int]:
    """P after up to 50 sweeps from ``start``, and how many it took; slow and hardy.

    Args:
        delassus: (3n, 3n) W [1/kg].
        shifted: (3n,) b [m/s].
        friction: (n,) µ.
        floor: (n,) the least normal impulses [N s]; None for 0.
        start: (3n,) where to begin [N s].
        scale: the size of the velocities [m/s].
    """
    n = len(friction)
    impulse = start.copy()
    velocity = delassus @ impulse + shifted
    mus = friction.tolist()
    floors = [0.0] * n if floor is None else floor.tolist()
    blocks = [block_of(delassus, i) for i in range(n)]
    columns = [np.ascontiguousarray(delassus[:, 3 * i : 3 * i + 3]) for i in range(n)]
    for count in range(1, SWEEPS + 1):
        largest = 0.0
        for i in range(n):
            at = slice(3 * i, 3 * i + 3)
            t11, t12, t22, n1, n2, nn = blocks[i]
            p1, p2, pn = impulse[at].tolist()
            u1, u2, un = velocity[at].tolist()
            own = (
                u1 - t11 * p1 - t12 * p2 - n1 * pn,
                u2 - t12 * p1 - t22 * p2 - n2 * pn,
                un - n1 * p1 - n2 * p2 - nn * pn,
            )
            found, _ = released(blocks[i], own, mus[i], floors[i], scale)
            change = np.array((found[0] - p1, found[1] - p2, found[2] - pn))
            impulse[at] = found
            step = columns[i] @ change
            velocity += step
            largest = max(largest, float(np.abs(step).max()))
        if largest <= 1e-13 * scale:
            return impulse, count
        # Afresh, so that rounding does not pile up from sweep to sweep.
        velocity = delassus @ impulse + shifted
    return impulse, SWEEPS
