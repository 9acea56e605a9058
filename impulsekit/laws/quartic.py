"""Sliding at one contact in 3-D: the direction of slip, from a quartic.

With P = P_n (−µ s, 1), |s| = 1, and ξ = W P + b: ξ_n = 0 gives
P_n = −b_n / (W_nn − µ w·s), and ξ_t = λ s, λ ≥ 0, becomes A s + c = λ' s with
A = µ (b_n W_tt − b_t wᵀ), c = b_t W_nn − b_n w, w = W_tn. Eliminating s,
|adj(λ' − A) c|² = det(λ' − A)²: a quartic in λ' (Bonnefon & Daviet 2011, "Quartic
formulation of Coulomb 3D frictional contact"), of which the roots λ' ≥ 0 count.
"""

from __future__ import annotations

import math

from .borrowed import borrowing
from .pair import Pair
from .words import Block

__all__ = ["Directions", "slides"]

# A vector shorter than this has no direction.
NO_DIRECTION = 1e-12
# Components across or backwards below this share of their terms are rounding error.
ACROSS = 1e-9
# Accuracy of a root from which Newton's method on the directions goes on, and of extremes, whose
# signs separate roots.
ROOT, EXTREME = 1e-7, 1e-15
# A turn [rad] whose square is near rounding error, and the square at which Newton ends.
LITTLE, LAST = 1e-5, 1e-17
# How many directions of slip, and up to four of them.
Directions = tuple[int, Pair, Pair, Pair, Pair]
# q0 + q1 λ + q2 λ² + q3 λ³ + λ⁴, or a cubic with three entries that count.
Monic = tuple[float, float, float, float]
_Matrix = tuple[float, float, float, float, float, float]

# Of W_nn + µ |w|, what friction may leave before P_n is no longer of the size of b_n.
GRAZING = 1e-6
# A double root by rounding: the quartic, its coefficients below 1, comes so near to zero there,
# or has its root so little below zero.
TOUCHES, BELOW = 1e-10, 1e-7
# No root is above 1 as the coefficients are scaled; beyond that by rounding.
TOP = 1.01
# W_nn − µ w·s below this share of W_nn + µ |w| is rounding, and P_n would have no digits.
NO_DIGITS = 1e-11
# What moves, couples or slips out of a plane by less than this share does so by rounding, and
# slip that goes back by less than this does not.
IN_PLANE, BACKWARDS = 1e-12, 1e-12
# Directions nearer than this are one.
SAME_DIRECTION = 1e-7
_NONE = (0.0, 0.0)


