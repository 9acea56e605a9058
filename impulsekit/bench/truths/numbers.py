"""The numbers of the truth: 50 digits, by MPFR where it is installed, by mpmath elsewhere."""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np

from ...reference import Arithmetic

__all__ = ["DIGITS", "EPS", "SMALLEST", "truth_numbers"]

DIGITS = 50
# Of doubles: the distance from 1 to the next.
EPS = float(np.finfo(float).eps)
# The spacing of denormal numbers: below it doubles have nothing.
SMALLEST = 5e-324


@cache
def truth_numbers(digits: int = DIGITS) -> Arithmetic:
    """Arithmetic of that many digits.

    MPFR does by compiled code what mpmath does in Python, the same digits some five times
    as fast.
    """
    try:
        import gmpy2  # noqa: F401
    except ImportError:
        return Arithmetic.mpmath(digits)
    functions = _Mpfr(digits)
    return Arithmetic(f"MPFR, {digits} digits", np.dtype(object), functions.eps, functions)


class _Mpfr:
    """The functions that an ``Arithmetic`` asks of mpmath, by gmpy2.

    gmpy2's precision belongs to the thread, so it is set at each number that is brought in.
    """

    def __init__(self, digits: int) -> None:
        import gmpy2

        self._gmpy2 = gmpy2
        self._bits = int(digits * 3.3219281) + 4
        self.sin, self.cos, self.sqrt = gmpy2.sin, gmpy2.cos, gmpy2.sqrt
        self.atan2, self.isfinite = gmpy2.atan2, gmpy2.is_finite
        self.eps = self.mpf(2) ** (1 - self._bits)

    def mpf(self, value: Any) -> Any:
        context = self._gmpy2.get_context()
        if context.precision < self._bits:
            context.precision = self._bits
        return self._gmpy2.mpfr(value)
