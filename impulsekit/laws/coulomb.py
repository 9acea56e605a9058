"""Coulomb's law at one contact, in closed form.

ξ = W P + b with 0 ≤ P_n ⊥ ξ_n ≥ 0, |P_t| ≤ µ P_n, P_t = −µ P_n ξ_t/|ξ_t| where ξ_t ≠ 0.
"""

from __future__ import annotations

import math

from .borrowed import borrowing
from .pair import Pair, solve_pair
from .quartic import slides
from .status import Status
from .tolerances import ARRIVED, AT_REST, ROUNDING_OF_SUMS, SINGULAR
from .words import JAM, MANY, NOT_UNIQUE, Block, Triple

__all__ = [
    "bounded_friction",
    "coulomb",
    "is_jammed",
    "raising",
    "released",
    "sliding_impulse",
    "slips",
    "sticking_impulse",
    "stopping",
]

# A release whose normal impulse is below its least value by more than this share is not valid.
SHORT = 1e-12
# Relative tolerance for the edge of the disc of friction.
ON_EDGE = 1e-15
# Slip that W_tt cannot change, as a share of the velocities: above it nothing sticks.
STOPPABLE = 1e-10
_NOTHING = (0.0, 0.0, 0.0)
_SOLVED, _NONE = int(Status.SOLVED), int(Status.NO_SOLUTION)

# A tangential inertia this much smaller than its terms is a zero.
NO_INERTIA = 1e-12
# Excess over the cone that is rounding.
ON_CONE = 1e-13
# Slip below this share of the velocities is none.
NO_SLIP = 1e-13
# Velocities below this [m/s], whose squares would underflow, are multiplied by a power of two, so
# that they come to about 1; the exponent is one that leaves it the normal doubles.
SMALLEST, MOST_RAISED = 1e-70, 1000
# Of both normal impulses: what sets two answers apart; of the velocities: slip that is not the
# rounding of a quartic's double root.
ANSWERS_APART, REAL_SLIP = 1e-7, 1e-6


@borrowing
def raising(scale: float) -> float:
    """By how much velocities of this size [m/s] are raised for their law, which is homogeneous."""
    if scale >= SMALLEST or scale == 0.0:
        return 1.0
    return math.ldexp(1.0, min(-math.frexp(scale)[1], MOST_RAISED))


@borrowing
def coulomb(
    block: Block, b1: float, b2: float, bn: float, mu: float, scale: float
) -> tuple[Triple, int]:
    """The impulse of one contact [N s], and the code of its ``Status``.

    Args:
        block: W [1/kg].
        b1, b2, bn: ξ without contact impulse [m/s].
        mu: the friction.
        scale: the size of the velocities, for what counts as zero [m/s].
    """
    nn = block[5]
    if bn >= -AT_REST * scale:
        # It parts, or lies still: there is no impulse, whatever else would be possible.
        if mu > 0.0 and bn <= NO_SLIP * scale and is_jammed(block, b1, b2, mu, scale):
            return _NOTHING, MANY
        return _NOTHING, _SOLVED
    if not nn > 0.0:
        return _NOTHING, _NONE
    if mu == 0.0:
        return (0.0, 0.0, -bn / nn), _SOLVED
    stick, sticks, determined = sticking_impulse(block, b1, b2, bn, mu, scale)
    if sticks and not determined:
        # What slides with velocities that vanish is one more split of what sticks.
        count, one, two, three, four = slides(block, b1, b2, bn, mu)
        if (
            (count > 0 and slips(block, b1, b2, sliding_impulse(block, bn, mu, one), scale))
            or (count > 1 and slips(block, b1, b2, sliding_impulse(block, bn, mu, two), scale))
            or (count > 2 and slips(block, b1, b2, sliding_impulse(block, bn, mu, three), scale))
            or (count > 3 and slips(block, b1, b2, sliding_impulse(block, bn, mu, four), scale))
        ):
            return stick, MANY
        return stick, NOT_UNIQUE
    code = JAM if is_jammed(block, b1, b2, mu, scale) else _SOLVED
    # Even far below Painlevé's friction it may slide as well, where W_tt is anisotropic; the
    # signs in the quartic mostly tell at once that it cannot.
    count, one, two, three, four = slides(block, b1, b2, bn, mu)
    if count == 0:
        return (stick, code) if sticks else (_NOTHING, _NONE)
    first = sliding_impulse(block, bn, mu, one)
    chosen = stick if sticks else first
    if (
        _apart(first, chosen)
        or (count > 1 and _apart(sliding_impulse(block, bn, mu, two), chosen))
        or (count > 2 and _apart(sliding_impulse(block, bn, mu, three), chosen))
        or (count > 3 and _apart(sliding_impulse(block, bn, mu, four), chosen))
    ):
        return chosen, MANY
    return chosen, code


@borrowing
def slips(block: Block, b1: float, b2: float, impulse: Triple, scale: float) -> bool:
    """Whether an impulse leaves slip."""
    t11, t12, t22, n1, n2, _ = block
    p1, p2, pn = impulse
    u1, u2 = b1 + t11 * p1 + t12 * p2 + n1 * pn, b2 + t12 * p1 + t22 * p2 + n2 * pn
    return math.sqrt(u1 * u1 + u2 * u2) > REAL_SLIP * scale


