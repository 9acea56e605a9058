"""Several contacts with friction: Coulomb's law at all of them at once.

0 ≤ P_n − f ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0, with
ξ = W P + b. f is 0, or what Poisson's expansion asks for at least.

First all contacts are held still: an answer in which nothing slips is near that, and Newton on
the modes of the contacts goes to it. Where contacts slip, a few rounds of sweeps or of splitting
come near, and Newton goes on to rounding level. Where that fails all modes are tried, if there
are few; then Newton goes there through regular problems nearby. Redundant contacts whose targets
contradict each other are unloaded one by one.
"""

from __future__ import annotations

import math

import numpy as np

from .approach import ALL_ROUNDS, NO_ROUND, approach_in_rounds, approach_regularized, sweep
from .borrowed import borrowing
from .compiled import compiled, entry
from .even_shares import share_evenly
from .least_shares import least_holding
from .modes import (
    BALANCED,
    MOST_STEPS,
    NULL,
    RIDGE,
    SLIDES,
    SLIDES_AT_FLOOR,
    height_of,
    largest_term,
    polish,
    residual_of,
    sizes_of,
)
from .redundant import find_shared, is_redundant
from .status import Status
from .sticking import held_still
from .tolerances import AT_REST, BAR, ROUNDING
from .uniqueness import (
    AT_LAST,
    FAR,
    MOST_FOUND,
    PLANE,
    TRIED_ALL,
    is_searched,
    search_modes,
)
from .unloading import may_unload, unload
from .words import AGAIN, NO, YES
from .workspace import Sizes, Workspace, workspace

__all__ = ["clear_smooth", "frictional", "search_slipping"]

# Newton's steps from a first guess, and what rounding leaves.
ONE: int = np.int64(1)  # type: ignore[assignment]
FEW: int = np.int64(8)  # type: ignore[assignment]
# Slip that is faster than this many times what Newton's first step leaves does not end.
SLIPS = 1e3
# Of contacts that hold all still by one share of the load among many.
HELD = 1e-13
# What a W of dependent rows leaves of the terms of W P, its own rounding being some ten ulps: less
# than that must not decide whether what holds all still is an answer.
UNEVEN = 1e-14
# The rounds before all modes are tried; sweeps at last, and how often.
EARLY: int = np.int64(5)  # type: ignore[assignment]
SWEEPS: int = np.int64(50)  # type: ignore[assignment]
MOST_SWEEPS = 30
# Shares of the normal impulse that stops a contact alone, from which Newton starts at last.
PUSHES = (0.25, 0.5, 1.0, 2.0)
# Nothing found yet.
_OPEN = -2
_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)
_NONE, _NOT_CONVERGED = int(Status.NO_SOLUTION), int(Status.NOT_CONVERGED)


def _examples() -> tuple[object, ...]:
    return workspace(1), 1, 1.0, False, 0.0, 0.0


def _search_examples() -> tuple[object, ...]:
    return workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), False, 0.0


@entry(_examples, seconds=2.5, apart=True)
def frictional(
    work: Workspace, n: int, scale: float, started: bool, spread: float, dependent: float
) -> tuple[int, float]:
    """P (3n,) of n contacts; the code and the residual.

    Args:
        work: the problem; W and b of smooth tangents are cleared. ``unique`` is written.
        n: how many contacts.
        scale: the size of the velocities where they were larger before [m/s].
        started: whether P is near the answer, as the expansion's is.
        spread: contacts of which one moves less than this share of another are left (AGAIN).
        dependent: pivots, the diagonal being 1, below which rows depend on each other.
    """
    P = work.P
    clear_smooth(work, n)
    slowest = math.inf
    floors = False
    for i in range(n):
        work.unique[i] = True
        floors = floors or work.floor[i] > 0.0
        slowest = min(slowest, work.b[3 * i + 2])
    sizes = sizes_of(work, n, scale)
    parts = not floors and slowest >= -AT_REST * sizes.scale
    if parts or not sizes.largest > 0.0:
        for i in range(n):
            P[3 * i], P[3 * i + 1], P[3 * i + 2] = 0.0, 0.0, work.floor[i]
        if parts:
            return _SOLVED, 0.0
        # Between parts that are held no impulse changes anything.
        residual = residual_of(work, n, sizes)
        return (_SOLVED if residual <= BAR else _NONE), residual
    if _is_spread(work, n, spread * sizes.largest):
        return AGAIN, 0.0
    if floors or started:
        return _expanded(work, n, sizes, floors, started, dependent)
    code, residual = _hold_still(work, n, sizes, dependent)
    if code == _OPEN:
        code, residual = search_slipping(work, n, sizes, floors, dependent)
    return code, residual