@borrowing
def slides(block: Block, b1: float, b2: float, bn: float, mu: float) -> Directions:
    """All directions of slip (s_1, s_2), each with P_n > 0.

    A contact that parts, b_n > 0, slips under load where friction draws it in more than its
    load presses it out: W_nn < µ w·s, with λ' ≤ 0.

    Args:
        block: W [1/kg].
        b1, b2, bn: ξ without contact impulse [m/s].
        mu: the friction, more than 0.

    Returns:
        How many there are, and four places for them.
    """
    t11, t12, t22, n1, n2, nn = block
    a11, a12 = mu * (bn * t11 - b1 * n1), mu * (bn * t12 - b1 * n2)
    a21, a22 = mu * (bn * t12 - b2 * n1), mu * (bn * t22 - b2 * n2)
    c1, c2 = b1 * nn - bn * n1, b2 * nn - bn * n2
    found = (0, _NONE, _NONE, _NONE, _NONE)
    size = math.sqrt(c1 * c1 + c2 * c2) + abs(a11) + abs(a12) + abs(a21) + abs(a22)
    if not 0.0 < size < math.inf:
        return found
    if bn > 0.0:
        size = -size
    matrix = (a11 / size, a12 / size, a21 / size, a22 / size, c1 / size, c2 / size)
    a11, a12, a21, a22, c1, c2 = matrix
    flat, d1, d2 = _line(block, b1, b2, bn)
    if flat:
        # One way or the other: roots of the quartic would be eigenvalues of A.
        along = d1 * (a11 * d1 + a12 * d2) + d2 * (a21 * d1 + a22 * d2)
        shift = d1 * c1 + d2 * c2
        if along + shift > -BACKWARDS:
            found = _with(found, block, b1, b2, bn, mu, d1, d2)
        if along - shift > -BACKWARDS:
            found = _with(found, block, b1, b2, bn, mu, -d1, -d2)
        return found
    m1, m2 = a12 * c2 - a22 * c1, a21 * c1 - a11 * c2
    trace, det = a11 + a22, a11 * a22 - a12 * a21
    q3 = -2.0 * trace
    q2 = trace * trace + 2.0 * det - c1 * c1 - c2 * c2
    q1 = -2.0 * (trace * det + c1 * m1 + c2 * m2)
    q0 = det * det - m1 * m1 - m2 * m2
    roots = _roots((q0, q1, q2, q3))
    for k in range(roots[0]):
        root = _pick(roots, k)
        x1, x2 = root * c1 + m1, root * c2 + m2
        length = math.sqrt(x1 * x1 + x2 * x2)
        good = length >= NO_DIRECTION
        s1, s2 = 1.0, 0.0
        if good:
            # x = det(λ' − A) s, so its sign is that of the determinant.
            if root * root - trace * root + det < 0.0:
                length = -length
            s1, s2, good = _turned(matrix, x1 / length, x2 / length)
        if not good:
            # λ' is an eigenvalue of A, whose direction is not in the quartic, or roots are too
            # close together.
            return _scanned(matrix, block, b1, b2, bn, mu)
        found = _with(found, block, b1, b2, bn, mu, s1, s2)
    return found


@borrowing
def _line(block: Block, b1: float, b2: float, bn: float) -> tuple[bool, float, float]:
    """Whether one tangent alone moves anything, as of bodies in a plane, and that tangent."""
    t11, t12, t22, n1, n2, nn = block
    size, speed = max(t11 + t22, nn), max(abs(b1), abs(b2), abs(bn))
    # Of three that have to lie along it the longest tells it best.
    half = 0.5 * (t11 - t22)
    most, angle = math.sqrt(half * half + t12 * t12) / size, 0.5 * math.atan2(t12, half)
    d1, d2 = math.cos(angle), math.sin(angle)
    length = math.sqrt(n1 * n1 + n2 * n2)
    if length / size > most:
        most, d1, d2 = length / size, n1 / length, n2 / length
    length = math.sqrt(b1 * b1 + b2 * b2)
    if length / speed > most:
        d1, d2 = b1 / length, b2 / length
    off = t11 * d2 * d2 - 2.0 * t12 * d1 * d2 + t22 * d1 * d1
    flat = off <= IN_PLANE * size and abs(n2 * d1 - n1 * d2) <= IN_PLANE * size
    return flat and abs(b2 * d1 - b1 * d2) <= IN_PLANE * speed, d1, d2


