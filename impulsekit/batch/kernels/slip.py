"""Directions of slip at one contact, as ``impact.laws.slide`` finds them, for kernels.

The same quartic; its roots in (0, 1] are parted by those of its derivatives.
"""

from __future__ import annotations

import math

from .jit import built_in

__all__ = ["slips"]


@built_in
def _value(a, degree, x):
    total = 1.0
    for k in range(degree - 1, -1, -1):
        total = total * x + a[k]
    return total


@built_in
def _between(a, degree, low, high, near):
    """The root between two points of opposite signs: Newton, kept in by bisection."""
    rising = _value(a, degree, high) > 0.0
    x = 0.5 * (low + high)
    for _ in range(100):
        value = _value(a, degree, x)
        if (value > 0.0) == rising:
            high = x
        else:
            low = x
        slope = float(degree)
        for k in range(degree - 1, 0, -1):
            slope = slope * x + k * a[k]
        following = x - value / slope if slope != 0.0 else 0.5 * (low + high)
        if not (low < following < high):
            following = 0.5 * (low + high)
        if abs(following - x) < near:
            return following
        x = following
    return x


@built_in
def _roots(a, found):
    """The roots in [0, 1] of x⁴ + a3 x³ + a2 x² + a1 x + a0, into ``found``; how many.

    Where the quartic only comes very near to zero, that point counts, too.
    """
    changes = 0
    positive = True
    for k in (3, 2, 1, 0):
        if a[k] != 0.0 and (a[k] > 0.0) != positive:
            positive = not positive
            changes += 1
    if changes == 0:
        return 0
    if changes == 1:
        # Descartes: one positive root, below 1 as the coefficients are scaled.
        found[0] = _between(a, 4, 0.0, 1.0, 1e-7)
        return 1
    # Monic derivatives, from the quadratic up.
    b = (a[2] / 6.0, a[3] / 2.0, 0.0, 0.0)
    c = (a[1] / 4.0, a[2] / 2.0, 0.75 * a[3], 0.0)
    p0 = p1 = 0.0
    parts = 0
    half = -0.5 * b[1]
    under = half * half - b[0]
    if under > 0.0:
        reach = math.sqrt(under)
        p0, p1 = half - reach, half + reach
        parts = 2
    t0 = t1 = t2 = 0.0
    turns = 0
    low = 0.0
    for k in range(parts + 1):
        high = 1.0
        if k < parts:
            high = p0 if k == 0 else p1
            if high <= low:
                continue
            high = min(high, 1.0)
        if high > low and (_value(c, 3, low) > 0.0) != (_value(c, 3, high) > 0.0):
            root = _between(c, 3, low, high, 1e-15)
            if turns == 0:
                t0 = root
            elif turns == 1:
                t1 = root
            else:
                t2 = root
            turns += 1
        low = high
    count = 0
    low = 0.0
    for k in range(turns + 1):
        high = 1.0
        if k < turns:
            high = t0 if k == 0 else (t1 if k == 1 else t2)
        at_low, at_high = _value(a, 4, low), _value(a, 4, high)
        if (at_low > 0.0) != (at_high > 0.0):
            found[count] = _between(a, 4, low, high, 1e-7)
            count += 1
        elif k < turns and abs(at_high) < 1e-12 and count < 4:
            found[count] = high
            count += 1
        low = high
    return count


@built_in
def _turned(a11, a12, a21, a22, c1, c2, s1, s2):
    """s turned until A s + c points along s, and whether it does."""
    for _ in range(20):
        y1, y2 = a11 * s1 + a12 * s2 + c1, a21 * s1 + a22 * s2 + c2
        across, along = s1 * y2 - s2 * y1, s1 * y1 + s2 * y2
        d1, d2 = a12 * s1 - a11 * s2, a22 * s1 - a21 * s2
        slope = s1 * d2 - s2 * d1 - along
        if slope == 0.0:
            return s1, s2, False
        turn = -across / slope
        if abs(turn) < 1e-5:
            s1, s2 = s1 - turn * s2, s2 + turn * s1
            length = math.sqrt(s1 * s1 + s2 * s2)
            s1, s2 = s1 / length, s2 / length
            if turn * turn > 1e-17:
                continue
            return s1, s2, along > -1e-12
        turn = max(-0.5, min(0.5, turn))
        cosine, sine = math.cos(turn), math.sin(turn)
        s1, s2 = cosine * s1 - sine * s2, cosine * s2 + sine * s1
    return s1, s2, False


@built_in
def slips(t11, t12, t22, n1, n2, nn, b1, b2, bn, mu, found, roots):
    """All directions of slip for b_n < 0 into ``found`` (4, 2); how many, -1 if unsure."""
    a11, a12 = mu * (bn * t11 - b1 * n1), mu * (bn * t12 - b1 * n2)
    a21, a22 = mu * (bn * t12 - b2 * n1), mu * (bn * t22 - b2 * n2)
    c1, c2 = b1 * nn - bn * n1, b2 * nn - bn * n2
    size = math.sqrt(c1 * c1 + c2 * c2) + abs(a11) + abs(a12) + abs(a21) + abs(a22)
    if not 0.0 < size < math.inf:
        return 0
    a11, a12, a21, a22 = a11 / size, a12 / size, a21 / size, a22 / size
    c1, c2 = c1 / size, c2 / size
    m1, m2 = a12 * c2 - a22 * c1, a21 * c1 - a11 * c2
    trace, det = a11 + a22, a11 * a22 - a12 * a21
    q3 = -2.0 * trace
    q2 = trace * trace + 2.0 * det - c1 * c1 - c2 * c2
    q1 = -2.0 * (trace * det + c1 * m1 + c2 * m2)
    q0 = det * det - m1 * m1 - m2 * m2
    count = 0
    for k in range(_roots((q0, q1, q2, q3), roots)):
        root = roots[k]
        x1, x2 = root * c1 + m1, root * c2 + m2
        length = math.sqrt(x1 * x1 + x2 * x2)
        if length < 1e-12:
            return -1
        if root * root - trace * root + det < 0.0:
            length = -length
        s1, s2, good = _turned(a11, a12, a21, a22, c1, c2, x1 / length, x2 / length)
        if not good:
            return -1
        if nn - mu * (n1 * s1 + n2 * s2) <= 0.0:
            continue
        new = True
        for j in range(count):
            new = new and abs(s1 - found[j, 0]) + abs(s2 - found[j, 1]) > 1e-7
        if new:
            found[count, 0], found[count, 1] = s1, s2
            count += 1
    return count