def _expanded_examples() -> tuple[object, ...]:
    return workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), False, False, 0.0


@entry(_expanded_examples, seconds=2.5, apart=True)
def _expanded(
    work: Workspace, n: int, sizes: Sizes, floors: bool, started: bool, dependent: float
) -> tuple[int, float]:
    """``frictional`` from a start, or with floors, as an expansion has."""
    P = work.P
    code, heaviest = _OPEN, math.inf
    start = P[: 3 * n].copy()
    if floors and is_redundant(work.W, 3 * n, dependent, NULL):
        code, residual = _hold_by_shares(work, n, sizes, dependent)
        if code != _OPEN:
            return code, residual
        for k in range(3 * n):
            P[k] = start[k]
    if started:
        residual = polish(work, n, sizes, MOST_STEPS, RIDGE)
        heaviest = largest_term(work.W, P, 3 * n) if residual <= BAR else math.inf
        if heaviest <= BALANCED * sizes.scale:
            return _settled(work, n, sizes, dependent, residual)
        # Where Newton wandered to is decided by rounding.
        for k in range(3 * n):
            P[k], start[k] = start[k], P[k]
    code, residual = search_slipping(work, n, sizes, floors, dependent)
    if heaviest < math.inf and not (residual <= BAR and largest_term(work.W, P, 3 * n) < heaviest):
        for k in range(3 * n):
            P[k] = start[k]
        return _settled(work, n, sizes, dependent, residual_of(work, n, sizes))
    return code, residual


@compiled
def _hold_still(work: Workspace, n: int, sizes: Sizes, dependent: float) -> tuple[int, float]:
    """The answer where nothing slips, or where Newton finds it with W regular; else _OPEN.

    Elsewhere the law may have several answers, and Newton's may be any of them.
    """
    ridge = held_still(work, n, sizes)
    if ridge >= 0.0:
        residual = polish(work, n, sizes, FEW, ridge)
        return (_SOLVED if residual <= BAR else _OPEN), residual
    return _hold_dependent(work, n, sizes, dependent)


def _dependent_examples() -> tuple[object, ...]:
    return workspace(1), 1, Sizes(1.0, 1.0, 1.0, True), 0.0


@entry(_dependent_examples, seconds=2.0, apart=True)
def _hold_dependent(work: Workspace, n: int, sizes: Sizes, dependent: float) -> tuple[int, float]:
    """The same where rows of W depend on each other, P being the guess that holds all still."""
    residual = residual_of(work, n, sizes)
    slips = _slips(work, n, sizes, HELD)
    if residual > ROUNDING or slips:
        start = work.P[: 3 * n].copy()
        # Another share of the same load may be within all cones.
        code, bar = _hold_by_shares(work, n, sizes, dependent)
        if code != _OPEN:
            return code, bar
        if not _slips(work, n, sizes, HELD):
            # Targets of redundant contacts that contradict each other.
            bar = unload(work, n, sizes, bar) if may_unload(bar) else bar
            if bar <= HELD:
                return _code_of(work, n, sizes, dependent, YES), bar
        for k in range(3 * n):
            work.P[k] = start[k]
    if residual > ROUNDING and not slips:
        residual = polish(work, n, sizes, ONE, RIDGE)
        if not _slips(work, n, sizes, max(HELD, SLIPS * residual)):
            polish(work, n, sizes, FEW, RIDGE)
        residual = residual_of(work, n, sizes)
        slips = _slips(work, n, sizes, HELD)
    terms = largest_term(work.W, work.P, 3 * n) / sizes.scale
    if slips or residual > max(ROUNDING, min(UNEVEN * terms, HELD)):
        return _OPEN, residual
    return _code_of(work, n, sizes, dependent, NO), residual


