"""Contacts at one instant of which only one acts: slip along the path, all at once."""

from __future__ import annotations

import dataclasses

import numpy as np

from ...errors import InputError
from ...laws.alone import find_acting
from ...laws.status import Status
from ...laws.tolerances import AT_REST_AMONG_OTHERS
from ...scene.law import RESTITUTIONS, Law
from .problem import ContactProblem, ContactSolution
from .single import block_of, strike

__all__ = ["solve_alone"]


def solve_alone(problem: ContactProblem, law: Law) -> ContactSolution:
    """Slip along the path of the one contact that acts, the others parting or at rest.

    Several contacts without friction are solved as with slip at the end, which is the same.

    Raises:
        InputError: several contacts act at once and one has friction, or the law is
            Stronge's; tangential restitution.
    """
    n = len(problem.friction)
    free = problem.velocity_free
    acting, i, scale = find_acting(
        problem.velocity_before,
        free,
        problem.restitution,
        n,
        RESTITUTIONS.index(law.restitution),
        1.0,
    )
    if acting == 1:
        own = slice(3 * i, 3 * i + 3)
        hit = strike(
            block_of(problem.delassus, i),
            tuple(problem.velocity_before[own].tolist()),
            tuple(free[own].tolist()),
            problem.restitution[i].item(),
            problem.friction[i].item(),
            problem.tangential_restitution[i].item(),
            law,
        )
        impulse = np.zeros(3 * n)
        impulse[own] = hit.impulse
        after = problem.delassus @ impulse + free
        others = np.delete(after[2::3], i)
        if not hit.status.valid or others.min(initial=0.0) >= -AT_REST_AMONG_OTHERS * scale:
            normal, friction = np.zeros(n), np.zeros(n)
            normal[i], friction[i] = hit.normal_work, hit.friction_work
            unique = None
            if hit.status is Status.NOT_UNIQUE:
                unique = np.ones(n, dtype=bool)
                unique[i] = False
            return ContactSolution(
                impulse, after, hit.status, hit.residual, unique, free, normal, friction
            )
    if acting == 0 or (not problem.friction.any() and law.restitution != "stronge"):
        from .simultaneous import solve_simultaneous

        # Nothing acts or nothing rubs: both slips are the same.
        smooth = dataclasses.replace(problem, friction=np.zeros(n))
        return solve_simultaneous(smooth, Law(restitution=_of_end(law)))
    what = 'slip="path"' if law.restitution != "stronge" else 'restitution="stronge"'
    raise InputError(
        f"contacts: more than one of the {n} contacts would take part at once; {what} "
        "follows one contact along its impact, and how several share it is not defined. Use "
        'Law(order="sequential"), or slip="end" with Newton\'s or Poisson\'s restitution'
    )


def _of_end(law: Law) -> str:
    """The restitution with slip at the end that is the same where nothing rubs."""
    return "poisson" if law.restitution == "stronge" else law.restitution
