"""Whether other velocities obey the law of contact, as ``solve`` finds out."""

from __future__ import annotations

import numpy as np

from ...laws.compiled import entry
from ...laws.confirmed import confirmed, find_beside
from ...laws.others import ALL_TRIED, MOST_ANSWERS, SMOOTH, WEAK, find_answers
from ...laws.progress import Block, Triple
from ...laws.status import Status
from ...laws.uniqueness import NEAR
from ...laws.words import NEWTON
from ..codes import OPEN, SHARED
from .jit import built_in, uncounted

__all__ = ["find_others", "gives_back_shares", "judge_lone", "judge_others"]

_MANY, _NOT_UNIQUE = int(Status.MANY_SOLUTIONS), int(Status.NOT_UNIQUE)


@built_in
def find_others(W, before, free, after, mus, es, ets, count, P, restitution):
    """``laws.others.find_answers`` beside an answer.

    Args:
        W: (3n, 3n) and more; of the contacts that touch the first.
        before, free, after: (3n,) u⁻, u_free, u⁺ [m/s].
        mus, es, ets: (n,) friction and restitutions.
        count: n.
        P: (3n,) of the answer [N s].
        restitution: NEWTON or POISSON.
    """
    size = 3 * count
    scale = 0.0
    for r in range(size):
        scale = max(scale, abs(before[r]), abs(free[r]), abs(after[r]))
    if not scale > 0.0:
        # Nothing moves.
        return SMOOTH, 0, 0, False
    coefficients, room = np.empty((3, count)), np.empty((2, MOST_ANSWERS, size))
    for i in range(count):
        coefficients[0, i], coefficients[1, i], coefficients[2, i] = mus[i], es[i], ets[i]
    return find_answers(
        W[:size, :size].copy(), before[:size].copy(), free[:size].copy(), coefficients, restitution,
        P[:size].copy(), scale, room, NEAR,
    )  # fmt: skip


@uncounted
def judge_others(code, how, known, others, split, gives):
    """The code of an answer: MANY_SOLUTIONS, or what is open of it added.

    Args:
        code: of an answer that is valid.
        how, known, others, split: what ``find_answers`` tells.
        gives: whether v⁺ may depend on how redundant contacts share their load.
    """
    if split and (others > 0 or code == _NOT_UNIQUE):
        return code + SHARED
    if others > 0:
        return _MANY
    if how in (SMOOTH, WEAK):
        return code + OPEN if code == _NOT_UNIQUE and gives else code
    return code if how == ALL_TRIED and known > 0 else code + OPEN


@uncounted
def gives_back_shares(mus, es, unique, count):
    """Whether Poisson's v⁺ may depend on how redundant contacts share their load."""
    least, most, rubs = 1.0, 0.0, False
    for i in range(count):
        if not unique[i]:
            least, most, rubs = min(least, es[i]), max(most, es[i]), rubs or mus[i] > 0.0
    return most > 0.0 and (rubs or most > least)


def _examples() -> tuple[object, ...]:
    return (1.0,) * 6, (1.0,) * 3, (1.0,) * 3, 0.5, 0.5, 0.0, NEWTON, (1.0,) * 3, 0


@entry(_examples, seconds=1.0, apart=True)
def judge_lone(
    block: Block,
    before: Triple,
    free: Triple,
    e: float,
    mu: float,
    e_t: float,
    restitution: int,
    impulse: Triple,
    code: int,
) -> int:
    """The same for one contact, whose closed form tells most: ``single.hit_contact``.

    Args:
        block, before, free, e, mu, e_t, restitution: its arguments.
        impulse, code: its answer, P [N s].
    """
    if code == _MANY:
        code = confirmed(block, before, free, e, mu, e_t, restitution, impulse)
    if code != _NOT_UNIQUE or mu == 0.0:
        return code
    how, known, others, split = find_beside(block, before, free, e, mu, e_t, restitution, impulse)
    return judge_others(code, how, known, others, split, restitution != NEWTON and e > 0.0)
