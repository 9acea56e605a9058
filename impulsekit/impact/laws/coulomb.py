"""Coulomb's law at one contact, in closed form.

ξ = W P + b with 0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0.
"""

from __future__ import annotations

import math

from ...laws.status import Status
from .slide import Block, slides

__all__ = ["Impulse", "bounded_friction", "coulomb", "coulomb_impulse", "is_jammed", "residual_of"]

# P_t1, P_t2, P_n [N s].
Impulse = tuple[float, float, float]
NOTHING: Impulse = (0.0, 0.0, 0.0)

# A tangential inertia this much smaller than its terms is a zero.
NULL = 1e-12
# Excess over the cone that is rounding.
ON_CONE = 1e-13


def coulomb(
    block: Block, b1: float, b2: float, bn: float, mu: float, scale: float
) -> tuple[Impulse, Status]:
    """The impulse of one contact, and what is to be known about it.

    Args:
        block: W [1/kg].
        b1, b2, bn: ξ without contact impulse [m/s].
        mu: the friction.
        scale: the size of the velocities, for what counts as zero [m/s].
    """
    nn = block[5]
    if bn >= -1e-15 * scale:
        # It parts, or lies still: there is no impulse, whatever else would be possible.
        if mu and bn <= 1e-13 * scale and is_jammed(block, b1, b2, mu, scale):
            return NOTHING, Status.MANY_SOLUTIONS
        return NOTHING, Status.SOLVED
    if nn <= 0.0:
        return NOTHING, Status.NO_SOLUTION
    if not mu:
        return (0.0, 0.0, -bn / nn), Status.SOLVED
    stick, determined = _stick(block, b1, b2, bn, scale)
    jammed = is_jammed(block, b1, b2, mu, scale)
    status = Status.PAINLEVE_JAM if jammed else Status.SOLVED
    if stick is not None:
        p1, p2, pn = stick
        if pn > 0.0 and math.hypot(p1, p2) <= mu * pn * (1.0 + ON_CONE):
            if not determined:
                return stick, Status.NOT_UNIQUE
            # Even far below Painlevé's friction it may slide as well, where W_tt is
            # anisotropic; the signs in the quartic mostly tell at once that it cannot.
            for other in slides(block, b1, b2, bn, mu):
                if _apart(_sliding(block, bn, mu, other), stick):
                    return stick, Status.MANY_SOLUTIONS
            return stick, status
    found = slides(block, b1, b2, bn, mu)
    if not found:
        return NOTHING, Status.NO_SOLUTION
    first = _sliding(block, bn, mu, found[0])
    if any(_apart(_sliding(block, bn, mu, other), first) for other in found[1:]):
        return first, Status.MANY_SOLUTIONS
    return first, status


def coulomb_impulse(
    block: Block, b1: float, b2: float, bn: float, mu: float, scale: float
) -> Impulse:
    """The impulse of ``coulomb`` by itself: what else would be possible is not looked for."""
    nn = block[5]
    if bn >= -1e-15 * scale or nn <= 0.0:
        return NOTHING
    if not mu:
        return (0.0, 0.0, -bn / nn)
    stick, _ = _stick(block, b1, b2, bn, scale)
    if stick is not None:
        p1, p2, pn = stick
        if pn > 0.0 and math.hypot(p1, p2) <= mu * pn * (1.0 + ON_CONE):
            return stick
    found = slides(block, b1, b2, bn, mu)
    return _sliding(block, bn, mu, found[0]) if found else NOTHING


def is_jammed(block: Block, u1: float, u2: float, mu: float, scale: float) -> bool:
    """Whether slip at u presses the contact further in: W_nn ≤ µ W_nt·s."""
    speed = math.hypot(u1, u2)
    if speed <= 1e-13 * scale:
        return False
    return block[5] * speed <= mu * (block[3] * u1 + block[4] * u2)


