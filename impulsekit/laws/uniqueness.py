"""Whether other velocities obey the law of contact as well: all modes are tried."""

from __future__ import annotations

from typing import Any

import numpy as np

from .answers_of_one import answers_of_one
from .compiled import compiled, entry
from .found import SAME
from .plane_modes import plane_modes, plane_of
from .space_modes import space_modes
from .tolerances import GAIN

__all__ = [
    "AT_LAST", "FAR", "MOST_FOUND", "MOST_IN_PLANE", "MOST_IN_SPACE", "NEAR",
    "NOTHING_TRIED", "PLANE", "TRIED_ALL", "TRIED_SOME", "is_another", "is_searched",
    "search_modes",
]  # fmt: skip

# Contacts of which all modes are tried: 4⁴ linear systems in the plane (6⁴ at release), and in
# space, where one of so many has friction (0, 1, ...), as many as take less than 10 ms.
MOST_IN_PLANE, MOST_IN_SPACE = 4, (0, 6, 5, 4)
# The same where an answer gains energy, and where no other way led to one: less than 60 ms.
MOST_FARTHER, MOST_AT_LAST = (0, 8, 7, 6), (0, 8, 7, 6, 4)
# How far ``search_modes`` goes: to the first; in the plane alone; to the others. Integers of
# numpy: for literals numba would compile all that takes them once more.
NEAR: int = np.int64(0)  # type: ignore[assignment]
PLANE: int = np.int64(1)  # type: ignore[assignment]
FAR: int = np.int64(2)  # type: ignore[assignment]
AT_LAST: int = np.int64(3)  # type: ignore[assignment]
# How many solutions are kept at most: of four contacts in a plane that move along one motion
# about 50 shares of one load have been found.
MOST_FOUND = 64

# What ``search_modes`` did.
NOTHING_TRIED, TRIED_SOME, TRIED_ALL = 0, 1, 2


def _examples() -> tuple[Any, ...]:
    line, few = np.ones(6), np.ones(2)
    return np.eye(6), line, few, few, 1.0, NEAR, np.eye(6), np.eye(6)


def _plane_examples() -> tuple[Any, ...]:
    line, few = np.ones(6), np.ones(2)
    return np.eye(6), line, few, few, 1.0, np.ones((2, 2)), np.eye(6)


@entry(_plane_examples, seconds=2.0, apart=True)
def _search_plane(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    floor: np.ndarray,
    scale: float,
    direction: np.ndarray,
    found: np.ndarray,
) -> int:
    """``search_modes`` of contacts whose tangents (n, 2) all move in one plane."""
    n = len(mu)
    basis = np.zeros((2 * n, 3 * n))
    for i in range(n):
        basis[2 * i, 3 * i], basis[2 * i, 3 * i + 1] = direction[i, 0], direction[i, 1]
        basis[2 * i + 1, 3 * i + 2] = 1.0
    flat = np.empty((len(found), 2 * n))
    own = np.dot(np.dot(basis, W), basis.T.copy())
    count = plane_modes(own, np.dot(basis, b), mu, floor, scale, flat)
    for k in range(count):
        found[k] = np.dot(flat[k], basis)
    return count


@entry(_examples, seconds=0.5, apart=True)
def search_modes(
    W: np.ndarray,
    b: np.ndarray,
    mu: np.ndarray,
    floor: np.ndarray,
    scale: float,
    reach: int,
    found: np.ndarray,
    outside: np.ndarray,
) -> tuple[int, int, int]:
    """What was tried, how many solutions of one phase were found, and how many are outside.

    Those outside leave a cone of a contact that sticks, and obey the rest (``space_modes``).

    Args:
        W: (3n, 3n), tangents without friction cleared [1/kg].
        b: (3n,) likewise [m/s].
        mu, floor: (n,) friction, and the least normal impulses [N s].
        scale: the size of the velocities [m/s].
        reach: NEAR, PLANE (only where all modes can be tried), FAR or AT_LAST; of one contact
            all are known.
        found: (most, 3n), written: P of the solutions [N s].
        outside: (any number, 3n), written: P of those outside [N s].
    """
    n = len(mu)
    direction = np.empty((n, 2))
    if n <= MOST_IN_PLANE and plane_of(W, b, mu, scale, direction):
        return TRIED_ALL, _search_plane(W, b, mu, floor, scale, direction, found), 0
    if n == 1 and mu[0] > 0.0:
        count, all_of_them = answers_of_one(W, b, mu[0], floor[0], scale, found)
        return (TRIED_ALL if all_of_them else TRIED_SOME), count, 0
    if reach == PLANE or not is_searched(mu, reach) or floor.max() > 0.0:
        return NOTHING_TRIED, 0, 0
    count, beyond = space_modes(W, b, mu, scale, found, outside)
    return TRIED_SOME, count, beyond


@compiled
def is_searched(mu: np.ndarray, reach: int) -> bool:
    """Whether modes of contacts with these coefficients (n,) of friction are tried in space."""
    rubbing = int(np.int64(0))
    for i in range(len(mu)):
        rubbing += 1 if mu[i] > 0.0 else 0
    if reach == AT_LAST:
        return rubbing < len(MOST_AT_LAST) and len(mu) <= MOST_AT_LAST[rubbing]
    if reach == FAR:
        return rubbing < len(MOST_FARTHER) and len(mu) <= MOST_FARTHER[rubbing]
    return rubbing < len(MOST_IN_SPACE) and len(mu) <= MOST_IN_SPACE[rubbing]


@compiled
def is_another(W, P, shown, start, free, scale):  # type: ignore[no-untyped-def]
    """Whether P makes other velocities than ``shown``, and adds no energy.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        P, shown: (3n,) impulses [N s].
        start: (3n,) the velocity from which works count [m/s].
        free: (3n,) u_free [m/s].
        scale: the size of the velocities [m/s].
    """
    apart, work, size, by_blows = 0.0, 0.0, 0.0, 0.0
    for r in range(len(P)):
        after, change = free[r], 0.0
        for c in range(len(P)):
            after += W[r, c] * P[c]
            change += W[r, c] * (P[c] - shown[c])
        apart = max(apart, abs(change))
        own = 0.5 * P[r] * (start[r] + after)
        work += own
        by_blows += 0.5 * P[r] * (free[r] - start[r])
        size += abs(own) + abs(P[r] * start[r]) + abs(P[r] * free[r])
    return apart > SAME * scale and min(work, work + by_blows) <= GAIN * size
