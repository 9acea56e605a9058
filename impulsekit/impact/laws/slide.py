"""Sliding at one contact in 3-D: the direction of slip, from a quartic.

With P = P_n (−µ s, 1), |s| = 1, and ξ = W P + b: ξ_n = 0 gives
P_n = −b_n / (W_nn − µ w·s), and ξ_t = λ s, λ ≥ 0, becomes A s + c = λ' s with
A = µ (b_n W_tt − b_t wᵀ), c = b_t W_nn − b_n w, w = W_tn. Eliminating s,
|adj(λ' − A) c|² = det(λ' − A)²: a quartic in λ' (Bonnefon & Daviet 2011, "Quartic
formulation of Coulomb 3D frictional contact"), of which the roots λ' ≥ 0 count.
Coordinates are plain floats: at this size an array operation costs more than the sum.
"""

from __future__ import annotations

import math

__all__ = ["Block", "slides"]

# W of one contact: t1t1, t1t2, t2t2, t1n, t2n, nn.
Block = tuple[float, float, float, float, float, float]
Direction = tuple[float, float]

# Of W_nn, what friction may leave of it before P_n is no longer of the size of b_n.
GRAZING = 1e-6


def slides(block: Block, b1: float, b2: float, bn: float, mu: float) -> list[Direction]:
    """All directions of slip (s_1, s_2) for b_n < 0, each with P_n > 0.

    Args:
        block: W [1/kg].
        b1, b2, bn: ξ without contact impulse [m/s].
        mu: the friction, more than 0.
    """
    t11, t12, t22, n1, n2, nn = block
    a11, a12 = mu * (bn * t11 - b1 * n1), mu * (bn * t12 - b1 * n2)
    a21, a22 = mu * (bn * t12 - b2 * n1), mu * (bn * t22 - b2 * n2)
    c1, c2 = b1 * nn - bn * n1, b2 * nn - bn * n2
    size = math.hypot(c1, c2) + abs(a11) + abs(a12) + abs(a21) + abs(a22)
    if not 0.0 < size < math.inf:
        return []
    a11, a12, a21, a22 = a11 / size, a12 / size, a21 / size, a22 / size
    c1, c2 = c1 / size, c2 / size
    m1, m2 = a12 * c2 - a22 * c1, a21 * c1 - a11 * c2
    trace, det = a11 + a22, a11 * a22 - a12 * a21
    q3 = -2.0 * trace
    q2 = trace * trace + 2.0 * det - c1 * c1 - c2 * c2
    q1 = -2.0 * (trace * det + c1 * m1 + c2 * m2)
    q0 = det * det - m1 * m1 - m2 * m2
    matrix = (a11, a12, a21, a22, c1, c2)
    found: list[Direction] = []
    for root in _positive_roots(q3, q2, q1, q0):
        x1, x2 = root * c1 + m1, root * c2 + m2
        length = math.hypot(x1, x2)
        if length < 1e-12:
            # λ' is an eigenvalue of A: the direction is not in the quartic.
            return _forward(_scanned(matrix, nn, n1, n2, mu), block, b1, b2, mu)
        # x = det(λ' − A) s, so its sign is that of the determinant.
        if root * root - trace * root + det < 0.0:
            length = -length
        s = _turned(matrix, x1 / length, x2 / length)
        if s is None:
            return _forward(_scanned(matrix, nn, n1, n2, mu), block, b1, b2, mu)
        if nn - mu * (n1 * s[0] + n2 * s[1]) > 0.0 and all(
            abs(s[0] - o[0]) + abs(s[1] - o[1]) > 1e-7 for o in found
        ):
            found.append(s)
    return _forward(found, block, b1, b2, mu)


def _forward(
    found: list[Direction], block: Block, b1: float, b2: float, mu: float
) -> list[Direction]:
    """Those along which ξ_t = λ s has λ ≥ 0.

    Where P_n is large beside b_n, λ' = λ (W_nn − µ w·s) is too small to tell by its sign; but
    b_t = λ s + P_n (µ W_tt s − w) gives λ.
    """
    t11, t12, t22, n1, n2, nn = block
    kept = []
    for s1, s2 in found:
        if nn - mu * (n1 * s1 + n2 * s2) <= GRAZING * nn:
            a1, a2 = mu * (t11 * s1 + t12 * s2) - n1, mu * (t12 * s1 + t22 * s2) - n2
            across = s1 * a2 - s2 * a1
            told = abs(across) > 1e-9 * math.hypot(a1, a2)
            if told and (b1 * a2 - b2 * a1) / across < -1e-9 * math.hypot(b1, b2):
                continue
        kept.append((s1, s2))
    return kept


