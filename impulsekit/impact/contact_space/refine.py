"""An answer of the contact law, held against the velocities that it makes in the whole system.

W = J M⁻¹ Jᵀ and Δv each have rounding of their own. Where light bodies stand between contacts,
shares cancel in W P that are many times the velocities, and P is known to fewer digits than
J (v + Δv), which is a plain sum. Newton on the modes, with these velocities, gives P the digits
that it lacks: by W first, and where W itself has too few, by the equations of Δv and P together,
in which no share is larger than the whole.
"""

from __future__ import annotations

import dataclasses
import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from ...laws.modes import DEPENDENT, NULL
from ...laws.redundant import is_redundant
from ...laws.sharpening import MOST_STEPS, lead
from ...laws.status import Status
from ...laws.tolerances import BAR, ROUNDING
from ...scene.law import Law
from .problem import RESTS, THROWN, ContactProblem, ContactSolution, in_order

__all__ = ["Steps", "System", "refined"]

# Rounding level: further steps gain nothing.
DEEP = 5e-16
# More than this of a valid answer tells that rows which depend on each other do so only nearly.
TOO_MUCH = 1e-14
# Iterates that did not converge are taken on from here.
NEAR = 1e-3


class System(NamedTuple):
    """The equations of a Newton step: (Aim W Wayᵀ + stiffness) x = right; P changes by −x Way.

    Attributes:
        way: (m, 3n) the directions of P.
        aim: (m, 3n) the velocities to be brought to zero.
        stiffness: (m,) of the slip's direction, on the diagonal.
        right: (m,) what these velocities are [m/s].
    """

    way: np.ndarray
    aim: np.ndarray
    stiffness: np.ndarray
    right: np.ndarray


@dataclasses.dataclass(frozen=True, eq=False)
class Steps:
    """How Δv follows a change of the contacts' impulses.

    Attributes:
        jacobian: (3n, nv) the rows of the contacts.
        moved_by: from a change of P (3n,) to the change of Δv.
        momentum: from P and Δv to what M Δv lacks of all impulses (nv,), and the largest share
            of that in its terms.
        together: from a system of the modes and what M Δv lacks to the changes of Δv and of x,
            by the equations of both at once.
    """

    jacobian: np.ndarray
    moved_by: Callable[[np.ndarray], np.ndarray]
    momentum: Callable[[np.ndarray, np.ndarray], tuple[np.ndarray, float]]
    together: Callable[[System, np.ndarray], tuple[np.ndarray, np.ndarray]]


def refined(
    problem: ContactProblem,
    law: Law,
    solution: ContactSolution,
    dv: np.ndarray,
    steps: Steps,
) -> tuple[ContactSolution, np.ndarray]:
    """The solution and Δv, nearer to the law where Newton's law with slip at the end holds.

    The other laws follow contacts one at a time, in closed forms that lose nothing.

    Args:
        problem: what was solved.
        law: by which.
        solution: the answer.
        dv: (nv,) what the answer's impulses make with all others.
        steps: how to change it.
    """
    status = solution.status
    if not problem.delassus.any():
        # Bilateral rows hold every contact still: there is nothing that could be moved.
        return solution, dv
    if law != Law() or status is Status.NO_SOLUTION:
        return solution, dv
    if status is Status.NOT_CONVERGED and not solution.residual < NEAR:
        return solution, dv
    before, shift = problem.velocity_before, problem.newtons_shift()
    delassus, friction = in_order(problem.delassus), in_order(problem.friction)
    scale = float(max(np.abs(problem.velocity_free + shift).max(), np.abs(before).max()))
    # What a blow alone would throw is no measure of the velocities that are left.
    terms = float((np.abs(before) + np.abs(steps.jacobian).dot(np.abs(dv))).max())
    if terms > RESTS * scale:
        scale = min(scale, THROWN * terms)
    best, least = (solution.impulse, dv), math.inf
    for by_delassus in (True, False):
        impulse, dv = best
        for step in range(MOST_STEPS + 1):
            velocity = before + steps.jacobian.dot(dv) + shift
            residual, change, offset, *parts = lead(delassus, friction, impulse, velocity, scale)
            if not residual < math.inf:
                break
            lacking, share = steps.momentum(impulse, dv)
            residual = max(residual, share)
            # It may rise for a step where slip turns.
            if residual < least:
                best, least = (impulse, dv), residual
            if residual <= DEEP or step == MOST_STEPS:
                break
            # Changes, and no new P: beside large impulses in balance their digits would be lost.
            if by_delassus:
                change_of_dv = steps.moved_by(change)
            else:
                system = System(*parts)
                change_of_dv, x = steps.together(system, lacking)
                change = offset + x.dot(system.way)
                change_of_dv = change_of_dv + steps.moved_by(offset)
            dv, impulse = dv + change_of_dv, impulse + change
        if least <= ROUNDING:
            break
    impulse, dv = best
    return _told(problem, solution, impulse, before + steps.jacobian.dot(dv), least), dv


def _told(
    problem: ContactProblem,
    solution: ContactSolution,
    impulse: np.ndarray,
    after: np.ndarray,
    residual: float,
) -> ContactSolution:
    """The solution with the impulses and velocities that were reached."""
    work = 0.5 * impulse * (problem.velocity_before + after)
    status = solution.status
    if status is Status.NOT_CONVERGED and residual <= BAR:
        status = Status.SOLVED if solution.unique is None else Status.NOT_UNIQUE
    # Load that one carries alone may be another's where rows depend but for what is left.
    bar = TOO_MUCH if status is Status.SOLVED else ROUNDING
    if status in (Status.SOLVED, Status.NOT_UNIQUE) and residual > bar:
        W = problem.delassus
        if status is Status.NOT_UNIQUE or is_redundant(W, len(W), DEPENDENT, NULL):
            status = Status.NEARLY_DEPENDENT
    return dataclasses.replace(
        solution,
        impulse=impulse,
        velocity_after=after,
        status=status,
        residual=residual,
        normal_work=work[2::3],
        friction_work=work[0::3] + work[1::3],
    )
