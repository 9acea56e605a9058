"""Arrays, numbers and names that users give: kept as plain data, or an error that names them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from ..errors import InputError, NotFiniteError, RangeError, ShapeError, quoted

# Beyond this the products of a solve would overflow.
LARGEST = 1e100
# Arrays of exactly this type are taken as they are.
FLOAT = np.dtype(float)
# Kinds of dtype that become floats without a loss: whole numbers, floats, True and False.
_REAL = "fiub"
# What numpy turns into a float that it is not.
_NOT_REAL = (str, bytes, np.complexfloating, np.datetime64, np.timedelta64, np.void)
# What float() would take, or numpy turn into a float.
_NO_NUMBERS = (
    str, bytes, bool, np.bool_, np.complexfloating, np.datetime64, np.timedelta64,
)  # fmt: skip


def real_numbers(value: Any, *, copied: bool = True) -> np.ndarray:
    """Return a copy as floats, of any shape; what numpy would drop on the way is an error.

    Args:
        copied: False where it is only read.

    Raises:
        TypeError: complex numbers, texts, dates, records, or entries that a mask hides.
        ValueError, OverflowError: as numpy.
    """
    if type(value) is np.ndarray and value.dtype is FLOAT:
        return np.array(value) if copied else value
    array = np.asarray(value)
    kind = array.dtype.kind
    if kind not in _REAL:
        inner = array.ravel().tolist() if kind == "O" else None
        if inner is None or any(isinstance(each, _NOT_REAL) for each in inner):
            raise TypeError("no real numbers")
    if type(value) in (list, tuple):
        if array.ndim > 1 and any(map(_is_masked, value)):
            raise TypeError("a mask hides entries")
        if array.dtype is FLOAT:
            return array
    elif _is_masked(value):
        raise TypeError("a mask hides entries")
    return (np.array if copied else np.asarray)(array, dtype=float)


def floats(value: Any, what: str, *, copied: bool = True) -> np.ndarray:
    """Return a copy as floats, of any shape.

    Args:
        copied: False where it is only read: an array of floats is given back as it is.

    Raises:
        InputError: it does not hold numbers.
        NotFiniteError: some are complex or masked.
    """
    try:
        return real_numbers(value, copied=copied)
    except (TypeError, ValueError, OverflowError):
        raise no_numbers(value, what) from None


def no_numbers(value: Any, what: str, count: str = "") -> InputError:
    """Return the error for what holds no real numbers."""
    sentence = f"{what} must be {count}numbers, got {quoted(value)}"
    try:
        is_text = np.asarray(value).dtype.kind not in "biufcM"
    except ValueError:
        is_text = True
    return InputError(sentence) if is_text else NotFiniteError(sentence, what=what, where=what)


def _is_masked(value: Any) -> bool:
    return hasattr(value, "mask") and np.ma.is_masked(value)


def array_of(value: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    """Return a copy as finite floats of a shape."""
    array = floats(value, what)
    if array.shape != shape:
        raise ShapeError.of(what, shape, array.shape)
    finite = np.isfinite(array)
    if not finite.all():
        where = tuple(np.argwhere(~finite)[0].tolist())
        index = ", ".join(map(str, where))
        raise NotFiniteError.of(what, f"entry {index}", array[where])
    return array


def lock(*arrays: np.ndarray | None) -> None:
    """Make arrays read-only."""
    for array in arrays:
        if array is not None:
            array.setflags(write=False)


def read_only(array: np.ndarray) -> np.ndarray:
    """Return the same array, made read-only."""
    lock(array)
    return array


def number(value: Any, what: str) -> float:
    """Return a finite float.

    Raises:
        InputError: not a number; text and truth values are none.
        NotFiniteError: NaN or infinite.
        RangeError: beyond ±1e100.
    """
    try:
        # Python would take "2" and True for numbers, and numpy's complex numbers and times.
        if isinstance(value, _NO_NUMBERS):
            raise TypeError
        result = float(value)
    except (TypeError, ValueError, OverflowError):
        raise InputError(f"{what} must be a number, got {quoted(value)}", what=what) from None
    if not math.isfinite(result):
        raise NotFiniteError(f"{what} must be a finite number, got {result}", what=what, where=what)
    if abs(result) > LARGEST:
        raise RangeError.of(what, result, f"-{LARGEST:g} to {LARGEST:g}")
    return result


def not_negative(value: Any, what: str) -> float:
    """Return a finite float, 0 or more."""
    result = number(value, what)
    if result < 0.0:
        raise RangeError.of(what, result, "0 or more")
    return result


def text(value: Any, what: str) -> str:
    """Return a name: text that is not empty, without what a terminal would obey."""
    if not isinstance(value, str) or not value:
        raise InputError(f"{what} must be a non-empty name, got {quoted(value)}", what=what)
    if not value.isprintable():
        raise InputError(f"{what} must be printable text, got {quoted(value)}", what=what)
    return value