def _positive_roots(q3: float, q2: float, q1: float, q0: float) -> list[float]:
    """The roots of λ⁴ + q3 λ³ + q2 λ² + q1 λ + q0 in (0, 1], or what may be one."""
    # Descartes: as many positive roots as changes of sign, or fewer by an even number.
    changes, sign = 0, True
    for value in (q3, q2, q1, q0):
        if value and (value > 0.0) is not sign:
            sign = not sign
            changes += 1
    if changes == 0:
        return []
    if changes > 1:
        import numpy as np

        roots = np.roots([1.0, q3, q2, q1, q0])
        # Double roots come out with a small imaginary part.
        return [r.real for r in roots.tolist() if r.real > -1e-7 and abs(r.imag) < 1e-5]
    # One sign change: one root, below 1 as the coefficients are scaled.
    low, high = 0.0, 1.0
    x = 0.5
    for _ in range(60):
        value = (((x + q3) * x + q2) * x + q1) * x + q0
        if value > 0.0:
            high = x
        else:
            low = x
        slope = ((4.0 * x + 3.0 * q3) * x + 2.0 * q2) * x + q1
        following = x - value / slope if slope else 0.5 * (low + high)
        if not low <= following <= high:
            following = 0.5 * (low + high)
        if abs(following - x) < 1e-6:
            return [following]
        x = following
    return [x]


def _turned(
    matrix: tuple[float, float, float, float, float, float], s1: float, s2: float
) -> Direction | None:
    """s turned until A s + c points along s, by Newton; None if it does not or points back."""
    a11, a12, a21, a22, c1, c2 = matrix
    for _ in range(20):
        y1, y2 = a11 * s1 + a12 * s2 + c1, a21 * s1 + a22 * s2 + c2
        across, along = s1 * y2 - s2 * y1, s1 * y1 + s2 * y2
        # d(across)/dθ: s turns by s⊥, y by A s⊥.
        d1, d2 = a12 * s1 - a11 * s2, a22 * s1 - a21 * s2
        slope = s1 * d2 - s2 * d1 - along
        if slope == 0.0:
            return None
        turn = -across / slope
        if abs(turn) < 1e-5:
            # The next step would be of the size of its square: rounding.
            s1, s2 = s1 - turn * s2, s2 + turn * s1
            length = math.hypot(s1, s2)
            if turn * turn > 1e-17:
                s1, s2 = s1 / length, s2 / length
                continue
            return (s1 / length, s2 / length) if along > -1e-12 else None
        turn = max(-0.5, min(0.5, turn))
        cosine, sine = math.cos(turn), math.sin(turn)
        s1, s2 = cosine * s1 - sine * s2, cosine * s2 + sine * s1
    return None


def _scanned(
    matrix: tuple[float, float, float, float, float, float],
    nn: float,
    n1: float,
    n2: float,
    mu: float,
) -> list[Direction]:
    """The same by walking around the circle, for quartics with roots too close together."""
    a11, a12, a21, a22, c1, c2 = matrix

    def across(angle: float) -> float:
        s1, s2 = math.cos(angle), math.sin(angle)
        return s1 * (a21 * s1 + a22 * s2 + c2) - s2 * (a11 * s1 + a12 * s2 + c1)

    found: list[Direction] = []
    count = 1440
    # Off the axes, so that directions along them lie between two steps.
    angles = [(i + 0.3819) * 2.0 * math.pi / count for i in range(count + 1)]
    values = [across(angle) for angle in angles]
    for i in range(count):
        if (values[i] > 0.0) is (values[i + 1] > 0.0):
            continue
        low, high = angles[i], angles[i + 1]
        for _ in range(52):
            middle = 0.5 * (low + high)
            if (across(middle) > 0.0) is (values[i] > 0.0):
                low = middle
            else:
                high = middle
        s1, s2 = math.cos(low), math.sin(low)
        along = s1 * (a11 * s1 + a12 * s2 + c1) + s2 * (a21 * s1 + a22 * s2 + c2)
        if along > -1e-12 and nn - mu * (n1 * s1 + n2 * s2) > 0.0:
            found.append((s1, s2))
    return found
