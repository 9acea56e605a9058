"""``solve_contacts``: from a contact problem and a law to the impulses."""

from __future__ import annotations

import numpy as np

from ...errors import InputError, RangeError
from ...laws.status import Status
from ...scene.law import Law
from .problem import ContactProblem, ContactSolution, check_problem
from .single import is_finite, strike

__all__ = ["find_impulses", "solve_contacts"]


def solve_contacts(problem: ContactProblem, law: Law) -> ContactSolution:
    """The impulses of all contacts of one instant.

    With Newton's law and slip at the end, ξ = u⁺ + e∘min(u⁻, 0) for normals and
    ξ_t = u_t⁺ + e_t u_t⁻ for tangents obey 0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, and
    P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0 (Moreau 1988; Glocker 2001). The other laws are
    told by ``Law``. A contact that parts gets no impulse, and none pulls. Where the law allows
    other velocities as well, the status says so (MANY_SOLUTIONS), as far as that can be found.

    Args:
        problem: W, velocities and coefficients.
        law: how restitution, slip and order are understood.

    Raises:
        InputError: law and coefficients cannot go together, or several frictional
            contacts that act on each other act at once under slip="path".
        ShapeError, NotFiniteError, RangeError: what is wrong with the problem.

    Example:
        >>> import numpy as np
        >>> from impulsekit.scene.law import Law
        >>> drop = np.array([0.0, 0.0, -2.0])  # a ball of 0.5 kg
        >>> W = np.diag([7.0, 7.0, 2.0])
        >>> one = np.ones(1)
        >>> ball = ContactProblem(W, drop, drop, 0.5 * one, 0.3 * one, 0 * one)
        >>> solve_contacts(ball, Law()).impulse.tolist()
        [0.0, 0.0, 1.5]
    """
    solution = find_impulses(problem, law)
    from .others import told_if_several

    return told_if_several(problem, law, solution)


def find_impulses(problem: ContactProblem, law: Law) -> ContactSolution:
    """The same, without a search for other solutions where several contacts act.

    Raises:
        As ``solve_contacts``.
    """
    if problem.adhesion is not None:
        from .adhesive import finish_adhesive, pulled

        return finish_adhesive(problem, law, find_impulses(pulled(problem), law))
    if problem.turning is not None:
        return _turning(problem, law)
    if len(problem.friction) == 1 and law.order == "simultaneous":
        return _one(problem, law)
    check_problem(problem)
    if not problem.delassus[0, 0] and not problem.delassus.any():
        return _immovable(problem)
    if law.order == "sequential":
        from .sequential import solve_sequential

        return solve_sequential(problem, law)
    if law.slip == "path":
        return _along_the_path(problem, law)
    from .simultaneous import solve_simultaneous

    return solve_simultaneous(problem, law)


def _along_the_path(problem: ContactProblem, law: Law) -> ContactSolution:
    """Impacts that are followed, each group of contacts by itself."""
    if law.restitution == "lzb":
        from .by_energy import check_stiffness, solve_by_energy

        check_stiffness(problem, law)
        solve = solve_by_energy
    else:
        from .alone import solve_alone

        solve = solve_alone
    from .groups import groups_of, solve_by_groups

    groups = groups_of(problem)
    if len(groups) == 1:
        return solve(problem, law)
    return solve_by_groups(
        problem,
        groups,
        lambda part: _one(part, law) if len(part.friction) == 1 else solve(part, law),
    )


def _turning(problem: ContactProblem, law: Law) -> ContactSolution:
    """Contacts of which some resist rolling or spin."""
    if (law.slip, law.order) != ("end", "simultaneous"):
        raise InputError(
            'contacts: rolling and torsion need slip="end" and order="simultaneous"; they are not '
            "defined along the path of an impact"
        )
    from .turning import solve_turning

    check_problem(problem)
    return solve_turning(problem, law)


def _immovable(problem: ContactProblem) -> ContactSolution:
    """Contacts between what no impulse can move: none acts, and none may approach."""
    n, free = len(problem.friction), problem.velocity_free
    status = Status.SOLVED if (free[2::3] >= 0.0).all() else Status.NO_SOLUTION
    none = np.zeros(n)
    return ContactSolution(np.zeros(3 * n), free, status, 0.0, None, free, none, none)


def _one(problem: ContactProblem, law: Law) -> ContactSolution:
    """One contact, without arrays on the way."""
    e, mu = problem.restitution.item(), problem.friction.item()
    e_t = problem.tangential_restitution.item()
    if problem.delassus.shape != (3, 3):
        check_problem(problem)
    (t11, t12, n1), (_, t22, n2), (_, _, nn) = problem.delassus.tolist()
    before, free = tuple(problem.velocity_before.tolist()), tuple(problem.velocity_free.tolist())
    if not (
        0.0 <= e <= 1.0
        and 0.0 <= mu < np.inf
        and -1.0 <= e_t <= 1.0
        and len(before) == len(free) == 3
        and is_finite(before)
        and is_finite(free)
        and is_finite((t11, t12, t22))
        and is_finite((n1, n2, nn))
    ):
        check_problem(problem)
        raise RangeError.of("contacts: delassus", "an overflow", "small enough to be added up")
    hit = strike((t11, t12, t22, n1, n2, nn), before, free, e, mu, e_t, law)
    unique = None
    if hit.status is Status.NOT_UNIQUE:
        unique = np.zeros(1, dtype=bool)
    from_before = law.restitution == "newton" and law.slip == "end"
    return ContactSolution(
        np.array(hit.impulse),
        np.array(hit.after),
        hit.status,
        hit.residual,
        unique,
        problem.velocity_before if from_before else problem.velocity_free,
        np.array((hit.normal_work,)),
        np.array((hit.friction_work,)),
    )
