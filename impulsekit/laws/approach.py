"""Coming near the impulses of contacts with friction, from where Newton goes on."""

from __future__ import annotations

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import entry
from .coulomb import coulomb, released
from .status import Status
from .tolerances import SETTLED
from .words import MANY, Block
from .workspace import Workspace, workspace

__all__ = ["block_at", "sweep"]

_NONE = int(Status.NO_SOLUTION)


def _examples() -> tuple[object, ...]:
    return workspace(1), 1, 1.0, 1


@entry(_examples, seconds=2.5, apart=True)
def sweep(work: Workspace, n: int, scale: float, sweeps: int) -> bool:
    """Contact after contact in closed form; one that needs a second look keeps what it has.

    Whether nothing changed in the end.
    """
    work = borrowed(work)
    W, b, mu, floor, P = work.W, work.b, work.mu, work.floor, work.P
    size = 3 * n
    for _ in range(sweeps):
        largest = 0.0
        for i in range(n):
            k = 3 * i
            u1, u2, un = b[k], b[k + 1], b[k + 2]
            for j in range(size):
                if j < k or j > k + 2:
                    u1 += W[k, j] * P[j]
                    u2 += W[k + 1, j] * P[j]
                    un += W[k + 2, j] * P[j]
            block = block_at(W, k)
            if floor[i] > 0.0:
                (p1, p2, pn), code = released(block, (u1, u2, un), mu[i], floor[i], scale)
            else:
                (p1, p2, pn), code = coulomb(block, u1, u2, un, mu[i], scale)
            if code in (MANY, _NONE) and not pn > 0.0:
                continue
            largest = max(largest, W[k + 2, k + 2] * abs(pn - P[k + 2]))
            P[k], P[k + 1], P[k + 2] = p1, p2, pn
        if largest <= SETTLED * scale:
            return True
    return False


@borrowing
def block_at(W: np.ndarray, k: int) -> Block:
    """W of the contact whose rows begin at k with itself, as the law of one contact takes it."""
    return W[k, k], W[k, k + 1], W[k + 1, k + 1], W[k, k + 2], W[k + 1, k + 2], W[k + 2, k + 2]