@compiled
def _hold_by_shares(work: Workspace, n: int, sizes: Sizes, dependent: float) -> tuple[int, float]:
    """The answer in which redundant contacts hold all still, where there is one; else _OPEN."""
    residual = least_holding(work, n, sizes)
    if HELD < residual <= BAR:
        # At an edge of cones the shares are known to fewer digits than Newton on the modes gives.
        residual = polish(work, n, sizes, FEW, RIDGE)
        if _slips(work, n, sizes, HELD):
            return _OPEN, residual
    if not residual <= HELD:
        return _OPEN, residual
    return _code_of(work, n, sizes, dependent, NO), residual


@entry(_search_examples, seconds=3.0, apart=True)
def search_slipping(
    work: Workspace, n: int, sizes: Sizes, floors: bool, dependent: float
) -> tuple[int, float]:
    """The answer where contacts slip."""
    residual = approach_in_rounds(work, n, sizes, NO_ROUND, EARLY, BAR)
    if not floors and may_unload(residual):
        residual = unload(work, n, sizes, residual)
    if residual <= BAR:
        return _settled(work, n, sizes, dependent, residual)
    return _search_on(work, n, sizes, floors, dependent)


@entry(_search_examples, seconds=3.0, apart=True)
def _search_on(
    work: Workspace, n: int, sizes: Sizes, floors: bool, dependent: float
) -> tuple[int, float]:
    """``search_slipping`` behind the rounds that mostly do."""
    rough = work.P[: 3 * n].copy()
    code, bar = _try_modes(work, n, sizes, PLANE, dependent)
    if code != _OPEN:
        return code, bar
    for k in range(3 * n):
        work.P[k] = rough[k]
    residual = approach_in_rounds(work, n, sizes, EARLY, ALL_ROUNDS, BAR)
    if not floors and may_unload(residual):
        residual = unload(work, n, sizes, residual)
    if residual <= BAR:
        return _settled(work, n, sizes, dependent, residual)
    residual = approach_regularized(work, n, sizes, BAR)
    if not floors and may_unload(residual):
        residual = unload(work, n, sizes, residual)
    if residual <= BAR:
        return _settled(work, n, sizes, dependent, residual)
    for k in range(3 * n):
        rough[k] = work.P[k]
    code, bar = _try_modes(work, n, sizes, FAR, dependent)
    if code != _OPEN:
        return code, bar
    for k in range(3 * n):
        work.P[k] = rough[k]
    least = residual_of(work, n, sizes)
    best = rough.copy()
    for _ in range(MOST_SWEEPS):
        sweep(work, n, sizes.scale, SWEEPS)
        left = residual_of(work, n, sizes)
        for k in range(3 * n):
            rough[k] = work.P[k]
        if left < least:
            least = left
            for k in range(3 * n):
                best[k] = rough[k]
        residual = polish(work, n, sizes, MOST_STEPS, RIDGE)
        if residual <= BAR:
            return _settled(work, n, sizes, dependent, residual)
        if not left < math.inf:
            break
        for k in range(3 * n):
            work.P[k] = rough[k]
    residual = _from_pushes(work, n, sizes)
    if residual <= BAR:
        return _settled(work, n, sizes, dependent, residual)
    if not is_searched(work.mu[:n], FAR):
        code, bar = _try_modes(work, n, sizes, AT_LAST, dependent)
        if code != _OPEN:
            return code, bar
    for k in range(3 * n):
        work.P[k] = best[k] if least < math.inf else 0.0
    return _NOT_CONVERGED, least


