"""Contacts that have nothing to do with each other: groups that W does not couple.

Each group is solved by itself, so that a contact does what it would do if the others were not
there: two robots in one scene, or bodies that lie apart.
"""

from __future__ import annotations

import math

import numpy as np

from .borrowed import borrowing
from .compiled import compiled, entry
from .status import Status
from .tolerances import NEGLIGIBLE

__all__ = ["few_of", "find_groups", "line_of", "members_of", "square_of", "worse"]

# Entries of W up to this share of both rows' own are rounding: some ten products of two doubles.
UNCOUPLED = 2e-15

# Statuses from the best to the worst, by their codes: what is said of all is that of the worst.
_FROM_THE_BEST = (
    Status.SOLVED, Status.NOT_UNIQUE, Status.NEARLY_DEPENDENT, Status.PAINLEVE_JAM,
    Status.MANY_SOLUTIONS, Status.ENERGY_GAIN, Status.INACCURATE, Status.SEQUENCE_TOO_LONG,
    Status.NOT_CONVERGED, Status.NO_SOLUTION,
)  # fmt: skip
# What is not among these is refused or no input at all, and worse.
BADNESS = tuple(
    _FROM_THE_BEST.index(status) if status in _FROM_THE_BEST else len(_FROM_THE_BEST)
    for status in sorted(Status)
)


def _examples() -> tuple[object, ...]:
    return np.eye(6), np.ones(2), 2, np.zeros(2, np.int64), np.zeros(2, np.int64)


@entry(_examples, seconds=0.2, apart=True)
def find_groups(W: np.ndarray, mu: np.ndarray, n: int, group: np.ndarray, queue: np.ndarray) -> int:
    """How many groups there are; each contact's is written, numbered by their first contacts.

    Args:
        W: (3n, 3n) and more, Delassus matrix [1/kg].
        mu: (n,) friction: where there is none the tangents couple nothing.
        n: how many contacts.
        group: (n,) is written.
        queue: (n,) room.
    """
    for i in range(n):
        group[i] = -1
    groups, found = 0, 0
    for first in range(n):
        if group[first] >= 0:
            continue
        group[first], queue[0] = groups, first
        head, tail = 0, 1
        while head < tail and found + tail < n:
            i = queue[head]
            for j in range(first + 1, n):
                if group[j] < 0 and _is_coupled(W, mu, i, j):
                    group[j], queue[tail] = groups, j
                    tail += 1
            head += 1
        groups, found = groups + 1, found + tail
    return groups


@borrowing
def _is_coupled(W: np.ndarray, mu: np.ndarray, i: int, j: int) -> bool:
    """Whether an impulse at one of two contacts moves the other, in rows that its law looks at."""
    for r in range(3 * i if mu[i] > NEGLIGIBLE else 3 * i + 2, 3 * i + 3):
        own = UNCOUPLED * math.sqrt(max(W[r, r], 0.0))
        for c in range(3 * j if mu[j] > NEGLIGIBLE else 3 * j + 2, 3 * j + 3):
            if abs(W[r, c]) > own * math.sqrt(max(W[c, c], 0.0)):
                return True
    return False


@borrowing
def members_of(group: np.ndarray, n: int, number: int, chosen: np.ndarray) -> int:
    """How many of n contacts are in a group; they are written in order."""
    count = 0
    for i in range(n):
        if group[i] == number:
            chosen[count] = i
            count += 1
    return count


@compiled
def square_of(matrix: np.ndarray, chosen: np.ndarray, count: int) -> np.ndarray:
    """(3k, 3k) the rows and columns of the first k chosen contacts."""
    part = np.empty((3 * count, 3 * count))
    for r in range(3 * count):
        row = 3 * chosen[r // 3] + r % 3
        for c in range(3 * count):
            part[r, c] = matrix[row, 3 * chosen[c // 3] + c % 3]
    return part


@compiled
def line_of(values: np.ndarray, chosen: np.ndarray, count: int) -> np.ndarray:
    """(3k,) the rows of the first k chosen contacts."""
    part = np.empty(3 * count)
    for r in range(3 * count):
        part[r] = values[3 * chosen[r // 3] + r % 3]
    return part


@compiled
def few_of(values: np.ndarray, chosen: np.ndarray, count: int) -> np.ndarray:
    """(k,) the numbers of the first k chosen contacts."""
    part = np.empty(count)
    for k in range(count):
        part[k] = values[chosen[k]]
    return part


@borrowing
def worse(one: int, other: int) -> int:
    """The code of the worse of two statuses."""
    return other if BADNESS[other] > BADNESS[one] else one
