"""Which of the contacts at one instant act, where slip is followed along the path of one."""

from __future__ import annotations

from .borrowed import borrowing
from .single import newtons_shift
from .taylor import Array
from .tolerances import AT_REST_AMONG_OTHERS
from .words import NEWTON

__all__ = ["find_acting"]


@borrowing
def find_acting(
    before: Array, free: Array, restitution: Array, count: int, law: int, sure: float
) -> tuple[int, int, float]:
    """How many contacts approach, the last of these, and the size of all approaches [m/s].

    Args:
        before, free: (3n,) u⁻ and u_free [m/s].
        restitution: (n,) e.
        count: n.
        law: NEWTON, POISSON or STRONGE; under Newton's an approach is one against the target.
        sure: how many times smaller or larger than AT_REST_AMONG_OTHERS an approach must be to
            be told; otherwise the first number is -1.
    """
    scale = 0.0
    for k in range(count):
        scale = max(scale, abs(_approach(before, free, restitution, k, law)))
    acting, last = 0, 0
    for k in range(count):
        approach = _approach(before, free, restitution, k, law)
        if approach < -AT_REST_AMONG_OTHERS * scale * sure:
            acting += 1
            last = k
        elif approach < -AT_REST_AMONG_OTHERS * scale / sure:
            return -1, last, scale
    return acting, last, scale


@borrowing
def _approach(before: Array, free: Array, restitution: Array, k: int, law: int) -> float:
    approach = float(free[3 * k + 2])
    if law == NEWTON:
        approach += newtons_shift(restitution[k], before[3 * k + 2])
    return approach