def bounded_friction(
    block: Block, b1: float, b2: float, pn: float, mu: float
) -> tuple[float, float]:
    """P_t of least ½ P_tᵀ W_tt P_t + P_t·b_t' within |P_t| ≤ µ P_n, P_n being given.

    Args:
        b1, b2: ξ_t without contact impulse [m/s].
        pn: the normal impulse [N s].
    """
    t11, t12, t22, n1, n2, _ = block
    r1, r2 = -(b1 + n1 * pn), -(b2 + n2 * pn)
    bound = mu * pn
    if bound <= 0.0:
        return (0.0, 0.0)
    trace, regular = t11 + t22, max(t11 * t22 - t12 * t12, 0.0)
    if trace <= 0.0:
        return (0.0, 0.0)
    if regular > NULL * t11 * t22 > 0.0:
        p1, p2 = (t22 * r1 - t12 * r2) / regular, (t11 * r2 - t12 * r1) / regular
    else:
        # Of rank one, and r in its range.
        p1, p2 = r1 / trace, r2 / trace
    if math.hypot(p1, p2) <= bound:
        return (p1, p2)
    # On the edge: |(W_tt + k)⁻¹ r| = bound. Its inverse is concave in k, so that Newton
    # from a k that is too small climbs to the root and never passes it.
    length = math.hypot(r1, r2)
    if length == 0.0:
        return (0.0, 0.0)
    mean, spread = 0.5 * (t11 + t22), math.hypot(0.5 * (t11 - t22), t12)
    tiny = 1e-15 * (mean + spread)
    k = max(length / bound - mean - spread, tiny)
    p1 = p2 = 0.0
    for _ in range(100):
        k1, k2 = t11 + k, t22 + k
        det = k * (k + trace) + regular
        p1, p2 = (k2 * r1 - t12 * r2) / det, (k1 * r2 - t12 * r1) / det
        size = math.hypot(p1, p2)
        if size <= bound * (1.0 + 1e-15):
            break
        slope = (k2 * p1 * p1 - 2.0 * t12 * p1 * p2 + k1 * p2 * p2) / det
        step = size * size * (size - bound) / (bound * slope)
        if step <= 1e-16 * k:
            break
        k += step
    return (p1, p2)


def residual_of(
    block: Block,
    b: tuple[float, float, float],
    impulse: Impulse,
    mu: float,
    floor: float,
    scale: float,
) -> float:
    """How far P is from Coulomb's law, relative to the velocities at hand; P_n ≥ floor."""
    t11, t12, t22, n1, n2, nn = block
    p1, p2, pn = impulse
    worst = 0.0
    scale = max(scale, nn * pn)
    if nn > 0.0:
        xn = b[2] + n1 * p1 + n2 * p2 + nn * pn
        worst = abs(min(xn, nn * (pn - floor)))
    elif b[2] < 0.0:
        worst = -b[2]
    if mu and pn > 0.0:
        x1 = b[0] + t11 * p1 + t12 * p2 + n1 * pn
        x2 = b[1] + t12 * p1 + t22 * p2 + n2 * pn
        rate = t11 + t22
        if rate > 0.0:
            q1, q2 = p1 - x1 / rate, p2 - x2 / rate
            size = math.hypot(q1, q2)
            if size > mu * pn:
                q1, q2 = q1 * mu * pn / size, q2 * mu * pn / size
            worst = max(worst, rate * math.hypot(p1 - q1, p2 - q2))
    return worst / scale if worst else 0.0


def _stick(
    block: Block, b1: float, b2: float, bn: float, scale: float
) -> tuple[Impulse | None, bool]:
    """P with W P = −b, the normal eliminated first; None where there is none; whether it is one."""
    t11, t12, t22, n1, n2, nn = block
    s11, s12, s22 = t11 - n1 * n1 / nn, t12 - n1 * n2 / nn, t22 - n2 * n2 / nn
    r1, r2 = n1 * bn / nn - b1, n2 * bn / nn - b2
    det = s11 * s22 - s12 * s12
    if det > 1e-10 * t11 * t22 > 0.0:
        p1, p2 = (s22 * r1 - s12 * r2) / det, (s11 * r2 - s12 * r1) / det
        return (p1, p2, -(bn + n1 * p1 + n2 * p2) / nn), True
    # Some tangential direction, together with the normal, moves no inertia of its own.
    mean, spread = 0.5 * (s11 + s22), math.hypot(0.5 * (s11 - s22), s12)
    angle = 0.5 * math.atan2(2.0 * s12, s11 - s22)
    p1 = p2 = 0.0
    determined = True
    for value, e1, e2 in (
        (mean + spread, math.cos(angle), math.sin(angle)),
        (mean - spread, -math.sin(angle), math.cos(angle)),
    ):
        right = r1 * e1 + r2 * e2
        inertia = t11 * e1 * e1 + 2.0 * t12 * e1 * e2 + t22 * e2 * e2
        if value > NULL * (t11 + t22):
            p1, p2 = p1 + right / value * e1, p2 + right / value * e2
        elif abs(right) > 1e-10 * scale:
            return None, True
        elif inertia > NULL * (t11 + t22):
            determined = False
    return (p1, p2, -(bn + n1 * p1 + n2 * p2) / nn), determined


def _sliding(block: Block, bn: float, mu: float, s: tuple[float, float]) -> Impulse:
    """P = P_n (−µ s, 1) with ξ_n = 0."""
    pn = -bn / (block[5] - mu * (block[3] * s[0] + block[4] * s[1]))
    return (-mu * s[0] * pn, -mu * s[1] * pn, pn)


def _apart(one: Impulse, other: Impulse) -> bool:
    """Whether two impulses differ by more than rounding."""
    size = abs(one[2]) + abs(other[2])
    return any(abs(x - y) > 1e-7 * size for x, y in zip(one, other, strict=True))
