"""Several contacts of one instant that act on each other, slip at the end of the impact.

Newton's restitution asks for u_n⁺ ≥ −e u_n⁻; Poisson's is a compression with e = 0, then an
expansion with P_n ≥ e P_n^c (Glocker & Pfeiffer 1995).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .borrowed import borrowed, borrowing
from .compiled import compiled, entry
from .frictional import frictional
from .frictionless import frictionless
from .least_shares import share_if_redundant
from .modes import DEPENDENT
from .redundant import is_redundant
from .single import newtons_shift
from .status import Status
from .tolerances import GAIN, LEAST_RELEASE
from .words import AGAIN, NO, YES
from .workspace import Workspace, workspace

__all__ = ["Care", "newton", "poisson"]

_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_NOT_UNIQUE, _NOT_CONVERGED = int(Status.NOT_UNIQUE), int(Status.NOT_CONVERGED)
_NONE = int(Status.NO_SOLUTION)


class Care(NamedTuple):
    """What is left to a slower way.

    Attributes:
        dependent: pivots of W, its diagonal being 1, below which rows depend on each other.
        spread: contacts that move by less than this share of what others do.
        regular: whether redundant rows are left.
    """

    dependent: float
    spread: float
    regular: bool


def _newton_examples() -> tuple[object, ...]:
    line, few = np.ones(6), np.ones(2)
    return workspace(2), np.eye(6), line, line, few, few, 2, Care(DEPENDENT, 0.0, False)


@entry(_newton_examples, seconds=1.0, apart=True)
def newton(
    work: Workspace,
    W: np.ndarray,
    before: np.ndarray,
    free: np.ndarray,
    e: np.ndarray,
    e_t: np.ndarray,
    n: int,
    care: Care,
) -> tuple[int, float]:
    """Newton's restitution; the code, or AGAIN, and the residual.

    Args:
        work: with µ; P, u⁺ (``velocity``) and the works are written.
        W, before, free, e, e_t: as in ``at_once.hit_contacts``.
        n: how many contacts.
        care: what is left.
    """
    work, W, before, free = borrowed(work), borrowed(W), borrowed(before), borrowed(free)
    e, e_t = borrowed(e), borrowed(e_t)
    b = work.b
    scale = 0.0
    for k in range(3 * n):
        b[k] = free[k]
    for i in range(n):
        un = before[3 * i + 2]
        b[3 * i + 2] += newtons_shift(e[i], un)
        if work.mu[i] > 0.0:
            b[3 * i] += e_t[i] * before[3 * i]
            b[3 * i + 1] += e_t[i] * before[3 * i + 1]
        scale = max(scale, abs(un), abs(free[3 * i + 2]))
    code, residual = _solved(work, W, n, scale, 0.0, care)
    if code == AGAIN:
        return code, residual
    for k in range(3 * n):
        work.velocity[k] = before[k]
        work.total[k] = 0.0
    for i in range(n):
        work.normal[i], work.friction[i] = 0.0, 0.0
    size = 0.0
    works = 0.0
    by_blows = 0.0
    for i in range(n):
        for k in range(3 * i, 3 * i + 3):
            after = free[k]
            for j in range(3 * n):
                after += W[k, j] * work.P[j]
            own = 0.5 * work.P[k] * (before[k] + after)
            size += abs(work.P[k] * before[k]) + abs(work.P[k] * free[k])
            by_blows += 0.5 * work.P[k] * (free[k] - before[k])
            work.velocity[k] = after
            if k == 3 * i + 2:
                work.normal[i] = own
            else:
                work.friction[i] += own
        size += abs(work.normal[i]) + abs(work.friction[i])
        works += work.normal[i] + work.friction[i]
    works = min(works, works + by_blows)
    if works > GAIN * size and code != _NONE and code != _NOT_CONVERGED:
        return _GAIN, residual
    return code, residual


def _poisson_examples() -> tuple[object, ...]:
    return workspace(2), np.eye(6), np.ones(6), np.ones(2), 2, Care(DEPENDENT, 0.0, False)


@entry(_poisson_examples, seconds=1.5, apart=True)
def poisson(
    work: Workspace, W: np.ndarray, free: np.ndarray, e: np.ndarray, n: int, care: Care
) -> tuple[int, float]:
    """Poisson's restitution; the code, or AGAIN, and the residual. Arguments as ``newton``'s."""
    work, W, free, e = borrowed(work), borrowed(W), borrowed(free), borrowed(e)
    P, b, floor = work.P, work.b, work.floor
    size = 3 * n
    scale, fastest = 0.0, 0.0
    smooth, releases = bool(YES), bool(NO)
    for k in range(size):
        b[k], work.total[k], work.velocity[k] = free[k], 0.0, free[k]
        fastest = max(fastest, abs(free[k]))
    for i in range(n):
        work.normal[i], work.friction[i] = 0.0, 0.0
        scale = max(scale, abs(free[3 * i + 2]))
        smooth = smooth and work.mu[i] == 0.0
        releases = releases or e[i] > 0.0
    code, residual = _solved(work, W, n, scale, 0.0, care)
    if code == AGAIN:
        return code, residual
    if releases and not smooth and code not in (_NOT_CONVERGED, _NONE):
        # What comes back depends on how the load was shared.
        residual = share_if_redundant(work, n, 0.0, care.dependent, residual)
    _book(work, W, n)
    if code in (_NOT_CONVERGED, _NONE):
        return code, residual
    released = False
    for i in range(n):
        floor[i] = e[i] * P[3 * i + 2]
        if floor[i] < LEAST_RELEASE:
            floor[i] = 0.0
        released = released or floor[i] > 0.0
    if released:
        unique = work.unique.copy()
        second, more = _expand(work, W, e, n, smooth, scale, fastest, care)
        residual = max(residual, more)
        if second == AGAIN:
            return AGAIN, residual
        for i in range(n):
            work.unique[i] = work.unique[i] and unique[i]
        if code == _SOLVED or second in (_NOT_CONVERGED, _NONE):
            code = second
        _book(work, W, n)
    energies, works = 0.0, 0.0
    for k in range(size):
        P[k] = work.total[k]
        energies += abs(P[k] * free[k])
    for i in range(n):
        works += work.normal[i] + work.friction[i]
        energies += abs(work.normal[i]) + abs(work.friction[i])
    if works > GAIN * energies and code != _NONE and code != _NOT_CONVERGED:
        return _GAIN, residual
    return code, residual


@compiled
def _expand(
    work: Workspace,
    W: np.ndarray,
    e: np.ndarray,
    n: int,
    smooth: bool,
    scale: float,
    fastest: float,
    care: Care,
) -> tuple[int, float]:
    """P of the expansion, from that of the compression; the code, or AGAIN, and the residual."""
    P, b, floor = work.P, work.b, work.floor
    for k in range(3 * n):
        b[k] = work.velocity[k]
    if smooth:
        for k in range(3 * n):
            for j in range(n):
                b[k] += W[k, 3 * j + 2] * floor[j]
        code, residual = _solved(work, W, n, scale, 0.0, care)
        for i in range(n):
            P[3 * i + 2] += e[i] * work.total[3 * i + 2]
        return code, residual
    for i in range(n):
        for k in range(3 * i, 3 * i + 3):
            P[k] *= e[i]
    code, residual = frictional(work, n, fastest, YES, care.spread, care.dependent)
    if code == _NOT_UNIQUE:
        residual = share_if_redundant(work, n, fastest, care.dependent, residual)
    return code, residual


@borrowing
def _book(work: Workspace, W: np.ndarray, n: int) -> None:
    """Add the impulses P of one part, with what they do and their works."""
    P, velocity = work.P, work.velocity
    for i in range(n):
        for k in range(3 * i, 3 * i + 3):
            change = 0.0
            for j in range(3 * n):
                change += W[k, j] * P[j]
            own = P[k] * (velocity[k] + 0.5 * change)
            velocity[k] += change
            work.total[k] += P[k]
            if k == 3 * i + 2:
                work.normal[i] += own
            else:
                work.friction[i] += own


@compiled
def _solved(
    work: Workspace, W: np.ndarray, n: int, scale: float, fastest: float, care: Care
) -> tuple[int, float]:
    """P of one part, 0 ≤ P_n ⊥ ξ_n ≥ 0 with friction; the code, or AGAIN, and the residual."""
    smooth = True
    for i in range(n):
        smooth = smooth and work.mu[i] == 0.0
        work.floor[i] = 0.0
    if smooth:
        return frictionless(work, W, work.b, n, scale, care.spread, care.dependent, care.regular)
    for r in range(3 * n):
        for c in range(3 * n):
            work.W[r, c] = W[r, c]
    if care.regular and not _is_regular(W, 3 * n, care.dependent):
        return AGAIN, 0.0
    return frictional(work, n, fastest, NO, care.spread, care.dependent)


@borrowing
def _is_regular(W: np.ndarray, size: int, dependent: float) -> bool:
    """Whether every row moves something, and none depends on others."""
    for r in range(size):
        if not W[r, r] > 0.0:
            return False
    return not is_redundant(W, size, dependent, 0.0)