@borrowing
def _with(
    found: Directions,
    block: Block,
    b1: float,
    b2: float,
    bn: float,
    mu: float,
    s1: float,
    s2: float,
) -> Directions:
    """The directions with one more, if it is new, has P_n > 0 and ξ_t = λ s with λ ≥ 0.

    Where P_n is large beside b_n, λ' = λ (W_nn − µ w·s) is too small to tell by its sign; but
    b_t = λ s + P_n (µ W_tt s − w) gives λ.
    """
    t11, t12, t22, n1, n2, nn = block
    left, terms = nn - mu * (n1 * s1 + n2 * s2), nn + mu * math.sqrt(n1 * n1 + n2 * n2)
    if left * bn >= 0.0 or abs(left) <= NO_DIGITS * terms:
        return found
    count, one, two, three, four = found
    if count > 0:
        # Entries without a direction are (0, 0), which is far from all.
        nearest = min(
            abs(s1 - one[0]) + abs(s2 - one[1]),
            abs(s1 - two[0]) + abs(s2 - two[1]),
            abs(s1 - three[0]) + abs(s2 - three[1]),
        )
        if nearest <= SAME_DIRECTION:
            return found
    if abs(left) <= GRAZING * terms:
        a1, a2 = mu * (t11 * s1 + t12 * s2) - n1, mu * (t12 * s1 + t22 * s2) - n2
        across = s1 * a2 - s2 * a1
        told = abs(across) > ACROSS * math.sqrt(a1 * a1 + a2 * a2)
        if told and (b1 * a2 - b2 * a1) / across < -ACROSS * math.sqrt(b1 * b1 + b2 * b2):
            return found
    if count == 0:
        return 1, (s1, s2), two, three, four
    if count == 1:
        return 2, one, (s1, s2), three, four
    if count == 2:
        return 3, one, two, (s1, s2), four
    return 4, one, two, three, (s1, s2)


@borrowing
def _value(a: Monic, x: float) -> float:
    return (((x + a[3]) * x + a[2]) * x + a[1]) * x + a[0]


@borrowing
def _slope(a: Monic, x: float) -> float:
    """The derivative over 4: monic, too."""
    return ((x + 0.75 * a[3]) * x + 0.5 * a[2]) * x + 0.25 * a[1]


@borrowing
def _curve(a: Monic, x: float) -> float:
    """The derivative of ``_slope`` over 3."""
    return (x + 0.5 * a[3]) * x + a[2] / 6.0


@borrowing
def _between(a: Monic, order: int, low: float, high: float, near: float) -> float:
    """The root of the quartic or of its derivative (order 0 or 1) between opposite signs."""
    rising = (_slope(a, high) if order else _value(a, high)) > 0.0
    x = 0.5 * (low + high)
    for _ in range(100):
        value = _slope(a, x) if order else _value(a, x)
        slope = 3.0 * _curve(a, x) if order else 4.0 * _slope(a, x)
        if (value > 0.0) == rising:
            high = x
        else:
            low = x
        # Newton, kept in by bisection.
        following = x - value / slope if slope != 0.0 else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - x) < near:
            return following
        x = following
    return x


@borrowing
def _pick(values: tuple[int, float, float, float, float], k: int) -> float:
    if k == 0:
        return values[1]
    if k == 1:
        return values[2]
    if k == 2:
        return values[3]
    return values[4]


@borrowing
def _roots(a: Monic) -> tuple[int, float, float, float, float]:
    """How many roots in [0, 1], or what may be one, and up to four of them.

    They are parted by those of the derivative, and these by those of the second one.
    """
    # Descartes: as many positive roots as changes of sign, or fewer by an even number.
    changes, positive = 0, True
    for value in (a[3], a[2], a[1], a[0]):
        if value != 0.0 and (value > 0.0) != positive:
            positive = not positive
            changes += 1
    if changes == 0:
        return 0, 0.0, 0.0, 0.0, 0.0
    if changes == 1:
        return 1, _between(a, 0, 0.0, TOP, ROOT), 0.0, 0.0, 0.0
    extremes = _extremes(a)
    count, one, two, three = 0, 0.0, 0.0, 0.0
    low, at_low = -BELOW, _value(a, -BELOW)
    for k in range(extremes[0] + 1):
        last = k == extremes[0]
        high = TOP if last else _pick(extremes, k)
        at_high = _value(a, high)
        root = high
        is_root = not last and abs(at_high) < TOUCHES
        if (at_low > 0.0) != (at_high > 0.0):
            root, is_root = _between(a, 0, low, high, ROOT), True
        if is_root:
            if count == 0:
                one = root
            elif count == 1:
                two = root
            elif count == 2:
                three = root
            else:
                return 4, one, two, three, root
            count += 1
        low, at_low = high, at_high
    return count, one, two, three, 0.0


