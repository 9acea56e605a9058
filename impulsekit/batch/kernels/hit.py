"""One contact of several struck once, with slip at the end."""

from __future__ import annotations

from ...laws.single import hit_at_end
from ...laws.status import Status
from ..codes import AGAIN
from .coulomb import block_at, is_close_call
from .jit import built_in

__all__ = ["hit_contact"]

_SOLVED, _JAM = int(Status.SOLVED), int(Status.PAINLEVE_JAM)


@built_in
def hit_contact(W, i, velocity, e, mu, e_t, restitution, digits):
    """(P_t1, P_t2, P_n, work of the normal, of friction, code) of contact i.

    Args:
        W: (3n, 3n) of all contacts.
        velocity: (3n,) before, known impulses included.
        e, mu, e_t: its coefficients; e_t is 0 but under Newton's restitution.
        restitution: NEWTON or POISSON.
        digits: of the numbers that W is made of.
    """
    k = 3 * i
    block = block_at(W, k)
    u = (velocity[k], velocity[k + 1], velocity[k + 2])
    hit = hit_at_end(block, u, u, e, mu, e_t, restitution)
    code = hit.code
    if code not in (_SOLVED, _JAM) or is_close_call(block, mu, hit.impulse, code, digits):
        code = AGAIN
    p1, p2, pn = hit.impulse
    return p1, p2, pn, hit.normal_work, hit.friction_work, code
