"""Several contacts with friction: Coulomb's law at all of them at once.

0 ≤ P_n − f ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0, with
ξ = W P + b. f is 0, or what Poisson's expansion asks for at least.

First all contacts are held still: an answer in which nothing slips is near that, and Newton
on the modes of the contacts goes to it. Where contacts slip and are redundant, Pinocchio's ADMM
comes near and Newton goes on from there to rounding level. Where that fails, Newton goes there
through regular problems nearby, and at last contact after contact is solved in closed form
until all agree. Redundant contacts whose targets contradict each other are unloaded one by one.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from ...laws.single import NEGLIGIBLE
from ...laws.status import Status
from ...laws.uniqueness import search_phase
from .modes import DEPENDENT, Modes
from .split import least_holding, least_split
from .sticking import held_still
from .uniqueness import unique_contacts
from .unload import unload

__all__ = ["Frictional", "is_redundant", "rubbing", "solve_frictional"]

# What the residual must come down to.
BAR = 1e-10
# Newton's steps from a first guess at most; what rounding leaves.
FEW = 8
ROUNDING = 2e-15
# Of contacts that hold all still by one share of the load among many.
HELD = 1e-13
# Where Newton takes over from ADMM: its tolerance, relative, and its iterations at most.
NEAR = 1e-3
ENOUGH = 400
# The same for a second try.
NEARER = 1e-11
MORE = 4000
# Of Gauss-Seidel sweeps, each followed by a try of Newton.
MOST_ROUNDS = 30


@dataclass(frozen=True, eq=False)
class Frictional:
    """The impulses of contacts with friction.

    Attributes:
        impulse: (3n,) P [N s].
        status: SOLVED, NOT_UNIQUE, NO_SOLUTION or NOT_CONVERGED.
        residual: relative to the velocities.
        unique: (n,) whether each impulse is determined; None where all are.
        iterations: of ADMM, and of what came after it; 0 where it was not needed.
    """

    impulse: np.ndarray
    status: Status
    residual: float
    unique: np.ndarray | None
    iterations: int


def solve_frictional(
    delassus: np.ndarray,
    shifted: np.ndarray,
    friction: np.ndarray,
    floor: np.ndarray | None = None,
    start: np.ndarray | None = None,
    scale: float = 0.0,
    *,
    least: bool = False,
) -> Frictional:
    """P of all contacts.

    Args:
        delassus: (3n, 3n) W [1/kg], positive semidefinite.
        shifted: (3n,) b [m/s].
        friction: (n,) µ.
        floor: (n,) the least normal impulse [N s] of each; None for 0.
        start: (3n,) an impulse nearby, instead of ADMM's [N s].
        scale: the size of the velocities where they were larger before [m/s].
        least: of redundant impulses take the split that knows no axes.
    """
    found = _solved(delassus, shifted, friction, floor, start, scale)
    if least and found.status.valid and is_redundant(delassus):
        modes = Modes(*rubbing(delassus, shifted, friction), friction, floor, scale)
        impulse = least_split(modes, found.impulse)
        residual = modes.residual(impulse)
        if residual <= BAR:
            return replace(found, impulse=impulse, residual=residual)
    return found


def is_redundant(delassus: np.ndarray) -> bool:
    """Whether rows of W that move anything depend on each other."""
    diagonal = delassus.diagonal()
    rows = np.flatnonzero(diagonal > DEPENDENT * diagonal.max())
    if not len(rows):
        return True
    units = 1.0 / np.sqrt(diagonal[rows])
    values = np.linalg.eigvalsh(delassus[np.ix_(rows, rows)] * units * units[:, None])
    return bool(values[0] <= DEPENDENT * values[-1])


def rubbing(
    delassus: np.ndarray, shifted: np.ndarray, friction: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """W and b; tangent rows without friction carry nothing, whatever stands in them."""
    if min(friction.tolist()) < NEGLIGIBLE:
        delassus, shifted = delassus.copy(), shifted.copy()
        rows = np.flatnonzero(friction < NEGLIGIBLE)
        for offset in (0, 1):
            delassus[3 * rows + offset] = 0.0
            delassus[:, 3 * rows + offset] = 0.0
            shifted[3 * rows + offset] = 0.0
    return delassus, shifted


def _solved(
    delassus: np.ndarray,
    shifted: np.ndarray,
    friction: np.ndarray,
    floor: np.ndarray | None,
    start: np.ndarray | None,
    scale: float,
) -> Frictional:
    delassus, shifted = rubbing(delassus, shifted, friction)
    if floor is not None and not floor.any():
        floor = None
    modes = Modes(delassus, shifted, friction, floor, scale)
    if floor is None and min(shifted[2::3].tolist()) >= -1e-15 * modes.scale:
        return Frictional(np.zeros_like(shifted), Status.SOLVED, 0.0, None, 0)
    if not modes.largest:
        # Between parts that are held no impulse changes anything.
        idle = np.zeros_like(shifted)
        idle[2::3] = 0.0 if floor is None else floor
        residual = modes.residual(idle)
        stays = Status.SOLVED if residual <= BAR else Status.NO_SOLUTION
        return Frictional(idle, stays, residual, None, 0)
    if floor is None and start is None:
        found = _tried(modes)
        if found is not None:
            return found
    count = 0
    if floor is not None and is_redundant(delassus):
        found = _held(modes)
        if found is not None:
            return found
    if start is not None:
        impulse, residual = modes.polish(start)
        if residual <= BAR:
            return _told(modes, impulse, residual, 0)
    if floor is not None:
        by_modes = _by_modes(modes, count, all_of_them=True)
        if by_modes is not None:
            return by_modes
    from .proximal import approach

    rough = np.zeros_like(shifted)
    if floor is None:
        from .admm import admm

        rough, count = admm(delassus, shifted, friction, NEAR * modes.scale, ENOUGH)
        impulse, residual = unload(modes, *modes.polish(rough))
        if residual <= BAR:
            return _told(modes, impulse, residual, count)
        by_modes = _by_modes(modes, count, all_of_them=True)
        if by_modes is not None:
            return by_modes
        # The modes were not the right ones yet: nearer, and again.
        closer, more = admm(delassus, shifted, friction, NEARER * modes.scale, MORE)
        count += more
        impulse, residual = unload(modes, *modes.polish(closer))
        if residual <= BAR:
            return _told(modes, impulse, residual, count)
        residual = modes.residual(closer)
        if residual <= BAR:
            return _told(modes, closer, residual, count)
        rough = closer
    last, residual, steps = approach(modes, rough, BAR)
    count += steps
    if floor is None:
        last, residual = unload(modes, last, residual)
    if residual <= BAR:
        return _told(modes, last, residual, count)
    by_modes = _by_modes(modes, count, all_of_them=False)
    if by_modes is not None:
        return by_modes
    from .gauss_seidel import sweep

    for _ in range(MOST_ROUNDS):
        last, sweeps = sweep(delassus, shifted, friction, floor, last, modes.scale)
        count += sweeps
        impulse, residual = modes.polish(last)
        if residual <= BAR:
            return _told(modes, impulse, residual, count)
    return Frictional(last, Status.NOT_CONVERGED, modes.residual(last), None, count)


def _tried(modes: Modes) -> Frictional | None:
    """The answer, where it is one in which nothing slips, or Newton finds it with W regular.

    Elsewhere the law may have several answers, and Newton's may be any of them.
    """
    impulse, regular, ridge = held_still(modes)
    if regular:
        impulse, residual = modes.polish(impulse, FEW, ridge)
        if residual <= BAR:
            return Frictional(impulse, Status.SOLVED, residual, None, 0)
        return None
    residual, seen = modes.seen(impulse)
    if residual > ROUNDING or any(s1 or s2 for _, _, s1, s2 in seen):
        # Another share of the same load may be within all cones.
        held = _held(modes)
        if held is not None:
            return held
    if residual > ROUNDING and not any(s1 or s2 for _, _, s1, s2 in seen):
        impulse, residual = modes.polish(impulse, FEW)
        residual, seen = modes.seen(impulse)
    if residual > ROUNDING or any(s1 or s2 for _, _, s1, s2 in seen):
        return None
    return _told(modes, impulse, residual, 0, slips=False)


def _held(modes: Modes) -> Frictional | None:
    """The answer in which redundant contacts hold all still, where there is one."""
    impulse = least_holding(modes)
    residual = modes.residual(impulse)
    return _told(modes, impulse, residual, 0, slips=False) if residual <= HELD else None


def _by_modes(modes: Modes, count: int, *, all_of_them: bool) -> Frictional | None:
    """The answer nearest to sticking, ½ PᵀWP + b·P being least, among those of the modes tried.

    Args:
        count: of iterations before.
        all_of_them: only where all modes can be tried; then it is also known that none solves.
    """
    search = search_phase(
        modes.delassus, modes.shifted, modes.friction, modes.floor, modes.scale, plane=all_of_them
    )
    best: tuple[float, np.ndarray, float] | None = None
    for one in search.impulses:
        impulse, residual = modes.polish(one)
        height = float(impulse @ (0.5 * (modes.delassus @ impulse) + modes.shifted))
        if residual <= BAR and (best is None or height < best[0]):
            best = height, impulse, residual
    if best is not None:
        return _told(modes, best[1], best[2], count)
    if search.complete and not len(search.impulses):
        nothing = np.zeros_like(modes.shifted)
        return Frictional(nothing, Status.NO_SOLUTION, modes.residual(nothing), None, count)
    return None


def _told(
    modes: Modes, impulse: np.ndarray, residual: float, count: int, *, slips: bool = True
) -> Frictional:
    """The answer, with what is not determined in it."""
    unique = unique_contacts(modes, impulse, slips=slips)
    status = Status.SOLVED if unique is None else Status.NOT_UNIQUE
    return Frictional(impulse, status, residual, unique, count)
