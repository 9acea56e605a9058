"""What kernels leave to ``solve``."""

from __future__ import annotations

from ...laws.coulomb import can_press
from ...laws.modes import DEPENDENT
from ...laws.rank_tolerances import COARSE
from ...laws.several import Care
from ...laws.single import newtons_shift
from ...laws.status import Status
from ...laws.words import NEWTON
from ..codes import AGAIN
from .jit import built_in

__all__ = ["LEFT", "care_for", "is_close_call", "is_faint", "is_left"]

# Nearer than this to no answer or to many, single precision has lost the digits that decide.
NEAR = 1e-4
# W_nn beside W of the tangents: rows of 1e-2 have lost two digits of their terms.
FAINT_NORMAL = 1e-4
# Where friction leaves less of what the normal impulse moves, digits are lost: ``solve`` refines.
CANCELLED = 0.02
# Contacts of which one is this much more mobile than another are left to ``solve``, which refines.
ALIKE = 1e-3
# Codes of several contacts that are no answers: there ``solve`` refines what came nearest.
LEFT = (AGAIN, int(Status.NO_SOLUTION), int(Status.NOT_CONVERGED))
# Rows in single precision have so many times the rounding, squared.
COARSER = 1e10
_SOLVED, _JAM = int(Status.SOLVED), int(Status.PAINLEVE_JAM)
_NOT_UNIQUE = int(Status.NOT_UNIQUE)


@built_in
def care_for(digits):
    """What the law of several contacts is to leave, its numbers having so many binary digits.

    In single precision what is left in doubt is solved again in double precision.
    """
    if digits == 53:
        return Care(DEPENDENT, ALIKE, False)
    return Care(COARSE, ALIKE, True)


@built_in
def is_faint(nn, tt, faintest, digits):
    """Whether the normal's row, or both tangents, may be zero but for rounding.

    Args:
        nn, tt: W_nn, and the trace of W_tt; 0 where no tangents matter [1/kg].
        faintest: up to this it may be [1/kg].
    """
    least = faintest if digits == 53 else COARSER * faintest
    return 0.0 < nn <= least or 0.0 < tt <= least


@built_in
def is_left(block, before, free, e, mu, e_t, restitution, hit, digits):
    """Whether ``solve`` is to decide what one contact does: see ``is_close_call``.

    Or it parts and could be pressed in as well: ``solve`` looks whether that gains energy.
    """
    if hit.impulse[2] == 0.0 and mu > 0.0:
        b1, b2, bn = free
        if restitution == NEWTON:
            b1, b2 = b1 + e_t * before[0], b2 + e_t * before[1]
            bn += newtons_shift(e, before[2])
        if can_press(block, b1, b2, bn, mu, abs(b1) + abs(b2) + abs(bn)):
            return True
    # A normal that hardly moves is what levers leave of each other: ``solve`` refines.
    if hit.code == _NOT_UNIQUE and block[5] < FAINT_NORMAL * (block[0] + block[2]):
        return True
    p1, p2, pn = hit.impulse
    if mu > 0.0 and block[5] * pn + block[3] * p1 + block[4] * p2 < CANCELLED * block[5] * pn:
        return True
    return is_close_call(block, mu, hit.impulse, hit.code, digits)


@built_in
def is_close_call(block, mu, impulse, code, digits):
    """Whether an answer from numbers of so many digits is to be found anew with more."""
    t11, t12, t22, n1, n2, nn = block
    p1, p2, pn = impulse
    if digits == 53 or mu == 0.0 or pn == 0.0:
        return False
    if code not in (_SOLVED, _JAM):
        return True
    s11, s12, s22 = t11 - n1 * n1 / nn, t12 - n1 * n2 / nn, t22 - n2 * n2 / nn
    if not s11 * s22 - s12 * s12 > NEAR * t11 * t22:
        return True
    # W_nn − µ w·s where it slides, and no less than that where it sticks.
    return nn * pn + n1 * p1 + n2 * p2 <= NEAR * nn * pn
