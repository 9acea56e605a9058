"""Coulomb's law at one contact in closed form, as ``impact.laws.coulomb``, for kernels.

Where the answer needs a second look (more than one, none, or one that is not determined)
the code AGAIN leaves the state to the solver of single states.
"""

from __future__ import annotations

import math

from ...laws.status import Status
from ..codes import AGAIN
from .jit import built_in
from .slip import slips

__all__ = ["coulomb", "gain"]

ON_CONE = 1e-13
GAIN = 1e-10
# Nearer than this to no answer or to many, digits are lost that the other way may keep.
NEAR = 1e-4
_SOLVED, _JAM = int(Status.SOLVED), int(Status.PAINLEVE_JAM)


@built_in
def _jammed(n1, n2, nn, u1, u2, mu, scale):
    speed = math.sqrt(u1 * u1 + u2 * u2)
    if speed <= 1e-13 * scale:
        return False
    return nn * speed <= mu * (n1 * u1 + n2 * u2)


@built_in
def coulomb(t11, t12, t22, n1, n2, nn, b1, b2, bn, mu, scale, found, roots):
    """(P_t1, P_t2, P_n, code) of one contact.

    Args:
        t11, t12, t22, n1, n2, nn: W [1/kg].
        b1, b2, bn: ξ without contact impulse [m/s].
        mu: the friction.
        scale: the size of the velocities [m/s].
        found, roots: room, (4, 2) and (4,).
    """
    if bn >= -1e-15 * scale:
        if mu > 0.0 and bn <= 1e-13 * scale and _jammed(n1, n2, nn, b1, b2, mu, scale):
            return 0.0, 0.0, 0.0, AGAIN
        return 0.0, 0.0, 0.0, _SOLVED
    if not nn > 0.0:
        return 0.0, 0.0, 0.0, AGAIN
    if mu == 0.0:
        return 0.0, 0.0, -bn / nn, _SOLVED
    s11, s12, s22 = t11 - n1 * n1 / nn, t12 - n1 * n2 / nn, t22 - n2 * n2 / nn
    r1, r2 = n1 * bn / nn - b1, n2 * bn / nn - b2
    det = s11 * s22 - s12 * s12
    if not det > NEAR * t11 * t22:
        return 0.0, 0.0, 0.0, AGAIN
    code = _JAM if _jammed(n1, n2, nn, b1, b2, mu, scale) else _SOLVED
    p1, p2 = (s22 * r1 - s12 * r2) / det, (s11 * r2 - s12 * r1) / det
    pn = -(bn + n1 * p1 + n2 * p2) / nn
    if pn > 0.0 and math.sqrt(p1 * p1 + p2 * p2) <= mu * pn * (1.0 + ON_CONE):
        if (
            mu * math.sqrt(n1 * n1 + n2 * n2) > 0.3 * nn or mu * mu * max(t11, t22) > 4.0 * nn
        ) and slips(t11, t12, t22, n1, n2, nn, b1, b2, bn, mu, found, roots) != 0:
            return p1, p2, pn, AGAIN
        return p1, p2, pn, code
    if slips(t11, t12, t22, n1, n2, nn, b1, b2, bn, mu, found, roots) != 1:
        return 0.0, 0.0, 0.0, AGAIN
    s1, s2 = found[0, 0], found[0, 1]
    left = nn - mu * (n1 * s1 + n2 * s2)
    pn = -bn / left
    return -mu * s1 * pn, -mu * s2 * pn, pn, code if left > NEAR * nn else AGAIN


@built_in
def gain(impulse, before, after, count):
    """Whether contacts raise the energy by more than rounding."""
    total = 0.0
    size = 0.0
    for i in range(count):
        normal = 0.0
        friction = 0.0
        for k in range(3 * i, 3 * i + 3):
            work = 0.5 * impulse[k] * (before[k] + after[k])
            size += abs(impulse[k] * before[k])
            if k == 3 * i + 2:
                normal = work
            else:
                friction += work
        total += normal + friction
        size += abs(normal) + abs(friction)
    return total > 0.0 and total > GAIN * size
