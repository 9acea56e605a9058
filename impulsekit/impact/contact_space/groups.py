"""Contacts that have nothing to do with each other, each group solved by itself."""

from __future__ import annotations

import dataclasses
from collections.abc import Callable

import numpy as np

from ...laws.groups import find_groups, worse
from ...laws.status import BY_CODE, Status
from ...laws.tolerances import NEGLIGIBLE
from .problem import ContactProblem, ContactSolution, in_order, rows_of_contacts

__all__ = ["groups_of", "solution_of_contacts", "solve_by_groups"]


def groups_of(problem: ContactProblem) -> list[np.ndarray]:
    """(k,) the numbers of the contacts of each group that W does not couple with others."""
    n = len(problem.friction)
    group, queue = np.zeros(n, np.int64), np.zeros(n, np.int64)
    count = find_groups(in_order(problem.delassus), in_order(problem.friction), n, group, queue)
    return [np.flatnonzero(group == number) for number in range(count)]


def solve_by_groups(
    problem: ContactProblem,
    groups: list[np.ndarray],
    solve: Callable[[ContactProblem], ContactSolution],
) -> ContactSolution:
    """One solution of all contacts, each group solved without the others.

    Args:
        problem: of all, none of which adheres or resists turning.
        groups: the numbers of the contacts of each.
        solve: one group's problem.
    """
    n = len(problem.friction)
    impulse, after, start = np.zeros((3, 3 * n))
    normal, friction = np.zeros((2, n))
    unique, steps, code = np.ones(n, dtype=bool), 0, int(Status.SOLVED)
    residual, tied = 0.0, False
    for members in groups:
        part, rows = solve(problem.of_contacts(members)), rows_of_contacts(members)
        impulse[rows], after[rows] = part.impulse, part.velocity_after
        start[rows] = part.velocity_start
        normal[members], friction[members] = part.normal_work, part.friction_work
        if part.unique is not None:
            unique[members] = part.unique
        steps, tied = steps + part.iterations, tied or part.tied
        code, residual = worse(code, int(part.status)), max(residual, part.residual)
    # Along tangents without friction contacts of other groups may move them.
    smooth = np.repeat(problem.friction <= NEGLIGIBLE, 3)
    smooth[2::3] = False
    after[smooth] = (problem.velocity_free + problem.delassus @ impulse)[smooth]
    return ContactSolution(
        impulse,
        after,
        BY_CODE[code],
        residual,
        None if unique.all() else unique,
        start,
        normal,
        friction,
        steps,
        tied,
    )


def solution_of_contacts(solution: ContactSolution, chosen: np.ndarray) -> ContactSolution:
    """The part of a solution that some contacts have, which act on no others.

    The status is that of all, but for redundancy, which is told of each.
    """
    rows = rows_of_contacts(chosen)
    unique = None if solution.unique is None else solution.unique[chosen]
    unique = None if unique is None or unique.all() else unique
    status = solution.status
    if status is Status.NOT_UNIQUE and unique is None:
        status = Status.SOLVED
    return dataclasses.replace(
        solution,
        impulse=solution.impulse[rows],
        velocity_after=solution.velocity_after[rows],
        status=status,
        unique=unique,
        velocity_start=solution.velocity_start[rows],
        normal_work=solution.normal_work[chosen],
        friction_work=solution.friction_work[chosen],
    )
