"""Contacts one after the other: the fastest approach first, until none approaches.

As ``impact.laws.sequential`` has it; where two approach so evenly that digits would decide
which comes first, the state is left to the solver of single states.
"""

from __future__ import annotations

from ..codes import AGAIN, RowStatus
from .coulomb import GAIN
from .hit import hit_at_end
from .jit import built_in
from .layout import CONTACT_INTS
from .problem import pose, problem_in, put_back, room
from .words import NEWTON

__all__ = ["MOST_HITS", "begin", "book", "fastest", "sequel", "sequential_lanes"]

# A chain that loses energy dies out well before; one that does not end never would.
MOST_HITS = 10_000
# Approaches this small against the first velocities are over.
AT_REST = 1e-15
# Approaches this even, against themselves and against the first velocities, may come in
# either order. Below SLOW the order is of no matter.
EVEN, EVEN_AT_FIRST, SLOW = 1e-12, 4e-15, 1e-14
# A sequence that has gained this much is not followed.
FASTER = 1e6
_SOLVED, _GAIN = int(RowStatus.SOLVED), int(RowStatus.ENERGY_GAIN)
_TOO_LONG = int(RowStatus.SEQUENCE_TOO_LONG)


def sequential_lanes(
    base, rows, target, keeping, contact_ints, contact_floats, given, words, digits,
    work, w_at, before_at, free_at, p_at, w, code,
):  # fmt: skip
    """Write the impulses of all rows, and the codes, for the states of a block from ``base`` on.

    The arguments are those of ``problem.pose``.
    """
    space = room(rows, len(contact_ints) // CONTACT_INTS)
    for lane in range(w):
        count = pose(
            base + lane, lane, rows, target, keeping, contact_ints, contact_floats, given, digits,
            work, w_at, before_at, free_at, w, code, space,
        )  # fmt: skip
        if count > 0:
            code[lane] = _solved(count, words[0], digits, space)
        put_back(lane, count, rows, len(target), contact_ints, work, p_at, w, code, space)


@built_in
def _solved(count, restitution, digits, space):
    """The code, with P of the contacts that touch in ``space``."""
    _, _, (_, found, roots), _ = space
    W, _, _, mus, es, ets, _ = problem_in(space)
    velocity, first = begin(count, space)
    code = _SOLVED
    works, spent = 0.0, 0.0
    for _ in range(MOST_HITS):
        i = fastest(velocity, count, first, digits)
        if i < 0:
            return sequel(i, code, works, spent)
        if restitution != NEWTON and mus[i] > 0.0 and ets[i] != 0.0:
            # Which is refused.
            return AGAIN
        k = 3 * i
        p1, p2, pn, normal, friction, one = hit_at_end(
            W, i, velocity[k], velocity[k + 1], velocity[k + 2], es[i], mus[i], ets[i],
            restitution, found, roots,
        )  # fmt: skip
        if one == AGAIN:
            return AGAIN
        if code == _SOLVED:
            code = one
        works += normal + friction
        spent += abs(normal) + abs(friction)
        spent += abs(p1 * velocity[k]) + abs(p2 * velocity[k + 1]) + abs(pn * velocity[k + 2])
        book(i, p1, p2, pn, count, space)
    return _TOO_LONG


@built_in
def begin(count, space):
    """(3n,) the velocities, which hits change, and the size of the first normal ones."""
    line = space[1]
    free, P, velocity = line[1], line[9], line[20]
    first = 0.0
    for k in range(3 * count):
        P[k] = 0.0
        velocity[k] = free[k]
        if k % 3 == 2:
            first = max(first, abs(free[k]))
    return velocity, first


@built_in
def fastest(velocity, count, first, digits):
    """The contact that approaches fastest; -1 where none does, -2 where digits would decide."""
    found = 0
    for i in range(count):
        if velocity[3 * i + 2] < velocity[3 * found + 2]:
            found = i
    speed = -velocity[3 * found + 2]
    if speed <= AT_REST * first:
        return -1
    if not speed < FASTER * first:
        return -2
    if speed > SLOW * first:
        even = EVEN * speed + EVEN_AT_FIRST * first
        if digits < 53:
            even = 1e-4 * speed + 1e-6 * first
        for i in range(count):
            if i != found and -velocity[3 * i + 2] > speed - even:
                return -2
    return found


@built_in
def book(i, p1, p2, pn, count, space):
    """Add what a hit of contact i does."""
    W, line = space[0][0], space[1]
    P, velocity = line[9], line[20]
    k = 3 * i
    P[k] += p1
    P[k + 1] += p2
    P[k + 2] += pn
    for j in range(3 * count):
        velocity[j] += W[j, k] * p1 + W[j, k + 1] * p2 + W[j, k + 2] * pn


@built_in
def sequel(i, code, works, spent):
    """The code of a sequence that is over, by what ``fastest`` said."""
    if i == -2:
        return AGAIN
    # One hit may gain what the others lose: the sum is what counts.
    return _GAIN if works > GAIN * spent else code
