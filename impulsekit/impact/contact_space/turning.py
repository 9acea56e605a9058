"""Contacts that resist rolling and spin, all at once: Newton's and Poisson's restitution.

After the rows of the points come those of the turning of some of them. With normal impulse p_n,
beside |P_t| ≤ µ p_n: |M_t| ≤ rolling p_n opposes ω_t⁺, |M_n| ≤ torsion p_n opposes ω_n⁺, with
maximal dissipation each (six-dimensional cones of Siconos, Chrono, and MuJoCo's condim 4 and 6).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from ...laws.product_cones import Cones, find_cone_impulses
from ...laws.status import Status
from ...laws.tolerances import BAR, GAIN, LEAST_RELEASE
from ...scene.law import Law
from .problem import ContactProblem, ContactSolution, Turning
from .single import refuse_tangential

__all__ = ["cones_of", "solve_turning"]

# Eigenvalues of W below this share of the largest, scaled, are those of redundant rows; a contact
# that has no more than the second of their vectors is determined.
REDUNDANT, OUTSIDE = 1e-12, 1e-9
# Velocities that differ by less than this share are one answer, within the bar of both.
SAME = 1e-8


def solve_turning(problem: ContactProblem, law: Law) -> ContactSolution:
    """The impulses of all rows, under Newton's or Poisson's law with slip at the end.

    Raises:
        InputError: tangential restitution under Poisson's law.
    """
    if law.restitution == "newton":
        return _newton(problem)
    if problem.tangential_restitution[problem.friction > 0.0].any():
        refuse_tangential(law)
    return _poisson(problem)


def cones_of(friction: np.ndarray, turning: Turning, floor: np.ndarray) -> Cones:
    """The groups of n points and of those of them that resist turning.

    Args:
        friction: (n,) µ.
        turning: whose rows come after those of the points.
        floor: (n,) the least normal impulses.
    """
    n = len(friction)
    first = [3 * i for i in range(n)]
    size, contact, reach = [2] * n, list(range(n)), friction.tolist()
    for k, (i, rolling, torsion) in enumerate(
        zip(turning.of.tolist(), turning.rolling.tolist(), turning.torsion.tolist(), strict=True)
    ):
        at = 3 * (n + k)
        first += [at, at + 2]
        size += [2, 1]
        contact += [i, i]
        reach += [rolling, torsion]
    normals = np.arange(2, 3 * n, 3, dtype=np.int64)
    return Cones(
        normals,
        np.ascontiguousarray(floor, dtype=float),
        np.array(first, dtype=np.int64),
        np.array(size, dtype=np.int64),
        np.array(contact, dtype=np.int64),
        np.array(reach),
    )


def _newton(problem: ContactProblem) -> ContactSolution:
    n, before = len(problem.friction), problem.velocity_before
    aim = problem.velocity_free + problem.newtons_shift()
    floor = np.zeros(n)
    impulse, residual, steps = _phase(problem, aim, floor, np.zeros(len(aim)))
    after = problem.velocity_free + problem.delassus @ impulse
    works = _works(impulse, before, after)
    found = _solution(problem, impulse, after, before, works, residual, steps)
    return _if_several(problem, aim, floor, impulse, found)


def _poisson(problem: ContactProblem) -> ContactSolution:
    """Compression with e = 0, then expansion with P_n ≥ e P_n^c, moments in step with it."""
    n, free = len(problem.friction), problem.velocity_free
    none = np.zeros(n)
    impulse, residual, steps = _phase(problem, free, none, np.zeros(len(free)))
    compressed = impulse
    after = free + problem.delassus @ impulse
    works = _works(impulse, free, after)
    floor = problem.restitution * impulse[2 : 3 * n : 3]
    floor[floor < LEAST_RELEASE] = 0.0
    if floor.any() and residual <= BAR:
        start = after
        back, left, more = _phase(problem, start, floor, np.zeros(len(free)))
        residual, steps = max(residual, left), steps + more
        impulse = impulse + back
        after = free + problem.delassus @ impulse
        works = works + _works(back, start, after)
    found = _solution(problem, impulse, after, free, works, residual, steps)
    return _if_several(problem, free, none, compressed, found)


def _if_several(
    problem: ContactProblem,
    aim: np.ndarray,
    floor: np.ndarray,
    impulse: np.ndarray,
    found: ContactSolution,
) -> ContactSolution:
    """MANY_SOLUTIONS where redundant points that slide or roll come to another v⁺ elsewhere.

    What a cone gives is in proportion to its load, so shares of the load that W does not tell
    apart may move the velocities. Another start, of other shares, shows whether they do.
    """
    if found.status is not Status.NOT_UNIQUE:
        return found
    start = impulse * np.repeat(2.0 / (1.0 + np.arange(len(impulse) // 3)), 3)
    other, residual, _ = _phase(problem, aim, floor, start)
    change = problem.delassus @ (other - impulse)
    size = max(np.abs(aim).max(), np.abs(problem.velocity_before).max())
    if residual <= BAR and np.abs(change).max() > SAME * size:
        return replace(found, status=Status.MANY_SOLUTIONS)
    return found


def _phase(
    problem: ContactProblem, aim: np.ndarray, floor: np.ndarray, start: np.ndarray
) -> tuple[np.ndarray, float, int]:
    turning = problem.turning
    if turning is None:
        raise TypeError("nothing turns")
    W = np.ascontiguousarray(problem.delassus)
    cones = cones_of(problem.friction, turning, floor)
    return find_cone_impulses(W, W.diagonal().copy(), aim.copy(), start, cones)


def _works(impulse: np.ndarray, start: np.ndarray, after: np.ndarray) -> np.ndarray:
    """(n + k, 3) the work of each row [J]."""
    return (0.5 * impulse * (start + after)).reshape(-1, 3)


def _solution(
    problem: ContactProblem,
    impulse: np.ndarray,
    after: np.ndarray,
    start: np.ndarray,
    works: np.ndarray,
    residual: float,
    steps: int,
) -> ContactSolution:
    n = len(problem.friction)
    normal, friction = works[:, 2].copy(), works[:, :2].sum(axis=1)
    # About the normal a moment acts, not the normal impulse.
    friction[n:] += normal[n:]
    normal[n:] = 0.0
    unique = _determined(problem, impulse)
    status = Status.SOLVED if unique is None else Status.NOT_UNIQUE
    free = problem.velocity_free
    size = np.abs(impulse) @ (np.abs(start) + np.abs(free)) + np.abs(works).sum()
    work = works.sum() + min(0.0, 0.5 * impulse @ (free - start))
    if not residual <= BAR:
        status = Status.NOT_CONVERGED
    elif work > GAIN * size:
        status = Status.ENERGY_GAIN
    return ContactSolution(impulse, after, status, residual, unique, start, normal, friction, steps)


def _determined(problem: ContactProblem, impulse: np.ndarray) -> np.ndarray | None:
    """(n + k,) whether the impulses of each triple are determined; None where all are."""
    n, W = len(problem.friction), problem.delassus
    turning = problem.turning
    of = np.arange(n) if turning is None else np.concatenate([np.arange(n), turning.of])
    loaded = impulse[2 : 3 * n : 3][of] > 0.0
    reach = np.zeros((len(of), 3), dtype=bool)
    reach[:n, 2] = True
    reach[:n, :2] = (problem.friction > 0.0)[:, None]
    if turning is not None:
        reach[n:, :2] = (turning.rolling > 0.0)[:, None]
        reach[n:, 2] = turning.torsion > 0.0
    sizes = W.diagonal()
    rows = np.flatnonzero((reach & loaded[:, None]).ravel() & (sizes > 0.0))
    if not len(rows):
        return None
    units = 1.0 / np.sqrt(sizes[rows])
    values, vectors = np.linalg.eigh(W[np.ix_(rows, rows)] * units * units[:, None])
    null = vectors[:, values <= REDUNDANT * values[-1]]
    if not null.shape[1]:
        return None
    part = np.zeros(3 * len(of))
    part[rows] = (null**2).sum(axis=1)
    return part.reshape(-1, 3).sum(axis=1) <= OUTSIDE
