"""A sequence of hits in a system whose mass matrix is factored, in one compiled call."""

from __future__ import annotations

import numpy as np

from .compiled import entry
from .progress import path_memory
from .sequence import COUNT, ENDED, LONG, TIED, WORST, Contacts, advance_sequence, sequence_of
from .struck import PlainTogether, examples, is_sound, posed, write_jump
from .words import AGAIN, END

__all__ = ["strike_in_turn"]


def _examples() -> tuple[object, ...]:
    return *examples(), END


@entry(_examples, seconds=2.0)
def strike_in_turn(
    lower: np.ndarray,
    pivots: np.ndarray,
    rows: np.ndarray,
    v: np.ndarray,
    coefficients: np.ndarray,
    restitution: int,
    slip: int,
) -> PlainTogether:
    """One contact after the other, where hits end soon: the fields of a ``Together``.

    Args:
        lower, pivots, rows, v, coefficients: as in ``strike_at_once``.
        restitution, slip: words of the law.
    """
    n = coefficients.shape[1]
    W, before = posed(lower, pivots, rows, v)
    points, works, jump = np.empty((3, 3 * n)), np.empty((3, n)), np.empty(len(v))
    mu, e, e_t = coefficients[0], coefficients[1], coefficients[2]
    if not is_sound(W, before, rows, mu):
        return AGAIN, 0.0, 0.0, 0.0, 0, False, jump, points, works
    contacts = Contacts(W, before, e, mu, e_t, restitution, slip)
    sequence, who, hits = sequence_of(n), np.empty(LONG, np.int64), np.empty((LONG, 3))
    step, code = advance_sequence(sequence, contacts, before, LONG, who, hits, path_memory())
    if step != ENDED:
        return AGAIN, 0.0, 0.0, 0.0, 0, False, jump, points, works
    points[0], points[2] = sequence.impulse, before
    for k in range(3 * n):
        points[1, k] = before[k]
        for j in range(3 * n):
            points[1, k] += W[k, j] * points[0, j]
    works[0], works[1] = sequence.normal, sequence.friction
    for i in range(n):
        works[2, i] = sequence.unique[i]
    off, fastest = write_jump(lower, pivots, rows, points, jump)
    count, tied = int(sequence.now[COUNT]), bool(sequence.now[TIED] != 0.0)
    return code, sequence.now[WORST], off, fastest, count, tied, jump, points, works