@borrowing
def is_jammed(block: Block, u1: float, u2: float, mu: float, scale: float) -> bool:
    """Whether slip at u presses the contact further in: W_nn ≤ µ W_nt·s."""
    speed = math.sqrt(u1 * u1 + u2 * u2)
    if speed <= NO_SLIP * scale:
        return False
    return block[5] * speed <= mu * (block[3] * u1 + block[4] * u2)


@borrowing
def released(block: Block, b: Triple, mu: float, floor: float, scale: float) -> tuple[Triple, int]:
    """Coulomb's law with P_n ≥ floor instead of 0, as ``coulomb``."""
    if floor > 0.0:
        p1, p2 = bounded_friction(block, b[0], b[1], floor, mu)
        across, along = block[3] * p1 + block[4] * p2, block[5] * floor
        # Where the release sticks, shares cancel, and what is left is their rounding.
        if b[2] + across + along >= -ROUNDING_OF_SUMS * max(scale, abs(across), along):
            return (p1, p2, floor), _SOLVED
        if abs(b[2]) <= NO_SLIP * scale:
            # Slip loads a contact that neither parts nor approaches by nothing: it sticks.
            stick, sticks, determined = sticking_impulse(block, b[0], b[1], 0.0, mu, scale)
            if not sticks or not stick[2] > floor:
                return _NOTHING, _NONE
            return stick, _SOLVED if determined else NOT_UNIQUE
    impulse, code = coulomb(block, b[0], b[1], b[2], mu, scale)
    if impulse[2] < floor * (1.0 - SHORT):
        return impulse, _NONE
    return impulse, code


@borrowing
def bounded_friction(block: Block, b1: float, b2: float, pn: float, mu: float) -> Pair:
    """P_t of least ½ P_tᵀ W_tt P_t + P_t·b_t' within |P_t| ≤ µ P_n, P_n being given.

    Args:
        b1, b2: ξ_t without contact impulse [m/s].
        pn: the normal impulse [N s].
    """
    t11, t12, t22, n1, n2, _ = block
    r1, r2 = -(b1 + n1 * pn), -(b2 + n2 * pn)
    bound = mu * pn
    trace, regular = t11 + t22, max(t11 * t22 - t12 * t12, 0.0)
    if bound <= 0.0 or not trace > 0.0:
        return 0.0, 0.0
    if regular > NO_INERTIA * t11 * t22:
        p1, p2 = solve_pair(t11, t12, t22, r1, r2)
        held = True
    else:
        # Of rank one: it stops slip along its range alone, and other slip takes all friction.
        p1, p2 = r1 / trace, r2 / trace
        off1, off2 = r1 - (t11 * p1 + t12 * p2), r2 - (t12 * p1 + t22 * p2)
        terms = abs(b1) + abs(b2) + (abs(n1) + abs(n2)) * pn
        held = math.sqrt(off1 * off1 + off2 * off2) <= STOPPABLE * terms
    length = math.sqrt(r1 * r1 + r2 * r2)
    if (held and math.sqrt(p1 * p1 + p2 * p2) <= bound) or length == 0.0:
        return p1, p2
    # On the edge: |(W_tt + k)⁻¹ r| = bound. Its inverse is concave in k, so that Newton
    # from a k that is too small climbs to the root and never passes it.
    mean, half = 0.5 * trace, 0.5 * (t11 - t22)
    spread = math.sqrt(half * half + t12 * t12)
    k = max(length / bound - mean - spread, ON_EDGE * (mean + spread))
    for _ in range(100):
        k1, k2 = t11 + k, t22 + k
        det = k * (k + trace) + regular
        p1, p2 = (k2 * r1 - t12 * r2) / det, (k1 * r2 - t12 * r1) / det
        size = math.sqrt(p1 * p1 + p2 * p2)
        if size <= bound * (1.0 + ON_EDGE):
            break
        slope = (k2 * p1 * p1 - 2.0 * t12 * p1 * p2 + k1 * p2 * p2) / det
        step = size * size * (size - bound) / (bound * slope)
        if step <= ARRIVED * k:
            break
        k += step
    return p1, p2


@borrowing
def sticking_impulse(
    block: Block, b1: float, b2: float, bn: float, mu: float, scale: float
) -> tuple[Triple, bool, bool]:
    """P with W P = −b; whether friction holds it, and whether it is one."""
    (p1, p2, pn), exists, determined = stopping(block, b1, b2, bn, scale)
    _, _, _, n1, n2, nn = block
    holds = pn > 0.0 and math.sqrt(p1 * p1 + p2 * p2) <= mu * pn * (1.0 + ON_CONE)
    if exists and not determined and not holds:
        t, e1, e2, holds = _into_the_cone(block, _reduced(block), p1, p2, pn, mu)
        p1, p2 = p1 + t * e1, p2 + t * e2
        pn = -(bn + n1 * p1 + n2 * p2) / nn
    return (p1, p2, pn), exists and holds, determined


