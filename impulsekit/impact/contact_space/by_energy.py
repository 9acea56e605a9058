"""Contacts whose impulses grow with their stored energies: the law of Liu, Zhao and Brogliato."""

from __future__ import annotations

import numpy as np

from ...errors import InputError
from ...laws.lzb import APPROACH_ENDED, Waved, strike_by_energy
from ...laws.status import Status
from ...scene.law import Law
from .problem import ContactProblem, ContactSolution
from .single import refuse_tangential

__all__ = ["check_stiffness", "solve_by_energy"]


def solve_by_energy(problem: ContactProblem, law: Law) -> ContactSolution:
    """All contacts at once, from where they touch until all have parted.

    Raises:
        InputError: as ``check_stiffness``; an infinite stiffness where a contact approaches, at
            first or after it has parted.
    """
    stiffness, free = check_stiffness(problem, law), problem.velocity_free
    speed = float(np.abs(free).max())
    rigid = np.flatnonzero(np.isinf(stiffness) & (free[2::3] < -APPROACH_ENDED * speed))
    if len(rigid):
        raise InputError(
            f"contacts: contact {problem.number_of(rigid[0])} is approached at "
            f"{-free[3 * rigid[0] + 2]:.6g} m/s and has an infinite stiffness, which is for "
            "supports at rest; give it a finite one"
        )
    hit = Waved(
        *strike_by_energy(
            np.ascontiguousarray(problem.delassus),
            np.ascontiguousarray(free),
            np.array(problem.restitution, dtype=float),
            np.array(problem.friction, dtype=float),
            np.array(stiffness, dtype=float),
            law.exponent,
        )
    )
    if hit.status is Status.REFUSED:
        met = int(np.where(np.isinf(stiffness), hit.after[2::3], np.inf).argmin())
        raise InputError(
            f"contacts: contact {problem.number_of(met)} has an infinite stiffness, parts in this "
            f"impact and is met again at {-hit.after[3 * met + 2]:.6g} m/s; such a stiffness is "
            "for supports that stay, give it a finite one"
        )
    return ContactSolution(
        hit.impulse,
        hit.after,
        hit.status,
        hit.residual,
        None,
        free,
        hit.normal_work,
        hit.friction_work,
        hit.steps,
    )


def check_stiffness(problem: ContactProblem, law: Law) -> np.ndarray:
    """(n,) the stiffness of all contacts.

    Raises:
        InputError: a contact without stiffness, or tangential restitution.
    """
    stiffness = problem.stiffness
    if stiffness is None or stiffness.shape != problem.friction.shape:
        raise InputError('contacts: restitution="lzb" needs the stiffness of every contact')
    if not (stiffness > 0.0).all():
        raise InputError(f"contacts: stiffness must be above 0, got {stiffness.min()}")
    if problem.tangential_restitution[problem.friction > 0.0].any():
        refuse_tangential(law)
    return stiffness
