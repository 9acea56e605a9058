"""Whether one contact has several answers indeed, where its closed form has more than one."""

from __future__ import annotations

import numpy as np

from .borrowed import borrowing
from .compiled import entry
from .coulomb import is_jammed, raising, sticking_impulse
from .others import MOST_ANSWERS, find_answers
from .progress import Block, Triple
from .single import gained, largest, moved, newtons_shift, times
from .status import Status
from .tolerances import AT_REST
from .uniqueness import NEAR
from .words import NEWTON

__all__ = ["confirmed", "find_beside"]

_SOLVED, _JAM = int(Status.SOLVED), int(Status.PAINLEVE_JAM)
_MANY, _NOT_UNIQUE = int(Status.MANY_SOLUTIONS), int(Status.NOT_UNIQUE)
_GAIN = int(Status.ENERGY_GAIN)


def _examples() -> tuple[object, ...]:
    return (1.0,) * 6, (1.0,) * 3, (1.0,) * 3, 0.5, 0.5, 0.0, NEWTON, (1.0,) * 3


@entry(_examples, seconds=0.5, apart=True)
def find_beside(
    block: Block,
    before: Triple,
    free: Triple,
    e: float,
    mu: float,
    e_t: float,
    restitution: int,
    impulse: Triple,
) -> tuple[int, int, int, bool]:
    """``others.find_answers`` of one contact, beside the answer of ``single.hit_contact``.

    Args:
        block, before, free, e, mu, e_t, restitution: its arguments.
        impulse: its answer, P [N s].
    """
    up = raising(largest(before, free))
    t11, t12, t22, n1, n2, nn = block
    W = np.array([[t11, t12, n1], [t12, t22, n2], [n1, n2, nn]])
    first, start, P = up * np.array(before), up * np.array(free), up * np.array(impulse)
    u1, u2, un = moved(block, times(up, free), times(up, impulse), mu)
    scale = max(up * largest(before, free), abs(u1), abs(u2), abs(un))
    room, coefficients = np.empty((2, MOST_ANSWERS, 3)), np.array([[mu], [e], [e_t]])
    return find_answers(W, first, start, coefficients, restitution, P, scale, room, NEAR)


@entry(_examples, seconds=1.0, apart=True)
def confirmed(
    block: Block,
    before: Triple,
    free: Triple,
    e: float,
    mu: float,
    e_t: float,
    restitution: int,
    impulse: Triple,
) -> int:
    """The code of an answer that ``single.hit_contact`` has as MANY_SOLUTIONS.

    What it found beside the answer may gain energy, or come to the same v⁺ in the expansion.
    Arguments as ``find_beside``'s.
    """
    if impulse[2] == 0.0:
        # It lies still, and slip could load it by as much as one likes.
        return _MANY
    _, _, others, split = find_beside(block, before, free, e, mu, e_t, restitution, impulse)
    if others > 0 and not split:
        return _MANY
    up = raising(largest(before, free))
    u, aim, P = times(up, before), times(up, free), times(up, impulse)
    start, after = u if restitution == NEWTON else aim, moved(block, aim, P, mu)
    work = 0.0
    for k in range(3):
        work += 0.5 * P[k] * (start[k] + after[k])
    code = _code_of(block, u, aim, e, mu, e_t, restitution, largest(u, aim))
    return _GAIN if gained(code, work, 0.0, P, start, aim) else code


@borrowing
def _code_of(
    block: Block,
    before: Triple,
    free: Triple,
    e: float,
    mu: float,
    e_t: float,
    restitution: int,
    scale: float,
) -> int:
    """The code of the answer by itself: whether it has many shares, or jams."""
    b1, b2, bn = free
    if restitution == NEWTON:
        b1, b2 = b1 + e_t * before[0], b2 + e_t * before[1]
        bn += newtons_shift(e, before[2])
    if bn >= -AT_REST * scale:
        return _SOLVED
    _, sticks, determined = sticking_impulse(block, b1, b2, bn, mu, scale)
    if sticks and not determined:
        return _NOT_UNIQUE
    return _JAM if is_jammed(block, b1, b2, mu, scale) else _SOLVED
