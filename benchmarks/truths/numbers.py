"""The numbers of the truth: 50 digits."""

from __future__ import annotations

from functools import cache

import numpy as np

from impulsekit.reference import Arithmetic

DIGITS = 50
# Of doubles: the distance from 1 to the next.
EPS = float(np.finfo(float).eps)
# The spacing of denormal numbers: below it doubles have nothing.
SMALLEST = 5e-324


@cache
def truth_numbers(digits: int = DIGITS) -> Arithmetic:
    """Arithmetic of that many digits."""
    return Arithmetic.mpmath(digits)
