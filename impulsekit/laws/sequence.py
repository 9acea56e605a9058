"""Contacts one after the other: the fastest approach first, until none approaches."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .approach import block_at
from .borrowed import borrowing
from .compiled import compiled, entry
from .groups import find_groups
from .order import NOISE, fastest, foremost, pace_of
from .path import follow
from .progress import (
    FRICTION,
    NORMAL,
    P1,
    P2,
    RESIDUAL,
    U1,
    U2,
    UN,
    Block,
    P,
    PathMemory,
    Triple,
    path_memory,
)
from .single import Hit, hit_at_end
from .status import Status
from .tolerances import CLEAR, GAIN, NEGLIGIBLE, RESIDUAL_LIMIT
from .words import END, NEWTON

__all__ = [
    "CODE", "COUNT", "ENDED", "FIRST", "GOES_ON", "LAST", "LONG", "REFUSED", "TIED",
    "WORST", "Contacts", "Sequence", "advance", "advance_sequence", "begin", "end_code",
    "sequence_of",
]  # fmt: skip

# A chain that loses energy dies out well before; one that does not end never would.
MOST_HITS = 10_000
# So many where hits shrink, by too little to see the limit and too steadily to give up: a
# series of ratio 1 − 1e-3 reaches rounding by then.
MOST_SHRINKING_HITS = 40_000
# Hits shrink where they come down to this share of the first.
SHRUNK = 1e-3
# Every so many hits it is looked whether they shrink: what does not come down to the second share
# in these does not.
LONG, HANDED_ON = 100, 0.5
# What the closed form of a hit may leave in directions that it does not know of, and what hits may
# hand on as rounding, relative.
LEFT = 1e-10
# After MOST_HITS what has come down by less than this in as many hits again does not shrink: two
# contacts whose W nearly depend hand on rounding of 2e-10 of the first hit without end, of which
# the largest of LONG hits varies by some 1e-3.
STEADY = 1.0 - 1e-2
# Where contacts gain from each other, speeds would leave the doubles in time.
FASTER = 1e30
# Eigenvalues of a contact's W below this share of the largest are those of motions that the
# bodies do not have against each other; pivots above CLEAR have no such.
NO_MOTION = 1e-13
# What ``advance`` says: none approaches any more; hits go on; tangential restitution where it has
# no meaning.
ENDED, GOES_ON, REFUSED = 0, 1, 2
# Where in ``Sequence.now`` is what: how many hits; |u_n|/√W_nn of the fastest contact at first, and
# the largest of LONG hits, LONG hits ago; at how many hits it was looked; whether the order of the
# entries said which of two was hit first; the largest residual; the status so far; the size of u⁻;
# as LAST, at the last count that was LONG times a power of two; as LAST, of the hits since.
COUNT, FIRST, LAST, LOOKED, TIED, WORST, CODE, SCALE, HALFWAY, PEAK, _SIZE = range(11)
_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_JAM, _NOT_UNIQUE = int(Status.PAINLEVE_JAM), int(Status.NOT_UNIQUE)
_TOO_LONG = int(Status.SEQUENCE_TOO_LONG)


class Contacts(NamedTuple):
    """What is struck.

    Attributes:
        W: (3n, 3n) Delassus matrix [1/kg].
        free: (3n,) u_free [m/s].
        e, mu, e_t: (n,) restitution, friction, tangential restitution.
        restitution, slip: words of the law.
    """

    W: np.ndarray
    free: np.ndarray
    e: np.ndarray
    mu: np.ndarray
    e_t: np.ndarray
    restitution: int
    slip: int


class Sequence(NamedTuple):
    """How far it has come.

    Attributes:
        velocity, impulse: (3n,) u now [m/s], P so far [N s].
        normal, friction: (n,) works [J].
        spent: (n,) the sums of |works| and |P·u| [J].
        group, queue: (n,) which contacts act on each other, and room to find that.
        unique: (n,) whether each impulse is determined.
        motions: (n, 3, 3) the projection on the relative velocities that each contact can have.
        limited: (n,) whether these are not all.
        now: numbers, by the names above.
    """

    velocity: np.ndarray
    impulse: np.ndarray
    normal: np.ndarray
    friction: np.ndarray
    spent: np.ndarray
    group: np.ndarray
    queue: np.ndarray
    unique: np.ndarray
    motions: np.ndarray
    limited: np.ndarray
    now: np.ndarray


@compiled
def sequence_of(n: int) -> Sequence:
    """Room for n contacts."""
    return Sequence(
        np.zeros(3 * n), np.zeros(3 * n), np.zeros(n), np.zeros(n), np.zeros(n),
        np.zeros(n, np.int64), np.zeros(n, np.int64), np.ones(n, np.bool_),
        np.zeros((n, 3, 3)), np.zeros(n, np.bool_), np.zeros(_SIZE),
    )  # fmt: skip


@borrowing
def begin(sequence: Sequence, contacts: Contacts, before: np.ndarray, n: int) -> None:
    """Write the start of a sequence of n contacts, ``before`` being u⁻."""
    sequence.now[:] = 0.0
    for k in range(3 * n):
        sequence.velocity[k], sequence.impulse[k] = contacts.free[k], 0.0
        sequence.now[SCALE] = max(sequence.now[SCALE], abs(before[k]))
    for i in range(n):
        sequence.normal[i], sequence.friction[i], sequence.unique[i] = 0.0, 0.0, True
        sequence.spent[i] = 0.0
        sequence.limited[i] = _limit(contacts.W, 3 * i, contacts.mu[i], sequence.motions[i])


@compiled
def _limit(W: np.ndarray, k: int, mu: float, motions: np.ndarray) -> bool:
    """Write the projection on what W of one contact moves; False where that is all."""
    if not mu > 0.0:
        return False
    d1 = W[k, k]
    if d1 > 0.0:
        d2 = W[k + 1, k + 1] - W[k, k + 1] ** 2 / d1
        if d2 > CLEAR * W[k + 1, k + 1]:
            c = W[k + 1, k + 2] - W[k, k + 1] * W[k, k + 2] / d1
            d3 = W[k + 2, k + 2] - W[k, k + 2] ** 2 / d1 - c * c / d2
            most = max(d1, W[k + 1, k + 1], W[k + 2, k + 2])
            if min(d1, d2, d3) > CLEAR * most:
                return False
    values, axes = np.linalg.eigh(W[k : k + 3, k : k + 3].copy())
    if values[0] > NO_MOTION * values[2]:
        return False
    motions[:] = 0.0
    for m in range(3):
        if values[m] > NO_MOTION * values[2]:
            for r in range(3):
                for c in range(3):
                    motions[r, c] += axes[r, m] * axes[c, m]
    return True


@borrowing
def advance(
    sequence: Sequence,
    contacts: Contacts,
    n: int,
    until: int,
    who: np.ndarray,
    hits: np.ndarray,
    memory: PathMemory,
) -> int:
    """Hit one contact after the other; what comes next: ENDED, GOES_ON or REFUSED.

    Args:
        sequence: is changed.
        contacts: what is struck.
        n: how many contacts.
        until: how many hits there are to be at most, those before included.
        who, hits: (m,) and (m, 3), written: contact and impulse of each hit.
        memory: of ``path.follow``.
    """
    # Taken out here: an array that is taken out of a tuple is counted every time.
    now, velocity, impulse = sequence.now, sequence.velocity, sequence.impulse
    normal, friction, limited = sequence.normal, sequence.friction, sequence.limited
    spent = sequence.spent
    W, free, e, mu, e_t = contacts.W, contacts.free, contacts.e, contacts.mu, contacts.e_t
    plain = contacts.slip == END and contacts.restitution == NEWTON
    first_hit = int(now[COUNT])
    while True:
        found = fastest(W, velocity, free, impulse, mu, now[SCALE], n)
        if found < 0:
            return ENDED
        i, tied = foremost(found, W, velocity, contacts.free, sequence.impulse, e, mu)
        nn = W[3 * i + 2, 3 * i + 2]
        pace = pace_of(velocity[3 * i + 2], nn) if nn > 0.0 else 0.0
        count = int(now[COUNT])
        if count < n:
            now[FIRST] = max(now[FIRST], pace)
        first = now[FIRST]
        if tied and pace > NOISE * first:
            now[TIED] = 1.0
        # What does not shrink any more, that small, is the rounding that hits hand on.
        now[PEAK] = max(now[PEAK], pace)
        if count > now[LOOKED] and count % LONG == 0:
            # The largest of them all: two contacts that hit each other need not be equally fast.
            peak = now[PEAK]
            now[LOOKED], now[PEAK] = count, 0.0
            if HANDED_ON * now[LAST] < peak <= NOISE * first:
                return ENDED
            now[LAST] = peak
            # Light bodies hand on more: seen over twice as many hits.
            if count // LONG & (count // LONG - 1) == 0:
                steady = count > MOST_HITS and peak > STEADY * now[HALFWAY]
                bar = RESIDUAL_LIMIT if steady else LEFT
                if 0.0 < HANDED_ON * now[HALFWAY] < peak <= bar * first:
                    now[WORST] = max(now[WORST], peak / first)
                    return ENDED
                now[HALFWAY] = peak
        most = MOST_HITS if pace > SHRUNK * first else MOST_SHRINKING_HITS
        if count >= most or pace > FASTER * first:
            now[CODE] = _TOO_LONG
            return ENDED
        if count >= until:
            return GOES_ON
        if not plain and e_t[i] != 0.0 and mu[i] > NEGLIGIBLE:
            return REFUSED
        if limited[i]:
            _leave_possible(sequence, free, n, i)
        block, k = block_at(W, 3 * i), 3 * i
        start = (velocity[k], velocity[k + 1], velocity[k + 2])
        if contacts.slip == END:
            hit = hit_at_end(block, start, start, e[i], mu[i], e_t[i], contacts.restitution)
        else:
            hit = _followed(block, start, e[i], mu[i], contacts.restitution, memory)
        jams = hit.code not in (_SOLVED, _JAM, _NOT_UNIQUE, _GAIN)
        if jams and 0.0 < pace <= LEFT * first:
            # What the hits before have left has no impulse to answer it.
            now[WORST] = max(now[WORST], pace / first)
            return ENDED
        at = count - first_hit
        who[at] = i
        hits[at, 0], hits[at, 1], hits[at, 2] = hit.impulse
        normal[i] += hit.normal_work
        friction[i] += hit.friction_work
        # Where nothing is lost, works are but the rounding of what went in and came back.
        spent[i] += abs(hit.normal_work) + abs(hit.friction_work)
        for j in range(3):
            spent[i] += abs(hit.impulse[j] * start[j])
        _take(now, velocity, impulse, W, n, k, hit)
        if hit.code == _NOT_UNIQUE:
            sequence.unique[i] = False
        if jams:
            return ENDED


@borrowing
def _leave_possible(sequence: Sequence, free: np.ndarray, n: int, i: int) -> None:
    """Take away what is but rounding along motions that the bodies at contact i do not have."""
    velocity, motions, k = sequence.velocity, sequence.motions[i], 3 * i
    size, off = sequence.now[SCALE], 0.0
    u = (velocity[k], velocity[k + 1], velocity[k + 2])
    possible = (
        motions[0, 0] * u[0] + motions[0, 1] * u[1] + motions[0, 2] * u[2],
        motions[1, 0] * u[0] + motions[1, 1] * u[1] + motions[1, 2] * u[2],
        motions[2, 0] * u[0] + motions[2, 1] * u[1] + motions[2, 2] * u[2],
    )
    for j in range(3 * n):
        size = max(size, abs(velocity[j]), abs(free[j]))
    for j in range(3):
        off = max(off, abs(possible[j] - u[j]))
    if off <= NOISE * size:
        velocity[k], velocity[k + 1], velocity[k + 2] = possible


@borrowing
def _followed(
    block: Block, start: Triple, e: float, mu: float, restitution: int, memory: PathMemory
) -> Hit:
    """What a hit does along the path of its slip."""
    mu = mu if mu > NEGLIGIBLE else 0.0
    e = e if e > NEGLIGIBLE else 0.0
    code = follow(block, start[2], start, e, mu, restitution, memory)
    path = memory.now
    impulse, after = (path[P1], path[P2], path[P]), (path[U1], path[U2], path[UN])
    return Hit(impulse, after, code, path[RESIDUAL], path[NORMAL], path[FRICTION])


@borrowing
def _take(
    now: np.ndarray,
    velocity: np.ndarray,
    impulse: np.ndarray,
    W: np.ndarray,
    n: int,
    k: int,
    hit: Hit,
) -> None:
    """Go on from behind a hit of the contact whose rows begin at k."""
    p1, p2, pn = hit.impulse
    now[WORST] = max(now[WORST], hit.residual)
    impulse[k] += p1
    impulse[k + 1] += p2
    impulse[k + 2] += pn
    for j in range(3 * n):
        velocity[j] += W[j, k] * p1 + W[j, k + 1] * p2 + W[j, k + 2] * pn
    now[COUNT] += 1.0
    lawful = hit.code in (_SOLVED, _GAIN, _NOT_UNIQUE)
    if not lawful and now[CODE] in (_SOLVED, _JAM):
        now[CODE] = hit.code


@borrowing
def end_code(sequence: Sequence, contacts: Contacts, n: int) -> int:
    """The code of a sequence that is over."""
    code = int(sequence.now[CODE])
    unique = True
    for i in range(n):
        unique = unique and sequence.unique[i]
    if code in (_SOLVED, _JAM) and _gains(sequence, contacts, n):
        return _GAIN
    return _NOT_UNIQUE if code == _SOLVED and not unique else code


@borrowing
def _gains(sequence: Sequence, contacts: Contacts, n: int) -> bool:
    """Whether contacts that act on each other gain energy together.

    One hit may gain what others of these lose; what bodies lose that lie apart counts for nothing.
    """
    normal, friction, spent = sequence.normal, sequence.friction, sequence.spent
    any_gains = False
    for i in range(n):
        any_gains = any_gains or normal[i] + friction[i] > 0.0
    if not any_gains:
        return False
    group = sequence.group
    for number in range(find_groups(contacts.W, contacts.mu, n, group, sequence.queue)):
        works, size = 0.0, 0.0
        for i in range(n):
            if group[i] == number:
                works += normal[i] + friction[i]
                size += spent[i]
        if works > GAIN * size:
            return True
    return False


def _examples() -> tuple[object, ...]:
    line, few = np.ones(6), np.ones(2)
    contacts = Contacts(np.eye(6), line, few, few, few, NEWTON, END)
    return sequence_of(2), contacts, line, 1, np.ones(2, np.int64), np.ones((2, 3)), path_memory()


@entry(_examples, seconds=8.0, apart=True)
def advance_sequence(
    sequence: Sequence,
    contacts: Contacts,
    before: np.ndarray,
    until: int,
    who: np.ndarray,
    hits: np.ndarray,
    memory: PathMemory,
) -> tuple[int, int]:
    """``advance``, begun before where there were no hits yet; what comes next, and the code."""
    n = len(contacts.mu)
    if sequence.now[COUNT] == 0.0:
        begin(sequence, contacts, before, n)
    step = advance(sequence, contacts, n, until, who, hits, memory)
    return step, end_code(sequence, contacts, n)