@borrowing
def _extremes(a: Monic) -> tuple[int, float, float, float, float]:
    """Where in [0, 1] the quartic is highest or lowest: how many, and up to three."""
    half = -0.25 * a[3]
    under = half * half - a[2] / 6.0
    reach = math.sqrt(max(under, 0.0))
    first, second = (half - reach, half + reach) if under > 0.0 else (2.0, 2.0)
    count, one, two, three = 0, 0.0, 0.0, 0.0
    low = -BELOW
    for high in (min(first, TOP), min(second, TOP), TOP):
        if high <= low:
            continue
        if (_slope(a, low) > 0.0) != (_slope(a, high) > 0.0):
            root = _between(a, 1, low, high, EXTREME)
            if count == 0:
                one = root
            elif count == 1:
                two = root
            else:
                three = root
            count += 1
        low = high
    return count, one, two, three, 0.0


@borrowing
def _turned(matrix: _Matrix, s1: float, s2: float) -> tuple[float, float, bool]:
    """s turned until A s + c points along s, by Newton; whether it does, and not backwards."""
    a11, a12, a21, a22, c1, c2 = matrix
    for _ in range(20):
        y1, y2 = a11 * s1 + a12 * s2 + c1, a21 * s1 + a22 * s2 + c2
        across, along = s1 * y2 - s2 * y1, s1 * y1 + s2 * y2
        # d(across)/dθ: s turns by s⊥, y by A s⊥.
        d1, d2 = a12 * s1 - a11 * s2, a22 * s1 - a21 * s2
        slope = s1 * d2 - s2 * d1 - along
        if slope == 0.0:
            return s1, s2, False
        turn = -across / slope
        if abs(turn) < LITTLE:
            # The next step would be of the size of its square: rounding.
            s1, s2 = s1 - turn * s2, s2 + turn * s1
            length = math.sqrt(s1 * s1 + s2 * s2)
            s1, s2 = s1 / length, s2 / length
            if turn * turn > LAST:
                continue
            return s1, s2, along > -BACKWARDS
        turn = max(-0.5, min(0.5, turn))
        cosine, sine = math.cos(turn), math.sin(turn)
        s1, s2 = cosine * s1 - sine * s2, cosine * s2 + sine * s1
    return s1, s2, False


@borrowing
def _across(matrix: _Matrix, angle: float) -> float:
    """How far A s + c is from pointing along s."""
    a11, a12, a21, a22, c1, c2 = matrix
    s1, s2 = math.cos(angle), math.sin(angle)
    return s1 * (a21 * s1 + a22 * s2 + c2) - s2 * (a11 * s1 + a12 * s2 + c1)


@borrowing
def _scanned(
    matrix: _Matrix, block: Block, b1: float, b2: float, bn: float, mu: float
) -> Directions:
    """The same by walking around the circle, for quartics with roots too close together."""
    a11, a12, a21, a22, c1, c2 = matrix
    found = (0, _NONE, _NONE, _NONE, _NONE)
    count = 1440
    # Off the axes, so that directions along them lie between two steps.
    before = _across(matrix, 0.3819 * 2.0 * math.pi / count)
    for i in range(count):
        low = (i + 0.3819) * 2.0 * math.pi / count
        high = (i + 1.3819) * 2.0 * math.pi / count
        behind = _across(matrix, high)
        if (before > 0.0) != (behind > 0.0):
            for _ in range(52):
                middle = 0.5 * (low + high)
                if (_across(matrix, middle) > 0.0) == (before > 0.0):
                    low = middle
                else:
                    high = middle
            s1, s2 = math.cos(low), math.sin(low)
            along = s1 * (a11 * s1 + a12 * s2 + c1) + s2 * (a21 * s1 + a22 * s2 + c2)
            if along > -BACKWARDS:
                found = _with(found, block, b1, b2, bn, mu, s1, s2)
        before = behind
    return found