@borrowing
def stopping(
    block: Block, b1: float, b2: float, bn: float, scale: float
) -> tuple[Triple, bool, bool]:
    """P with W P = −b, the normal eliminated first; whether there is one, and just one.

    Of many it is the one without a share of P_t in the direction that moves nothing.
    """
    t11, _, t22, n1, n2, nn = block
    s11, s12, s22 = _reduced(block)
    r1, r2 = n1 * bn / nn - b1, n2 * bn / nn - b2
    det = s11 * s22 - s12 * s12
    exists = determined = True
    if det > SINGULAR * t11 * t22 and det > 0.0:
        p1, p2 = solve_pair(s11, s12, s22, r1, r2)
    else:
        p1, p2, exists, determined = _stick_in_a_line(block, s11, s12, s22, r1, r2, scale)
    return (p1, p2, -(bn + n1 * p1 + n2 * p2) / nn), exists, determined


@borrowing
def _reduced(block: Block) -> Triple:
    """W_tt with the normal held at its velocity: s11, s12, s22 [1/kg]."""
    t11, t12, t22, n1, n2, nn = block
    return t11 - n1 * n1 / nn, t12 - n1 * n2 / nn, t22 - n2 * n2 / nn


@borrowing
def _into_the_cone(
    block: Block, reduced: Triple, p1: float, p2: float, pn: float, mu: float
) -> tuple[float, float, float, bool]:
    """The least t with P + t (e, −W_nt·e/W_nn) in the cone, e, and whether there is one.

    That direction moves nothing; P_t is across it. With g = W_nt·e/W_nn the edge is at
    (1 − µ²g²) t² + 2 µ² g P_n t + |P_t|² − µ² P_n² = 0.
    """
    _, _, _, n1, n2, nn = block
    s11, s12, s22 = reduced
    angle = 0.5 * math.atan2(2.0 * s12, s11 - s22)
    # Of the reduced inertia's two axes the one without any.
    e1, e2 = -math.sin(angle), math.cos(angle)
    length = math.sqrt(n1 * n1 + n2 * n2)
    if s11 + s22 <= NO_INERTIA * (block[0] + block[2]) and length > 0.0:
        # Neither axis has any: the one that the normal answers to is the shortest way.
        e1, e2 = n1 / length, n2 / length
    g = (n1 * e1 + n2 * e2) / nn
    square, half = 1.0 - mu * mu * g * g, mu * mu * g * pn
    rest = p1 * p1 + p2 * p2 - mu * mu * pn * pn
    best, found = 0.0, False
    inside = half * half - square * rest
    if not inside >= 0.0:
        return best, e1, e2, False
    # The two roots without cancellation; where one is at infinity there is the other.
    total = -half - math.copysign(math.sqrt(inside), half)
    if total != 0.0:
        t = rest / total
        if pn - g * t > 0.0:
            best, found = t, True
    if square != 0.0:
        t = total / square
        if pn - g * t > 0.0 and (not found or abs(t) < abs(best)):
            best, found = t, True
    return best, e1, e2, found


@borrowing
def _stick_in_a_line(
    block: Block, s11: float, s12: float, s22: float, r1: float, r2: float, scale: float
) -> tuple[float, float, bool, bool]:
    """P_t where some tangential direction, together with the normal, moves no inertia of its own.

    Whether there is one, and whether it is determined.
    """
    t11, t12, t22, _, _, _ = block
    mean, half = 0.5 * (s11 + s22), 0.5 * (s11 - s22)
    spread = math.sqrt(half * half + s12 * s12)
    angle = 0.5 * math.atan2(2.0 * s12, s11 - s22)
    p1 = p2 = 0.0
    exists = determined = True
    value, e1, e2 = mean + spread, math.cos(angle), math.sin(angle)
    for _ in range(2):
        right = r1 * e1 + r2 * e2
        inertia = t11 * e1 * e1 + 2.0 * t12 * e1 * e2 + t22 * e2 * e2
        if value > NO_INERTIA * (t11 + t22):
            p1, p2 = p1 + right / value * e1, p2 + right / value * e2
        elif abs(right) > STOPPABLE * scale:
            exists = False
        elif inertia > NO_INERTIA * (t11 + t22):
            determined = False
        value, e1, e2 = mean - spread, -e2, e1
    return p1, p2, exists, determined


@borrowing
def sliding_impulse(block: Block, bn: float, mu: float, s: Pair) -> Triple:
    """P = P_n (−µ s, 1) with ξ_n = 0."""
    pn = -bn / (block[5] - mu * (block[3] * s[0] + block[4] * s[1]))
    return -mu * s[0] * pn, -mu * s[1] * pn, pn


@borrowing
def _apart(one: Triple, other: Triple) -> bool:
    """Whether two impulses differ by more than rounding."""
    size = ANSWERS_APART * (abs(one[2]) + abs(other[2]))
    return (
        abs(one[0] - other[0]) > size
        or abs(one[1] - other[1]) > size
        or abs(one[2] - other[2]) > size
    )
