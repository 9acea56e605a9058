"""Contacts one after the other: the fastest approach first, until none approaches.

As ``impact.laws.sequential`` has it; where two approach so evenly that digits would decide
which comes first, the state is left to the solver of single states.
"""

from __future__ import annotations

from ...impact.laws import order
from ...laws.single import GAIN
from ...laws.status import Status
from ...laws.words import NEWTON
from ..codes import AGAIN
from .hit import hit_contact
from .jit import built_in
from .layout import CONTACT_INTS
from .problem import pose, problem_in, put_back, room

__all__ = ["MOST_HITS", "begin", "book", "next_hit", "sequel", "sequential_lanes"]

# A chain that loses energy dies out well before; one that does not end never would.
MOST_HITS = 10_000
# From here on ``solve`` looks for the limit of hits that shrink.
LONG = 100
# Approaches this even, against themselves and against the first velocities, may come in
# either order. Below SLOW the order is of no matter.
EVEN, EVEN_AT_FIRST, SLOW = order.EVEN, 4e-14, 2e-13
# A sequence that has gained this much is not followed; one that has shrunk this much may have a
# limit.
FASTER, SHRUNK = 1e6, 0.5
fastest, pace_of = built_in(order.fastest), built_in(order.pace_of)
_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_TOO_LONG = int(Status.SEQUENCE_TOO_LONG)


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
    W, _, _, mus, es, ets, _ = problem_in(space)
    velocity, first = begin(count, space)
    code = _SOLVED
    works, spent = 0.0, 0.0
    for hits in range(MOST_HITS):
        i = next_hit(hits, velocity, count, first, digits, space)
        if i < 0:
            return sequel(i, code, works, spent)
        if restitution != NEWTON and mus[i] > 0.0 and ets[i] != 0.0:
            # Which is refused.
            return AGAIN
        k = 3 * i
        p1, p2, pn, normal, friction, one = hit_contact(
            W, i, velocity, es[i], mus[i], ets[i], restitution, digits
        )
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
    """(3n,) the velocities, which hits change, and the pace of the fastest at first."""
    W, line = space[0][0], space[1]
    free, P, velocity = line[1], line[9], line[10]
    first = 0.0
    for k in range(3 * count):
        P[k] = 0.0
        velocity[k] = free[k]
        if k % 3 == 2 and W[k, k] > 0.0:
            first = max(first, pace_of(free[k], W[k, k]))
    return velocity, first


@built_in
def next_hit(hits, velocity, count, first, digits, space):
    """The contact that is hit next; -1 where none approaches, -2 where ``solve`` is to say.

    That is where digits would decide which comes first, and where hits shrink for so long that
    they may have a limit.
    """
    W, line = space[0][0], space[1]
    free, mus, P = line[1], line[2], line[9]
    before, scale = line[0], 0.0
    for k in range(3 * count):
        scale = max(scale, abs(before[k]))
    found = fastest(W.reshape(-1), W.shape[0], velocity, free, P, mus, scale, count)
    if found < 0:
        return -1
    if not W[3 * found + 2, 3 * found + 2] > 0.0:
        return -2
    pace = pace_of(velocity[3 * found + 2], W[3 * found + 2, 3 * found + 2])
    if not pace < FASTER * first or (hits >= LONG and pace < SHRUNK * first):
        return -2
    if pace > SLOW * first:
        even = EVEN * pace + EVEN_AT_FIRST * first
        if digits < 53:
            even = 1e-4 * pace + 1e-6 * first
        for i in range(count):
            n = 3 * i + 2
            approaches = i != found and velocity[n] < 0.0 and W[n, n] > 0.0
            if approaches and pace_of(velocity[n], W[n, n]) > pace - even:
                return -2
    return found


@built_in
def book(i, p1, p2, pn, count, space):
    """Add what a hit of contact i does."""
    W, line = space[0][0], space[1]
    P, velocity = line[9], line[10]
    k = 3 * i
    P[k] += p1
    P[k + 1] += p2
    P[k + 2] += pn
    for j in range(3 * count):
        velocity[j] += W[j, k] * p1 + W[j, k + 1] * p2 + W[j, k + 2] * pn


@built_in
def sequel(i, code, works, spent):
    """The code of a sequence that is over, by what ``next_hit`` said."""
    if i == -2:
        return AGAIN
    # One hit may gain what the others lose: the sum is what counts.
    return _GAIN if works > GAIN * spent else code
