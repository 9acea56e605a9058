"""Arrays that users give: copies of finite numbers, or an error that says what is wrong."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..errors import NotFiniteError, ShapeError, quoted

__all__ = ["array_of", "floats", "lock", "read_only"]

# Truth values, integers, floats, and objects, of which Python makes floats.
_NUMBERS = "biufO"


def floats(value: Any, what: str, *, copied: bool = True) -> np.ndarray:
    """A copy as floats, of any shape.

    Args:
        copied: False where it is only read: an array of floats is given back as it is.

    Raises:
        NotFiniteError: it does not hold real numbers, or some are masked.
    """
    if type(value) is np.ndarray and value.dtype == float:
        return np.array(value) if copied else value
    try:
        array = np.asarray(value)
        # numpy would drop imaginary parts and masks, read texts, and count times in their units.
        if array.dtype.kind not in _NUMBERS or _is_masked(value):
            raise TypeError
        if array.dtype != float:
            return array.astype(float)
        return np.array(array) if copied else array
    except (TypeError, ValueError, OverflowError):
        raise NotFiniteError(
            f"{what} must be numbers, got {quoted(value)}", what=what, where=what
        ) from None


def _is_masked(value: Any) -> bool:
    if isinstance(value, list | tuple) and value and isinstance(value[0], np.ndarray):
        return any(map(_is_masked, value))
    return isinstance(value, np.ndarray) and bool(np.any(getattr(value, "mask", False)))


def array_of(value: Any, shape: tuple[int, ...], what: str) -> np.ndarray:
    """A copy as finite floats of a shape.

    Raises:
        NotFiniteError, ShapeError.
    """
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
    """Nobody can write to these arrays any more."""
    for array in arrays:
        if array is not None:
            array.setflags(write=False)


def read_only(array: np.ndarray) -> np.ndarray:
    """The same array, which nobody can write to any more."""
    lock(array)
    return array