@borrowing
def _from_pushes(work: Workspace, n: int, sizes: Sizes) -> float:
    """Newton from shares of what would stop each contact alone, where all else diverged."""
    residual = math.inf
    for share in PUSHES:
        for i in range(n):
            k = 3 * i + 2
            stops = -work.b[k] / work.W[k, k] if work.W[k, k] > 0.0 else 0.0
            work.P[k - 2], work.P[k - 1] = 0.0, 0.0
            work.P[k] = max(work.floor[i], share * stops, 0.0)
        residual = polish(work, n, sizes, MOST_STEPS, RIDGE)
        if residual <= BAR:
            break
    return residual


@compiled
def _try_modes(
    work: Workspace, n: int, sizes: Sizes, reach: int, dependent: float
) -> tuple[int, float]:
    """The answer nearest to sticking, ½ PᵀWP + b·P being least, among those of the modes tried.

    Args:
        reach: of ``search_modes``. Where all modes were tried it is known that none solves.
    """
    size = 3 * n
    W, b = work.W[:size, :size].copy(), work.b[:size].copy()
    mu, floor = work.mu[:n].copy(), work.floor[:n].copy()
    found, best = np.empty((MOST_FOUND, size)), np.empty(size)
    none = np.empty((0, size))
    how, count, _ = search_modes(W, b, mu, floor, sizes.scale, reach, found, none)
    if how == TRIED_ALL and count == 0:
        for k in range(size):
            work.P[k] = 0.0
        return _NONE, residual_of(work, n, sizes)
    least, left = math.inf, math.inf
    for one in range(count):
        for k in range(size):
            work.P[k] = found[one, k]
        residual = polish(work, n, sizes, MOST_STEPS, RIDGE)
        height = height_of(work, n)
        if residual <= BAR and height < least:
            least, left = height, residual
            for k in range(size):
                best[k] = work.P[k]
    if not left <= BAR:
        return _OPEN, left
    for k in range(size):
        work.P[k] = best[k]
    return _settled(work, n, sizes, dependent, left)


@compiled
def _settled(
    work: Workspace, n: int, sizes: Sizes, dependent: float, residual: float
) -> tuple[int, float]:
    """The code and the residual of an answer with slip, its redundant contacts sharing evenly."""
    residual, shared = share_evenly(work, n, sizes, dependent, residual)
    unique = work.unique[:n].copy()
    code = _code_of(work, n, sizes, dependent, YES)
    if shared:
        for i in range(n):
            work.unique[i] = work.unique[i] and unique[i]
        return _NOT_UNIQUE, residual
    return code, residual


@compiled
def _code_of(work: Workspace, n: int, sizes: Sizes, dependent: float, slips: bool) -> int:
    """The code of an answer; ``unique`` tells what is not determined in it."""
    return _NOT_UNIQUE if find_shared(work, n, sizes, dependent, slips) else _SOLVED


@borrowing
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


@borrowing
def _is_spread(work: Workspace, n: int, least: float) -> bool:
    """Whether a contact moves by less than ``least`` [1/kg] in all of its directions."""
    for i in range(n):
        own = max(work.W[3 * i, 3 * i], work.W[3 * i + 1, 3 * i + 1])
        if max(own, work.W[3 * i + 2, 3 * i + 2]) < least:
            return True
    return False


@borrowing
def _slips(work: Workspace, n: int, sizes: Sizes, share: float) -> bool:
    """Whether any contact slides, by the modes seen last, at more than a share of all velocities.

    One that touches without a load may be told to slide by the rounding of its velocity.
    """
    count = 0
    for i in range(n):
        speed = math.hypot(work.xi[3 * i], work.xi[3 * i + 1])
        slides = work.mode[i] in (SLIDES, SLIDES_AT_FLOOR) and speed > share * sizes.scale
        count += 1 if slides else 0
    return count > 0
