"""Several contacts at once, friction looking at the end of the impact."""

from __future__ import annotations

import numpy as np

from ...laws.several import Struck, hit_contacts
from ...laws.single import GAIN
from ...laws.status import Status
from ...laws.words import AGAIN, NEWTON, POISSON
from ...scene.law import Law
from .problem import ContactProblem, ContactSolution
from .single import refuse_tangential

__all__ = ["solve_simultaneous"]

# [N s] Of smaller impulses a solution would leave the normal doubles, and none of it would count.
LEAST_RELEASE = 1e-290


def solve_simultaneous(problem: ContactProblem, law: Law) -> ContactSolution:
    """All contacts at once, under Newton's or Poisson's law.

    Raises:
        InputError: tangential restitution under Poisson's law.
    """
    newton = law.restitution == "newton"
    if not newton and problem.tangential_restitution[problem.friction > 0.0].any():
        refuse_tangential(law)
    found = _by_law(problem, NEWTON if newton else POISSON)
    if found is not None:
        return found
    return _newton(problem) if newton else _poisson(problem)


def _by_law(problem: ContactProblem, restitution: int) -> ContactSolution | None:
    """The answer of ``laws.several``; None where it leaves the problem."""
    # Compiled code takes arrays in order that may be written to.
    hit = Struck(
        *hit_contacts(
            _in_order(problem.delassus),
            _in_order(problem.velocity_before),
            _in_order(problem.velocity_free),
            _in_order(problem.friction),
            _in_order(problem.restitution),
            _in_order(problem.tangential_restitution),
            restitution,
        )
    )
    if hit.code == AGAIN:
        return None
    return ContactSolution(
        hit.impulse,
        hit.after,
        hit.status,
        hit.residual,
        None if hit.status is Status.SOLVED or hit.unique.all() else hit.unique,
        problem.velocity_before if restitution == NEWTON else problem.velocity_free,
        hit.normal_work,
        hit.friction_work,
    )


def _in_order(array: np.ndarray) -> np.ndarray:
    flags = array.flags
    return array if flags.c_contiguous and flags.writeable else array.copy()


def _newton(problem: ContactProblem) -> ContactSolution:
    before, free = problem.velocity_before, problem.velocity_free
    shifted = free.copy()
    shifted[2::3] += problem.restitution * np.minimum(before[2::3], 0.0)
    if any(problem.tangential_restitution.tolist()):
        e_t = problem.tangential_restitution
        shifted[0::3] += e_t * before[0::3]
        shifted[1::3] += e_t * before[1::3]
    from .frictional import solve_frictional

    phase = solve_frictional(problem.delassus, shifted, problem.friction)
    impulse, status = phase.impulse, phase.status
    after = problem.delassus.dot(impulse) + free
    normal, friction = _works(impulse, before, after)
    return ContactSolution(
        impulse,
        after,
        _judged(status, normal, friction, impulse, before),
        phase.residual,
        phase.unique,
        before,
        normal,
        friction,
        phase.iterations,
    )


def _poisson(problem: ContactProblem) -> ContactSolution:
    """Compression with e = 0, then expansion with P_n ≥ e P_n^c (Glocker & Pfeiffer 1995)."""
    from .frictional import solve_frictional

    delassus, free = problem.delassus, problem.velocity_free
    fastest = max(map(abs, free.tolist()))
    floor = np.zeros_like(problem.friction)
    impulse = np.zeros_like(free)
    velocity = free
    normal, friction = np.zeros_like(floor), np.zeros_like(floor)
    status, residual, iterations = Status.SOLVED, 0.0, 0
    unique: np.ndarray | None = None
    start: np.ndarray | None = None
    released = bool(problem.restitution.any())
    for phase in ("compression", "expansion"):
        part = solve_frictional(
            delassus, velocity, problem.friction, floor, start, fastest, least=released
        )
        share, found, alone = part.impulse, part.status, part.unique
        after = velocity + delassus @ share
        works = _works(share, velocity, after)
        normal, friction = normal + works[0], friction + works[1]
        impulse, velocity = impulse + share, after
        iterations += part.iterations
        residual = max(residual, part.residual)
        if found is not Status.SOLVED and status.valid:
            status = found
        if alone is not None:
            unique = alone if unique is None else unique & alone
        if not status.valid or not problem.restitution.any():
            break
        if phase == "compression":
            floor = problem.restitution * share[2::3]
            floor[floor < LEAST_RELEASE] = 0.0
            if not floor.any():
                break
            start = np.repeat(problem.restitution, 3) * share
    after = delassus @ impulse + free
    return ContactSolution(
        impulse,
        after,
        _judged(status, normal, friction, impulse, free),
        residual,
        unique,
        free,
        normal,
        friction,
        iterations,
    )


def _works(
    impulse: np.ndarray, start: np.ndarray, after: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """(n,) P·(u_start + u⁺)/2 of the normals and of the tangents."""
    work = 0.5 * impulse * (start + after)
    return work[2::3], work[0::3] + work[1::3]


def _judged(
    status: Status,
    normal: np.ndarray,
    friction: np.ndarray,
    impulse: np.ndarray,
    start: np.ndarray,
) -> Status:
    """The status, or that the energy went up."""
    total = sum(normal.tolist()) + sum(friction.tolist())
    if total > 0.0 and status.valid:
        size = np.abs(impulse) @ np.abs(start) + np.abs(normal).sum() + np.abs(friction).sum()
        if total > GAIN * size:
            return Status.ENERGY_GAIN
    return status
