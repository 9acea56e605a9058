"""Contacts one after the other: the fastest approach first, until none approaches."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from ...scene.law import Law
from ..status import Status
from .problem import ContactProblem, ContactSolution
from .single import GAIN, Hit, Triple, block_of, strike

__all__ = ["hits_of", "solve_sequential"]

# A chain that loses energy dies out well before; one that does not end never would.
MOST_HITS = 10_000
# Where contacts gain from each other, speeds would leave the doubles in time.
FASTER = 1e30
# Approaches this small against the first velocities are over.
AT_REST = 1e-15


def solve_sequential(problem: ContactProblem, law: Law) -> ContactSolution:
    """Single hits, each with the velocities that the last one left.

    Raises:
        InputError: tangential restitution under any but Newton's law with slip at the end.
    """
    n = len(problem.friction)
    delassus, free = problem.delassus, problem.velocity_free
    impulse = np.zeros(3 * n)
    normal, friction = np.zeros(n), np.zeros(n)
    status, residual = Status.SOLVED, 0.0
    unique: np.ndarray | None = None
    count = 0
    spent = 0.0
    most = FASTER * float(np.abs(free[2::3]).max())
    for i, velocity, hit in hits_of(problem, law):
        if count == MOST_HITS or not -velocity[3 * i + 2] < most:
            status = Status.SEQUENCE_TOO_LONG
            break
        count += 1
        impulse[3 * i : 3 * i + 3] += hit.impulse
        normal[i] += hit.normal_work
        friction[i] += hit.friction_work
        residual = max(residual, hit.residual)
        # Where nothing is lost, works are but the rounding of what went in and came back.
        spent += abs(hit.normal_work) + abs(hit.friction_work)
        spent += sum(
            abs(p * u) for p, u in zip(hit.impulse, velocity[3 * i : 3 * i + 3], strict=True)
        )
        if hit.status is Status.NOT_UNIQUE:
            unique = np.ones(n, dtype=bool) if unique is None else unique
            unique[i] = False
        elif hit.status not in (Status.SOLVED, Status.ENERGY_GAIN) and status.valid:
            status = hit.status
        if not hit.status.valid and hit.status is not Status.ENERGY_GAIN:
            break
    # One hit may gain what the others lose: the sum is what counts.
    if status.valid and float(normal.sum() + friction.sum()) > GAIN * spent:
        status = Status.ENERGY_GAIN
    elif status is Status.SOLVED and unique is not None:
        status = Status.NOT_UNIQUE
    after = delassus @ impulse + free
    return ContactSolution(impulse, after, status, residual, unique, free, normal, friction, count)


def hits_of(problem: ContactProblem, law: Law) -> Iterator[tuple[int, np.ndarray, Hit]]:
    """The hits in order: which contact, (3n,) all velocities at its start, what it did."""
    n = len(problem.friction)
    delassus, velocity = problem.delassus, problem.velocity_free.copy()
    blocks = [block_of(delassus, i) for i in range(n)]
    columns = [np.ascontiguousarray(delassus[:, 3 * i : 3 * i + 3]) for i in range(n)]
    coefficients = list(
        zip(
            problem.restitution.tolist(),
            problem.friction.tolist(),
            problem.tangential_restitution.tolist(),
            strict=True,
        )
    )
    rest = AT_REST * float(np.abs(velocity[2::3]).max())
    while True:
        i = int(velocity[2::3].argmin())
        if velocity[3 * i + 2] >= -rest:
            return
        now: Triple = tuple(velocity[3 * i : 3 * i + 3].tolist())
        e, mu, e_t = coefficients[i]
        hit = strike(blocks[i], now, now, e, mu, e_t, law)
        yield i, velocity, hit
        velocity = velocity + columns[i] @ np.array(hit.impulse)
