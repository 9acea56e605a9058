"""Several contacts with friction: Coulomb's law at all of them at once.

0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0, with ξ = W P + b.

Newton on the modes of the contacts starts from what would hold them all still; where that
finds nothing, a few rounds of sweeps or of splitting come near, and Newton goes on to rounding
level. What it does not find, and what it finds but cannot tell, is left by the code AGAIN.
"""

from __future__ import annotations

import math

import numpy as np

from .compiled import compiled
from .coulomb import coulomb
from .modes import BAR, FINE, MOST_STEPS, RIDGE, SLIDES, polish, residual_of, sizes_of
from .progress import Block
from .redundant import find_shared
from .splitting import split
from .status import Status
from .sticking import held_still
from .words import AGAIN
from .workspace import Sizes, Workspace

__all__ = ["block_at", "clear_smooth", "frictional"]

# Newton's steps from a first guess, and what rounding leaves.
FEW = 8
ROUNDING = 2e-15
# Rounds of sweeps (above 0) and of splitting (below).
SWEEPS = (3, 10, 30, -100, -200, -400, -800, 200)
ROUNDS = len(SWEEPS)
# Share of the largest load, or of the velocities, that is none.
EDGE = 1e-9
_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)
_MANY, _NONE = int(Status.MANY_SOLUTIONS), int(Status.NO_SOLUTION)


@compiled
def frictional(
    work: Workspace, n: int, scale: float, spread: float, dependent: float
) -> tuple[int, float, bool]:
    """P (3n,) of n contacts; the code, the residual, and whether W is regular.

    Args:
        work: the problem, with ``floor`` 0; W and b of smooth tangents are cleared.
        n: how many contacts.
        scale: the size of the velocities where they were larger before [m/s].
        spread: contacts of which one moves less than this share of another are left.
        dependent: pivots, the diagonal being 1, below which rows depend on each other.
    """
    P = work.P
    clear_smooth(work, n)
    slowest = math.inf
    for i in range(n):
        work.floor[i], work.unique[i] = 0.0, True
        slowest = min(slowest, work.b[3 * i + 2])
    for k in range(3 * n):
        P[k] = 0.0
    sizes = sizes_of(work, n, scale)
    if slowest >= -1e-15 * sizes.scale:
        return _SOLVED, 0.0, True
    if not sizes.largest > 0.0 or _is_spread(work, n, spread * sizes.largest):
        return AGAIN, 0.0, False
    # First what holds all still: of several answers the same is found whoever asks.
    ridge = held_still(work, n, sizes)
    if ridge >= 0.0:
        bar = polish(work, n, sizes, FEW, ridge)
        if bar <= BAR:
            return (_SOLVED if bar <= 10.0 * FINE else AGAIN), bar, True
    else:
        bar = residual_of(work, n, sizes)
        if bar > ROUNDING and not _slips(work, n):
            polish(work, n, sizes, FEW, RIDGE)
            bar = residual_of(work, n, sizes)
        if bar <= ROUNDING and not _slips(work, n):
            redundant = find_shared(work, n, sizes, dependent, False)
            return (_NOT_UNIQUE if redundant else _SOLVED), bar, False
    code, bar = _approach(work, n, sizes, dependent, ridge >= 0.0)
    return code, bar, ridge >= 0.0


@compiled
def _approach(
    work: Workspace, n: int, sizes: Sizes, dependent: float, regular: bool
) -> tuple[int, float]:
    """Rounds of sweeps and splitting, Newton after each; the code and the residual."""
    P = work.P
    for k in range(3 * n):
        P[k], work.y[k], work.z[k] = 0.0, 0.0, 0.0
    rate = 0.05 * sizes.largest
    bar = math.inf
    for k in range(ROUNDS):
        if SWEEPS[k] > 0:
            _sweep(work, n, sizes.scale, SWEEPS[k])
        else:
            rate = split(work, n, -SWEEPS[k], rate)
            for j in range(3 * n):
                P[j] = work.y[j]
        bar = polish(work, n, sizes, MOST_STEPS, RIDGE)
        if bar > BAR:
            continue
        if bar > 10.0 * FINE:
            break
        # Load that can be shifted, now or once a contact leaves an edge, is told elsewhere.
        if not regular and (
            _is_on_an_edge(work, n, sizes.scale) or find_shared(work, n, sizes, dependent, True)
        ):
            break
        return _SOLVED, bar
    return AGAIN, bar


@compiled
def clear_smooth(work: Workspace, n: int) -> None:
    """Clear W and b of tangents without friction, which carry nothing."""
    W, b = work.W, work.b
    for i in range(n):
        if work.mu[i] == 0.0:
            for k in (3 * i, 3 * i + 1):
                b[k] = 0.0
                for j in range(3 * n):
                    W[k, j] = 0.0
                    W[j, k] = 0.0


@compiled
def _is_spread(work: Workspace, n: int, least: float) -> bool:
    """Whether a contact moves by less than ``least`` [1/kg] in all of its directions."""
    for i in range(n):
        own = max(work.W[3 * i, 3 * i], work.W[3 * i + 1, 3 * i + 1])
        if max(own, work.W[3 * i + 2, 3 * i + 2]) < least:
            return True
    return False


@compiled
def _sweep(work: Workspace, n: int, scale: float, sweeps: int) -> None:
    """Contact after contact in closed form; one that needs a second look keeps what it has."""
    W, b, mu, P = work.W, work.b, work.mu, work.P
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
            (p1, p2, pn), code = coulomb(block_at(W, k), u1, u2, un, mu[i], scale)
            if code in (_MANY, _NONE) and not pn > 0.0:
                continue
            largest = max(largest, W[k + 2, k + 2] * abs(pn - P[k + 2]))
            P[k], P[k + 1], P[k + 2] = p1, p2, pn
        if largest <= 1e-13 * scale:
            return


@compiled
def block_at(W: np.ndarray, k: int) -> Block:
    """W of the contact whose rows begin at k with itself, as the law of one contact takes it."""
    return W[k, k], W[k, k + 1], W[k + 1, k + 1], W[k, k + 2], W[k + 1, k + 2], W[k + 2, k + 2]


@compiled
def _slips(work: Workspace, n: int) -> bool:
    """Whether any contact slides, by the modes seen last."""
    count = 0
    for i in range(n):
        count += 1 if work.mode[i] == SLIDES else 0
    return count > 0


@compiled
def _is_on_an_edge(work: Workspace, n: int, scale: float) -> bool:
    """Whether a contact touches and bears nothing, or is on its cone and does not slip."""
    W, b, mu, P = work.W, work.b, work.mu, work.P
    most = 0.0
    for i in range(n):
        most = max(most, P[3 * i + 2])
    for i in range(n):
        k = 3 * i
        u1, u2, un = b[k], b[k + 1], b[k + 2]
        for j in range(3 * n):
            u1 += W[k, j] * P[j]
            u2 += W[k + 1, j] * P[j]
            un += W[k + 2, j] * P[j]
        if P[k + 2] <= EDGE * most:
            if un <= EDGE * scale:
                return True
        elif mu[i] > 0.0 and math.sqrt(u1 * u1 + u2 * u2) <= EDGE * scale:
            friction = math.sqrt(P[k] ** 2 + P[k + 1] ** 2)
            if friction >= mu[i] * P[k + 2] * (1.0 - EDGE):
                return True
    return False
