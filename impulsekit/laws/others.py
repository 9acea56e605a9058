"""The answers of the law of contact, and which of them have other velocities than one shown."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .borrowed import borrowing
from .compiled import compiled, entry
from .coupling import friction_is_weak
from .even_shares import can_shift, share_evenly
from .found import SAME
from .frictional import frictional
from .least_shares import least_holding, share_least
from .modes import DEPENDENT, NULL, largest_term, residual_of, sizes_of
from .neighbours import find_neighbours
from .redundant import is_redundant
from .single import newtons_shift
from .status import Status
from .tolerances import LEAST_RELEASE, NEGLIGIBLE
from .uniqueness import MOST_FOUND, NEAR, NOTHING_TRIED, TRIED_ALL, is_another, search_modes
from .words import NEWTON, YES
from .workspace import Workspace, workspace

__all__ = [
    "ALL_TRIED", "MOST_ANSWERS", "SEARCHED", "SMOOTH", "TOO_MANY", "WEAK", "find_answers",
]  # fmt: skip

# What is known of the answers: nothing rubs, friction is too weak to leave a choice, and all modes
# were tried prove how many there are; the others do not.
SMOOTH, WEAK, ALL_TRIED, SEARCHED, TOO_MANY = 0, 1, 2, 3, 4
# How many answers are kept: of every compression that can be found four with velocities of
# their own. Where they are full, nothing is proven.
MOST_ANSWERS = 256
# What an answer that is told of may leave of the law, relative to the velocities.
LAWFUL = 1e-10
# Terms of W P may be so many times the velocities: beyond, the errors of a good model, 1e-4, make
# all that an answer says. Friction may hold still what hardly moves by loads as large as one likes;
# which of them are found is a matter of rounding.
MOST_TERMS = 1e4
_VALID = (int(Status.SOLVED), int(Status.NOT_UNIQUE))


class Posed(NamedTuple):
    """The problem whose answers are searched.

    Attributes:
        W: (3n, 3n) Delassus matrix; own: what friction makes of it, smooth tangents cleared [1/kg].
        start, free: (3n,) velocities from which energy counts, and u_free [m/s].
        b: (3n,) of what is solved, ξ = W P + b [m/s].
        mu, e: (n,) friction and restitution.
    """

    W: np.ndarray
    start: np.ndarray
    free: np.ndarray
    own: np.ndarray
    b: np.ndarray
    mu: np.ndarray
    e: np.ndarray


def _examples() -> tuple[object, ...]:
    line = np.ones(6)
    return np.eye(6), line, line, np.ones((3, 2)), NEWTON, line, 1.0, np.ones((2, 2, 6)), NEAR


@entry(_examples, seconds=1.0, apart=True)
def find_answers(
    W: np.ndarray,
    before: np.ndarray,
    free: np.ndarray,
    coefficients: np.ndarray,
    restitution: int,
    shown: np.ndarray,
    scale: float,
    answers: np.ndarray,
    reach: int,
) -> tuple[int, int, int, bool]:
    """What is known, how many answers there are, how many of them are others, and if split.

    The others, with velocities that neither ``shown`` nor another has and no gain of energy, are
    the first in ``answers``. They are split where only shares of load differ: of
    compressions with one velocity at their end, or between contacts that slip, evened to one v⁺.
    Without others it says that such shares can be shifted.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        before, free: (3n,) u⁻ and u_free [m/s].
        coefficients: (3, n) friction, restitution, tangential restitution.
        restitution: NEWTON or POISSON.
        shown: (3n,) P of the answer that is shown [N s].
        scale: the size of the velocities [m/s].
        answers: (2, MOST_ANSWERS, 3n), written: P [N s], and under Poisson's law P of their
            compressions.
        reach: NEAR or FAR, of how many contacts modes are searched (``search_modes``).
    """
    mu, e, e_t = coefficients[0], coefficients[1], coefficients[2]
    n = len(mu)
    own, b, own_mu = np.zeros((3 * n, 3 * n)), np.zeros(3 * n), np.zeros(n)
    rubs, releases = False, False
    for i in range(n):
        own_mu[i] = mu[i] if mu[i] > NEGLIGIBLE else 0.0
        rubs = rubs or own_mu[i] > 0.0
        releases = releases or (restitution != NEWTON and e[i] > 0.0)
    if not rubs:
        return SMOOTH, 0, 0, False
    for r in range(3 * n):
        if r % 3 < 2 and own_mu[r // 3] == 0.0:
            continue
        b[r] = free[r]
        if restitution == NEWTON:
            if r % 3 < 2:
                b[r] += e_t[r // 3] * before[r]
            else:
                b[r] += newtons_shift(e[r // 3], before[r])
        for c in range(3 * n):
            if c % 3 == 2 or own_mu[c // 3] > 0.0:
                own[r, c] = W[r, c]
    if friction_is_weak(own, own_mu):
        return WEAK, 0, 0, False
    start = before if restitution == NEWTON else free
    posed = Posed(W, start, free, own, b, own_mu, e)
    return _search_answers(posed, releases, shown, scale, answers, reach)


def _search_examples() -> tuple[object, ...]:
    line, few = np.ones(6), np.ones(2)
    posed = Posed(np.eye(6), line, line, np.eye(6), line, few, few)
    return posed, False, line, 1.0, np.ones((2, 2, 6)), NEAR


@entry(_search_examples, seconds=4.0, apart=True)
def _search_answers(
    posed: Posed, releases: bool, shown: np.ndarray, scale: float, answers: np.ndarray, reach: int
) -> tuple[int, int, int, bool]:
    """``find_answers`` where friction is strong enough to leave a choice.

    Args:
        releases: whether Poisson's law gives load back.
        shown, scale, answers, reach: as in ``find_answers``.
    """
    free, b, own_mu, e = posed.free, posed.b, posed.mu, posed.e
    found, pressed, n = answers[0], answers[1], len(own_mu)
    outside = np.empty((MOST_FOUND, 3 * n))
    tried, count, beyond = search_modes(
        posed.own, b, own_mu, np.zeros(n), scale, reach, found[:MOST_FOUND], outside
    )
    how = ALL_TRIED if tried == TRIED_ALL else SEARCHED
    if n == 1 and not releases:
        # Which share of its load holds it still matters to what is given back alone.
        how = ALL_TRIED
    work = workspace(n)
    for r in range(3 * n):
        work.b[r] = b[r]
        for c in range(3 * n):
            work.W[r, c] = posed.own[r, c]
    for i in range(n):
        work.mu[i] = own_mu[i]
    if tried == NOTHING_TRIED:
        how = TOO_MANY
        count = find_neighbours(work, b, n, shown, e, releases, found[:MOST_FOUND])
        if count == 0:
            return TOO_MANY, 0, 0, not releases and _is_one_of_many(work, n, shown)
    if how == SEARCHED:
        count = _add_held(work, n, shown, outside[:beyond], found, count)
    full = count == MOST_FOUND
    if releases:
        count = _expansions(work, free, e, n, scale, how, count, found, pressed)
        if count == 0 and how == SEARCHED:
            how = TOO_MANY
    if how == ALL_TRIED and (full or count == len(found)):
        how = TOO_MANY
    split = releases and _is_split(posed.W, count, found, pressed, scale)
    others = _others_first(posed.W, shown, posed.start, free, scale, found, pressed, count)
    if not releases:
        return how, count, others, _are_evened(work, n, shown, found[:others], scale)
    return how, count, others, split and others > 0


@compiled
def _are_evened(
    work: Workspace, n: int, shown: np.ndarray, others: np.ndarray, scale: float
) -> bool:
    """Whether all other answers, their load shared evenly, are the one shown."""
    if not _is_one_of_many(work, n, shown):
        return False
    sizes = sizes_of(work, n, 0.0)
    for one in range(len(others)):
        for k in range(3 * n):
            work.P[k] = others[one, k]
        share_evenly(work, n, sizes, DEPENDENT, residual_of(work, n, sizes))
        if _speed_between(work.W, work.P, shown) > SAME * scale:
            return False
    return True


@compiled
def _is_one_of_many(work: Workspace, n: int, shown: np.ndarray) -> bool:
    """Whether the answer shown is one of those between which load can be shifted."""
    for k in range(3 * n):
        work.P[k] = shown[k]
    return can_shift(work, n, sizes_of(work, n, 0.0), DEPENDENT)


def _held_examples() -> tuple[object, ...]:
    return workspace(1), 1, np.ones(3), np.ones((2, 3)), np.ones((2, 3)), 1


@entry(_held_examples, seconds=2.0, apart=True)
def _add_held(
    work: Workspace, n: int, shown: np.ndarray, outside: np.ndarray, found: np.ndarray, count: int
) -> int:
    """Add P that hold some redundant contacts still, the others being as in a known answer.

    The modes take one share of a redundant load; the cones may ask for another. What lies
    ``outside`` of them is an answer where another share lies inside.
    """
    size = 3 * n
    few = workspace(n)
    rows = np.empty(size, np.int64)
    sizes = sizes_of(work, n, 0.0)
    known = count
    for chosen in range(1, 2**n):
        m = int(np.int64(0))
        for i in range(n):
            if (chosen >> i) & 1:
                few.mu[m] = work.mu[i]
                for k in range(3):
                    rows[3 * m + k] = 3 * i + k
                m += 1
        for r in range(3 * m):
            for c in range(3 * m):
                few.W[r, c] = work.W[rows[r], rows[c]]
        if not is_redundant(few.W, 3 * m, DEPENDENT, NULL):
            continue
        for one in range(-2 - len(outside), known):
            if count == len(found):
                return count
            for k in range(size):
                if one < -2:
                    work.P[k] = outside[-3 - one, k]
                else:
                    work.P[k] = 0.0 if one == -2 else (shown[k] if one == -1 else found[one, k])
            for r in range(3 * m):
                work.P[rows[r]] = 0.0
            for r in range(3 * m):
                few.b[r] = work.b[rows[r]]
                for c in range(size):
                    few.b[r] += work.W[rows[r], c] * work.P[c]
            least_holding(few, m, sizes_of(few, m, 0.0))
            most = 0.0
            for r in range(3 * m):
                work.P[rows[r]] = few.P[r]
                most = max(most, abs(few.P[r]))
            if most > 0.0 and residual_of(work, n, sizes) <= LAWFUL:
                for k in range(size):
                    found[count, k] = work.P[k]
                count += 1
    return count


def _expansion_examples() -> tuple[object, ...]:
    found = np.ones((2, 3))
    return workspace(1), np.ones(3), np.ones(1), 1, 1.0, ALL_TRIED, 1, found, found


@entry(_expansion_examples, seconds=2.0, apart=True)
def _expansions(
    work: Workspace,
    free: np.ndarray,
    e: np.ndarray,
    n: int,
    scale: float,
    how: int,
    count: int,
    found: np.ndarray,
    pressed: np.ndarray,
) -> int:
    """Write P of whole impacts to ``found`` for the compressions that stand there; how many."""
    size = 3 * n
    firsts = found[:count].copy()
    backs = np.empty((MOST_FOUND, size))
    total = int(np.int64(0))
    for one in range(count):
        first = firsts[one]
        if how == ALL_TRIED or n == 1:
            b, floor = _after_compression(work, e, n, first)
            _, many, _ = search_modes(work.W, b, work.mu, floor, scale, NEAR, backs, backs[:0])
        else:
            # Of each compression, shared as the law shares it, the expansion from it.
            many = 1 if _expanded(work, free, e, n, first, backs) else 0
        begin = total
        for back in range(many):
            if total == len(found):
                return total
            for k in range(size):
                pressed[total, k] = first[k]
                found[total, k] = first[k] + backs[back, k]
            # Of shares of one load one is enough: they have one velocity, and gain the same.
            new = largest_term(work.W, found[total], size) <= MOST_TERMS * scale
            for known in range(begin, total):
                new = new and _speed_between(work.W, found[total], found[known]) > SAME * scale
            total += 1 if new else 0
    return total


@compiled
def _after_compression(
    work: Workspace, e: np.ndarray, n: int, first: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """u after a compression, and the least normal impulses of the expansion."""
    floor, b = np.zeros(n), np.empty(3 * n)
    for i in range(n):
        floor[i] = e[i] * first[3 * i + 2]
        if floor[i] < LEAST_RELEASE:
            floor[i] = 0.0
    for k in range(3 * n):
        b[k] = work.b[k]
        for j in range(3 * n):
            b[k] += work.W[k, j] * first[j]
    return b, floor


@compiled
def _expanded(
    work: Workspace, free: np.ndarray, e: np.ndarray, n: int, first: np.ndarray, backs: np.ndarray
) -> bool:
    """Bring a compression to the law's share of its load, and write its expansion if found."""
    part = workspace(n)
    fastest = 0.0
    for r in range(3 * n):
        fastest = max(fastest, abs(free[r]))
        part.b[r], part.P[r] = work.b[r], first[r]
        for c in range(3 * n):
            part.W[r, c] = work.W[r, c]
    for i in range(n):
        part.mu[i] = work.mu[i]
    code, residual = frictional(part, n, 0.0, YES, 0.0, DEPENDENT)
    if code not in _VALID:
        return False
    share_least(part, n, 0.0, DEPENDENT, residual)
    for k in range(3 * n):
        first[k] = part.P[k]
    b, floor = _after_compression(work, e, n, first)
    for i in range(n):
        part.floor[i] = floor[i]
        for k in range(3 * i, 3 * i + 3):
            part.b[k] = b[k]
            part.P[k] = e[i] * first[k]
    code, residual = frictional(part, n, fastest, YES, 0.0, DEPENDENT)
    share_least(part, n, fastest, DEPENDENT, residual)
    for k in range(3 * n):
        backs[0, k] = part.P[k]
    return code in _VALID


