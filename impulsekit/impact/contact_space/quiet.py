"""An answer of several contacts that gains no energy, where the one found first does.

Coulomb's law at the end of an impact may allow several velocities, some of which need more energy
than there is (Kane & Levinson 1985). Such an answer is not shown where another obeys the law too.
"""

from __future__ import annotations

import dataclasses
from typing import NamedTuple

import numpy as np

from ...laws.found import SAME
from ...laws.frictional import frictional
from ...laws.least_shares import share_least
from ...laws.modes import DEPENDENT
from ...laws.others import MOST_ANSWERS, find_answers
from ...laws.status import BY_CODE, Status
from ...laws.tolerances import BAR, GAIN, LEAST_RELEASE, NEGLIGIBLE
from ...laws.uniqueness import FAR
from ...laws.words import NEWTON, POISSON, YES
from ...laws.workspace import Workspace, workspace
from .problem import ContactProblem, ContactSolution, arrays_of, in_order

__all__ = ["without_gain"]

_OBEY = (Status.SOLVED, Status.NOT_UNIQUE)


class _Part(NamedTuple):
    """A compression, an expansion, or all of an impact: (3n,) P, (n,) unique, and residual."""

    impulse: np.ndarray
    unique: np.ndarray
    residual: float


def without_gain(
    problem: ContactProblem, solution: ContactSolution, *, newton: bool
) -> ContactSolution:
    """Another answer without a gain of energy: of several the one of least energy.

    Args:
        problem: of several contacts at once, slip at the end.
        solution: an answer that gains energy.
        newton: whether restitution is Newton's, else Poisson's.

    Returns:
        The solution itself where none is found.
    """
    scale = problem.fastest(solution.velocity_after)
    found, pressed = room = np.zeros((2, MOST_ANSWERS, len(solution.impulse)))
    restitution, shown = NEWTON if newton else POISSON, in_order(solution.impulse)
    W, before, free, *coefficients = arrays_of(problem)
    _, _, count, _ = find_answers(
        W, before, free, np.array(coefficients), restitution, shown, scale, room, FAR
    )
    start, W = solution.velocity_start, problem.delassus
    works = [float(P @ (start + problem.velocity_free + W @ P)) for P in found[:count]]
    for one in np.argsort(works, kind="stable"):
        P = found[one]
        parts = _of_newton(problem, P) if newton else _of_poisson(problem, pressed[one].copy(), P)
        if parts is None:
            continue
        answer = _answer(problem, solution, parts)
        work = answer.normal_work.sum() + answer.friction_work.sum()
        speeds = np.abs(start) + np.abs(problem.velocity_free)
        work += min(0.0, 0.5 * float(answer.impulse.dot(problem.velocity_free - start)))
        size = np.abs(answer.impulse).dot(speeds) + np.abs(answer.normal_work).sum()
        if work <= GAIN * (size + np.abs(answer.friction_work).sum()):
            return answer
    return solution


def _of_newton(problem: ContactProblem, found: np.ndarray) -> tuple[_Part, ...] | None:
    """The one part of an impact under Newton's law, from P near it."""
    b = problem.velocity_free + problem.newtons_shift()
    part = _solved(problem, b, found, np.zeros(len(found) // 3), 0.0)
    return None if part is None else (part,)


def _of_poisson(
    problem: ContactProblem, pressed: np.ndarray, found: np.ndarray
) -> tuple[_Part, ...] | None:
    """Compression and expansion, from P near both; loads are shared as the law shares them."""
    free, W, e = problem.velocity_free, problem.delassus, problem.restitution
    n = len(e)
    first = _solved(problem, free, pressed, np.zeros(n), 0.0, shared=bool(e.any()))
    if first is None:
        return None
    floor = e * first.impulse[2::3]
    floor[floor < LEAST_RELEASE] = 0.0
    if not floor.any():
        return (first,)
    begin = found - pressed
    if np.abs(first.impulse - pressed).max() > SAME * np.abs(first.impulse).max():
        begin = np.repeat(e, 3) * first.impulse
    fastest = float(np.abs(free).max())
    second = _solved(problem, free + W @ first.impulse, begin, floor, fastest, shared=True)
    return None if second is None else (first, second)


def _solved(
    problem: ContactProblem,
    b: np.ndarray,
    begin: np.ndarray,
    floor: np.ndarray,
    fastest: float,
    *,
    shared: bool = False,
) -> _Part | None:
    """P of one part to rounding; None where none is found from there."""
    n = len(floor)
    work = _posed(problem, b, begin, floor)
    code, residual = frictional(work, n, fastest, bool(YES), 0.0, DEPENDENT)
    if BY_CODE[code] not in _OBEY:
        return None
    if shared:
        residual = share_least(work, n, fastest, DEPENDENT, residual)
    if residual > BAR:
        return None
    return _Part(work.P[: 3 * n].copy(), work.unique[:n].copy(), residual)


def _posed(
    problem: ContactProblem, b: np.ndarray, begin: np.ndarray, floor: np.ndarray
) -> Workspace:
    """One part as the laws take it."""
    n = len(floor)
    work = workspace(n)
    work.W[: 3 * n, : 3 * n] = problem.delassus
    work.b[: 3 * n], work.P[: 3 * n], work.floor[:n] = b, begin, floor
    work.mu[:n] = np.where(problem.friction > NEGLIGIBLE, problem.friction, 0.0)
    return work


def _answer(
    problem: ContactProblem, solution: ContactSolution, parts: tuple[_Part, ...]
) -> ContactSolution:
    """The solution of these parts, with its works."""
    W, start = problem.delassus, solution.velocity_start
    P, works = np.zeros_like(start), np.zeros_like(start)
    unique = np.ones(len(problem.friction), dtype=bool)
    for part in parts:
        after = problem.velocity_free + W @ (P + part.impulse)
        works += 0.5 * part.impulse * (start + after)
        P, start = P + part.impulse, after
        unique &= part.unique
    return dataclasses.replace(
        solution,
        impulse=P,
        velocity_after=start,
        status=Status.SOLVED if unique.all() else Status.NOT_UNIQUE,
        residual=max(part.residual for part in parts),
        unique=None if unique.all() else unique,
        normal_work=works[2::3],
        friction_work=works[0::3] + works[1::3],
    )
