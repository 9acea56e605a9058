"""Sine and cosine of many angles at once.

The angle is brought to within π/4 by a multiple of π/2 in three parts (Cody & Waite 1980),
where polynomials of degree 13 and 14 serve (the minimax coefficients that fdlibm made
known). Within 1.5 units in the last place for angles up to 1e5; beyond, angle by angle
by the C library. Angles in single precision come without whole turns (``collect_angle``).
"""

from __future__ import annotations

import math

from .jit import inlined
from .lanes import absolute, any_less, digits, rounded, where_less, width
from .memory import load, store

__all__ = ["sine_cosine"]

LARGEST = 1e5
HALF_PI = (1.57079632673412561417, 6.07710050630396597660e-11, 2.02226624879595063154e-21)
TWO_OVER_PI = 0.63661977236758134308
# The same in parts of few enough digits for single precision.
HALF_PI_32 = (1.5703125, 4.8351287841796875e-4, 3.13855707645416259766e-7, 6.077100628e-11)
_H1, _H2, _H3 = HALF_PI
_G1, _G2, _G3, _G4 = HALF_PI_32
_S1, _S2, _S3 = -1.66666666666666324348e-01, 8.33333333332248946124e-03, -1.98412698298579493134e-04
_S4, _S5, _S6 = 2.75573137070700676789e-06, -2.50507602534068634195e-08, 1.58969099521155010221e-10
_C1, _C2, _C3 = 4.16666666666666019037e-02, -1.38888888888741095749e-03, 2.48015872894767294178e-05
_C4, _C5, _C6 = -2.75573143513906633035e-07, 2.08757232129817482790e-09, -1.13596475577881948265e-11


@inlined
def sine_cosine(angle, work, at, witness):
    """(sin, cos) of an angle [rad]; ``work`` from ``at`` on is room for two values."""
    if any_less(LARGEST, absolute(angle)):
        count = width(witness)
        store(work, at, angle)
        for lane in range(count):
            x = work[at + lane]
            finite = abs(x) < math.inf
            work[at + lane] = math.sin(x) if finite else math.nan
            work[at + count + lane] = math.cos(x) if finite else math.nan
        return load(work, at, witness), load(work, at + count, witness)
    k = rounded(angle * TWO_OVER_PI)
    if digits(witness) == 53:
        r = ((angle - k * _H1) - k * _H2) - k * _H3
    else:
        r = (((angle - k * _G1) - k * _G2) - k * _G3) - k * _G4
    z = r * r
    s = r + r * z * (_S1 + z * (_S2 + z * (_S3 + z * (_S4 + z * (_S5 + z * _S6)))))
    c = 1.0 - (0.5 * z - z * z * (_C1 + z * (_C2 + z * (_C3 + z * (_C4 + z * (_C5 + z * _C6))))))
    # The quadrant, -2 to 2: 1 and -1 exchange the two, and each changes sign in two of four.
    quadrant = k - 4.0 * rounded(0.25 * k)
    odd = absolute(absolute(quadrant) - 1.0)
    sine = where_less(odd, 0.5, c, s)
    cosine = where_less(odd, 0.5, s, c)
    negative = absolute(quadrant - 0.5)
    sine = where_less(1.25, negative, -sine, sine)
    cosine = where_less(absolute(quadrant + 0.5), 1.25, cosine, -cosine)
    return sine, cosine
