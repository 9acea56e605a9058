"""Contacts that hold: with P̂ = P + A n the law of a contact that pushes, and µ P̂ its cone.

u⁺ = u_free − W A n + W P̂, so that a pull of A at every adhesive contact comes first, and what
presses back is found by the law without adhesion (Moreau's unilateral contact shifted along its
normal; Raous, Cangémi & Cocu 1999 for the cone).
"""

from __future__ import annotations

import dataclasses

import numpy as np

from ...laws.status import Status
from ...laws.tolerances import BAR, GAIN
from ...scene.law import Law
from .problem import ContactProblem, ContactSolution
from .refine import Steps, refined

__all__ = ["finish_adhesive", "pulled", "pulled_solution", "refined_adhesive"]

# Where more than this is left of the law, and it still is an answer, it is refined.
COARSE = 1e-13


def _pull(problem: ContactProblem) -> np.ndarray:
    """(3n,) A along the normals."""
    pull = np.zeros(len(problem.velocity_free))
    if problem.adhesion is not None:
        # What resists turning comes after the points.
        pull[2 : 3 * len(problem.adhesion) : 3] = problem.adhesion
    return pull


def pulled(problem: ContactProblem) -> ContactProblem:
    """The problem of P̂, in which nothing adheres."""
    free = problem.velocity_free - problem.delassus @ _pull(problem)
    return dataclasses.replace(problem, velocity_free=free, adhesion=None)


def pulled_solution(problem: ContactProblem, solution: ContactSolution) -> ContactSolution:
    """The solution as one of ``pulled(problem)``."""
    return dataclasses.replace(solution, impulse=solution.impulse + _pull(problem))


def finish_adhesive(problem: ContactProblem, law: Law, found: ContactSolution) -> ContactSolution:
    """The impulses of contacts of which some hold, from a solution of ``pulled(problem)``.

    Under Newton's law with slip at the end.
    """
    pushed = pulled(problem)
    if COARSE < found.residual <= BAR:
        found = _sharpened(pushed, law, found)
    return _as_adhesive(problem, found)


def _sharpened(problem: ContactProblem, law: Law, found: ContactSolution) -> ContactSolution:
    """The solution by Newton steps on its modes: slow slip turns by many times what is left.

    What moves is P itself and a 1, so that u = u⁻ + (W, u_free − u⁻) (P, 1).
    """
    n = len(problem.velocity_free)
    away = problem.velocity_free - problem.velocity_before
    steps = Steps(
        np.column_stack([problem.delassus, away]),
        lambda change: np.append(change, 0.0),
        lambda impulse, state: (state[:n] - impulse, 0.0),
        lambda system, lacking: (np.zeros(n + 1), np.zeros(len(system.way))),
    )
    finer, _ = refined(problem, law, found, np.append(found.impulse, 1.0), steps)
    return finer if finer.residual < found.residual else found


def refined_adhesive(
    problem: ContactProblem, law: Law, solution: ContactSolution, dv: np.ndarray, steps: Steps
) -> tuple[ContactSolution, np.ndarray]:
    """``refine.refined`` of P̂; its arguments."""
    pull = _pull(problem)
    of_pushes = dataclasses.replace(
        steps, momentum=lambda impulse, change: steps.momentum(impulse - pull, change)
    )
    found, dv = refined(pulled(problem), law, pulled_solution(problem, solution), dv, of_pushes)
    return _as_adhesive(problem, found), dv


def _as_adhesive(problem: ContactProblem, found: ContactSolution) -> ContactSolution:
    """The solution of P from one of ``pulled(problem)``."""
    impulse = found.impulse - _pull(problem)
    before, after = problem.velocity_before, found.velocity_after
    works = 0.5 * impulse * (before + after)
    n = len(problem.friction)
    normal, friction = works[2::3].copy(), works[0::3] + works[1::3]
    # About the normal a moment acts, not the normal impulse.
    friction[n:] += normal[n:]
    normal[n:] = 0.0
    status = found.status
    if status in (Status.SOLVED, Status.NOT_UNIQUE, Status.ENERGY_GAIN):
        # Of P̂ the works would count the pull, which nothing exerts.
        free = problem.velocity_free
        work = float(works.sum()) + min(0.0, 0.5 * float(impulse @ (free - before)))
        gained = work > GAIN * float(
            np.abs(impulse) @ (np.abs(before) + np.abs(free) + np.abs(after))
        )
        unique = found.unique is None or bool(found.unique.all())
        status = Status.SOLVED if unique else Status.NOT_UNIQUE
        status = Status.ENERGY_GAIN if gained else status
    return dataclasses.replace(
        found,
        impulse=impulse,
        status=status,
        velocity_start=before,
        normal_work=normal,
        friction_work=friction,
    )