@compiled
def _others_first(
    W: np.ndarray,
    shown: np.ndarray,
    start: np.ndarray,
    free: np.ndarray,
    scale: float,
    found: np.ndarray,
    pressed: np.ndarray,
    count: int,
) -> int:
    """Bring the answers with velocities of their own and no gain of energy to the front."""
    others = int(np.int64(0))
    for one in range(count):
        P = found[one].copy()
        new = is_another(W, P, shown, start, free, scale)
        for k in range(others):
            new = new and is_another(W, P, found[k], start, free, scale)
        if new:
            for k in range(len(P)):
                found[one, k] = found[others, k]
                found[others, k] = P[k]
                pressed[one, k], pressed[others, k] = pressed[others, k], pressed[one, k]
            others += 1
    return others


@borrowing
def _is_split(
    W: np.ndarray, count: int, found: np.ndarray, pressed: np.ndarray, scale: float
) -> bool:
    """Whether the answers have one velocity at the end of compression, and one v⁺ each."""
    for i in range(1, count):
        if _speed_between(W, pressed[i], pressed[0]) > SAME * scale:
            return False
    for i in range(count):
        for j in range(i):
            apart = 0.0
            for k in range(W.shape[0]):
                apart = max(apart, abs(W[k, k] * (pressed[i, k] - pressed[j, k])))
            if apart <= SAME * scale and _speed_between(W, found[i], found[j]) > SAME * scale:
                return False
    return count > 0


@borrowing
def _speed_between(W: np.ndarray, P: np.ndarray, other: np.ndarray) -> float:
    """The largest velocity that a difference of impulses makes."""
    most = 0.0
    for r in range(len(P)):
        change = 0.0
        for c in range(len(P)):
            change += W[r, c] * (P[c] - other[c])
        most = max(most, abs(change))
    return most
