"""Contacts one after the other: the fastest approach first, until none approaches."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from ...laws.progress import Triple
from ...laws.single import GAIN, Hit
from ...laws.status import Status
from ...scene.law import Law
from .limit import Jump, find_limit
from .order import NOISE, fastest, foremost, pace_of
from .problem import ContactProblem, ContactSolution
from .single import block_of, strike

__all__ = ["hits_of", "solve_sequential"]

# A chain that loses energy dies out well before; one that does not end never would.
MOST_HITS = 10_000
# So many where hits shrink, by too little to see the limit and too steadily to give up: a
# series of ratio 1 − 1e-3 reaches rounding by then.
MOST_SHRINKING_HITS = 40_000
# From here on the limit of a series of hits is looked for, and again each time there are this
# many times as many hits. Shorter series end by themselves, all but a few of those with ratios
# below 0.7.
LONG, LATER = 100, 1.5
# Hits that do not come down to this share in LONG of them do not shrink.
HANDED_ON = 0.5
# What the closed form of a hit may leave in directions that it does not know of, relative.
LEFT = 1e-10
# Where contacts gain from each other, speeds would leave the doubles in time.
FASTER = 1e30
# Eigenvalues of a contact's W below this share of the largest are those of motions that the
# bodies do not have against each other.
NO_MOTION = 1e-13


class _Sequence:
    """The hits of a sequence, and the velocities that they leave.

    Attributes:
        velocity: (3n,) of all contacts now [m/s].
        impulse: (3n,) P so far [N s].
        hits: contact and impulse of each hit so far.
        pace: of the contact that is next; first: the fastest so.
        tied: whether the order of the entries said which is hit first.
    """

    def __init__(self, problem: ContactProblem, law: Law) -> None:
        self.problem, self._law = problem, law
        delassus, n = problem.delassus, len(problem.friction)
        self.velocity = problem.velocity_free
        self.impulse = np.zeros(3 * n)
        self.hits: list[tuple[int, tuple[float, float, float]]] = []
        self.pace = self.first = 0.0
        self.tied = False
        self._last, self._count = math.inf, 0
        self._scale = float(np.abs(problem.velocity_before).max())
        self._flat, self._free = delassus.ravel().tolist(), problem.velocity_free.tolist()
        self._blocks = [block_of(delassus, i) for i in range(n)]
        self._motions = [_motions_of(problem, i) for i in range(n)]
        self._columns = [np.ascontiguousarray(delassus[:, 3 * i : 3 * i + 3]) for i in range(n)]
        self._coefficients = (
            problem.restitution.tolist(),
            problem.friction.tolist(),
            problem.tangential_restitution.tolist(),
        )

    def next_contact(self) -> int:
        """Which is hit next; −1 where none approaches."""
        n = len(self._blocks)
        now, share = self.velocity.tolist(), self.impulse.tolist()
        e, mu, _ = self._coefficients
        found = fastest(self._flat, 3 * n, now, self._free, share, mu, self._scale, n)
        if found < 0:
            return -1
        found, tied = foremost(found, self._flat, now, e, mu, n)
        nn = self._flat[(3 * found + 2) * (3 * n + 1)]
        self.pace = pace_of(now[3 * found + 2], nn) if nn > 0.0 else 0.0
        if self._count < n:
            self.first = max(self.first, self.pace)
        self.tied = self.tied or (tied and self.pace > NOISE * self.first)
        # What does not shrink any more, that small, is the rounding that hits hand on.
        if self._count and self._count % LONG == 0:
            if HANDED_ON * self._last < self.pace <= NOISE * self.first:
                return -1
            self._last = self.pace
        return found

    def strike(self, i: int) -> Hit:
        """What the next hit of contact i would do."""
        e, mu, e_t = (values[i] for values in self._coefficients)
        velocity, motions = self.velocity[3 * i : 3 * i + 3], self._motions[i]
        if motions is not None:
            # What faster hits have left along motions that the bodies do not have is rounding.
            possible = motions @ velocity
            size = max(np.abs(self.velocity).max(), np.abs(self.problem.velocity_free).max())
            size = max(size, self._scale)
            if np.abs(possible - velocity).max() <= NOISE * size:
                velocity = possible
                self.velocity = self.velocity.copy()
                self.velocity[3 * i : 3 * i + 3] = possible
        now: Triple = tuple(velocity.tolist())
        return strike(self._blocks[i], now, now, e, mu, e_t, self._law)

    def take(self, i: int, hit: Hit) -> None:
        """Go on from behind it."""
        change = np.array(hit.impulse)
        self.velocity = self.velocity + self._columns[i] @ change
        self.impulse[3 * i : 3 * i + 3] += change
        self.hits.append((i, hit.impulse))
        self._count += 1

    def jump(self) -> Jump | None:
        """To the limit of all hits that would follow, if it can be told."""
        jump = find_limit(self.problem, self.velocity, self.hits)
        if jump is not None:
            self.velocity = self.velocity + jump.change
            self.impulse += jump.impulse
            self.hits.clear()
        return jump


def _motions_of(problem: ContactProblem, i: int) -> np.ndarray | None:
    """(3, 3) the projection on the relative velocities that contact i can have; None for all."""
    if not problem.friction[i]:
        return None
    values, axes = np.linalg.eigh(problem.delassus[3 * i : 3 * i + 3, 3 * i : 3 * i + 3])
    if values[0] > NO_MOTION * values[2]:
        return None
    kept = axes[:, values > NO_MOTION * values[2]]
    return kept @ kept.T


def solve_sequential(problem: ContactProblem, law: Law) -> ContactSolution:
    """Single hits, each with the velocities that the last one left, and the limit of such.

    Raises:
        InputError: tangential restitution under any but Newton's law with slip at the end.
    """
    n = len(problem.friction)
    free = problem.velocity_free
    normal, friction = np.zeros(n), np.zeros(n)
    status, residual = Status.SOLVED, 0.0
    unique: np.ndarray | None = None
    count, look_at = 0, LONG
    spent = 0.0
    sequence = _Sequence(problem, law)
    while (i := sequence.next_contact()) >= 0:
        pace, first = sequence.pace, sequence.first
        if count >= look_at:
            look_at = int(LATER * count)
            jump = sequence.jump()
            if jump is not None:
                works = 0.5 * jump.impulse * (2.0 * sequence.velocity - jump.change)
                normal += works[2::3]
                friction += works[0::3] + works[1::3]
                continue
        if count >= (MOST_HITS if pace > 1e-3 * first else MOST_SHRINKING_HITS) or (
            pace > FASTER * first
        ):
            status = Status.SEQUENCE_TOO_LONG
            break
        count += 1
        hit = sequence.strike(i)
        jams = not hit.status.valid and hit.status is not Status.ENERGY_GAIN
        if jams and 0.0 < pace <= LEFT * first:
            # What the hits before have left has no impulse to answer it.
            residual = max(residual, pace / first)
            break
        now = sequence.velocity[3 * i : 3 * i + 3]
        normal[i] += hit.normal_work
        friction[i] += hit.friction_work
        residual = max(residual, hit.residual)
        # Where nothing is lost, works are but the rounding of what went in and came back.
        spent += abs(hit.normal_work) + abs(hit.friction_work)
        spent += sum(abs(p * u) for p, u in zip(hit.impulse, now.tolist(), strict=True))
        sequence.take(i, hit)
        if hit.status is Status.NOT_UNIQUE:
            unique = np.ones(n, dtype=bool) if unique is None else unique
            unique[i] = False
        elif hit.status not in (Status.SOLVED, Status.ENERGY_GAIN) and status.valid:
            status = hit.status
        if jams:
            break
    # One hit may gain what the others lose: the sum is what counts.
    if status.valid and float(normal.sum() + friction.sum()) > GAIN * spent:
        status = Status.ENERGY_GAIN
    elif status is Status.SOLVED and unique is not None:
        status = Status.NOT_UNIQUE
    impulse = sequence.impulse
    after = problem.delassus @ impulse + free
    return ContactSolution(
        impulse, after, status, residual, unique, free, normal, friction, count, sequence.tied
    )


def hits_of(problem: ContactProblem, law: Law) -> Iterator[tuple[int, np.ndarray, Hit]]:
    """The hits in order: which contact, (3n,) all velocities at its start, what it did."""
    sequence = _Sequence(problem, law)
    while (i := sequence.next_contact()) >= 0:
        hit = sequence.strike(i)
        yield i, sequence.velocity, hit
        sequence.take(i, hit)
