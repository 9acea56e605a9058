"""One contact struck once, friction looking at the end (``impact.laws.single``), for kernels."""

from __future__ import annotations

import math

from ...laws.status import Status
from ...laws.words import NEWTON
from ..codes import AGAIN
from .coulomb import GAIN, coulomb
from .jit import built_in
from .release import released

__all__ = ["hit_at_end", "judged"]

# A contact that approaches this slowly beside its slip grazes.
GRAZING = 1e-4
_SOLVED, _GAIN = int(Status.SOLVED), int(Status.ENERGY_GAIN)


@built_in
def hit_at_end(W, i, u1, u2, un, e, mu, e_t, restitution, found, roots):
    """(P_t1, P_t2, P_n, work of the normal, of friction, code) of contact i.

    Args:
        W: (3n, 3n) of all contacts.
        u1, u2, un: its velocity before, known impulses included.
        e, mu, e_t: its coefficients; e_t is 0 but under Newton's restitution.
        restitution: NEWTON or POISSON.
        found, roots: room, see ``coulomb``.
    """
    k = 3 * i
    t11, t12, t22 = W[k, k], W[k, k + 1], W[k + 1, k + 1]
    n1, n2, nn = W[k, k + 2], W[k + 1, k + 2], W[k + 2, k + 2]
    scale = abs(un)
    if mu > 0.0:
        scale = max(scale, abs(u1), abs(u2), abs(e_t * u1), abs(e_t * u2))
    b1, b2, bn = u1, u2, un
    if restitution == NEWTON:
        if mu > 0.0:
            b1, b2 = u1 + e_t * u1, u2 + e_t * u2
        if un < 0.0:
            bn = un + e * un
    p1, p2, pn, code = coulomb(
        t11, t12, t22, n1, n2, nn, b1, b2, bn, mu, scale, found, roots
    )  # fmt: skip
    if code == AGAIN or _may_jam(t11, t12, t22, n1, n2, nn, b1, b2, bn, mu):
        return p1, p2, pn, 0.0, 0.0, AGAIN
    m1 = u1 + t11 * p1 + t12 * p2 + n1 * pn
    m2 = u2 + t12 * p1 + t22 * p2 + n2 * pn
    mn = un + n1 * p1 + n2 * p2 + nn * pn
    normal = 0.5 * pn * (un + mn)
    friction = 0.5 * (p1 * (u1 + m1) + p2 * (u2 + m2))
    if restitution == NEWTON or not pn > 0.0 or e == 0.0:
        return p1, p2, pn, normal, friction, code
    r1, r2, rn, second = released(
        t11, t12, t22, n1, n2, nn, m1, m2, mn, mu, e * pn, scale, found, roots
    )  # fmt: skip
    if second == AGAIN:
        return p1, p2, pn, 0.0, 0.0, AGAIN
    a1 = m1 + t11 * r1 + t12 * r2 + n1 * rn
    a2 = m2 + t12 * r1 + t22 * r2 + n2 * rn
    an = mn + n1 * r1 + n2 * r2 + nn * rn
    normal += 0.5 * rn * (mn + an)
    friction += 0.5 * (r1 * (m1 + a1) + r2 * (m2 + a2))
    code = second if second != _SOLVED else code
    return p1 + r1, p2 + r2, pn + rn, normal, friction, code


@built_in
def _may_jam(t11, t12, t22, n1, n2, nn, b1, b2, bn, mu):
    """Whether a contact that grazes may bear any load: another answer, hard to tell by then.

    At b_n = 0 that is sticking, or slip along an s with W_nn = µ W_nt·s. Both need a friction
    of W_nn ≤ µ |W_nt|.
    """
    across = math.sqrt(n1 * n1 + n2 * n2)
    speed = math.sqrt(b1 * b1 + b2 * b2)
    if bn >= 0.0 or bn < -GRAZING * speed or mu * across < 0.99 * nn:
        return False
    s11, s12, s22 = t11 - n1 * n1 / nn, t12 - n1 * n2 / nn, t22 - n2 * n2 / nn
    det = s11 * s22 - s12 * s12
    p1, p2 = (s12 * b2 - s22 * b1) / det, (s12 * b1 - s11 * b2) / det
    pn = -(n1 * p1 + n2 * p2) / nn
    if not math.sqrt(p1 * p1 + p2 * p2) > 1.01 * mu * pn:
        return True
    cosine = min(1.0, nn / (mu * across))
    for turn in (-1.0, 1.0):
        sine = turn * math.sqrt(1.0 - cosine * cosine)
        s1, s2 = (cosine * n1 - sine * n2) / across, (cosine * n2 + sine * n1) / across
        # b = κ s + P_n (µ W_tt s − W_nt), κ and P_n above 0.
        a1 = mu * (t11 * s1 + t12 * s2) - n1
        a2 = mu * (t12 * s1 + t22 * s2) - n2
        det = s1 * a2 - s2 * a1
        size = math.sqrt(a1 * a1 + a2 * a2)
        slip, load = (b1 * a2 - b2 * a1) / det, (s1 * b2 - s2 * b1) / det
        if not (slip < -0.01 * speed or load * size < -0.01 * speed):
            return True
    return False


@built_in
def judged(code, size, normal, friction):
    """The code, or that the energy went up; ``size`` is Σ|P||u| of what was struck."""
    total = normal + friction
    if total > 0.0 and total > GAIN * (size + abs(normal) + abs(friction)):
        return _GAIN
    return code
