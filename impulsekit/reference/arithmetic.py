"""Numbers of any precision behind one face.

The formulas of this package are written once, on numpy arrays. An :class:`Arithmetic`
says what the entries are: doubles, long doubles, or mpmath numbers of as many digits as
are asked for (arrays of dtype object). The linear algebra is plain elimination written
here, so that the same operations run in every precision and none of them is LAPACK's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any

import numpy as np
from numpy.typing import NDArray

from impulsekit.errors import MissingExtraError, NotFiniteError, RangeError

Array = NDArray[Any]


@dataclass(frozen=True)
class Arithmetic:
    """The numbers that a computation runs on.

    Make one with :meth:`double`, :meth:`long_double` or :meth:`mpmath`.

    Attributes:
        name: "double", "long double" or "mpmath, 50 digits".
        dtype: numpy's type of the arrays.
        epsilon: distance from 1 to the next number.

    Example:
        >>> fifty = Arithmetic.mpmath(digits=50)
        >>> third = fifty.number(1) / 3
        >>> abs(3 * third - 1) < 1e-49
        True
    """

    name: str
    dtype: np.dtype[Any]
    epsilon: Any
    _context: Any = field(default=None, repr=False, compare=False)

    @classmethod
    def double(cls) -> Arithmetic:
        """Return IEEE doubles, some 16 digits."""
        return cls("double", np.dtype(np.float64), float(np.finfo(np.float64).eps))

    @classmethod
    def long_double(cls) -> Arithmetic:
        """Return the machine's long doubles, some 19 digits on x86."""
        return cls("long double", np.dtype(np.longdouble), np.finfo(np.longdouble).eps)

    @classmethod
    def mpmath(cls, digits: int = 50) -> Arithmetic:
        """Return numbers of ``digits`` decimal digits.

        The precision lives in a context of its own: ``mpmath.mp`` is left as it was.

        Raises:
            MissingExtraError: mpmath is not installed.
            RangeError: fewer than 16 digits asked for.
        """
        if int(digits) != digits or digits < 16:
            raise RangeError.of("digits", digits, "a whole number from 16 up")
        with MissingExtraError.unless("mpmath", "reference", f"arithmetic of {digits} digits"):
            context = _context_for_arrays()
        context.dps = int(digits)
        return cls(f"mpmath, {digits} digits", np.dtype(object), context.eps, context)

    # -- numbers and arrays ---------------------------------------------------

    def number(self, value: Any) -> Any:
        """Return one number: of an int, a float, a fraction, a decimal or a number of mpmath.

        A string is read as the decimal it writes, to the precision at hand.
        """
        if self._context is not None:
            if isinstance(value, Fraction):
                return self._context.mpf(value.numerator) / value.denominator
            if isinstance(value, np.longdouble):
                high = float(value)  # a long double is the sum of two doubles
                return self._context.mpf(high) + float(value - np.longdouble(high))
            if isinstance(value, np.generic):
                value = value.item()
            return self._context.mpf(value)
        if self.dtype == np.float64:
            return float(value)
        if isinstance(value, Fraction):
            return np.longdouble(value.numerator) / np.longdouble(value.denominator)
        if type(value).__name__ == "mpf":
            high = float(value)
            return np.longdouble(high) + np.longdouble(float(value - high))
        return np.longdouble(value)

    def array(self, values: Any) -> Array:
        """Return a copy of ``values`` as an array of these numbers."""
        given = np.asarray(values)
        if self._context is None and given.dtype != object:
            return np.array(given, dtype=self.dtype)
        converted = np.empty(given.shape, dtype=self.dtype)
        for index in np.ndindex(given.shape):
            converted[index] = self.number(given[index])
        return converted

    def finite_array(self, values: Any, what: str) -> Array:
        """Return a copy of ``values``, all of them finite.

        Raises:
            NotFiniteError: an entry is not a finite number.
        """
        try:
            given = self.array(values)
        except (TypeError, ValueError):
            raise NotFiniteError.of(what, "an entry", repr(values)) from None
        finite = self._context.isfinite if self._context is not None else np.isfinite
        for index in np.ndindex(given.shape):
            if not finite(given[index]):
                where = f"entry {index[0] if len(index) == 1 else index}" if index else "the value"
                raise NotFiniteError.of(what, where, given[index])
        return given

    def zeros(self, *shape: int) -> Array:
        """Return an array of zeros."""
        return np.full(shape, self.number(0), dtype=self.dtype)

    def eye(self, size: int) -> Array:
        """Return the identity matrix."""
        identity = self.zeros(size, size)
        identity[np.arange(size), np.arange(size)] = self.number(1)
        return identity

    # -- functions of one number ----------------------------------------------

    def sin(self, angle: Any) -> Any:
        """Return the sine of an angle in radians."""
        return self._context.sin(angle) if self._context is not None else np.sin(angle)

    def cos(self, angle: Any) -> Any:
        """Return the cosine of an angle in radians."""
        return self._context.cos(angle) if self._context is not None else np.cos(angle)

    def sqrt(self, value: Any) -> Any:
        """Return square root."""
        return self._context.sqrt(value) if self._context is not None else np.sqrt(value)

    def atan2(self, sine: Any, cosine: Any) -> Any:
        """Return the angle whose sine and cosine are in the ratio given, in (-pi, pi]."""
        if self._context is not None:
            return self._context.atan2(sine, cosine)
        return np.arctan2(sine, cosine)

    def norm(self, vector: Array) -> Any:
        """Return Euclidean length of a vector."""
        return self.sqrt(vector @ vector)

    # -- linear algebra --------------------------------------------------------

    def solve_symmetric(
        self, matrix: Array, right: Array, on_singular: Callable[[int], Exception]
    ) -> Array:
        """Solve ``matrix @ x = right``, the matrix symmetric and positive definite.

        Square-root-free Cholesky elimination, A = L D Lᵀ, after scaling the diagonal of
        A to one, so that grams beside tonnes cost no digits.

        Args:
            matrix: (n, n).
            right: (n,) or (n, m).
            on_singular: makes the error to raise from the index of the pivot that
                vanished.

        Returns:
            x, of the shape of ``right``.
        """
        size = len(matrix)
        scale = self.zeros(size)
        for i in range(size):
            if not matrix[i, i] > 0:
                raise on_singular(i)
            scale[i] = 1 / self.sqrt(matrix[i, i])
        lower = scale[:, None] * matrix * scale[None, :]
        columns = _as_columns(right) * scale[:, None]
        smallest = size * self.epsilon
        pivots = self.zeros(size)
        for i in range(size):
            pivots[i] = lower[i, i]
            if not pivots[i] > smallest:
                raise on_singular(i)
            below = lower[i + 1 :, i] / pivots[i]
            lower[i + 1 :, i + 1 :] -= np.outer(below * pivots[i], below)
            lower[i + 1 :, i] = below
        for i in range(size):
            columns[i + 1 :] -= np.outer(lower[i + 1 :, i], columns[i])
        columns /= pivots[:, None]
        for i in reversed(range(size)):
            columns[:i] -= np.outer(lower[i, :i], columns[i])
        return (columns * scale[:, None]).reshape(right.shape)

    def solve_minimum_norm(self, matrix: Array, right: Array) -> tuple[Array, int]:
        """Return the shortest x with ``matrix @ x = right``, for a matrix that may have lost rank.

        The matrix W is symmetric and positive semidefinite, such as A M⁻¹ Aᵀ of rows A that
        repeat each other. Elimination with exchanges, on W scaled to a unit diagonal, picks
        rows p that are independent: those whose pivot is above epsilon^(3/4). The others, d,
        follow from them. With x_p = W_pp⁻¹ right_p and the null vectors N = [−W_pp⁻¹ W_pd; 1],

            x = x₀ − N (NᵀN)⁻¹ Nᵀ x₀,    x₀ = [x_p; 0].

        Whether x solves the dependent equations as well is for the caller to see.

        Args:
            matrix: (m, m).
            right: (m,).

        Returns:
            x (m,) and the rank.
        """
        size = len(matrix)
        scale = self.zeros(size)
        for i in range(size):
            if matrix[i, i] > 0:  # a row that moves nothing gets no impulse
                scale[i] = 1 / self.sqrt(matrix[i, i])
        left = scale[:, None] * matrix * scale[None, :]
        tolerance = self.sqrt(self.epsilon) * self.sqrt(self.sqrt(self.epsilon))
        chosen: list[int] = []
        while len(chosen) < size:
            diagonal = [left[i, i] for i in range(size)]
            pivot = max(range(size), key=diagonal.__getitem__)
            if not diagonal[pivot] > tolerance:
                break
            chosen.append(pivot)
            left = left - np.outer(left[:, pivot], left[pivot] / diagonal[pivot])
            left[pivot, :] = left[:, pivot] = self.number(0)

        def impossible(_: int) -> Exception:
            return ArithmeticError("a matrix found to have full rank is singular")

        rest = [i for i in range(size) if i not in chosen]
        solution = self.zeros(size)
        within = matrix[np.ix_(chosen, chosen)]
        solution[chosen] = self.solve_symmetric(within, right[chosen], impossible)
        if rest:
            null = self.zeros(size, len(rest))
            across = matrix[np.ix_(chosen, rest)]
            null[chosen] = -self.solve_symmetric(within, across, impossible)
            null[rest] = self.eye(len(rest))
            along = self.solve_symmetric(null.T @ null, null.T @ solution, impossible)
            solution = solution - null @ along
        return solution, len(chosen)


def _context_for_arrays() -> Any:
    """A context of mpmath whose numbers leave products with arrays to numpy at once."""
    from mpmath import MPContext

    class Context(MPContext):
        def npconvert(self, value: Any) -> Any:
            # mpmath's own writes the whole array into an error first.
            if isinstance(value, np.ndarray):
                raise TypeError("an array is no number")
            return super().npconvert(value)

    return Context()


def read_only(*arrays: Array) -> None:
    """Close arrays against writing."""
    for values in arrays:
        values.flags.writeable = False


def closed(values: Array) -> Array:
    """Return the same array, closed against writing."""
    read_only(values)
    return values


def _as_columns(right: Array) -> Array:
    return right[:, None] if right.ndim == 1 else right
