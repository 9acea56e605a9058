"""The law of a state with one contact on a plane and nothing else."""

from __future__ import annotations

from ...laws.single import strike_at_end
from ...laws.status import Status
from ...laws.tolerances import AT_REST, GAIN
from ...laws.words import NEWTON
from ..codes import AGAIN
from .jit import built_in
from .left import is_faint, is_left
from .uniqueness import judge_lone

__all__ = ["solve_alone"]

_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)
_NONE = int(Status.NO_SOLUTION)
_NOT_UNIQUE, _MANY = int(Status.NOT_UNIQUE), int(Status.MANY_SOLUTIONS)


@built_in
def solve_alone(rows, contact, places, work, w, lane, digits):
    """The law for a lone contact on a plane: no arrays on the way.

    Args:
        rows: 3, or 1 without friction.
        contact: its numbers.
    """
    w_at, before_at, free_at = places.delassus, places.before, places.free
    capture, e_t, e, mu, faintest = contact
    n = (places.p + rows - 1) * w + lane
    # Widened, that the law itself is exact where the rest is in single precision.
    before = float(work[(before_at + rows - 1) * w + lane])
    free = float(work[(free_at + rows - 1) * w + lane])
    nn = float(work[(w_at + rows * rows - 1) * w + lane])
    b = free
    if before < 0.0 and -before >= capture:
        b += e * before
    work[n] = 0.0
    if rows == 3:
        work[n - w] = 0.0
        work[n - 2 * w] = 0.0
    if rows == 1 or mu == 0.0:
        if is_faint(nn, 0.0, faintest, digits):
            return AGAIN
        if b >= -AT_REST * max(abs(before), abs(free)):
            return _SOLVED
        if not nn > 0.0:
            return _NONE
        pn = -b / nn
        work[n] = pn
        normal = 0.5 * pn * (before + free + nn * pn)
        work = min(normal, normal + 0.5 * pn * (free - before))
        gained = work > GAIN * (abs(pn * before) + abs(pn * free) + abs(normal))
        return _GAIN if gained else _SOLVED
    a1, a2 = float(work[before_at * w + lane]), float(work[(before_at + 1) * w + lane])
    f1, f2 = float(work[free_at * w + lane]), float(work[(free_at + 1) * w + lane])
    t11, t12 = float(work[w_at * w + lane]), float(work[(w_at + 1) * w + lane])
    n1, t22 = float(work[(w_at + 2) * w + lane]), float(work[(w_at + 4) * w + lane])
    n2 = float(work[(w_at + 5) * w + lane])
    if is_faint(nn, t11 + t22, faintest, digits):
        return AGAIN
    if not (before < 0.0 and -before >= capture):
        e = 0.0
    block = (t11, t12, t22, n1, n2, nn)
    u, start = (a1, a2, before), (f1, f2, free)
    hit = strike_at_end(block, u, start, e, mu, e_t, NEWTON)
    work[n - 2 * w], work[n - w], work[n] = hit.impulse
    left = is_left(block, u, start, e, mu, e_t, NEWTON, hit, digits)
    if left:
        return AGAIN
    if hit.code in (_NOT_UNIQUE, _MANY):
        return judge_lone(block, u, start, e, mu, e_t, NEWTON, hit.impulse, hit.code)
    return hit.code
