"""All contacts of one instant at once, slip at the end: each group that W couples by itself.

What a single contact does has a closed form; several that act on each other are ``several``'s.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from .approach import block_at
from .borrowed import borrowed, borrowing
from .compiled import entry
from .confirmed import confirmed
from .groups import few_of, find_groups, line_of, members_of, square_of, worse
from .modes import DEPENDENT
from .several import Care, newton, poisson
from .single import hit_contact
from .status import BY_CODE, Status
from .tolerances import NEGLIGIBLE
from .words import NEWTON, NO
from .workspace import Workspace, workspace

__all__ = ["Struck", "hit_contacts"]

_SOLVED, _NOT_UNIQUE = int(Status.SOLVED), int(Status.NOT_UNIQUE)
_MANY = int(Status.MANY_SOLUTIONS)


class Struck(NamedTuple):
    """What several contacts did at once.

    Attributes:
        code: of its ``Status``; AGAIN where it is left to a slower way.
        residual: how far it is from the law, relative.
        impulse: (3n,) P [N s].
        after: (3n,) u⁺ [m/s].
        normal_work, friction_work: (n,) [J].
        unique: (n,) whether no other contact could carry what this one carries.
    """

    code: int
    residual: float
    impulse: np.ndarray
    after: np.ndarray
    normal_work: np.ndarray
    friction_work: np.ndarray
    unique: np.ndarray

    @property
    def status(self) -> Status:
        """How it is to be taken."""
        return BY_CODE[self.code]


# A named tuple made by compiled code would end the process where an interrupt meets it.
PlainStruck = tuple[int, float, np.ndarray, np.ndarray, np.ndarray, np.ndarray, np.ndarray]


def _examples() -> tuple[object, ...]:
    line, few = np.ones(6), np.ones(2)
    return np.eye(6), line, line, few, few, few, NEWTON


@entry(_examples, seconds=0.5)
def hit_contacts(
    W: np.ndarray,
    before: np.ndarray,
    free: np.ndarray,
    mu: np.ndarray,
    e: np.ndarray,
    e_t: np.ndarray,
    restitution: int,
) -> PlainStruck:
    """What all contacts do: the fields of a ``Struck``.

    Args:
        W: (3n, 3n) Delassus matrix [1/kg].
        before, free: (3n,) u⁻ and u_free [m/s].
        mu, e, e_t: (n,) friction, restitution, tangential restitution (0 but under Newton's).
        restitution: NEWTON or POISSON.
    """
    n = len(mu)
    work = workspace(n)
    group = np.zeros(n, np.int64)
    for i in range(n):
        work.mu[i] = mu[i] if mu[i] > NEGLIGIBLE else 0.0
    if n > 1 and find_groups(W, work.mu, n, group, work.owner) == 1:
        code, residual = _together(work, W, before, free, e, e_t, n, restitution)
    else:
        code, residual = _by_groups(work, W, before, free, e, e_t, group, restitution)
    return code, residual, work.P, work.velocity, work.normal, work.friction, work.unique


@borrowing
def _together(
    work: Workspace,
    W: np.ndarray,
    before: np.ndarray,
    free: np.ndarray,
    e: np.ndarray,
    e_t: np.ndarray,
    n: int,
    restitution: int,
) -> tuple[int, float]:
    """The code and the residual of contacts that act on each other."""
    care = Care(DEPENDENT, 0.0, NO)
    if restitution == NEWTON:
        return newton(work, W, before, free, e, e_t, n, care)
    return poisson(work, W, free, e, n, care)


def _groups_examples() -> tuple[object, ...]:
    line, few = np.ones(6), np.ones(2)
    return workspace(2), np.eye(6), line, line, few, few, np.zeros(2, np.int64), NEWTON


@entry(_groups_examples, seconds=0.5, apart=True)
def _by_groups(
    work: Workspace,
    W: np.ndarray,
    before: np.ndarray,
    free: np.ndarray,
    e: np.ndarray,
    e_t: np.ndarray,
    group: np.ndarray,
    restitution: int,
) -> tuple[int, float]:
    """The code and the residual of all groups, with what they do written into ``work``."""
    work, W, before, free = borrowed(work), borrowed(W), borrowed(before), borrowed(free)
    e, e_t, group = borrowed(e), borrowed(e_t), borrowed(group)
    n = len(group)
    chosen = np.empty(n, np.int64)
    worst, residual, number = _SOLVED, 0.0, 0
    count = members_of(group, n, number, chosen)
    while count > 0:
        if count == 1:
            code, left = _alone(work, W, before, free, e, e_t, chosen[0], restitution)
        else:
            own = workspace(count)
            own.mu[:] = few_of(work.mu, chosen, count)
            code, left = _together(
                own, square_of(W, chosen, count), line_of(before, chosen, count),
                line_of(free, chosen, count), few_of(e, chosen, count),
                few_of(e_t, chosen, count), count, restitution,
            )  # fmt: skip
            _put(work, own, chosen, count)
        worst, residual = worse(worst, code), max(residual, left)
        number += 1
        count = members_of(group, n, number, chosen)
    _slide(work, W, free, n)
    return worst, residual


@borrowing
def _alone(
    work: Workspace,
    W: np.ndarray,
    before: np.ndarray,
    free: np.ndarray,
    e: np.ndarray,
    e_t: np.ndarray,
    i: int,
    restitution: int,
) -> tuple[int, float]:
    """The code and the residual of a contact that acts on no other, in closed form."""
    t, s, n = 3 * i, 3 * i + 1, 3 * i + 2
    u, start = (before[t], before[s], before[n]), (free[t], free[s], free[n])
    impulse, after, code, residual, normal, friction = hit_contact(
        block_at(W, t), u, start, e[i], work.mu[i], e_t[i], restitution
    )
    if code == _MANY:
        code = confirmed(block_at(W, t), u, start, e[i], work.mu[i], e_t[i], restitution, impulse)
    work.P[t], work.P[s], work.P[n] = impulse
    work.velocity[t], work.velocity[s], work.velocity[n] = after
    work.normal[i], work.friction[i] = normal, friction
    work.unique[i] = code != _NOT_UNIQUE
    return code, residual


@borrowing
def _put(work: Workspace, own: Workspace, chosen: np.ndarray, count: int) -> None:
    """Write what one group did among all."""
    for k in range(count):
        i = chosen[k]
        for j in range(3):
            work.P[3 * i + j] = own.P[3 * k + j]
            work.velocity[3 * i + j] = own.velocity[3 * k + j]
        work.normal[i], work.friction[i] = own.normal[k], own.friction[k]
        work.unique[i] = own.unique[k]


@borrowing
def _slide(work: Workspace, W: np.ndarray, free: np.ndarray, n: int) -> None:
    """u⁺ along tangents without friction, which contacts of other groups may move."""
    for i in range(n):
        if work.mu[i] == 0.0:
            for r in (3 * i, 3 * i + 1):
                after = free[r]
                for c in range(3 * n):
                    after += W[r, c] * work.P[c]
                work.velocity[r] = after
