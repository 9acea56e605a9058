"""Several contacts at once, friction looking at the end of the impact."""

from __future__ import annotations

from ...laws.at_once import Struck, hit_contacts
from ...laws.status import Status
from ...laws.words import NEWTON, POISSON
from ...scene.law import Law
from .problem import ContactProblem, ContactSolution, arrays_of
from .single import refuse_tangential

__all__ = ["solve_simultaneous"]


def solve_simultaneous(problem: ContactProblem, law: Law) -> ContactSolution:
    """All contacts at once, under Newton's or Poisson's law.

    Raises:
        InputError: tangential restitution under Poisson's law.
    """
    newton = law.restitution == "newton"
    if not newton and problem.tangential_restitution[problem.friction > 0.0].any():
        refuse_tangential(law)
    hit = Struck(
        *hit_contacts(
            *arrays_of(problem),
            NEWTON if newton else POISSON,
        )
    )
    solution = ContactSolution(
        hit.impulse,
        hit.after,
        hit.status,
        hit.residual,
        None if hit.status is Status.SOLVED or hit.unique.all() else hit.unique,
        problem.velocity_before if newton else problem.velocity_free,
        hit.normal_work,
        hit.friction_work,
    )
    if hit.status is Status.ENERGY_GAIN and len(problem.friction) > 1 and problem.friction.any():
        from .groups import groups_of, solve_by_groups

        groups = groups_of(problem)
        if len(groups) > 1:
            return solve_by_groups(problem, groups, lambda part: solve_simultaneous(part, law))
        from .quiet import without_gain

        return without_gain(problem, solution, newton=newton)
    return solution
