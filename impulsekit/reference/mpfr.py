"""MPFR's numbers, by gmpy2: compiled code does what mpmath does in Python."""

from __future__ import annotations

from contextlib import AbstractContextManager
from typing import Any

__all__ = ["Mpfr"]

# Binary digits of a decimal one; some more, so that the last decimal is whole.
BITS, GUARD = 3.3219281, 4


class Mpfr:
    """The functions that an ``Arithmetic`` asks of mpmath's context.

    gmpy2's precision belongs to the thread. ``precision`` sets it for a while; where that was not
    asked for, each number that is brought in raises one that is too low.
    """

    def __init__(self, digits: int) -> None:
        import gmpy2

        self._gmpy2 = gmpy2
        self._bits = int(digits * BITS) + GUARD
        self.sin, self.cos, self.sqrt = gmpy2.sin, gmpy2.cos, gmpy2.sqrt
        self.atan2, self.isfinite = gmpy2.atan2, gmpy2.is_finite
        with self.precision():
            self.eps = gmpy2.mpfr(2) ** (1 - self._bits)

    def precision(self) -> AbstractContextManager[Any]:
        """Within it, this thread's numbers of gmpy2 have these digits; afterwards what they had."""
        gmpy2: Any = self._gmpy2
        return gmpy2.local_context(gmpy2.context(precision=self._bits))

    def mpf(self, value: Any) -> Any:
        """One number, rounded to the precision at hand."""
        context = self._gmpy2.get_context()
        if context.precision < self._bits:
            context.precision = self._bits
        if hasattr(value, "man_exp"):
            # A number of mpmath's.
            mantissa, exponent = value.man_exp
            return self._gmpy2.mpfr(mantissa) * self._gmpy2.mpfr(2) ** exponent
        return self._gmpy2.mpfr(value)
